/** The packages as they are packed, in projects that know nothing of this one: with Vite, with React, and without a bundler. */

import { type ChildProcess, execFileSync, spawn } from "node:child_process";
import {
  copyFileSync, cpSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, symlinkSync, writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { AxeBuilder } from "@axe-core/playwright";
import { expect, test, type Page } from "@playwright/test";
import { PNG } from "pngjs";
import type { MeshFrontElement } from "../three/src/element.js";
import { model, screenshots } from "./files.js";
import type {} from "./fresh/src/main.js";
import { type FolderServer, serveFolder } from "./serve.js";

const web = fileURLToPath(new URL("..", import.meta.url));
const npm = process.platform === "win32" ? "npm.cmd" : "npm";
const home = mkdtempSync(join(tmpdir(), "meshfront-"));
const modules = join(home, "node_modules");
/** The first version of three.js that the packages promise to work with. */
const OLDEST = "npm:three@0.160.0";

let servers: { stop(): void }[] = [];
test.afterEach(() => {
  for (const server of servers) server.stop();
  servers = [];
});
async function serve(folder: string, shared = false): Promise<FolderServer> {
  const server = await serveFolder(folder, shared);
  servers.push(server);
  return server;
}

const run = (folder: string, command: string, ...args: string[]) =>
  execFileSync(command, args, { cwd: folder, stdio: ["ignore", "pipe", "inherit"], shell: process.platform === "win32" }).toString();
const vite = (folder: string, ...args: string[]) => run(folder, process.execPath, join(modules, "vite/bin/vite.js"), ...args);
const tsc = (folder: string) => run(folder, process.execPath, join(modules, "typescript/bin/tsc"), "--noEmit");

/** One folder for all projects, so that the registry is asked once. */
test.beforeAll(() => {
  const packed = join(home, "packed");
  mkdirSync(packed);
  run(web, npm, "pack", "--silent", "--workspace", "core", "--workspace", "three", "--pack-destination", packed);
  const dependencies = ["vite", "react-three-fiber"].map((name) => {
    const example = JSON.parse(readFileSync(join(web, "examples", name, "package.json"), "utf8"));
    return { ...example.dependencies, ...example.devDependencies };
  });
  const project = { private: true, type: "module", dependencies: Object.assign({ "three-oldest": OLDEST }, ...dependencies) };
  writeFileSync(join(home, "package.json"), JSON.stringify(project));
  run(home, npm, "install", "--no-audit", "--no-fund", "--silent", ...readdirSync(packed).map((file) => join(packed, file)));
  cpSync(join(web, "tests/fresh"), join(home, "fresh"), { recursive: true });
  for (const name of ["plain", "vite", "react-three-fiber"]) cpSync(join(web, "examples", name), join(home, name), { recursive: true });
  for (const name of ["fresh", "vite", "react-three-fiber"]) {
    mkdirSync(join(home, name, "public"), { recursive: true });
    copyFileSync(model, join(home, name, "public/model.front"));
  }
  copyFileSync(model, join(home, "plain/model.front"));
  symlinkSync(modules, join(home, "plain/node_modules"), "junction");
});
test.afterAll(() => rmSync(home, { recursive: true, force: true }));

/** Opens a page; what goes wrong there fails the test. */
async function open(page: Page, url: string): Promise<void> {
  page.on("pageerror", (error) => { throw error; });
  page.on("requestfailed", (request) => console.log(`failed: ${request.url()}`));
  await page.goto(url);
}

/** Part of an element's pixels that are not those of its upper left corner. */
async function drawnPart(page: Page, selector: string, name: string): Promise<number> {
  const path = join(screenshots, `${name}.png`);
  const { data, width, height } = PNG.sync.read(await page.locator(selector).screenshot({ path }));
  const [corner, all] = [data.subarray(4 * (5 * width + 20), 4 * (5 * width + 20) + 3), width * height];
  let different = 0;
  for (let i = 0; i < all; i++) if ([0, 1, 2].some((k) => Math.abs(data[4 * i + k]! - corner[k]!) > 12)) different++;
  return different / all;
}

test("what is packed: modules, types, licences, a text, and nothing else", () => {
  for (const name of ["core", "three"]) {
    const folder = join(modules, "@meshfront", name);
    const files = readdirSync(folder, { recursive: true, withFileTypes: true })
      .filter((entry) => entry.isFile())
      .map((entry) => join(entry.parentPath, entry.name).slice(folder.length + 1).replaceAll("\\", "/"));
    const known = [
      /^package\.json$/, /^README\.md$/, /^LICENSE-(MIT|APACHE)$/, /^dist\/[\w-]+\.(js|js\.map|d\.ts)$/,
      /^wasm\/meshfront_wasm(\.js|\.d\.ts|_bg\.wasm)$/,
    ];
    expect(files.filter((file) => !known.some((pattern) => pattern.test(file)))).toEqual([]);
    expect(files).toEqual(expect.arrayContaining(["README.md", "LICENSE-MIT", "LICENSE-APACHE", "dist/index.js", "dist/index.d.ts"]));
    for (const map of files.filter((file) => file.endsWith(".map"))) {
      expect(JSON.parse(readFileSync(join(folder, map), "utf8"))).toHaveProperty("sourcesContent");
    }
  }
});

test("a fresh Vite project: types, build, picture, picking, materials, shadows, events, and an end", async ({ page }) => {
  const project = join(home, "fresh");
  tsc(project);
  vite(project, "build");
  await open(page, (await serve(join(project, "dist"))).url);
  await page.waitForFunction(() => window.fresh?.settled());
  const [events, fractions] = await page.evaluate(() => [window.fresh.events, window.fresh.fractions] as const);
  expect(events.slice(0, 3)).toEqual(["load-base", "load", "front-settled"]);
  expect(fractions.filter((fraction) => fraction === 1)).toHaveLength(1);
  expect(fractions.at(-1)).toBe(1);
  expect(await drawnPart(page, "canvas", "packages-vite")).toBeGreaterThan(0.1);

  const picked = await page.evaluate(async () => {
    const { object, pick } = window.fresh;
    const hit = pick()!;
    return { distance: hit.distance, found: await object.inspect(hit.faceIndex!), info: object.info! };
  });
  expect(picked.distance).toBeGreaterThan(0);
  expect(picked.found!.error).toBeGreaterThan(0);
  expect(picked.found!.error).toBeLessThanOrEqual(picked.info.baseError);

  const [own, patched, shade] = await page.evaluate(() => window.fresh.materials());
  expect(own![0]).toBe(255);
  expect(own![1]).toBeGreaterThan(20);
  expect(patched).toEqual([0, 255, 0, 255]);
  expect(shade!.slice(0, 3)).not.toEqual([0, 0, 255]);

  const [lit, shaded] = await page.evaluate(() => window.fresh.shadows());
  expect(shaded).toBeLessThan(0.7 * lit);

  expect(page.workers()).toHaveLength(1);
  await page.evaluate(() => window.fresh.dispose());
  await expect.poll(() => page.workers().length).toBe(0);
});

test("the oldest three.js that is promised", async ({ page }) => {
  const project = join(home, "fresh");
  writeFileSync(join(project, "oldest.config.js"), 'export default { resolve: { alias: { three: "three-oldest" } } };');
  vite(project, "build", "--config", "oldest.config.js", "--outDir", "oldest", "--logLevel", "error");
  await open(page, (await serve(join(project, "oldest"))).url);
  await page.waitForFunction(() => window.fresh?.settled());
  expect(await page.evaluate(() => window.fresh.revision)).toBe("160");
  expect(await drawnPart(page, "canvas", "packages-oldest")).toBeGreaterThan(0.1);
  expect(await page.evaluate(() => window.fresh.pick()?.distance)).toBeGreaterThan(0);
  expect((await page.evaluate(() => window.fresh.materials()))[1]).toEqual([0, 255, 0, 255]);
  await page.evaluate(() => window.fresh.dispose());
  await expect.poll(() => page.workers().length).toBe(0);
});

test("Vite's development server finds worker and engine", async ({ page }) => {
  const args = [join(modules, "vite/bin/vite.js"), "--host", "127.0.0.1", "--port", "0"];
  const server: ChildProcess = spawn(process.execPath, args, { cwd: join(home, "fresh") });
  servers.push({ stop: () => void server.kill() });
  const url = await new Promise<string>((found) => {
    let said = "";
    server.stdout!.on("data", (text) => {
      // Without the colours.
      said += String(text).replace(/\u001b\[\d+m/g, "");
      const address = /http:\/\/127\.0\.0\.1:\d+\//.exec(said);
      if (address) found(address[0]);
    });
  });
  await open(page, url);
  await page.waitForFunction(() => window.fresh?.settled());
});

test("only what is used is bundled, and all of it is small", () => {
  const project = join(home, "legend");
  mkdirSync(project);
  writeFileSync(join(project, "index.html"), '<script type="module" src="/main.js"></script>');
  writeFileSync(join(project, "main.js"), 'import { RAMP_CSS } from "@meshfront/three";\ndocument.body.style.background = RAMP_CSS;\n');
  vite(project, "build", "--logLevel", "error");
  const assets = readdirSync(join(project, "dist/assets"));
  expect(assets).toHaveLength(1);
  expect(readFileSync(join(project, "dist/assets", assets[0]!)).length).toBeLessThan(3000);

  const shipped = ["core/dist", "core/wasm", "three/dist"].flatMap((folder) => {
    const at = join(modules, "@meshfront", folder);
    return readdirSync(at).filter((file) => /\.(js|wasm)$/.test(file)).map((file) => gzipSync(readFileSync(join(at, file))).length);
  });
  const bytes = shipped.reduce((sum, length) => sum + length, 0);
  console.log(`packages without three: ${bytes} bytes compressed`);
  expect(bytes).toBeLessThanOrEqual(350_000);
});

const said = (page: Page) => page.locator("#said, output, [role=status]").first();

test("a plain page without a bundler", async ({ page }) => {
  await open(page, (await serve(join(home, "plain"))).url);
  await expect(said(page)).toContainText("triangles are drawn");
  await page.locator("#picture").scrollIntoViewIfNeeded();
  expect(await drawnPart(page, "#picture", "packages-plain")).toBeGreaterThan(0.05);
  await page.locator("#picture").click();
  await expect(said(page)).toContainText("within");
  await page.locator("mesh-front").scrollIntoViewIfNeeded();
  await page.waitForFunction(() => document.querySelector("mesh-front")!.loaded);
  expect(await drawnPart(page, "mesh-front", "packages-element")).toBeGreaterThan(0.05);
});

test("packages from a server of another origin", async ({ page }) => {
  const elsewhere = await serve(home, true);
  const folder = join(home, "visitor");
  cpSync(join(web, "examples/plain"), folder, { recursive: true });
  copyFileSync(model, join(folder, "model.front"));
  const html = readFileSync(join(folder, "index.html"), "utf8");
  writeFileSync(join(folder, "index.html"), html.replaceAll("./node_modules/", `${elsewhere.url}node_modules/`));
  await open(page, (await serve(folder)).url);
  await expect(said(page)).toContainText("triangles are drawn");
});

for (const name of ["vite", "react-three-fiber"]) {
  test(`the example ${name} builds, draws, and tells what is picked`, async ({ page }) => {
    const project = join(home, name);
    tsc(project);
    vite(project, "build", "--logLevel", "error");
    await open(page, (await serve(join(project, "dist"))).url);
    await expect(said(page)).toContainText("triangles are drawn");
    expect(await drawnPart(page, "canvas", `packages-${name}`)).toBeGreaterThan(0.02);
    await page.locator("canvas").click();
    await expect(said(page)).toContainText(name === "vite" ? "The original surface is within" : "Picked");
  });
}

/** The element in a page of its own. */
async function openElement(page: Page, markup: string): Promise<void> {
  const folder = join(home, "plain");
  const html = readFileSync(join(folder, "index.html"), "utf8");
  const importMap = /<script type="importmap">[^]*?<\/script>/.exec(html)![0];
  writeFileSync(join(folder, "element.html"), `<!doctype html><html lang="en"><title>Element</title>${importMap}
    <style>:root { color-scheme: light dark } mesh-front { width: 400px; height: 300px }</style><main><h1>Element</h1>${markup}</main>
    <script type="module">import "@meshfront/three/element";</script></html>`);
  await open(page, `${(await serve(folder)).url}element.html`);
}
const element = <T>(page: Page, look: (element: MeshFrontElement) => T | Promise<T>): Promise<T> =>
  page.locator("mesh-front").first().evaluate(look as never) as Promise<T>;
const isSettled = (page: Page) =>
  page.waitForFunction(() => [...document.querySelectorAll("mesh-front")].every(({ object }) => object?.settled));

/** A grey picture. */
const POSTER = "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 4 3'%3E%3Cpath fill='%23888' d='M0 0h4v3H0z'/%3E%3C/svg%3E";

test("the element: name, poster, keys, mouse, and nothing for axe to say", async ({ page }) => {
  await openElement(page, `<mesh-front src="model.front" alt="A bumpy surface" camera-controls poster="${POSTER}"></mesh-front>`);
  const picture = page.getByRole("application", { name: "A bumpy surface" });
  await expect(picture).toBeVisible();
  await isSettled(page);
  await expect(page.locator("mesh-front .poster")).toHaveClass(/gone/);
  await expect(page.getByRole("progressbar")).toBeHidden();
  const distance = () => element(page, ({ camera, orbitControls }) => camera.position.distanceTo(orbitControls!.target));
  const bearing = () => element(page, ({ camera, orbitControls }) => orbitControls!.getAzimuthalAngle() + 0 * camera.position.x);
  const [start, away] = [await bearing(), await distance()];
  await picture.focus();
  await picture.press("ArrowRight");
  await expect.poll(bearing).toBeGreaterThan(start + 0.1);
  for (let i = 0; i < 4; i++) await picture.press("+");
  await expect.poll(distance).toBeLessThan(0.7 * away);
  await isSettled(page);
  await page.screenshot({ path: join(screenshots, "packages-element-keys.png") });
  await picture.press("Home");
  await expect.poll(distance).toBeGreaterThan(0.99 * away);
  const box = (await picture.boundingBox())!;
  await page.mouse.move(box.x + 200, box.y + 150);
  await page.mouse.down();
  await page.mouse.move(box.x + 320, box.y + 160, { steps: 4 });
  await page.mouse.up();
  await expect.poll(bearing).not.toBeCloseTo(start, 1);
  const hit = await element(page, (element) => {
    const { left, top } = element.getBoundingClientRect();
    return element.pick(left + 200, top + 150)?.distance;
  });
  expect(hit).toBeGreaterThan(0);
  const { violations } = await new AxeBuilder({ page }).analyze();
  expect(violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(" ")}`)).toEqual([]);
});

test("the element: attributes, failures, and leaving the page", async ({ page }) => {
  await openElement(page, '<mesh-front src="model.front"></mesh-front>');
  await isSettled(page);
  await expect(page.getByRole("img", { name: "3D model" })).toBeVisible();
  const triangles = () => element(page, ({ object }) => object!.stats!.triangles);
  const fine = await triangles();
  await element(page, (element) => { element.tolerance = 8; });
  await expect.poll(triangles).toBeLessThan(0.5 * fine);
  await element(page, (element) => { element.style.width = "200px"; element.style.height = "150px"; });
  await expect.poll(() => page.locator("mesh-front canvas").evaluate((canvas: HTMLCanvasElement) => canvas.width)).toBe(200);

  await element(page, (element) => { element.src = "nothing.front"; });
  await expect(page.getByRole("alert")).toContainText("does not exist");
  await element(page, (element) => { element.src = "model.front"; });
  await expect(page.getByRole("alert")).toBeHidden();
  await isSettled(page);

  expect(page.workers()).toHaveLength(1);
  await element(page, ({ budget }) => { budget.maxTriangles = 1000; });
  await expect.poll(triangles).toBeLessThanOrEqual(1000);
  // Moved within the page it goes on; taken out it ends; brought back it is there again, under the same budget.
  await element(page, (element) => document.querySelector("main")!.append(element));
  expect(await element(page, ({ loaded }) => loaded)).toBe(true);
  const gone = await page.evaluateHandle(() => {
    const element = document.querySelector("mesh-front")!;
    element.remove();
    return element;
  });
  await expect.poll(() => page.workers().length).toBe(0);
  expect(await gone.evaluate(({ loaded, object }) => [loaded, object === undefined])).toEqual([false, true]);
  await gone.evaluate((element) => document.querySelector("main")!.append(element));
  await isSettled(page);
  expect(await triangles()).toBeLessThanOrEqual(1000);
});

test("elements share worker, budget and context, and turn only where that is welcome", async ({ page }) => {
  const one = '<mesh-front src="model.front" auto-rotate auto-rotate-delay="0" rotation-per-second="60deg"></mesh-front>';
  await openElement(page, one.repeat(3) + '<div style="height: 3000px"></div>' + one);
  await page.waitForFunction(() => [...document.querySelectorAll("mesh-front")].slice(0, 3).every(({ loaded }) => loaded));
  expect(page.workers()).toHaveLength(1);
  expect(await page.evaluate(() => new Set([...document.querySelectorAll("mesh-front")].map(({ budget }) => budget)).size)).toBe(1);
  // What is far outside of the window is not even loaded.
  expect(await page.evaluate(() => [...document.querySelectorAll("mesh-front")].at(-1)!.object)).toBeUndefined();
  const x = () => element(page, ({ camera }) => camera.position.x);
  const start = await x();
  await expect.poll(x).not.toBeCloseTo(start, 3);
  await page.getByRole("button", { name: "Pause turning" }).first().click();
  const stopped = await x();
  const others = () => page.evaluate(() => document.querySelectorAll("mesh-front")[1]!.camera.position.x);
  const other = await others();
  await expect.poll(others).not.toBeCloseTo(other, 2);
  expect(await x()).toBe(stopped);
  // Out of sight nothing turns, and nothing is refined.
  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  await page.waitForFunction(() => document.querySelectorAll("mesh-front")[1]!.object!.frozen);
  const unseen = await others();
  await page.waitForFunction(() => [...document.querySelectorAll("mesh-front")].at(-1)!.loaded);
  expect(await others()).toBe(unseen);
  await page.evaluate(() => scrollTo(0, 0));
  await expect.poll(others).not.toBe(unseen);
  await page.emulateMedia({ reducedMotion: "reduce" });
  await expect(page.getByRole("button", { name: "Pause turning" }).first()).toBeHidden();
  const frames = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  await frames();
  const calm = await others();
  await frames();
  expect(await others()).toBe(calm);
});

test("the element: without WebGL it says so, and the poster stays", async ({ page }) => {
  await page.addInitScript(() => {
    const prototype = HTMLCanvasElement.prototype as unknown as { getContext(...a: any[]): RenderingContext | null };
    const { getContext } = prototype;
    prototype.getContext = function (...a) { return /webgl/.test(a[0]) ? null : getContext.apply(this, a); };
  });
  await openElement(page, `<mesh-front src="model.front" alt="A bumpy surface" poster="${POSTER}"></mesh-front>`);
  await expect(page.getByRole("alert")).toContainText("needs WebGL 2");
  await expect(page.locator("mesh-front img")).toBeVisible();
});

test("the element: a lost context comes back", async ({ page }) => {
  await page.addInitScript(() => {
    const prototype = HTMLCanvasElement.prototype as unknown as { getContext(...a: any[]): RenderingContext | null };
    const { getContext } = prototype;
    prototype.getContext = function (...a) {
      const context = getContext.apply(this, a);
      if (a[0] === "webgl2") Object.assign(window, { gl: context });
      return context;
    };
  });
  await openElement(page, '<mesh-front src="model.front" camera-controls></mesh-front>');
  await isSettled(page);
  const before = await drawnPart(page, "mesh-front", "packages-element-before");
  expect(before).toBeGreaterThan(0.05);
  await page.evaluate(() => {
    const { gl } = window as unknown as { gl: WebGL2RenderingContext };
    const lose = gl.getExtension("WEBGL_lose_context")!;
    lose.loseContext();
    Object.assign(window, { giveBack: () => lose.restoreContext() });
  });
  // The last picture stays.
  expect(await drawnPart(page, "mesh-front", "packages-element-lost")).toBeGreaterThan(0.9 * before);
  const restored = page.evaluate(() => new Promise<void>((done) => {
    const { gl, giveBack } = window as unknown as { gl: WebGL2RenderingContext; giveBack: () => void };
    gl.canvas.addEventListener("webglcontextrestored", () => done());
    giveBack();
  }));
  await restored;
  await page.locator("mesh-front canvas").press("ArrowRight");
  await isSettled(page);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  expect(await drawnPart(page, "mesh-front", "packages-element-restored")).toBeGreaterThan(0.8 * before);
});
