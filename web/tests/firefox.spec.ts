/**
 * The page in an ordinary Firefox, which Playwright cannot drive: puppeteer does, by WebDriver BiDi. `MESHFRONT_FIREFOX` names it; without that
 * nothing of this runs. It needs a screen, a made-up one will do (`xvfb-run`): without one Firefox has no WebGL.
 */

import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { PNG } from "pngjs";
import puppeteer, { type Browser, type Page } from "puppeteer-core";
import type { Vec3 } from "../core/src/index.js";
import { screenshots, small, view, type Server } from "./files.js";
import type { Meshfront } from "./page.js";

declare const window: { meshfront: Meshfront & { reading: { error?: number } | undefined } };

const firefox = process.env.MESHFRONT_FIREFOX;
test.skip(firefox === undefined, "MESHFRONT_FIREFOX names no Firefox");

let server: Server;
let browser: Browser;
test.beforeAll(async () => {
  if (firefox === undefined) return;
  server = await view(small);
  // Drawing in software is slow, but it is drawing.
  const extraPrefsFirefox = { "webgl.force-enabled": true, "webgl.disable-fail-if-major-performance-caveat": true };
  browser = await puppeteer.launch({ browser: "firefox", executablePath: firefox, headless: false, extraPrefsFirefox });
});
test.afterAll(async () => {
  await browser?.close();
  server?.stop();
});

const settled = (page: Page) => page.evaluate(() => window.meshfront.settled());
const eye = (page: Page) => page.evaluate(() => window.meshfront.camera.position.toArray());
const distance = (a: Vec3, b: Vec3) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
const shot = (page: Page, name: string) => page.screenshot({ path: join(screenshots, `firefox-${name}.png`) as `${string}.png` });
const text = (page: Page, selector: string) => page.$eval(selector, (element) => element.textContent!);

/** The page, once it has settled; what goes wrong in it is thrown in the end. */
async function onPage(query: string, act: (page: Page) => Promise<void>): Promise<void> {
  const page = await browser.newPage();
  const errors: unknown[] = [];
  page.on("pageerror", (error) => errors.push(error));
  await page.setViewport({ width: 800, height: 600 });
  await page.goto(server.url + query);
  await page.waitForFunction(() => window.meshfront?.stats() !== undefined);
  await settled(page);
  await act(page);
  expect(errors).toEqual([]);
  await page.close();
}

/** Pixels of the models that are drawn. */
async function drawn(page: Page): Promise<PNG> {
  const url = await page.evaluate(() => window.meshfront.picture());
  return PNG.sync.read(Buffer.from(url.split(",")[1]!, "base64"));
}
const covered = ({ data }: PNG) => data.filter((alpha, i) => i % 4 === 3 && alpha === 255).length;

test("it loads, is drawn, and refines where one goes near", async () => {
  await onPage("", async (page) => {
    const start = await settled(page);
    expect(start.errorPx).toBeLessThanOrEqual(1);
    expect(await text(page, "#stat-triangles")).toContain(`${start.triangles.toLocaleString("en")} of `);
    expect(covered(await drawn(page))).toBeGreaterThan(10_000);
    await shot(page, "loaded");
    await page.mouse.move(240, 280);
    for (let i = 0; i < 5; i++) await page.mouse.wheel({ deltaY: -240 });
    const near = await settled(page);
    expect(near.errorPx).toBeLessThanOrEqual(1);
    expect(near.triangles).toBeGreaterThan(start.triangles);
    await page.evaluate(() => window.meshfront.setBudget(2000));
    expect((await settled(page)).triangles).toBeLessThanOrEqual(2000);
  });
});

test("mouse and keys move it", async () => {
  await onPage("?tolerance=3", async (page) => {
    const start = await eye(page);
    await page.mouse.move(240, 300);
    await page.mouse.down();
    await page.mouse.move(330, 320, { steps: 4 });
    await page.mouse.up();
    await settled(page);
    const dragged = await eye(page);
    expect(distance(dragged, start)).toBeGreaterThan(0.2);
    await page.focus("#picture");
    await page.keyboard.press("ArrowLeft");
    await expect.poll(async () => distance(await eye(page), dragged)).toBeGreaterThan(0.05);
    await page.keyboard.press("KeyZ");
    expect(await page.evaluate(() => window.meshfront.settings.frozen)).toBe(true);
    await page.keyboard.press("KeyZ");
    await page.keyboard.press("Digit5");
    await expect.poll(() => page.evaluate(() => window.meshfront.tell())).toContain("above");
    await page.keyboard.press("Tab");
    expect(await page.evaluate(() => document.activeElement!.id)).not.toBe("picture");
  });
});

test("what is under the pointer is read", async () => {
  await onPage("", async (page) => {
    await page.mouse.move(240, 300);
    await page.waitForFunction(() => window.meshfront.reading?.error !== undefined);
    expect(await page.$eval("#readout", (readout) => (readout as HTMLElement).hidden)).toBe(false);
    expect(await text(page, "#readout")).toContain("Error");
  });
});

test("the original is compared with, and goes again", async () => {
  await onPage("?tolerance=12", async (page) => {
    await page.focus("#picture");
    await page.keyboard.press("KeyC");
    await page.waitForFunction(() => window.meshfront.original);
    expect(await text(page, "#divider")).toContain("Original, 19,814 triangles");
    await shot(page, "divider");
    const handle = (await (await page.$("#divider"))!.boundingBox())!;
    await page.mouse.move(handle.x + handle.width / 2, 200);
    await page.mouse.down();
    await page.mouse.move(200, 200, { steps: 3 });
    await page.mouse.up();
    expect(await page.$eval("#divider", (divider) => divider.getAttribute("aria-valuenow"))).toBe("25");
    await page.focus("#picture");
    await page.keyboard.press("KeyC");
    expect(await page.$eval("#divider", (divider) => (divider as HTMLElement).hidden)).toBe(true);
  });
});

test("the graphics card is reset: the picture comes back by itself", async () => {
  await onPage("?tolerance=3&panel=0", async (page) => {
    const before = covered(await drawn(page));
    await page.evaluate(() => {
      const extension = window.meshfront.renderer.getContext().getExtension("WEBGL_lose_context")!;
      extension.loseContext();
      Object.assign(window, { restore: () => extension.restoreContext() });
    });
    const failure = () => page.$eval("#failure", (box) => [(box as HTMLElement).hidden, box.textContent!] as const);
    await expect.poll(async () => (await failure())[0]).toBe(false);
    expect((await failure())[1]).toContain("The graphics card was reset");
    await page.evaluate(() => (window as unknown as { restore(): void }).restore());
    await expect.poll(async () => (await failure())[0]).toBe(true);
    await settled(page);
    await expect.poll(async () => covered(await drawn(page))).toBe(before);
  });
});
