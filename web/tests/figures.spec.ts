/**
 * What the packages cost a page, measured and printed; nothing is asserted.
 *
 *     MESHFRONT_FIGURES=dragon.front MESHFRONT_MINUTES=2 npm run figures
 *
 * The front is that of 1280 × 720 pixels at 1 px. Once the first picture is there nothing is drawn any more: without a graphics card,
 * drawing takes most of both cores, and is not what is to be measured. Uploads go on.
 */

import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { test, type Page } from "@playwright/test";
import type { FlyByReport } from "../core/src/index.js";
import { binary } from "./files.js";
import { serveFolder } from "./serve.js";

const file = process.env.MESHFRONT_FIGURES;
const minutes = Number(process.env.MESHFRONT_MINUTES ?? 1);

/** Milliseconds and so on, as the page has measured them. */
type Figures = Record<string, number>;
declare const window: { figures(minutes: number): Promise<Figures>; flyBy(): Promise<FlyByReport> };
/** The flight is compared so often, the browser's worker and the program taking turns. */
const ROUNDS = 3;

/** Runs in the page. */
const PAGE = /* js */ `
import { MeshfrontObject } from "@meshfront/three";
import { BufferAttribute, HemisphereLight, Mesh, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";

/** Time in what the packages do on this thread, and bytes that go to the card, since the last look. */
const spent = { ms: 0, bytes: 0, calls: 0, whole: 0, triangles: 0 };
const timed = (owner, name, count) => {
  const original = owner[name];
  // Five arguments at most, and no list of them: it is called hundreds of times a frame.
  owner[name] = function (a, b, c, d, e) {
    const start = performance.now();
    e === undefined ? original.call(this, a, b, c) : original.call(this, a, b, c, d, e);
    spent.ms += performance.now() - start;
    count(a, b, c, d, e);
  };
};
timed(WebGL2RenderingContext.prototype, "bufferSubData", (target, at, data, from, length) => {
  spent.bytes += length === undefined ? data.byteLength : length * data.BYTES_PER_ELEMENT;
  spent.calls++;
});
timed(WebGL2RenderingContext.prototype, "bufferData", (target, data) => { spent.whole += data.byteLength ?? 0; });
const onmessage = Object.getOwnPropertyDescriptor(Worker.prototype, "onmessage");
Object.defineProperty(Worker.prototype, "onmessage", {
  ...onmessage,
  set(handler) {
    onmessage.set.call(this, handler && ((event) => {
      const start = performance.now();
      handler(event);
      // The answer is applied in microtasks, a promise or two later.
      let later = 8;
      const wait = () => { if (later-- > 0) queueMicrotask(wait); else spent.ms += performance.now() - start; };
      queueMicrotask(wait);
    }));
  },
});
const longTasks = [];
new PerformanceObserver((list) => longTasks.push(...list.getEntries())).observe({ type: "longtask" });

const renderer = new WebGLRenderer({ canvas: document.querySelector("canvas") });
renderer.setSize(64, 36, false);
const scene = new Scene();
const camera = new PerspectiveCamera(40, 1280 / 720, 0.1, 1000);
const object = new MeshfrontObject("model.front");
const at = {};
const told = (name) => { at[name] ??= performance.now(); };
scene.add(object, new HemisphereLight());
object.setResolution(camera, 1280, 720);

const orbit = (angle, distance, height = 0.3) => {
  const { center, radius } = object.geometry.boundingSphere;
  camera.position.set(Math.sin(angle), height, Math.cos(angle)).multiplyScalar(distance * radius).add(center);
  camera.lookAt(center);
  [camera.near, camera.far] = [0.01 * radius, 20 * radius];
  camera.updateProjectionMatrix();
};
object.addEventListener("load-base", () => { orbit(0, 1.8); renderer.render(scene, camera); told("base"); });
object.addEventListener("load", () => { orbit(0, 1.8); object.update(); told("load"); });
// Once: what a page draws of its own accord is none of the packages' time.
const first = () => {
  object.removeEventListener("front-settled", first);
  renderer.render(scene, camera);
  told("settled");
};
object.addEventListener("front-settled", first);

const frame = () => new Promise((next) => requestAnimationFrame(next));
const settled = async () => { while (!object.settled) { object.update(); await frame(); renderer.render(scene, camera); } };
const percentile = (all, part) => [...all].sort((a, b) => a - b)[Math.min(all.length - 1, Math.floor(part * all.length))];

/** Triangles whose corners, or the place of a corner, are others than before. */
function countChanges() {
  const { client } = object.budget;
  const adapt = client.adapt.bind(client);
  client.adapt = async (...a) => {
    const frames = await adapt(...a);
    for (const { vertices, triangles, triangleSlots } of frames ?? []) {
      const { array } = object.geometry.index;
      const changed = new Set();
      let from = 0;
      for (let i = 0; i < triangles.ranges.length; i += 2) {
        for (let k = 0; k < triangles.ranges[i + 1]; k++, from += 3) {
          const t = triangles.ranges[i] + k;
          if ([0, 1, 2].some((c) => array[3 * t + c] !== triangles.corners[from + c])) changed.add(t);
        }
      }
      spent.triangles += changed.size;
    }
    return frames;
  };
}

async function fly(seconds, sample) {
  const [times, all] = [[], []];
  const start = performance.now();
  const sampled = [];
  let next = start;
  while (performance.now() - start < 1000 * seconds) {
    const t = (performance.now() - start) / 1000;
    orbit(0.5 * t, 1.6 + 0.8 * Math.sin(0.7 * t), 0.4 * Math.sin(0.3 * t));
    const before = performance.now();
    object.update();
    spent.ms += performance.now() - before;
    const drawing = performance.now();
    const uploaded = spent.ms;
    renderer.render(scene, camera);
    const rest = performance.now() - drawing - (spent.ms - uploaded);
    await frame();
    // What a long flight is asked for is memory: it keeps nothing of every frame.
    if (!sample) {
      times.push(spent.ms);
      all.push(spent.ms + rest);
    }
    spent.ms = 0;
    if (sample && performance.now() > next) {
      sampled.push(await sample());
      next += 5000;
    }
  }
  return { times, all, sampled };
}

window.flyBy = () => object.flyBy();
window.figures = async (minutes) => {
  await object.ready;
  await settled();
  WebGL2RenderingContext.prototype.drawElements = () => {};
  const found = { "base mesh on screen, ms": at.base, "open, ms": at.load, "first settled, ms": at.settled };

  // Picking at 1 px.
  const raycaster = new Raycaster();
  const rays = Array.from({ length: 600 }, () => new Vector2(1.2 * Math.random() - 0.6, 1.2 * Math.random() - 0.6));
  const picking = rays.map((ray) => {
    raycaster.setFromCamera(ray, camera);
    const start = performance.now();
    raycaster.intersectObject(object);
    return performance.now() - start;
  }).slice(100);
  found["triangles at 1 px"] = object.stats.triangles;
  found["picking, median ms"] = percentile(picking, 0.5);
  found["picking, p99 ms"] = percentile(picking, 0.99);

  // Once around, so that buffers are as long as they have to be.
  await fly(14);
  longTasks.length = 0;
  Object.assign(spent, { ms: 0, bytes: 0, calls: 0, whole: 0, triangles: 0 });
  const { times, all } = await fly(20);
  found["fly-by frames"] = times.length;
  found["script per frame, median ms"] = percentile(times, 0.5);
  found["script per frame, p99 ms"] = percentile(times, 0.99);
  found["script per frame, most ms"] = Math.max(...times);
  found["the same with all of three.js, median ms"] = percentile(all, 0.5);
  found["the same with all of three.js, p99 ms"] = percentile(all, 0.99);
  found["long tasks in it"] = longTasks.length;
  await window.trace(true);
  await fly(10);
  Object.assign(found, await window.trace(false));
  countChanges();
  Object.assign(spent, { ms: 0, bytes: 0, calls: 0, whole: 0, triangles: 0 });
  const { times: frames } = await fly(10);
  found["changed triangles per frame"] = spent.triangles / frames.length;
  found["upload per changed triangle, bytes"] = spent.bytes / spent.triangles;
  found["upload per frame, kB"] = spent.bytes / 1000 / frames.length;
  found["upload calls per frame"] = spent.calls / frames.length;
  found["buffers made anew, kB"] = spent.whole / 1000;

  const jumps = [];
  for (const [angle, distance] of [[0, 5], [3, 1.2], [1, 4], [4.5, 1.1], [2, 1.5]]) {
    orbit(angle, distance);
    const start = performance.now();
    object.update();
    await frame();
    await settled();
    jumps.push(performance.now() - start);
  }
  found["settled after a jump, median ms"] = percentile(jumps, 0.5);
  found["settled after a jump, most ms"] = Math.max(...jumps);

  if (minutes > 0) {
    const { sampled } = await fly(60 * minutes, async () => {
      const heap = await window.heap();
      const { engineBytes, bufferBytes } = await object.budget.memory();
      return { engineBytes, bufferBytes, heap, geometries: renderer.info.memory.geometries };
    });
    const [first, last] = [sampled[Math.min(2, sampled.length - 1)], sampled.at(-1)];
    for (const key of Object.keys(first)) {
      const unit = key === "geometries" ? 1 : 1e6;
      found["memory, " + key + " at the start"] = first[key] / unit;
      found["memory, " + key + " at the end"] = last[key] / unit;
      found["memory, " + key + " at most"] = Math.max(...sampled.map((s) => s[key])) / unit;
    }
  }
  return found;
};
`;

test("figures", async ({ page, browser }) => {
  test.skip(file === undefined, "MESHFRONT_FIGURES names no .front file");
  test.setTimeout((minutes + 8) * 60_000);
  const folder = mkdtempSync(join(tmpdir(), "meshfront-figures-"));
  copyFileSync(file!, join(folder, "model.front"));
  symlinkSync(fileURLToPath(new URL("../node_modules", import.meta.url)), join(folder, "node_modules"), "junction");
  writeFileSync(join(folder, "page.js"), PAGE);
  const imports = {
    three: "./node_modules/three/build/three.module.js",
    "@meshfront/core": "./node_modules/@meshfront/core/dist/index.js",
    "@meshfront/three": "./node_modules/@meshfront/three/dist/index.js",
  };
  writeFileSync(join(folder, "index.html"), `<!doctype html><title>Figures</title><canvas></canvas>
    <script type="importmap">${JSON.stringify({ imports })}</script><script type="module" src="page.js"></script>`);
  const server = await serveFolder(folder);
  page.on("pageerror", (error) => console.log(error));
  // What lies in the heap is what is used, not what was.
  await page.exposeFunction("trace", async (on: boolean) => {
    if (!on) return processorTime(JSON.parse((await browser.stopTracing()).toString()).traceEvents);
    return browser.startTracing(page, { categories: ["-*", "devtools.timeline", "v8"] });
  });
  const devtools = await page.context().newCDPSession(page);
  await page.exposeFunction("heap", async () => {
    await devtools.send("HeapProfiler.collectGarbage");
    return (await devtools.send("Runtime.getHeapUsage")).usedSize;
  });
  try {
    await page.goto(server.url);
    await page.waitForFunction(() => "figures" in window);
    const figures = await page.evaluate((minutes) => window.figures(minutes), minutes);
    Object.assign(figures, await ratio(page));
    for (const [name, value] of Object.entries(figures)) console.log(`${name.padEnd(44)} ${Number(value.toPrecision(4)).toLocaleString("en")}`);
  } finally {
    server.stop();
    rmSync(folder, { recursive: true, force: true });
  }
});

/** An event of the browser's trace, microseconds: by the clock, and on a processor. */
interface Traced {
  name: string;
  ph: string;
  pid: number;
  tid: number;
  ts: number;
  dur: number;
  tdur?: number;
}

/**
 * Script of a frame, its messages and what is collected meanwhile: by the clock, and on a processor. The clock also runs while other
 * processes have the cores, the one that draws in software among them. All of three.js and of this page's own script is in it.
 */
function processorTime(events: Traced[]): Figures {
  const isFrame = ({ name }: Traced) => name === "FireAnimationFrame";
  const frames = new Map<string, number>();
  const thread = ({ pid, tid }: Traced) => `${pid} ${tid}`;
  for (const event of events) if (isFrame(event)) frames.set(thread(event), (frames.get(thread(event)) ?? 0) + 1);
  const [main] = [...frames].sort(([, a], [, b]) => b - a)[0]!;
  const script = /^(FireAnimationFrame|FunctionCall|RunMicrotasks|v8\.callFunction|MinorGC|MajorGC)$/;
  const mine = events.filter((event) => thread(event) === main && event.ph === "X" && script.test(event.name)).sort((a, b) => a.ts - b.ts);
  const [clock, processor]: [number[], number[]] = [[], []];
  let end = 0;
  for (const event of mine) {
    // What lies in another one is counted there.
    if (event.ts < end) continue;
    end = event.ts + event.dur;
    if (isFrame(event)) (clock.push(0), processor.push(0));
    if (clock.length === 0) continue;
    clock[clock.length - 1]! += event.dur / 1000;
    processor[processor.length - 1]! += (event.tdur ?? 0) / 1000;
  }
  const part = (all: number[], p: number) => [...all].sort((a, b) => a - b)[Math.min(all.length - 1, Math.floor(p * all.length))]!;
  return {
    "all script, traced, median ms": part(clock, 0.5),
    "all script, traced, p99 ms": part(clock, 0.99),
    "of that on a processor, median ms": part(processor, 0.5),
    "of that on a processor, p99 ms": part(processor, 0.99),
  };
}

/** The same flight in the worker and in the program, mean milliseconds a frame: medians, and their ratio. */
async function ratio(page: Page): Promise<Figures> {
  const [worker, native]: [number[], number[]] = [[], []];
  for (let round = 0; round < ROUNDS; round++) {
    worker.push(middle(await Promise.all([0, 1, 2].map(() => page.evaluate(async () => (await window.flyBy()).meanMs)))));
    native.push(JSON.parse(execFileSync(binary, ["bench", file!, "--json"], { encoding: "utf8" })).fly_by.ms.mean);
  }

  console.log(`flights, ms per frame: worker ${worker.map((ms) => ms.toFixed(3))}, program ${native.map((ms) => ms.toFixed(3))}`);
  return {
    "flight in the worker, ms per frame": middle(worker),
    "flight in the program, ms per frame": middle(native),
    "flight, worker / native": middle(worker) / middle(native),
  };
}

function middle(all: number[]): number {
  return [...all].sort((a, b) => a - b)[Math.floor(all.length / 2)]!;
}
