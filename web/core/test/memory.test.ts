/** The real module where memory ends. */

import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { startEngine } from "../src/engine.js";
import { MeshfrontError } from "../src/errors.js";
import { limited } from "./limited.js";

const module = readFileSync(new URL("../wasm/meshfront_wasm_bg.wasm", import.meta.url));
const front = readFileSync(new URL("../../../testdata/front/v1-knot-lossless-painted.front", import.meta.url));
const MOST = 12e6;

test("fronts are made until memory ends; then they stay as they are, and nothing breaks down", async () => {
  const engine = await startEngine(limited(module, MOST));
  const { model, info } = engine.open(0, front, "first", () => {});
  const center = info.min.map((low, i) => (low + info.max[i]!) / 2) as [number, number, number];
  const radius = Math.hypot(...info.max.map((high, i) => high - center[i]!));
  const look = (group: number, model: number, tolerancePx: number) => engine.adapt(group, [{
    model,
    views: [{
      eye: [center[0], center[1], center[2] + 2 * radius], target: center, up: [0, 1, 0], fovY: 0.8, width: 800, height: 600, near: 0.01 * radius,
      tolerancePx, frustum: false, orientation: false,
    }],
  }], { maxTriangles: Infinity, maxBytes: Infinity, deadlineMs: Infinity })[0]!.stats;
  const free = look(0, model, 5);
  expect(free).toMatchObject({ budgetBound: false, byteBound: false, settled: true });

  const fronts: number[] = [];
  let failure: unknown;
  for (let i = 0; i < 10_000 && !failure; i++) {
    try {
      fronts.push(engine.duplicate(1, model).model);
    } catch (thrown) {
      failure = thrown;
    }
  }
  expect(MeshfrontError.from(failure)).toMatchObject({ kind: "memory", message: "another front needs more memory than the browser gives" });
  expect(engine.memory()).toBeLessThanOrEqual(MOST);
  // Whoever it was to be a front of still has its own, and goes on with it.
  expect(look(0, model, 6).triangles).toBeLessThan(free.triangles);
  expect(look(0, model, 5).triangles).toBe(free.triangles);

  const last = fronts.find((front) => look(1, front, 0).byteBound)!;
  const bound = look(1, last, 0);
  expect(bound).toMatchObject({ byteBound: true, settled: true });
  expect(bound.triangles).toBeLessThan(info.sourceTriangles);
  expect(engine.memory()).toBeLessThanOrEqual(MOST);
  // With room again it goes on.
  for (const front of fronts) if (front !== last) engine.close(front);
  expect(look(1, last, 0)).toMatchObject({ triangles: info.sourceTriangles, byteBound: false, settled: true });
});

test("a model that does not fit is told apart from a damaged one", async () => {
  const engine = await startEngine(module);
  let failure: unknown;
  for (let i = 0; i < 1000 && !failure; i++) {
    try {
      engine.open(0, front, "scan", () => {});
    } catch (thrown) {
      failure = thrown;
    }
  }
  const { kind, message, remedy } = MeshfrontError.from(failure);
  expect([kind, message]).toEqual(["memory", "scan needs more memory than the browser gives"]);
  expect(remedy).not.toBe("");
});
