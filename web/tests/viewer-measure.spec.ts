/** Picking and measuring: what is read is what is drawn, with what is not known of it. */

import { expect, test, type Page } from "@playwright/test";
import { small, view, type Server } from "./files.js";
import { open, openSection, set, settled, shot } from "./page.js";

let server: Server;
test.beforeAll(async () => { server = await view(small); });
test.afterAll(() => server.stop());

/** What is read at a point of the page, CSS pixels. */
async function readAt(page: Page, x: number, y: number) {
  await page.mouse.move(x + 3, y);
  await page.mouse.move(x, y);
  await page.waitForFunction(() => window.meshfront.reading?.error !== undefined);
  const { position, error } = (await page.evaluate(() => window.meshfront.reading))!;
  return { at: [position.x, position.y, position.z], error: error! };
}

test("under the pointer: position, normal, error and update", async ({ page }) => {
  const stats = await open(page, "?tolerance=4", server);
  await page.mouse.move(250, 300);
  const readout = page.locator("#readout");
  await expect(readout).toContainText("Position");
  for (const name of ["Normal", "Error", "Update"]) await expect(readout).toContainText(name);
  const reading = (await page.evaluate(() => {
    const { position, normal, error, update } = window.meshfront.reading!;
    return { position: { ...position }, normal: { ...normal } as { x: number; y: number; z: number }, error, update };
  }));
  const { min, max } = (await page.evaluate(() => window.meshfront.info()))!;
  for (const [i, axis] of (["x", "y", "z"] as const).entries()) {
    expect(reading.position[axis]).toBeGreaterThan(min[i]! - 0.05);
    expect(reading.position[axis]).toBeLessThan(max[i]! + 0.05);
  }
  expect(Math.hypot(reading.normal.x, reading.normal.y, reading.normal.z)).toBeCloseTo(1, 3);
  // No worse than the front as a whole promises from here, in the size of its pixels.
  const distance = await page.evaluate(({ x, y, z }) => {
    const eye = window.meshfront.camera.position.toArray();
    return Math.hypot(eye[0] - x, eye[1] - y, eye[2] - z);
  }, reading.position);
  const pixel = (2 * Math.tan(Math.PI / 9) * distance) / 600;
  expect(reading.error!).toBeGreaterThan(0);
  expect(reading.error!).toBeLessThanOrEqual(1.05 * stats.errorPx * pixel);
  await shot(page, "readout");
  // Beside the model there is nothing to read.
  await page.mouse.move(30, 500);
  await expect(readout).toBeHidden();
});

test("a distance between two points, and how well it is known", async ({ page }) => {
  await open(page, "?tolerance=4", server);
  const [a, b] = [await readAt(page, 190, 250), await readAt(page, 300, 380)];
  await page.getByRole("button", { name: "Measure" }).click();
  await openSection(page, "measure");
  await page.mouse.click(190, 250);
  await expect(page.locator("#status")).toContainText("second point");
  await page.mouse.click(300, 380);
  const distance = Math.hypot(...a.at.map((x, i) => x - b.at[i]!));
  const shown = page.locator("#distances li");
  await expect(shown).toHaveCount(1);
  const [value, uncertainty] = (await shown.textContent())!.split(" ± ").map(Number);
  expect(value).toBeCloseTo(distance, 3);
  expect(uncertainty! / (a.error + b.error)).toBeCloseTo(1, 1);
  await expect(page.locator("#status")).toContainText("give or take");
  await expect(page.locator(".overlay line")).toHaveCount(1);
  await expect(page.locator(".overlay circle")).toHaveCount(2);
  await shot(page, "measured");

  // In a unit, and in another language.
  await set(page, "unit", "m");
  await expect(shown).toHaveText(/^[\d.]+ (m|cm) ± [\d.]+ (mm|cm)$/);
  await set(page, "language", "pt");
  await expect(shown).toHaveText(/^[\d,]+ (m|cm) ± [\d,]+ (mm|cm)$/);
  await set(page, "language", "en");

  // It stays on the model while one looks around; a drag sets no point.
  const before = await page.locator(".overlay line").getAttribute("x1");
  await page.mouse.move(250, 300);
  await page.mouse.down();
  await page.mouse.move(320, 300, { steps: 4 });
  await page.mouse.up();
  await settled(page);
  expect(await page.locator(".overlay line").getAttribute("x1")).not.toBe(before);
  await expect(shown).toHaveCount(1);

  await page.getByRole("button", { name: "Clear" }).click();
  await expect(shown).toHaveCount(0);
  await expect(page.locator(".overlay circle")).toHaveCount(0);
});

test("by keyboard: a crosshair, two points, clear", async ({ page }) => {
  await open(page, "?tolerance=4", server);
  const picture = page.locator("#picture");
  await picture.focus();
  await page.keyboard.press("x");
  await expect(page.locator("#readout")).toContainText("Error");
  const first = await page.locator("#readout").textContent();
  for (let i = 0; i < 4; i++) await page.keyboard.press("ArrowLeft");
  await expect(page.locator("#readout")).not.toHaveText(first!);
  await page.keyboard.press("m");
  await page.keyboard.press("Enter");
  await expect(page.locator("#status")).toContainText("second point");
  for (let i = 0; i < 2; i++) await page.keyboard.press("Shift+ArrowUp");
  await page.keyboard.press("Enter");
  await expect(page.locator("#status")).toContainText("The distance is");
  await expect(page.locator("#distances li")).toHaveCount(1);
  await page.keyboard.press("Backspace");
  await expect(page.locator("#distances li")).toHaveCount(0);
  await page.keyboard.press("Escape");
  await expect(page.getByRole("button", { name: "Crosshair" })).toHaveAttribute("aria-pressed", "false");
});
