/** The page of the real binary, in a real browser. Figures are printed; only promises are asserted. */

import { execFileSync } from "node:child_process";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { expect, test, type Page } from "@playwright/test";
import pixelmatch from "pixelmatch";
import { PNG } from "pngjs";
import type { FlyByReport } from "../core/src/index.js";
import { binary, model, models, screenshots, view, type Server, terrain } from "./files.js";
import { complaints, eye, lookFrom, type Meshfront, open as openAt, openSection, settled, shot, tabTo } from "./page.js";

declare const window: {
  meshfront: Meshfront;
  innerWidth: number;
  /** Bytes that were written into buffers, and into buffers made anew. */
  uploads: { bytes: number; whole: number };
  changed: { updates: number; bytes: number };
};

let server: Server;
test.beforeAll(async () => { server = await view(model, "--credit", "A made-up scan, by procedure"); });
test.afterAll(() => server.stop());

const open = (page: Page, query = "", at = server) => openAt(page, query, at);

test("the page loads, and says what it shows", async ({ page }) => {
  const stats = await open(page);
  await expect(page).toHaveTitle(/scan/);
  await expect(page.getByText("A made-up scan, by procedure")).toBeVisible();
  const triangles = stats.triangles.toLocaleString("en");
  await expect(page.locator("#stat-triangles")).toContainText(`${triangles} of `);
  await expect(page.locator("#status")).toContainText("is loaded");
  await expect(page.getByRole("progressbar")).toBeHidden();
  expect(stats.errorPx).toBeLessThanOrEqual(1);
  await shot(page, "loaded");
  expect(await complaints(page)).toEqual([]);
});

test("it refines when dollying in, and coarsens when leaving", async ({ page }) => {
  await open(page);
  const start = (await lookFrom(page, 1.5)).triangles;
  await page.mouse.move(300, 300);
  for (let i = 0; i < 6; i++) await page.mouse.wheel(0, -300);
  const near = (await settled(page)).triangles;
  await shot(page, "near");
  expect(near).toBeGreaterThan(1.2 * start);
  for (let i = 0; i < 16; i++) await page.mouse.wheel(0, 300);
  const far = (await settled(page)).triangles;
  expect(far).toBeLessThan(0.5 * near);
  expect((await lookFrom(page, 40)).triangles).toBeLessThan(far);
});

test("at 1 px the picture differs from the full one in at most 1 % of the pixels", async ({ page }) => {
  const coarse = await open(page, "?panel=0&tolerance=1");
  const ours = PNG.sync.read(await shot(page, "at-1px"));
  await page.evaluate(() => window.meshfront.setTolerance(0));
  const fine = await settled(page);
  const full = PNG.sync.read(await shot(page, "at-0px"));
  expect(fine.triangles).toBeGreaterThan(1.5 * coarse.triangles);
  const { width, height } = full;
  const difference = new PNG({ width, height });
  const differing = pixelmatch(ours.data, full.data, difference.data, width, height);
  writeFileSync(join(screenshots, "difference.png"), PNG.sync.write(difference));
  console.log(`1 px: ${coarse.triangles} triangles, full: ${fine.triangles}; ${differing} of ${width * height} pixels differ`);
  expect(differing).toBeLessThanOrEqual(0.01 * width * height);
  // The other way round: a hundred times the tolerance can be seen.
  await page.evaluate(() => window.meshfront.setTolerance(100));
  await settled(page);
  const rough = PNG.sync.read(await shot(page, "at-100px"));
  expect(pixelmatch(rough.data, full.data, undefined, width, height)).toBeGreaterThan(0.01 * width * height);
});

test("a damaged file: what is wrong with it, and what to do", async ({ page }) => {
  const damaged = join(models, "damaged.front");
  const bytes = readFileSync(model);
  bytes[Math.floor(bytes.length / 2)]! ^= 0xff;
  writeFileSync(damaged, bytes);
  const other = await view(damaged);
  await page.goto(other.url);
  const alert = page.getByRole("alert");
  await expect(alert).toContainText("The file is damaged");
  await expect(alert).toContainText("meshfront build");
  await expect(alert).toContainText(/damaged\.front: .*byte \d+/);
  await expect(page.getByRole("progressbar")).toBeHidden();
  await shot(page, "damaged");
  expect(await complaints(page)).toEqual([]);
  // Mended on disk, it opens.
  copyFileSync(model, damaged);
  await page.getByRole("button", { name: "Try again" }).click();
  await expect(alert).toBeHidden();
  await settled(page);
  other.stop();
});

test("a missing file, and one that is no .front file", async ({ page }) => {
  await page.goto(`${server.url}?model=nothing.front`);
  await expect(page.getByRole("alert")).toContainText("There is no such file");
  await expect(page.getByRole("alert")).toContainText("nothing.front");
  await shot(page, "missing");
  await page.goto(`${server.url}?model=index.html`);
  await expect(page.getByRole("alert")).toContainText("This is not a .front file");
});

/** Waits until what arrived is on the screen: uploads happen when a frame is drawn, not when a front is settled. */
const drawn = (page: Page) =>
  page.evaluate(() => new Promise<void>((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => done())))));

test("only changed ranges are uploaded", async ({ page }) => {
  await page.addInitScript(() => {
    window.uploads = { bytes: 0, whole: 0 };
    const { prototype } = WebGL2RenderingContext as unknown as { prototype: Record<string, (...a: any[]) => void> };
    const { bufferData, bufferSubData } = prototype;
    prototype.bufferData = function (...a) {
      if (ArrayBuffer.isView(a[1])) window.uploads.whole += a[1].byteLength;
      bufferData!.apply(this, a);
    };
    prototype.bufferSubData = function (...a) {
      window.uploads.bytes += a.length > 3 ? a[4] * a[2].BYTES_PER_ELEMENT : a[2].byteLength;
      bufferSubData!.apply(this, a);
    };
  });
  await open(page);
  // Nearer and back once, so that the buffers are as long as they have to be.
  await lookFrom(page, 0.75);
  await lookFrom(page, 0.79);
  await drawn(page);
  await page.evaluate(() => {
    window.uploads = { bytes: 0, whole: 0 };
    window.changed = { updates: 0, bytes: 0 };
    window.meshfront.objects[0]!.addEventListener("needs-update", () => {
      const { refined, coarsened, uploadBytes } = window.meshfront.stats()!;
      window.changed.updates += refined + coarsened;
      window.changed.bytes += uploadBytes;
    });
  });
  await lookFrom(page, 0.785);
  // What arrived is written when the next picture is drawn.
  await page.waitForFunction(() => window.uploads.bytes > 0);
  await drawn(page);
  const [uploads, changed] = await page.evaluate(() => [window.uploads, window.changed] as const);
  const everything = await page.evaluate(() => {
    const { attributes, index } = window.meshfront.objects[0]!.geometry;
    const columns = [...Object.values(attributes), index];
    return columns.reduce((sum, { array }) => sum + array.byteLength, 0);
  });
  console.log(`upload: ${changed.updates} updates, ${uploads.bytes} bytes of ${everything}`);
  expect(changed.updates).toBeGreaterThan(0);
  expect(uploads.bytes).toBeGreaterThan(0);
  // Neighbouring ranges may be joined on the way, with a number between them.
  expect(uploads.bytes).toBeLessThanOrEqual(1.01 * changed.bytes);
  expect(uploads.bytes).toBeLessThan(0.5 * everything);
  expect(uploads.whole).toBe(0);
});

test("tolerance, budget and freezing", async ({ page }) => {
  const start = await open(page);
  await page.getByLabel("Tolerance").press("PageUp");
  const coarser = await settled(page);
  expect(coarser.triangles).toBeLessThan(start.triangles);
  await page.evaluate(() => window.meshfront.setBudget(3000));
  const small = await settled(page);
  expect(small.triangles).toBeLessThanOrEqual(3000);
  expect(small.triangles).toBeGreaterThan(2000);
  await page.getByLabel("Freeze front").check();
  const frozen = await lookFrom(page, 0.5);
  expect(frozen.triangles).toBe(small.triangles);
  await page.getByLabel("Freeze front").uncheck();
  await page.getByLabel("Triangle budget").press("End");
  expect((await settled(page)).triangles).toBeGreaterThan(3000);
});

test("wireframe and levels", async ({ page }) => {
  await open(page, "?tolerance=4");
  await openSection(page, "look");
  await page.getByLabel("Wireframe").check();
  await page.getByLabel("Colour by").selectOption("Level");
  await settled(page);
  await shot(page, "wireframe-levels");
});

test("terrain lies on the ground, and is refined where one looks", async ({ page }) => {
  const ground = await view(terrain);
  try {
    const stats = await open(page, "", ground);
    const { sourceTriangles, up } = await page.evaluate(() => window.meshfront.info()!);
    expect([sourceTriangles, up]).toEqual([524_288, [0, 0, 1]]);
    expect(stats.errorPx).toBeLessThanOrEqual(1);
    expect(stats.triangles).toBeLessThan(0.5 * sourceTriangles);
    await shot(page, "terrain");
    const before = stats.triangles;
    await page.mouse.move(400, 400);
    for (let i = 0; i < 6; i++) await page.mouse.wheel(0, -300);
    const near = await settled(page);
    await shot(page, "terrain-near");
    expect(near.refined + near.coarsened + Math.abs(near.triangles - before)).toBeGreaterThan(0);
  } finally {
    ground.stop();
  }
});

test("a small screen, by keyboard alone", async ({ page }) => {
  await page.setViewportSize({ width: 320, height: 568 });
  await open(page);
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  expect(overflow).toBeLessThanOrEqual(0);
  await shot(page, "small");
  await page.keyboard.press("Tab");
  await expect(page.locator("#picture")).toBeFocused();
  const before = await eye(page);
  await page.keyboard.press("ArrowLeft");
  await expect.poll(() => eye(page)).not.toEqual(before);
  await tabTo(page, "#panel > summary");
  await page.keyboard.press("Enter");
  await expect(page.getByLabel("Tolerance")).toBeVisible();
  await settled(page);
  await shot(page, "small-panel");
  for (const id of ["copy", "tolerance", "budget", "memory", "time", "freeze", "frustum", "orientation"]) await tabTo(page, `#${id}`, 3);
});

test("the worker flies as the native engine does", async ({ page }) => {
  await open(page);
  const flights: FlyByReport[] = [];
  for (let i = 0; i < 5; i++) flights.push(await page.evaluate(() => window.meshfront.flyBy()));
  const worker = flights.sort((a, b) => a.meanMs - b.meanMs)[2]!;
  const native = JSON.parse(execFileSync(binary, ["bench", model, "--json"], { encoding: "utf8" })).fly_by;
  const row = (name: string, ms: { mean: number; p50: number; p99: number; max: number }) =>
    `${name}: mean ${ms.mean.toFixed(3)}, median ${ms.p50.toFixed(3)}, p99 ${ms.p99.toFixed(3)}, worst ${ms.max.toFixed(2)} ms`;
  console.log(row("fly-by, worker", { mean: worker.meanMs, p50: worker.p50Ms, p99: worker.p99Ms, max: worker.maxMs }));
  console.log(row("fly-by, native", native.ms));
  console.log(`fly-by, worker ÷ native: ${(worker.meanMs / native.ms.mean).toFixed(2)}`);
  // The same work: rounding differs between machines, decisions hardly ever.
  expect(worker.frames).toBe(native.frames);
  expect(worker.updatesPerFrame / native.updates_per_frame).toBeCloseTo(1, 2);
  expect(worker.activeTriangles / native.triangles_mean).toBeCloseTo(1, 2);
  expect(worker.evaluationsPerFrame / native.evaluations_per_frame).toBeCloseTo(1, 1);
});

test("models of several kinds share one budget", async ({ page }) => {
  const several = await view(terrain, "--at", "0,0,0", model, "--at", "7500,3000,-7500,1500");
  try {
    const free = await open(page, "", several);
    await expect(page).toHaveTitle(/terrain.front, scan.front/);
    expect(await page.evaluate(() => window.meshfront.objects.length)).toBe(2);
    await shot(page, "several");
    const limit = Math.round(free.triangles / 2);
    await page.evaluate((limit) => window.meshfront.setBudget(limit), limit);
    await expect.poll(async () => (await settled(page)).budgetBound).toBe(true);
    const bound = await settled(page);
    expect(bound.triangles).toBeLessThanOrEqual(limit);
    expect(bound.triangles).toBeGreaterThan(0.95 * limit);
    await shot(page, "several-budget");
    await page.evaluate(() => window.meshfront.setBudget(Infinity));
    await expect.poll(async () => (await settled(page)).triangles).toBe(free.triangles);
    // What the panel counts is what is drawn.
    await expect(page.locator("#stat-triangles")).toContainText(`${free.triangles.toLocaleString("en")} of `);
  } finally {
    several.stop();
  }
});
