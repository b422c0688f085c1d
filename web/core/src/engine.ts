/** The engine: a thin wrapper around the WebAssembly module, in the words of `view.ts`. */

import init, { Model } from "../wasm/meshfront_wasm.js";
import type { Engine } from "./host.js";
import type { FlyByReport, FrameUpdate, ModelInfo, Region, View } from "./view.js";

const NO_LIMIT = 0xffffffff;

/** Starts WebAssembly (once) and reads a `.front` file; `module` is where the module's bytes are, if not beside this file. */
export async function loadEngine(bytes: Uint8Array, name: string, module?: BufferSource): Promise<Engine> {
  await init({ module_or_path: module ?? new URL("../wasm/meshfront_wasm_bg.wasm", import.meta.url) });
  const start = performance.now();
  const model = new Model(bytes, name);
  const decodeMs = performance.now() - start;
  return { info: infoOf(model, bytes.length, decodeMs), adapt: (view) => adapt(model, view), flyBy: () => flyBy(model) };
}

function infoOf(model: Model, bytes: number, decodeMs: number): ModelInfo {
  const [x0, y0, z0, x1, y1, z1] = model.bounds as unknown as [number, number, number, number, number, number];
  const { updates, sourceVertices, sourceTriangles, baseTriangles, floorError, hasColors } = model;
  return {
    updates, sourceVertices, sourceTriangles, baseTriangles, floorError, hasColors, bytes, decodeMs,
    min: [x0, y0, z0],
    max: [x1, y1, z1],
    up: [...model.up] as unknown as ModelInfo["up"],
  };
}

function adapt(model: Model, view: View): FrameUpdate {
  const { eye, target, up, fovY, width, height, near } = view;
  const camera = Float32Array.of(...eye, ...target, ...up, fovY, width, height, near);
  const frame = model.adapt(
    camera,
    view.tolerancePx,
    Math.min(view.maxTriangles, NO_LIMIT),
    Math.round(Math.min(1000 * view.deadlineMs, NO_LIMIT)),
    view.frustum,
    view.orientation,
    regionOf(view.region),
  );
  const vertices = {
    ranges: frame.takeVertexRanges(),
    positions: frame.takePositions(),
    normals: frame.takeNormals(),
    colors: frame.takeColors(),
    levels: frame.takeLevels(),
  };
  const triangles = { ranges: frame.takeTriangleRanges(), corners: frame.takeCorners() };
  const { positions, normals, colors, levels } = vertices;
  const columns = [positions, normals, colors, levels, triangles.corners];
  const update: FrameUpdate = {
    vertexSlots: frame.vertexSlots,
    triangleSlots: frame.triangleSlots,
    vertices,
    triangles,
    stats: {
      triangles: frame.triangles,
      refined: frame.refined,
      coarsened: frame.coarsened,
      evaluations: frame.evaluations,
      engineMs: frame.engineMs,
      gatherMs: frame.gatherMs,
      settled: frame.settled,
      budgetBound: frame.budgetBound,
      errorPx: frame.errorPx,
      uploadBytes: columns.reduce((sum, column) => sum + column.byteLength, 0),
    },
  };
  frame.free();
  return update;
}

function regionOf(region: Region | undefined): Float32Array {
  if (!region) return new Float32Array();
  const { shape, outsideError } = region;
  const place: readonly number[] = "min" in shape ? [...shape.min, ...shape.max] : [...shape.center, shape.radius];
  return Float32Array.of(...place, outsideError);
}

function flyBy(model: Model): FlyByReport {
  const flight = model.flyBy();
  const { frames, updatesPerFrame, activeTriangles, evaluationsPerFrame, meanMs, p50Ms, p99Ms, maxMs } = flight;
  flight.free();
  return { frames, updatesPerFrame, activeTriangles, evaluationsPerFrame, meanMs, p50Ms, p99Ms, maxMs };
}
