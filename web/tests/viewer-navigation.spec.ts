/** Getting around: by mouse and keys, sides, flying, axes, and views that can be sent to somebody. */

import { expect, test, type Page } from "@playwright/test";
import pixelmatch from "pixelmatch";
import type { Vec3 } from "../core/src/index.js";
import { small, terrain, view, type Server } from "./files.js";
import { eye, open, openSection, picture, set, settled } from "./page.js";

let server: Server;
test.beforeAll(async () => { server = await view(small); });
test.afterAll(() => server.stop());

const length = (v: readonly number[]) => Math.hypot(...v);
const minus = (a: readonly number[], b: readonly number[]) => a.map((x, i) => x - b[i]!);
const tell = (page: Page) => page.evaluate(() => window.meshfront.tell());
/** What is read under the pointer, once it is. */
const reading = async (page: Page) => {
  await page.waitForFunction(() => window.meshfront.reading?.error !== undefined);
  const { x, y, z } = (await page.evaluate(() => window.meshfront.reading))!.position;
  return [x, y, z];
};

test("mouse: turn, move, and nearer to what is under the pointer", async ({ page }) => {
  await page.emulateMedia({ reducedMotion: "reduce" });
  await open(page, "", server);
  const start = await eye(page);
  await page.mouse.move(250, 300);
  await page.mouse.down();
  await page.mouse.move(330, 330, { steps: 4 });
  await page.mouse.up();
  await settled(page);
  const turned = await eye(page);
  expect(length(minus(turned, start))).toBeGreaterThan(0.2);

  await page.mouse.down({ button: "right" });
  await page.mouse.move(300, 330, { steps: 4 });
  await page.mouse.up({ button: "right" });
  await settled(page);
  expect(length(minus(await eye(page), turned))).toBeGreaterThan(0.02);

  await page.mouse.move(220, 280);
  const there = await reading(page);
  for (let i = 0; i < 8; i++) await page.mouse.wheel(0, -240);
  await settled(page);
  await page.mouse.move(220, 281);
  await page.mouse.move(220, 280);
  const now = await reading(page);
  // The same place is under the pointer, and nearer.
  const distance = length(minus(there, await eye(page)));
  expect(distance).toBeLessThan(0.6 * length(minus(there, turned)));
  expect(length(minus(now, there))).toBeLessThan(0.05 * distance);
});

test("a turn runs out slowly, unless motion is to be reduced", async ({ page }) => {
  await open(page, "?tolerance=8", server);
  const drag = async () => {
    await page.mouse.move(250, 300);
    await page.mouse.down();
    await page.mouse.move(350, 300, { steps: 3 });
    await page.mouse.up();
    return page.evaluate(async () => {
      const at = () => window.meshfront.camera.position.toArray();
      const places = [];
      for (let i = 0; i < 12; i++) {
        await new Promise((done) => requestAnimationFrame(done));
        places.push(at());
      }
      return places;
    });
  };
  const different = (places: Vec3[]) => new Set(places.map(String)).size;
  expect(different(await drag())).toBeGreaterThan(4);
  await settled(page);
  await page.emulateMedia({ reducedMotion: "reduce" });
  expect(different(await drag())).toBeLessThanOrEqual(2);
});

test("six sides, fit, and the first view", async ({ page }) => {
  await open(page, "?tolerance=4", server);
  const first = await eye(page);
  const sides = { 1: "the front", 2: "the back", 3: "the left", 4: "the right", 5: "straight above", 6: "straight below" };
  for (const [key, said] of Object.entries(sides)) {
    await page.locator("#picture").press(key);
    await settled(page);
    expect(await tell(page)).toContain(`Seen from ${said}`);
  }
  await page.getByLabel("Look from").selectOption("Left");
  await settled(page);
  expect(await tell(page)).toContain("from the left");
  expect((await eye(page))[0]).toBeLessThan(0);
  for (let i = 0; i < 20; i++) await page.locator("#picture").press("-");
  await settled(page);
  expect(await tell(page)).toMatch(/left, filling a (tenth|speck)/);
  await page.locator("#picture").press("f");
  await settled(page);
  expect(await tell(page)).toMatch(/left, filling (three quarters|all)/);
  await page.getByRole("button", { name: "First view" }).click();
  await settled(page);
  expect(length(minus(await eye(page), first))).toBeLessThan(1e-6);
});

test("flying", async ({ page }) => {
  await open(page, "?tolerance=4", server);
  await page.evaluate(() => window.meshfront.look("front"));
  const picture = page.locator("#picture");
  await picture.focus();
  await picture.press("g");
  await expect(page.getByRole("button", { name: "Fly" })).toHaveAttribute("aria-pressed", "true");
  const moved = async (key: string) => {
    const before = await eye(page);
    await page.keyboard.down(key);
    await page.waitForFunction((before) => Math.hypot(...window.meshfront.camera.position.toArray().map((x, i) => x - before[i]!)) > 0.05, before);
    await page.keyboard.up(key);
    await settled(page);
    return minus(await eye(page), before);
  };
  expect((await moved("w"))[2]).toBeLessThan(-0.05);
  expect((await moved("s"))[2]).toBeGreaterThan(0.05);
  expect((await moved("d"))[0]).toBeGreaterThan(0.05);
  expect((await moved("ArrowLeft"))[0]).toBeLessThan(-0.05);
  expect((await moved("e"))[1]).toBeGreaterThan(0.05);
  expect((await moved("q"))[1]).toBeLessThan(-0.05);
  // Looking around does not move; what is ahead does change.
  const before = await eye(page);
  const faced = await tell(page);
  await page.mouse.move(300, 300);
  await page.mouse.down();
  await page.mouse.move(700, 300, { steps: 4 });
  await page.mouse.move(300, 300, { steps: 4 });
  await page.mouse.move(1, 300, { steps: 4 });
  await page.mouse.up();
  for (let i = 0; i < 8; i++) await page.keyboard.press("Shift+ArrowRight");
  await settled(page);
  expect(length(minus(await eye(page), before))).toBe(0);
  expect(await tell(page)).not.toBe(faced);
  await page.keyboard.press("Escape");
  await expect(page.getByRole("button", { name: "Fly" })).toHaveAttribute("aria-pressed", "false");
  expect(length(minus(await eye(page), before))).toBeLessThan(1e-9);
});

test("an address that flies", async ({ page }) => {
  await open(page, "?tolerance=4&fly=1", server);
  await expect(page.getByRole("button", { name: "Fly" })).toHaveAttribute("aria-pressed", "true");
  const before = await eye(page);
  await page.locator("#picture").focus();
  await page.keyboard.down("w");
  await page.waitForFunction((before) => Math.hypot(...window.meshfront.camera.position.toArray().map((x, i) => x - before[i]!)) > 0.05, before);
  await page.keyboard.up("w");
});

test("which way is up", async ({ page }) => {
  const ground = await view(terrain);
  await open(page, "?tolerance=8", ground);
  await page.locator("#picture").press("5");
  await settled(page);
  // z is up in the file: from above, all of the ground is seen.
  expect(await tell(page)).toContain("straight above");
  const share = async () => (await picture(page)).data.filter((alpha, i) => i % 4 === 3 && alpha > 0).length;
  const above = await share();
  await openSection(page, "axes");
  await page.getByLabel("Up is").selectOption("+y");
  await page.locator("#picture").press("5");
  await settled(page);
  expect(await share()).toBeLessThan(0.6 * above);
  await page.getByLabel("Up is").selectOption("−z");
  await expect(page).toHaveURL(/up=-z/);
  ground.stop();
});

test("a view can be sent to somebody", async ({ page, context }) => {
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  await open(page, "?lang=en&theme=dark", server);
  for (const key of ["ArrowLeft", "ArrowLeft", "ArrowUp", "+", "+", "Shift+ArrowRight"]) await page.locator("#picture").press(key);
  await set(page, "colorBy", "level");
  await set(page, "tolerancePx", 2.5);
  await set(page, "unit", "m");
  await settled(page);
  await page.getByRole("button", { name: "Copy a link" }).click();
  await expect(page.locator("#status")).toContainText("link");
  const link = await page.evaluate(() => navigator.clipboard.readText());
  expect(link).toMatch(/eye=-?[\d.]+,-?[\d.]+,-?[\d.]+&target=/);
  // Their language and theme are theirs.
  expect(link).not.toMatch(/lang|theme/);
  const mine = await picture(page);
  const other = await context.newPage();
  await open(other, new URL(link).search, server);
  expect(await other.evaluate(() => { const { colorBy, tolerancePx, unit } = window.meshfront.settings; return { colorBy, tolerancePx, unit }; }))
    .toEqual({ colorBy: "level", tolerancePx: 2.5, unit: "m" });
  const theirs = await picture(other);
  const pixels = mine.data.filter((alpha, i) => i % 4 === 3 && alpha > 0).length;
  expect(pixelmatch(mine.data, theirs.data, undefined, mine.width, mine.height)).toBeLessThan(0.01 * pixels);
  await other.close();
  // The address follows, without a trace in the history.
  const entries = await page.evaluate(() => history.length);
  await page.locator("#picture").press("ArrowLeft");
  await expect.poll(() => page.url()).not.toBe(link);
  expect(await page.evaluate(() => history.length)).toBe(entries);
});

test("what makes no sense in an address is as if it were not said", async ({ page }) => {
  await open(page, "?tolerance=minus&budget=-3&color=mauve&up=w&eye=1,2&unit=cubit&compare=7&memory=", server);
  const { tolerancePx, maxTriangles, maxBytes, colorBy, up, unit, divider } = await page.evaluate(() => window.meshfront.settings);
  expect({ tolerancePx, maxTriangles, maxBytes, colorBy, up, unit, divider })
    .toEqual({ tolerancePx: 1, maxTriangles: Infinity, maxBytes: Infinity, colorBy: "none", up: "file", unit: "none", divider: undefined });
});
