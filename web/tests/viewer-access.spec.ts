/** For everybody: without a mouse, without eyes, on any screen, in both languages. */

import { expect, test, type Page } from "@playwright/test";
import { small, view, type Server } from "./files.js";
import { complaints, eye, open, openSection, set, settled, shot, tabTo } from "./page.js";

let server: Server;
test.beforeAll(async () => { server = await view(small, "--credit", "A made-up scan, by procedure"); });
test.afterAll(() => server.stop());

const SECTIONS = ["figures", "quality", "look", "axes", "measure", "page"];
const SCREENS = { small: { width: 320, height: 568 }, large: { width: 1920, height: 1080 } };

/** Everything that can be pressed, and how large it is. */
const targets = (page: Page) => page.evaluate(() =>
  [...document.querySelectorAll<HTMLElement>("button, select, summary, input, [role=slider]")]
    .filter((element) => element.checkVisibility() && element.getClientRects().length > 0)
    .map((element) => {
      // A label is part of what it labels.
      const { width, height } = (element.closest("label.switch, .models label") ?? element).getBoundingClientRect();
      return { what: element.id || element.outerHTML.slice(0, 60), width, height };
    }));

for (const [name, viewport] of Object.entries(SCREENS)) {
  for (const colorScheme of ["light", "dark"] as const) {
    test(`axe finds nothing: ${name}, ${colorScheme}`, async ({ page }) => {
      await page.setViewportSize(viewport);
      await page.emulateMedia({ colorScheme });
      await open(page, "?tolerance=4&color=error&compare=0.5", server);
      expect(await page.evaluate(() => document.documentElement.dataset.theme)).toBe(colorScheme);
      await shot(page, `page-${name}-${colorScheme}`);
      const panel = page.locator("#panel");
      if ((await panel.getAttribute("open")) === null) await page.locator("#panel > summary").click();
      for (const section of SECTIONS) await openSection(page, section);
      await set(page, "measuring", true);
      await set(page, "crosshair", true);
      await settled(page);
      await shot(page, `open-${name}-${colorScheme}`);
      expect(await complaints(page)).toEqual([]);
      for (const { what, width, height } of await targets(page)) expect(Math.min(width, height), what).toBeGreaterThanOrEqual(24);
      expect(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth)).toBeLessThanOrEqual(0);
      await page.locator("#picture").press("?");
      await expect(page.getByRole("dialog")).toBeVisible();
      expect(await complaints(page)).toEqual([]);
      await shot(page, `keys-${name}-${colorScheme}`);
    });
  }
}

test("high contrast, forced colours, 4K", async ({ page }) => {
  await page.emulateMedia({ contrast: "more", colorScheme: "light" });
  await open(page, "?tolerance=4", server);
  expect(await page.evaluate(() => document.documentElement.dataset.theme)).toBe("contrast");
  expect(await complaints(page)).toEqual([]);
  await shot(page, "contrast");
  await page.emulateMedia({ contrast: "no-preference", forcedColors: "active" });
  expect(await complaints(page)).toEqual([]);
  await shot(page, "forced-colors");
  await page.emulateMedia({ forcedColors: "none" });
  await openSection(page, "page");
  await page.getByLabel("Theme").selectOption("Dark");
  expect(await page.evaluate(() => document.documentElement.dataset.theme)).toBe("dark");
  await expect(page).toHaveURL(/theme=dark/);
  await page.setViewportSize({ width: 3840, height: 2160 });
  await settled(page);
  await shot(page, "4k");
  expect(await page.evaluate(() => parseFloat(getComputedStyle(document.documentElement).fontSize))).toBeGreaterThan(18);
});

test("everything by keyboard alone", async ({ page, context }) => {
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  // From the beginning, or a real dialog may open and take the focus before anybody waits for it.
  page.on("filechooser", () => {});
  await open(page, "?tolerance=4", server);
  const status = page.locator("#status");
  await page.keyboard.press("Tab");
  await expect(page.locator("#picture")).toBeFocused();
  expect(await page.locator("#picture").evaluate((canvas) => getComputedStyle(canvas).outlineStyle)).not.toBe("none");
  const start = await eye(page);
  for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowLeft", "+", "-", "2", "5", "f", "h"]) {
    const before = await eye(page);
    await page.keyboard.press(key);
    await expect.poll(() => eye(page), key).not.toEqual(before);
    await settled(page);
  }
  expect(Math.hypot(...(await eye(page)).map((x, i) => x - start[i]!))).toBeLessThan(1e-6);
  await page.keyboard.press("t");
  await expect(status).toContainText("Seen from the front right and a little above, filling");
  await page.keyboard.press("l");
  await expect(status).toContainText("copied");
  await page.keyboard.press("z");
  await expect(status).toContainText("frozen");
  await page.keyboard.press("z");
  await page.keyboard.press("c");
  await page.keyboard.press("Tab");
  await expect(page.getByRole("slider", { name: "Divider" })).toBeFocused();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Shift+Tab");
  await page.keyboard.press("c");
  await Promise.all([page.waitForEvent("filechooser"), page.keyboard.press("o")]);
  const [picture] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("p")]);
  expect(picture.suggestedFilename()).toMatch(/png$/);
  await page.keyboard.press("?");
  await expect(page.getByRole("dialog")).toContainText("Shift + arrows");
  await page.keyboard.press("Escape");
  await expect(page.locator("#picture")).toBeFocused();

  // The tools, one by one.
  for (const tool of ["fit", "home", "fly", "measure", "crosshair", "compare", "shot", "link", "tell", "open", "keys"]) await tabTo(page, `#tool-${tool}`, 3);
  // Every control of the panel; what is shut is opened on the way.
  const ids = await page.locator("#panel input, #panel select, #panel button").evaluateAll((all) => all.map(({ id }) => id));
  const reached = new Set<string>();
  for (let i = 0; i < 80; i++) {
    await page.keyboard.press("Tab");
    const { id, shut, inPanel } = await page.evaluate(() => {
      const element = document.activeElement as HTMLElement;
      const shut = element.tagName === "SUMMARY" && !(element.parentElement as HTMLDetailsElement).open;
      return { id: element.id, shut, inPanel: element.closest("#panel") !== null };
    });
    if (!inPanel) break;
    if (shut) await page.keyboard.press("Enter");
    if (id) reached.add(id);
  }
  // What is not to be seen now is not to be reached: no colours in the file, no model to choose, nothing measured.
  const hidden = ["figures-of", "vertexColors", "own-background", "clear", ""];
  expect(ids.filter((id) => !reached.has(id) && !hidden.includes(id))).toEqual([]);
  // And they do what they say.
  await page.locator("#color").focus();
  await page.keyboard.press("ArrowDown");
  await expect(page.locator("#legend")).toBeVisible();
  await page.locator("#wireframe").focus();
  await page.keyboard.press("Space");
  await expect(page.locator("#wireframe")).toBeChecked();
});

test("keys belong to the picture: elsewhere they mean nothing", async ({ page }) => {
  await open(page, "?tolerance=4", server);
  await page.locator("#tolerance").focus();
  const before = await eye(page);
  for (const key of ["f", "z", "c", "m", "1"]) await page.keyboard.press(key);
  expect(await eye(page)).toEqual(before);
  const { frozen, divider, measuring } = await page.evaluate(() => window.meshfront.settings);
  expect([frozen, divider, measuring]).toEqual([false, undefined, false]);
});

test("from which side and how near one looks, in words", async ({ page }) => {
  await open(page, "?tolerance=8", server);
  const tell = () => page.evaluate(() => window.meshfront.tell());
  const from = async (...direction: [number, number, number]) => {
    await page.evaluate((at) => window.meshfront.setCamera(at, [0, 0, 0]), direction);
    await settled(page);
    return tell();
  };
  expect(await from(0, 0, 12)).toMatch(/^Seen from the front, filling (a quarter|a third) of the picture\.$/);
  expect(await from(6, 3, 6)).toContain("from the front right and a little above");
  expect(await from(-6, -12, 0)).toContain("from the left and far below");
  expect(await from(0, 9, 0.01)).toContain("straight above");
  expect(await from(0, 0, -60)).toContain("a speck");
  expect(await from(0, 0, 1.6)).toContain("times as large as the picture");
  await page.evaluate(() => window.meshfront.setCamera([0, 0, 9], [0, 0, 18]));
  await settled(page);
  expect(await tell()).toContain("outside the picture");
  await set(page, "language", "pt");
  expect(await from(0, 0, 12)).toMatch(/^Visto de frente; ocupa um (quarto|terço) da imagem\.$/);
});

test("Portuguese: by the address, by the browser, by choice", async ({ page, browser }) => {
  await open(page, "?lang=pt", server);
  expect(await page.evaluate(() => document.documentElement.lang)).toBe("pt");
  for (const text of ["Triângulos", "Tolerância", "Congelar a frente"]) await expect(page.getByText(text, { exact: true }).first()).toBeVisible();
  const { triangles } = await settled(page);
  await expect(page.locator("#stat-triangles")).toHaveText(new RegExp(`^${triangles.toLocaleString("pt").replace(".", "\\.")} de `));
  await expect(page.locator("#status")).toContainText("está carregado");
  for (const section of SECTIONS) await openSection(page, section);
  // Nothing was forgotten: no English where there is Portuguese.
  const english = ["Triangles", "Tolerance", "Budget", "Colour", "Surface", "Background", "Measure", "Page", "Quality", "Figures", "Copy", "Freeze"];
  const body = await page.locator("#dock").innerText();
  for (const word of english) expect(body).not.toContain(word);
  const labels = await page.locator("[aria-label], [title]").evaluateAll((all) => all.map((e) => `${e.getAttribute("aria-label")} ${e.getAttribute("title")}`).join("\n"));
  for (const word of ["View", "Show", "Fly", "Look", "Save", "Open", "Keys"]) expect(labels).not.toContain(word);
  expect(await complaints(page)).toEqual([]);
  await shot(page, "portuguese");
  await page.getByLabel("Língua").selectOption("English");
  await expect(page.getByText("Freeze front")).toBeVisible();
  await expect(page).not.toHaveURL(/lang=/);

  const brazil = await browser.newPage({ locale: "pt-BR" });
  await open(brazil, "", server);
  expect(await brazil.evaluate(() => document.documentElement.lang)).toBe("pt");
  await brazil.close();
  const elsewhere = await browser.newPage({ locale: "fi-FI" });
  await open(elsewhere, "", server);
  expect(await elsewhere.evaluate(() => document.documentElement.lang)).toBe("en");
  await elsewhere.close();
});
