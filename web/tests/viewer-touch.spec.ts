/** The page under fingers and a pen. */

import { expect, test, type Browser, type CDPSession, type Page } from "@playwright/test";
import { small, view, type Server } from "./files.js";
import { complaints, eye, open, openSection, set, settled, shot } from "./page.js";

let server: Server;
test.beforeAll(async () => { server = await view(small); });
test.afterAll(() => server.stop());

type At = [x: number, y: number];

/** Fingers that stay the same from their start to their end. */
class Hand {
  constructor(private readonly client: CDPSession) {}

  private send(type: "touchStart" | "touchMove" | "touchEnd", points: At[]) {
    return this.client.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  }
  /** All fingers go straight from one place to another. */
  async drag(...ways: [from: At, to: At][]): Promise<void> {
    const at = (part: number) => ways.map(([a, b]): At => [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part]);
    await this.send("touchStart", at(0));
    for (const part of [0.2, 0.4, 0.6, 0.8, 1]) await this.send("touchMove", at(part));
    await this.send("touchEnd", []);
  }
  async tap(at: At, roll = 0): Promise<void> {
    await this.send("touchStart", [at]);
    if (roll) await this.send("touchMove", [[at[0] + roll, at[1]]]);
    await this.send("touchEnd", []);
  }
}

/** A page on a device with a touch screen. */
async function device(browser: Browser, query: string, viewport = { width: 400, height: 600 }): Promise<{ page: Page; hand: Hand }> {
  const context = await browser.newContext({ hasTouch: true, isMobile: true, viewport, reducedMotion: "reduce" });
  const page = await context.newPage();
  await open(page, query, server);
  return { page, hand: new Hand(await page.context().newCDPSession(page)) };
}

const length = (v: readonly number[]) => Math.hypot(...v);
const minus = (a: readonly number[], b: readonly number[]) => a.map((x, i) => x - b[i]!);
/** Where the camera is, and which way it looks. */
const pose = async (page: Page) => {
  await settled(page);
  const forward = await page.evaluate(() => {
    const { elements } = (window.meshfront.camera as unknown as { matrixWorld: { elements: number[] } }).matrixWorld;
    return [-elements[8]!, -elements[9]!, -elements[10]!];
  });
  return { eye: await eye(page), forward };
};
const reading = async (page: Page) => {
  await page.waitForFunction(() => window.meshfront.reading?.error !== undefined);
  const { x, y, z } = (await page.evaluate(() => window.meshfront.reading))!.position;
  return [x, y, z];
};
const middle: At = [200, 300];

test("one finger turns around what it touched", async ({ browser }) => {
  const { page, hand } = await device(browser, "?panel=0");
  const start = await pose(page);
  await hand.drag([middle, [280, 320]]);
  const turned = await pose(page);
  expect(length(minus(turned.forward, start.forward))).toBeGreaterThan(0.2);
  // As far as before from where it turned.
  await hand.tap(middle);
  const touched = await reading(page);
  await hand.drag([middle, [150, 300]]);
  const again = await pose(page);
  expect(length(minus(again.eye, touched)) / length(minus(turned.eye, touched))).toBeCloseTo(1, 2);
  await page.context().close();
});

test("two fingers go nearer to what is between them, and away", async ({ browser }) => {
  const { page, hand } = await device(browser, "?panel=0");
  const between: At = [170, 270];
  await hand.tap(between);
  const place = await reading(page);
  const start = await pose(page);
  await hand.drag([[160, 270], [100, 270]], [[180, 270], [240, 270]]);
  const near = await pose(page);
  expect(length(minus(near.eye, place))).toBeLessThan(0.7 * length(minus(start.eye, place)));
  expect(length(minus(near.forward, start.forward))).toBeLessThan(0.02);
  await hand.tap(between);
  expect(length(minus(await reading(page), place))).toBeLessThan(0.1 * length(minus(near.eye, place)));
  await hand.drag([[100, 270], [160, 270]], [[240, 270], [180, 270]]);
  const away = await pose(page);
  expect(length(minus(away.eye, place))).toBeGreaterThan(1.4 * length(minus(near.eye, place)));
  await page.context().close();
});

test("two fingers side by side move the model with them", async ({ browser }) => {
  const { page, hand } = await device(browser, "?panel=0");
  await hand.tap(middle);
  const place = await reading(page);
  const start = await pose(page);
  await hand.drag([[190, 300], [230, 340]], [[210, 300], [250, 340]]);
  const moved = await pose(page);
  expect(length(minus(moved.forward, start.forward))).toBeLessThan(0.02);
  expect(length(minus(moved.eye, start.eye))).toBeGreaterThan(0.05 * length(start.eye));
  await hand.tap([240, 340]);
  expect(length(minus(await reading(page), place))).toBeLessThan(0.03 * length(minus(start.eye, place)));
  await page.context().close();
});

test("a tap reads what it meets, and measures", async ({ browser }) => {
  const { page, hand } = await device(browser, "");
  const start = await eye(page);
  const readout = page.locator("#readout");
  await expect(readout).toBeHidden();
  await hand.tap(middle, 6);
  await reading(page);
  await expect(readout).toBeVisible();
  await expect(page.locator(".overlay circle")).toHaveCount(1);
  await shot(page, "touch-tap");
  // Beside the model there is nothing.
  await hand.tap([5, 5]);
  await expect(readout).toBeHidden();
  // A drag asks nothing, and hides what was asked.
  await hand.tap(middle);
  await expect(readout).toBeVisible();
  await hand.drag([middle, [240, 300]]);
  await expect(readout).toBeHidden();
  expect(length(minus(await eye(page), start))).toBeGreaterThan(0.05);

  await set(page, "measuring", true);
  // A pinch that one finger hardly takes part in sets no point.
  await hand.drag([middle, [201, 300]], [[260, 300], [300, 300]]);
  await hand.tap(middle);
  await expect(page.locator("#status")).toContainText("second point");
  await hand.tap([230, 330]);
  await expect(page.locator("#status")).toContainText("give or take");
  await page.context().close();
});

test("flying under fingers: one looks around, two push", async ({ browser }) => {
  const { page, hand } = await device(browser, "?panel=0");
  await set(page, "flying", true);
  const start = await pose(page);
  await hand.drag([middle, [280, 320]]);
  const looked = await pose(page);
  expect(length(minus(looked.eye, start.eye))).toBeLessThan(1e-6);
  expect(length(minus(looked.forward, start.forward))).toBeGreaterThan(0.05);
  await hand.drag([[190, 300], [190, 200]], [[210, 300], [210, 200]]);
  const pushed = await pose(page);
  const way = minus(pushed.eye, looked.eye);
  expect(length(way)).toBeGreaterThan(0.01);
  // Straight ahead.
  expect(way.reduce((sum, x, i) => sum + x * looked.forward[i]!, 0) / length(way)).toBeCloseTo(1, 2);
  await page.context().close();
});

test("a pen hovers, turns and sets points as a mouse does", async ({ page }) => {
  await open(page, "?panel=0", server);
  const client = await page.context().newCDPSession(page);
  const pen = (type: "mouseMoved" | "mousePressed" | "mouseReleased", [x, y]: At, buttons = 0) =>
    client.send("Input.dispatchMouseEvent", { type, x, y, buttons, button: type === "mouseMoved" && !buttons ? "none" : "left", pointerType: "pen", clickCount: 1 });
  await pen("mouseMoved", [400, 300]);
  await reading(page);
  const start = await eye(page);
  await pen("mousePressed", [400, 300], 1);
  for (const x of [420, 440, 460]) await pen("mouseMoved", [x, 310], 1);
  await pen("mouseReleased", [460, 310]);
  await settled(page);
  expect(length(minus(await eye(page), start))).toBeGreaterThan(0.1);
  await set(page, "measuring", true);
  await pen("mousePressed", [400, 300], 1);
  await pen("mouseReleased", [400, 300]);
  await expect(page.locator("#status")).toContainText("second point");
});

test("320 pixels of touch screen: panel, sliders, tools and divider", async ({ browser }) => {
  const { page, hand } = await device(browser, "", { width: 320, height: 568 });
  const wide = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  expect(wide[0]).toBeLessThanOrEqual(320);
  expect(wide[1]).toBe(320);
  await page.locator("#panel > summary").tap();
  await openSection(page, "quality");
  const slider = page.locator("#tolerance");
  await slider.scrollIntoViewIfNeeded();
  const { x, y, width, height } = (await slider.boundingBox())!;
  const before = await page.evaluate(() => window.meshfront.settings.tolerancePx as number);
  await hand.tap([x + 0.7 * width, y + height / 2]);
  expect(await page.evaluate(() => window.meshfront.settings.tolerancePx as number)).toBeGreaterThan(2 * before);
  await shot(page, "touch-320-panel");
  // A finger in the panel scrolls the panel, and nothing else, even where it begins on a slider.
  const still = await eye(page);
  const scrolled = () => page.evaluate(() => Math.max(...[...document.querySelectorAll("*")].map(({ scrollTop }) => scrollTop)));
  const budget = page.locator("#budget");
  await budget.scrollIntoViewIfNeeded();
  const [from, track] = [await scrolled(), (await budget.boundingBox())!];
  const begin: At = [track.x + 0.4 * track.width, track.y + track.height / 2];
  await hand.drag([begin, [begin[0], begin[1] - 120]]);
  await expect.poll(scrolled).not.toBe(from);
  await expect.poll(() => page.evaluate(() => window.meshfront.settings.maxTriangles)).toBe(Infinity);
  expect(await eye(page)).toEqual(still);
  expect(await page.evaluate(() => scrollY)).toBe(0);
  // The first tap after it may only stop the scrolling.
  for (let last = -1; last !== (last = await scrolled());) await page.evaluate(() => new Promise((soon) => setTimeout(soon, 200)));
  await page.locator("#panel > summary").tap();
  await expect(page.locator("#panel")).not.toHaveAttribute("open");
  expect(await complaints(page)).toEqual([]);

  await page.getByRole("button", { name: "Compare with the original" }).tap();
  await page.waitForFunction(() => window.meshfront.original);
  const divider = (await page.locator("#divider").boundingBox())!;
  const middle: At = [divider.x + divider.width / 2, 200];
  await hand.drag([middle, [80, 200]]);
  await expect(page.locator("#divider")).toHaveAttribute("aria-valuenow", "25");
  expect(await eye(page)).toEqual(still);
  await shot(page, "touch-320-divider");
  const small = await page.evaluate(() => [...document.querySelectorAll<HTMLElement>("button, select, input, summary")]
    .filter((target) => target.checkVisibility() && !target.closest("label"))
    .map((target) => ({ id: target.id || target.textContent, box: target.getBoundingClientRect() }))
    .filter(({ box }) => box.width > 0 && (box.width < 24 || box.height < 24)).map(({ id }) => id));
  expect(small).toEqual([]);
  await page.context().close();
});
