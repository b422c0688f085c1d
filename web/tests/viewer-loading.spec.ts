/** How models arrive, from the server or from a person's hands, and what is said when they cannot. */

import { readFileSync, writeFileSync } from "node:fs";
import { createServer, request } from "node:http";
import type { AddressInfo } from "node:net";
import { join } from "node:path";
import { expect, test, type Page } from "@playwright/test";
import pixelmatch from "pixelmatch";
import { PNG } from "pngjs";
import { limited } from "../core/test/limited.js";
import { model, models, screenshots, small, terrain, view, type Server } from "./files.js";
import { complaints, decoded, open, picture, set, settled, shot } from "./page.js";

let server: Server;
test.beforeAll(async () => { server = await view(small); });
test.afterAll(() => server.stop());

/** The same server over a thin line: `.front` files in parts, one every 50 ms. */
async function thinLine({ url }: Server): Promise<Server> {
  const proxy = createServer((asked, answer) => {
    request(new URL(asked.url!, url), { method: asked.method!, headers: { ...asked.headers, host: new URL(url).host } }, (from) => {
      answer.writeHead(from.statusCode!, from.headers);
      const parts: Buffer[] = [];
      from.on("data", (part: Buffer) => parts.push(part));
      from.on("end", async () => {
        const all = Buffer.concat(parts);
        const step = asked.url!.endsWith(".front") ? Math.ceil(all.length / 20) : all.length || 1;
        for (let at = 0; at < all.length; at += step) {
          answer.write(all.subarray(at, at + step));
          if (step < all.length) await new Promise((done) => setTimeout(done, 50));
        }
        answer.end();
      });
    }).end();
  });
  await new Promise<void>((ready) => proxy.listen(0, "127.0.0.1", ready));
  return { url: `http://127.0.0.1:${(proxy.address() as AddressInfo).port}/`, stop: () => void proxy.close() };
}

declare const window: {
  meshfront: import("./page.js").Meshfront;
  seen: { value: number | undefined; shown: boolean; triangles: number; ready: boolean }[];
};

test("progress only grows, is full once, and then the model is there; the base mesh comes first", async ({ page }) => {
  const large = await view(model);
  const thin = await thinLine(large);
  await page.addInitScript(() => {
    window.seen = [];
    const look = () => {
      const bar = document.querySelector<HTMLProgressElement>("#loading-bar");
      const object = window.meshfront?.objects[0] as unknown as { geometry: { drawRange: { count: number } }; info?: object } | undefined;
      if (bar) {
        window.seen.push({
          value: bar.hasAttribute("value") ? bar.value : undefined,
          shown: !document.querySelector<HTMLElement>("#loading")!.hidden,
          triangles: (object?.geometry.drawRange.count ?? 0) / 3,
          ready: object?.info !== undefined,
        });
      }
      requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
  await open(page, "", thin);
  const seen = await page.evaluate(() => window.seen);
  const values = seen.flatMap(({ value, shown }) => (shown && value !== undefined ? [value] : []));
  expect(new Set(values).size).toBeGreaterThan(4);
  expect([...values].sort((a, b) => a - b)).toEqual(values);
  // Full and gone are one moment: as long as it is to be seen, there is something to wait for.
  expect(Math.max(...values)).toBeLessThan(1);
  for (const { shown, ready } of seen) if (shown) expect(ready).toBe(false);
  expect(await page.locator("#loading-bar").evaluate((bar: HTMLProgressElement) => bar.value)).toBe(1);
  // Long before the file is there, something is.
  const first = seen.findIndex(({ triangles }) => triangles > 0);
  const last = seen.findIndex(({ ready }) => ready);
  expect(first).toBeGreaterThanOrEqual(0);
  expect(first).toBeLessThan(0.6 * last);
  expect(seen[first]!.triangles).toBeLessThan(2000);
  thin.stop();
  large.stop();
});

test("of a terrain the coarse heights come first, the right way up", async ({ page }) => {
  const ground = await view(terrain);
  const thin = await thinLine(ground);
  await page.addInitScript(() => {
    const first: Record<string, unknown> = {};
    Object.assign(window, { first });
    const look = () => {
      const object = window.meshfront?.objects[0];
      const { x = 0, y = 0, z = 0 } = object?.quaternion ?? {};
      const seen = { triangles: (object?.geometry.drawRange.count ?? 0) / 3, up: [x, y, z], ready: object?.info !== undefined };
      if (seen.triangles > 0 && first.triangles === undefined) Object.assign(first, seen, { picture: window.meshfront.picture() });
      requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
  await open(page, "?tolerance=3&panel=0", thin);
  const first = await page.evaluate(() => (window as unknown as { first: { triangles: number; up: number[]; ready: boolean; picture: string } }).first);
  // 65 x 65 of 513 x 513 heights.
  expect(first).toMatchObject({ triangles: 2 * 64 * 64, ready: false });
  const up = await page.evaluate(() => {
    const { x, y, z } = window.meshfront.objects[0]!.quaternion;
    return [x, y, z];
  });
  expect(up).toEqual(first.up);
  expect(Math.abs(up[0]!)).toBeGreaterThan(0.5);
  // Much the same as what comes next.
  const [coarse, fine] = [decoded(first.picture), await picture(page)];
  const covered = fine.data.filter((alpha, i) => i % 4 === 3 && alpha > 0).length;
  expect(pixelmatch(coarse.data, fine.data, undefined, fine.width, fine.height)).toBeLessThan(0.3 * covered);
  await shot(page, "terrain-fine");
  writeFileSync(join(screenshots, "terrain-first.png"), PNG.sync.write(coarse));
  thin.stop();
  ground.stop();
});

/** Drops files on the page, as a file manager does. */
async function drop(page: Page, ...files: { name: string; content: Buffer }[]): Promise<void> {
  await page.evaluate(async (files) => {
    const transfer = new DataTransfer();
    for (const { name, content } of files) {
      const bytes = await (await fetch(`data:application/octet-stream;base64,${content}`)).arrayBuffer();
      transfer.items.add(new File([bytes], name));
    }
    for (const type of ["dragover", "drop"]) document.body.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
  }, files.map(({ name, content }) => ({ name, content: content.toString("base64") })));
}

test("a .front file dropped on the page is opened from its bytes", async ({ page }) => {
  await open(page, "", server);
  await drop(page, { name: "ground.front", content: readFileSync(terrain) });
  await expect(page).toHaveTitle(/ground\.front/);
  await page.waitForFunction(() => window.meshfront.stats() !== undefined);
  await settled(page);
  expect((await page.evaluate(() => window.meshfront.info()))!.sourceTriangles).toBe(524_288);
  await expect(page.locator("#status")).toContainText("ground.front is loaded");
  // Nobody else could open it: it has no address.
  expect(page.url()).not.toContain("ground");
});

test("a mesh dropped on the page is built by the local program", async ({ page }) => {
  // From the beginning, or a real dialog may open before anybody waits for it.
  page.on("filechooser", () => {});
  await open(page, "", server);
  await drop(page, { name: "stone.ply", content: readFileSync(small.replace(/front$/, "ply")) });
  await expect(page.locator("#loading-text")).toContainText("Building stone.ply");
  await expect(page).toHaveTitle(/stone/);
  await page.waitForFunction(() => window.meshfront.stats() !== undefined);
  const { triangles } = await settled(page);
  expect(triangles).toBeGreaterThan(1000);
  // The same by a button.
  const [chooser] = await Promise.all([page.waitForEvent("filechooser"), page.getByRole("button", { name: "Open a file" }).click()]);
  await chooser.setFiles(small);
  await expect(page).toHaveTitle(/small\.front/);
});

test("files that cannot be opened: why, and what to do; what was shown comes back", async ({ page }) => {
  await open(page, "", server);
  const alert = page.getByRole("alert");
  await drop(page, { name: "letter.txt", content: Buffer.from("Dear Sir") });
  await expect(alert).toContainText("letter.txt is no file that this page can open");
  await expect(alert).toContainText("PLY");
  await page.getByRole("button", { name: "Close" }).click();
  await expect(alert).toBeHidden();
  await drop(page, { name: "broken.ply", content: Buffer.from("ply\nformat ascii 1.0\nelement vertex 3\nend_header\n") });
  await expect(alert).toContainText("The mesh could not be built");
  await expect(page.locator("#failure-what")).not.toBeEmpty();
  await expect(page.getByRole("progressbar")).toBeHidden();
  await page.getByRole("button", { name: "Close" }).click();
  await drop(page, { name: "other.front", content: Buffer.from("not at all") });
  await expect(alert).toContainText("This is not a .front file");
  await page.getByRole("button", { name: "Close" }).click();
  await expect(page).toHaveTitle(/small\.front/);
  await page.waitForFunction(() => window.meshfront.stats() !== undefined);
  await settled(page);
});

test("a server that builds nothing: .front files only", async ({ page }) => {
  await page.route("**/model.json", (route) => route.fulfill({ json: { name: "small", models: [{ name: "small", url: "model.front" }] } }));
  await open(page, "", server);
  await drop(page, { name: "stone.ply", content: Buffer.from("ply") });
  await expect(page.getByRole("alert")).toContainText("this server cannot build");
  await expect(page.getByRole("alert")).toContainText("meshfront view");
});

test("a file from a later version, in two languages", async ({ page }) => {
  const bytes = readFileSync(small);
  // The version stands after the magic.
  bytes.writeUInt32LE(99, 8);
  writeFileSync(join(models, "later.front"), bytes);
  const later = await view(join(models, "later.front"));
  await page.goto(later.url);
  await expect(page.getByRole("alert")).toContainText("The file is too new");
  await expect(page.getByRole("alert")).toContainText("Update Meshfront");
  await page.goto(`${later.url}?lang=pt`);
  await expect(page.getByRole("alert")).toContainText("O ficheiro é demasiado recente");
  await shot(page, "failure-pt");
  expect(await complaints(page)).toEqual([]);
  later.stop();
});

/** The engine gets so many bytes of memory and no more. */
const memory = (page: Page, bytes: number) => page.route("**/*.wasm", async (route) => {
  const response = await route.fetch();
  await route.fulfill({ response, body: limited(await response.body(), bytes) });
});
/** Somebody turns the model, and it follows. */
async function turn(page: Page): Promise<void> {
  const before = await page.evaluate(() => window.meshfront.camera.position.toArray());
  await page.locator("#picture").press("ArrowLeft");
  await expect.poll(() => page.evaluate(() => window.meshfront.camera.position.toArray())).not.toEqual(before);
}

test("a model that needs more memory than the browser gives", async ({ page }) => {
  const errors: Error[] = [];
  page.on("pageerror", (error) => errors.push(error));
  const large = await view(model);
  await memory(page, 10e6);
  await page.goto(large.url);
  const alert = page.getByRole("alert");
  await expect(alert).toContainText("The model needs more memory than the browser gives");
  await expect(alert).toContainText("scan.front needs more memory than the browser gives");
  await expect(alert).toContainText("Close other tabs");
  await expect(page.getByRole("progressbar")).toBeHidden();
  await shot(page, "memory");
  expect(await complaints(page)).toEqual([]);
  // A smaller one fits, on the same page; and the same when there is more.
  await drop(page, { name: "small.front", content: readFileSync(small) });
  await expect(alert).toBeHidden();
  await expect(page).toHaveTitle(/small/);
  await page.waitForFunction(() => window.meshfront.stats() !== undefined);
  await settled(page);
  await page.unroute("**/*.wasm");
  await open(page, "", large);
  expect(errors).toEqual([]);
  large.stop();
});

test("memory that ends in flight: the front stays as fine as it got, and the original as well", async ({ page }) => {
  const large = await view(model);
  await memory(page, 20e6);
  await open(page, "?tolerance=40&frustum=0&orientation=0", large);
  // All at once: however long a call is, it ends before memory does.
  await page.evaluate(() => {
    const { budget } = window.meshfront.objects[0] as unknown as { budget: { deadlineMs: number } };
    budget.deadlineMs = 1e6;
  });
  await set(page, "tolerancePx", 0);
  await page.waitForFunction(() => window.meshfront.stats()!.byteBound);
  const bound = await settled(page);
  expect(bound.triangles).toBeGreaterThan(2000);
  expect(bound.triangles).toBeLessThan(118_000);
  await expect(page.locator("#bites")).toContainText("The browser gives no more memory");
  await expect(page.getByRole("alert")).toBeHidden();
  await turn(page);
  await set(page, "divider", 0.5);
  await page.waitForFunction(() => window.meshfront.original);
  await expect(page.locator("#divider")).toContainText("Original, limited to ");
  await set(page, "divider", undefined);
  await set(page, "tolerancePx", 10);
  const coarse = await settled(page);
  expect(coarse.errorPx).toBeLessThanOrEqual(10);
  await expect(page.locator("#bites")).toBeHidden();
  await turn(page);
  large.stop();
});

test("an engine that ends in flight: what is drawn stays, and the model can be opened again", async ({ page }) => {
  const errors: Error[] = [];
  page.on("pageerror", (error) => errors.push(error));
  const large = await view(model);
  await open(page, "?tolerance=40&frustum=0&orientation=0", large);
  const before = await picture(page);
  // Nothing that a page asks for ends it: the answer is put in its mouth.
  await page.evaluate(() => {
    const { budget } = window.meshfront.objects[0] as unknown as { budget: { client: { adapt(): Promise<never> } } };
    budget.client.adapt = () => Promise.reject(Object.assign(new Error("the front needs more memory"), { name: "memory" }));
    window.meshfront.setTolerance(0);
  });
  const alert = page.getByRole("alert");
  await expect(alert).toContainText("The model needs more memory than the browser gives");
  await page.getByRole("button", { name: "Close" }).click();
  await expect(alert).toBeHidden();
  expect(pixelmatch(before.data, (await picture(page)).data, undefined, before.width, before.height)).toBe(0);
  await turn(page);
  await drop(page, { name: "small.front", content: readFileSync(small) });
  await expect(page).toHaveTitle(/small/);
  await page.waitForFunction(() => window.meshfront.stats() !== undefined);
  await settled(page);
  expect(errors).toEqual([]);
  large.stop();
});

test("a server that is gone", async ({ page }) => {
  const other = await view(small);
  await open(page, "", other);
  other.stop();
  await page.evaluate(() => window.meshfront.objects[0]!.material.type);
  await drop(page, { name: "stone.ply", content: Buffer.from("ply") });
  await expect(page.getByRole("alert")).toContainText("The connection to the local program broke off");
});

test("no WebGL: said in words", async ({ page }) => {
  await page.addInitScript(() => { HTMLCanvasElement.prototype.getContext = () => null; });
  await page.goto(server.url);
  await expect(page.getByRole("alert")).toContainText("cannot draw in three dimensions");
  await expect(page.getByRole("alert")).toContainText("hardware acceleration");
  await expect(page.getByRole("progressbar")).toBeHidden();
  expect(await complaints(page)).toEqual([]);
});

test("the graphics card is reset: the picture comes back by itself", async ({ page }) => {
  await open(page, "?tolerance=3&panel=0", server);
  const before = await picture(page);
  await page.evaluate(() => {
    const extension = window.meshfront.renderer.getContext().getExtension("WEBGL_lose_context")!;
    extension.loseContext();
    Object.assign(window, { restore: () => extension.restoreContext() });
  });
  await expect(page.getByRole("alert")).toContainText("The graphics card was reset");
  await expect(page.getByRole("button", { name: "Reload the page" })).toBeVisible();
  // The front goes on meanwhile.
  await page.evaluate(() => window.meshfront.setTolerance(2));
  await page.evaluate(() => (window as unknown as { restore(): void }).restore());
  await expect(page.getByRole("alert")).toBeHidden();
  await expect(page.locator("#status")).toContainText("The picture is back");
  await page.evaluate(() => window.meshfront.setTolerance(3));
  await settled(page);
  const after = await picture(page);
  expect(pixelmatch(before.data, after.data, undefined, before.width, before.height)).toBeLessThan(20);
});

test("a hidden tab takes up again where it was", async ({ page }) => {
  await open(page, "?tolerance=3", server);
  const client = await page.context().newCDPSession(page);
  await client.send("Page.setWebLifecycleState", { state: "frozen" });
  await client.send("Page.setWebLifecycleState", { state: "active" });
  await page.evaluate(() => window.meshfront.setTolerance(1));
  expect((await settled(page)).errorPx).toBeLessThanOrEqual(1);
  const pixels = (await picture(page)).data.filter((alpha, i) => i % 4 === 3 && alpha > 0).length;
  expect(pixels).toBeGreaterThan(10_000);
});
