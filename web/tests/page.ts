/** The page as tests see it. */

import { join } from "node:path";
import { AxeBuilder } from "@axe-core/playwright";
import { expect, type Page } from "@playwright/test";
import { PNG } from "pngjs";
import type { FlyByReport, FrameStats, ModelInfo, Vec3 } from "../core/src/index.js";
import { screenshots, type Server } from "./files.js";

/** What the page offers to consoles. */
export interface Meshfront {
  settled(): Promise<FrameStats>;
  stats(): FrameStats | undefined;
  info(): ModelInfo | undefined;
  setCamera(eye: Vec3, target: Vec3): void;
  setTolerance(px: number): void;
  setBudget(triangles: number): void;
  freeze(on: boolean): void;
  set(key: string, value: unknown): void;
  settings: Record<string, unknown>;
  look(side: string): void;
  picture(): string;
  tell(): string;
  reading: { position: { x: number; y: number; z: number }; normal: object; error?: number; update?: number } | undefined;
  original: boolean;
  flyBy(): Promise<FlyByReport>;
  camera: { position: { toArray(): Vec3 }; near: number; far: number };
  renderer: { getContext(): WebGL2RenderingContext; info: { memory: { geometries: number } } };
  objects: {
    visible: boolean;
    info?: ModelInfo;
    bufferBytes: number;
    budget: { memory(): Promise<{ engineBytes: number }> };
    material: { color: { set(color: number): void }; type: string };
    addEventListener(type: string, listener: () => void): void;
    removeEventListener(type: string, listener: () => void): void;
    quaternion: { x: number; y: number; z: number };
    geometry: { drawRange: { count: number }; attributes: Record<string, { array: ArrayBufferView }>; index: { array: ArrayBufferView } };
  }[];
}
declare global {
  interface Window { meshfront: Meshfront }
}

/** Opens the page, with whatever the query asks for, and waits until its front is what the view asks for. */
export async function open(page: Page, query: string, { url }: Server): Promise<FrameStats> {
  const errors: Error[] = [];
  page.on("pageerror", (error) => errors.push(error));
  await page.goto(url + query);
  await page.waitForFunction(() => window.meshfront?.stats() !== undefined);
  expect(errors).toEqual([]);
  return settled(page);
}

export const settled = (page: Page) => page.evaluate(() => window.meshfront.settled());
export const shot = (page: Page, name: string) => page.screenshot({ path: join(screenshots, `${name}.png`) });
export const set = (page: Page, key: string, value: unknown) => page.evaluate(([key, value]) => window.meshfront.set(key as string, value), [key, value]);
export const eye = (page: Page) => page.evaluate(() => window.meshfront.camera.position.toArray());

/** The models as they are drawn now, where nothing is drawn transparent. */
export async function picture(page: Page): Promise<PNG> {
  return decoded(await page.evaluate(() => window.meshfront.picture()));
}

/** A PNG from a data URL. */
export function decoded(url: string): PNG {
  return PNG.sync.read(Buffer.from(url.split(",")[1]!, "base64"));
}

/** What axe finds to say against the page as a screen reader or a weak eye meets it. */
export async function complaints(page: Page): Promise<string[]> {
  const { violations } = await new AxeBuilder({ page }).analyze();
  return violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(" ")}`);
}

/** Eye and target on a line into the model's box: 1 is as far as the model is large. */
export async function lookFrom(page: Page, distance: number): Promise<FrameStats> {
  await page.evaluate((distance) => {
    const { min, max } = window.meshfront.info()!;
    const center = [0, 1, 2].map((i) => (min[i]! + max[i]!) / 2) as unknown as Vec3;
    const size = Math.hypot(...[0, 1, 2].map((i) => max[i]! - min[i]!));
    window.meshfront.setCamera([center[0] + 0.3 * size * distance, center[1], center[2] + size * distance], center);
  }, distance);
  return settled(page);
}

/** Opens a part of the panel, where it is shut. */
export async function openSection(page: Page, id: string): Promise<void> {
  const section = page.locator(`#${id}`);
  if ((await section.getAttribute("open")) === null) await section.locator("summary").first().click();
}

/** Goes there as somebody does who has no mouse. */
export async function tabTo(page: Page, selector: string, most = 40): Promise<void> {
  const isThere = () => page.locator(selector).evaluate((element) => element === document.activeElement);
  const where = () => page.evaluate(() => [...document.querySelectorAll("*")].indexOf(document.activeElement!));
  for (let i = 0; i < most && !(await isThere()); i++) {
    const before = await where();
    await page.keyboard.press("Tab");
    // A page that is busy moves the focus later.
    await expect.poll(where).not.toBe(before);
  }
  await expect(page.locator(selector)).toBeFocused();
}
