/** Figures, limits and looks: what a person sets is what is asked of the front, and what is drawn. */

import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { expect, test, type Page } from "@playwright/test";
import pixelmatch from "pixelmatch";
import { PNG } from "pngjs";
import { small, terrain, view, type Server } from "./files.js";
import { lookFrom, open, openSection, picture, set, settled, shot } from "./page.js";

const painted = fileURLToPath(new URL("../../testdata/front/v1-knot-lossless-painted.front", import.meta.url));

let server: Server;
test.beforeAll(async () => { server = await view(small); });
test.afterAll(() => server.stop());

/** How many pixels look different. */
const differing = (a: PNG, b: PNG) => pixelmatch(a.data, b.data, undefined, a.width, a.height);
const drawn = (page: Page) => page.evaluate(() => new Promise<void>((done) => requestAnimationFrame(() => requestAnimationFrame(() => done()))));

test("budgets are hard, and say what they leave", async ({ page }) => {
  const free = await open(page, "", server);
  const bites = page.locator("#bites");
  await expect(bites).toBeHidden();
  await set(page, "maxTriangles", 2000);
  const small = await settled(page);
  expect(small.triangles).toBeLessThanOrEqual(2000);
  await expect(bites).toContainText("triangle budget is used up");
  await expect(bites).toContainText(`within ${Number(small.errorPx.toPrecision(2))} px`);
  await expect(page.locator("#status")).toContainText("triangle budget");
  await set(page, "maxTriangles", Infinity);
  expect((await settled(page)).triangles).toBe(free.triangles);
  await expect(bites).toBeHidden();

  // Memory: in the engine and in buffers, at every moment.
  const bytes = () => page.evaluate(() => window.meshfront.stats()!.frontBytes + 2 * window.meshfront.objects[0]!.bufferBytes);
  const most = Math.round((await bytes()) / 2);
  await set(page, "maxBytes", most);
  await page.waitForFunction(() => window.meshfront.stats()!.byteBound);
  const capped = await settled(page);
  expect(capped.triangles).toBeLessThan(free.triangles);
  expect(await bytes()).toBeLessThanOrEqual(most);
  await expect(bites).toContainText("memory budget is used up");
  // It holds still: the same number from now on.
  for (let i = 0; i < 10; i++) await drawn(page);
  expect((await settled(page)).triangles).toBe(capped.triangles);
  await lookFrom(page, 0.5);
  expect(await bytes()).toBeLessThanOrEqual(most);
  await page.getByLabel("Memory budget").press("End");
  expect((await settled(page)).byteBound).toBe(false);
});

test("criteria and time", async ({ page }) => {
  await open(page, "", server);
  const both = (await lookFrom(page, 0.5)).triangles;
  await page.getByLabel("Coarse where it faces away").uncheck();
  const round = (await settled(page)).triangles;
  expect(round).toBeGreaterThan(both);
  await page.getByLabel("Coarse outside the picture").uncheck();
  expect((await settled(page)).triangles).toBeGreaterThan(round);
  await page.getByLabel("Time per frame").press("Home");
  await expect(page.locator("#time-value")).toHaveText("1 ms");
  await page.getByLabel("Coarse outside the picture").check();
  await page.getByLabel("Coarse where it faces away").check();
  expect((await settled(page)).settled).toBe(true);
});

test("a frozen front, seen from elsewhere, with the view that it was made for", async ({ page }) => {
  const made = await open(page, "?tolerance=4", server);
  await page.getByLabel("Freeze front").check();
  await page.evaluate(() => window.meshfront.look("back"));
  for (let i = 0; i < 12; i++) await page.locator("#picture").press("-");
  expect((await settled(page)).triangles).toBe(made.triangles);
  // Its lines are orange, and nothing else is.
  const orange = ({ data }: PNG) => {
    let n = 0;
    for (let i = 0; i < data.length; i += 4) n += Number(data[i]! > 150 && data[i]! - data[i + 2]! > 110);
    return n;
  };
  expect(orange(await picture(page))).toBeGreaterThan(100);
  await shot(page, "frozen");
  await page.getByLabel("Freeze front").uncheck();
  await settled(page);
  expect(orange(await picture(page))).toBe(0);
  await expect(page.locator("#status")).toContainText("follows the view");
});

test("colours, with a legend", async ({ page }) => {
  await open(page, "?tolerance=3", server);
  await openSection(page, "look");
  const plain = await picture(page);
  const covered = plain.data.filter((alpha, i) => i % 4 === 3 && alpha > 0).length;
  await expect(page.locator("#legend")).toBeHidden();
  const seen: PNG[] = [plain];
  for (const [name, ends] of [["Error", /\d/], ["Level", /base mesh.*level 20/], ["Age", /just now.*60 frames ago/], ["Spread of normals", /one direction.*all directions/]] as const) {
    await page.getByLabel("Colour by").selectOption(name);
    await settled(page);
    await expect(page.locator("#legend")).toHaveText(ends);
    const now = await picture(page);
    for (const before of seen) expect(differing(now, before), name).toBeGreaterThan(0.1 * covered);
    seen.push(now);
    await shot(page, `color-${name.toLowerCase().replaceAll(" ", "-")}`);
  }
  // On every surface.
  for (const surface of ["Matcap", "Flat facets"]) {
    await page.getByLabel("Surface").selectOption(surface);
    await drawn(page);
    expect(differing(await picture(page), seen.at(-1)!), surface).toBeGreaterThan(0.02 * covered);
  }
});

test("surfaces, wires, spheres, painted vertices", async ({ page }) => {
  await open(page, "?tolerance=6", server);
  await openSection(page, "look");
  // Nothing is painted here.
  await expect(page.getByLabel("Vertex colours")).toBeHidden();
  let last = await picture(page);
  const changes = async (what: string, least = 500) => {
    await settled(page);
    const now = await picture(page);
    expect(differing(now, last), what).toBeGreaterThan(least);
    last = now;
  };
  await page.getByLabel("Surface").selectOption("Matcap");
  await changes("matcap");
  await page.getByLabel("Surface").selectOption("Flat facets");
  await changes("flat");
  await page.getByLabel("Wireframe").check();
  await changes("wires");
  await page.getByLabel("Bounding spheres of the next updates").check();
  await expect.poll(async () => differing(await picture(page), last)).toBeGreaterThan(500);
  await shot(page, "spheres");
  await page.getByLabel("Bounding spheres of the next updates").uncheck();
  await page.getByLabel("Wireframe").uncheck();

  const knot = await view(painted);
  await open(page, "", knot);
  await openSection(page, "look");
  last = await picture(page);
  await page.getByLabel("Vertex colours").uncheck();
  await changes("vertex colours");
  await expect(page).toHaveURL(/colors=0/);
  knot.stop();
});

test("figures, charts, and all of it as JSON", async ({ page, context }) => {
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  await open(page, "", server);
  const stats = await lookFrom(page, 0.6);
  const cell = (id: string) => page.locator(`#stat-${id}`);
  const { sourceTriangles, sourceVertices } = (await page.evaluate(() => window.meshfront.info()))!;
  await expect(cell("triangles")).toHaveText(`${stats.triangles.toLocaleString("en")} of ${sourceTriangles.toLocaleString("en")}`);
  await expect(cell("vertices")).toHaveText(`${stats.vertices.toLocaleString("en")} of ${sourceVertices.toLocaleString("en")}`);
  await expect(cell("error")).toHaveText(/px$/);
  await expect(cell("errorAt")).toHaveText(/^0\.\d+$/);
  for (const id of ["upload", "engineMemory", "gpuMemory"]) await expect(cell(id)).toHaveText(/^[\d.]+ [kMG]B$/);
  await expect(cell("rate")).toHaveText("at rest");
  for (const chart of await page.locator(".chart path").all()) await expect(chart).toHaveAttribute("d", /^M.*Z$/);
  await page.getByRole("button", { name: "Copy as JSON" }).click();
  await expect(page.locator("#status")).toContainText("Copied");
  const report = JSON.parse(await page.evaluate(() => navigator.clipboard.readText()));
  expect(report.sum.triangles).toBe(stats.triangles);
  expect(report.asked).toEqual({ tolerancePx: 1, deadlineMs: 6 });
  expect(report.sum.engineBytes).toBeGreaterThan(report.models[0].engineBytes);
  // In the unit that a person gives: pixels at the pivot, millimetres.
  await openSection(page, "axes");
  await page.getByLabel("One unit is").selectOption("a millimetre");
  await expect(cell("errorAt")).toHaveText(/^[\d.]+ (mm|µm)$/);
});

test("where the browser does not let the page copy, the figures are there to be copied by hand", async ({ page }) => {
  await page.addInitScript(() => {
    Object.defineProperty(navigator, "clipboard", { value: { writeText: () => Promise.reject(new Error("no")) } });
  });
  await open(page, "", server);
  await page.getByRole("button", { name: "Copy as JSON" }).click();
  await expect(page.locator(".by-hand")).toBeFocused();
  expect(JSON.parse(await page.locator(".by-hand").inputValue()).sum.triangles).toBeGreaterThan(0);
});

test("several models: one by one, and switched off", async ({ page }) => {
  const several = await view(terrain, "--at", "0,0,0", small, "--at", "7500,3000,-7500,1500");
  try {
    const both = await open(page, "?tolerance=4", several);
    const rows = page.locator(".models li");
    await expect(rows).toHaveCount(2);
    await expect(rows.nth(1)).toContainText("small.front");
    await expect(rows.nth(1)).toContainText(/[\d,]+ triangles, [\d.]+ px/);
    await page.getByLabel("Figures of").selectOption("small.front");
    const { sourceTriangles } = (await page.evaluate(() => window.meshfront.objects[1]!.info))!;
    await expect(page.locator("#stat-triangles")).toContainText(`of ${sourceTriangles.toLocaleString("en")}`);
    await page.getByLabel("Figures of").selectOption("All models");
    await expect(page.locator("#stat-triangles")).toHaveText(`${both.triangles.toLocaleString("en")} of ${(sourceTriangles + 524_288).toLocaleString("en")}`);
    const before = await picture(page);
    await page.getByLabel("Show terrain.front").uncheck();
    const one = await settled(page);
    // What is not seen is not kept either.
    expect(one.triangles).toBeLessThan(both.triangles);
    expect(differing(await picture(page), before)).toBeGreaterThan(1000);
    await page.getByLabel("Show terrain.front").check();
    expect((await settled(page)).triangles).toBe(both.triangles);
    expect(differing(await picture(page), before)).toBe(0);
  } finally {
    several.stop();
  }
});

test("the divider: the front on the left, the original on the right", async ({ page }) => {
  await open(page, "?tolerance=0&panel=0", server);
  const original = await picture(page);
  await set(page, "tolerancePx", 12);
  await settled(page);
  const front = await picture(page);
  await set(page, "divider", 0.5);
  await page.waitForFunction(() => window.meshfront.original);
  await settled(page);
  const handle = page.getByRole("slider", { name: "Divider" });
  await expect(handle).toHaveAttribute("aria-valuetext", "Front on the left 50%");
  await expect(handle).toContainText(/Original, [\d,]+ triangles/);
  await shot(page, "divider");
  /** Columns of the picture, from one to another part of its width. */
  const part = (whole: PNG, from: number, to: number) => {
    const [left, right] = [Math.round(from * whole.width), Math.round(to * whole.width)];
    const cut = new PNG({ width: right - left, height: whole.height });
    PNG.bitblt(whole, cut, left, 0, right - left, whole.height, 0, 0);
    return cut;
  };
  const same = async (at: number) => {
    const both = await picture(page);
    if (at > 0) expect(differing(part(both, 0, at), part(front, 0, at))).toBe(0);
    // Facing away, a front is coarser than the original, which shows in nothing but the odd pixel of a rim.
    expect(differing(part(both, at, 1), part(original, at, 1))).toBeLessThan(50);
  };
  await same(0.5);
  await handle.focus();
  for (const key of ["PageDown", "PageDown", "ArrowLeft"]) await page.keyboard.press(key);
  await expect(handle).toHaveAttribute("aria-valuenow", "29");
  await same(0.29);
  await expect(page).toHaveURL(/compare=0\.290/);
  await page.keyboard.press("Home");
  await same(0);
  const { width, height } = original;
  await page.mouse.move(1, height / 2);
  await page.mouse.down();
  await page.mouse.move(0.75 * width, height / 2, { steps: 4 });
  await page.mouse.up();
  await same(0.75);
  await page.locator("#picture").press("c");
  await expect(handle).toBeHidden();
});

const complete = (page: Page) => page.waitForFunction(() => window.meshfront.original);

test("the original has limits of its own, and may be limited", async ({ page }) => {
  const { triangles } = await open(page, "?budget=2000&memory=1", server);
  const { sourceTriangles } = (await page.evaluate(() => window.meshfront.info()))!;
  const count = (n: number) => n.toLocaleString("en");
  const handle = page.locator("#divider");
  await openSection(page, "comparison");
  await page.locator("#comparing").check();
  await expect(handle).toContainText(`Original, ${count(sourceTriangles)} triangles`);
  // In the same worker, and yet the front is neither finer nor coarser for it.
  expect(page.workers()).toHaveLength(1);
  expect((await settled(page)).triangles).toBe(triangles);
  const most = page.locator("#original-triangles");
  await expect(most).toHaveValue("8000000");
  await most.fill("5000");
  await most.press("Enter");
  await expect(handle).toContainText(/Original, limited to (5,000|4,9\d\d) of /);
  await expect(handle).toContainText(`of ${count(sourceTriangles)} triangles`);
  await expect(page).toHaveURL(/original=5000/);
  await shot(page, "divider-limited");
  expect((await settled(page)).triangles).toBe(triangles);
  // From the beginning, in another language; what makes no sense is not taken.
  await open(page, "?compare=0.5&original=4000&lang=pt", server);
  await expect(handle).toContainText(/Original, limitado a (4[.\u00a0 ]?000|3[.\u00a0 ]?9\d\d) de /);
  await most.evaluate((field: HTMLInputElement) => { field.value = "-3"; field.dispatchEvent(new Event("change")); });
  expect(await page.evaluate(() => window.meshfront.settings.originalTriangles)).toBe(4000);
});

test("the original is complete though nobody stands still", async ({ page }) => {
  await open(page, "?panel=0", server);
  const { sourceTriangles, min, max } = (await page.evaluate(() => window.meshfront.info()))!;
  await page.evaluate(({ min, max }) => {
    const center = min.map((low, i) => (low + max[i]!) / 2) as [number, number, number];
    const far = 2 * Math.hypot(...max.map((high, i) => high - center[i]!));
    let angle = 0;
    const turn = () => {
      angle += 0.004;
      window.meshfront.setCamera([center[0] + far * Math.sin(angle), center[1], center[2] + far * Math.cos(angle)], center);
    };
    // Between frames: none of them sees the view that was asked for last.
    setInterval(turn, 2);
  }, { min, max });
  await set(page, "divider", 0.5);
  await complete(page);
  const handle = page.locator("#divider");
  await expect(handle).toContainText(`Original, ${sourceTriangles.toLocaleString("en")} triangles`);
  for (const [most, words] of [[5000, /limited to (5,000|4,9\d\d) of /], [3000, /limited to (3,000|2,9\d\d) of /]] as const) {
    await set(page, "originalTriangles", most);
    await expect(handle).toContainText(words);
    await complete(page);
  }
  await set(page, "originalTriangles", 8e6);
  await expect(handle).toContainText(`Original, ${sourceTriangles.toLocaleString("en")} triangles`);
});

test("what the original takes is given back", async ({ page }) => {
  const { frontBytes } = await open(page, "?panel=0&tolerance=0&frustum=0&orientation=0", server);
  const sizes: { engineBytes: number; geometries: number }[] = [];
  const measure = async () => sizes.push(await page.evaluate(async () => ({
    engineBytes: (await window.meshfront.objects[0]!.budget.memory()).engineBytes,
    geometries: window.meshfront.renderer.info.memory.geometries,
  })));
  await measure();
  for (let i = 0; i < 12; i++) {
    await set(page, "divider", 0.5);
    await complete(page);
    await drawn(page);
    expect(await page.evaluate(() => window.meshfront.renderer.info.memory.geometries)).toBe(sizes[0]!.geometries + 1);
    await set(page, "divider", undefined);
    await drawn(page);
    await measure();
  }
  // WebAssembly keeps what it had once, and how much that is depends on when frames come; but the next one takes the same place. What
  // stayed would ask for more every time.
  const [before, first, last] = [sizes[0]!, sizes[1]!, sizes.at(-1)!];
  const steps = sizes.slice(1).map(({ engineBytes }, i) => engineBytes - sizes[i]!.engineBytes);
  expect(steps.slice(-6).filter((step) => step < frontBytes / 2).length).toBeGreaterThanOrEqual(4);
  expect([first.geometries, last.geometries]).toEqual([before.geometries, before.geometries]);
});

test("the picture as a file, background and all", async ({ page }) => {
  await open(page, "?background=%23ff00ff&tolerance=4", server);
  const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save the picture" }).click()]);
  expect(file.suggestedFilename()).toBe("small.front.png");
  const saved = PNG.sync.read(readFileSync(await file.path()));
  expect([saved.width, saved.height]).toEqual([800, 600]);
  expect([...saved.data.subarray(0, 4)]).toEqual([255, 0, 255, 255]);
  // Models are in front of it.
  const alone = await picture(page);
  const i = alone.data.findIndex((alpha, i) => i % 4 === 3 && alpha === 255) - 3;
  expect([...saved.data.subarray(i, i + 3)]).toEqual([...alone.data.subarray(i, i + 3)]);
});

test("backgrounds", async ({ page }) => {
  await open(page, "", server);
  await openSection(page, "look");
  const behind = () => page.locator("#picture").evaluate((canvas) => getComputedStyle(canvas).background);
  expect(await behind()).toContain("gradient");
  for (const [name, color] of [["White", "rgb(255, 255, 255)"], ["Grey", "rgb(128, 128, 128)"], ["Black", "rgb(0, 0, 0)"]] as const) {
    await page.getByLabel("Background").selectOption(name);
    expect(await behind()).toContain(color);
  }
  await page.getByLabel("Background").selectOption("Own colour");
  await page.getByLabel("Own colour", { exact: true }).fill("#336699");
  expect(await behind()).toContain("rgb(51, 102, 153)");
  await expect(page).toHaveURL(/background=%23336699/);
});
