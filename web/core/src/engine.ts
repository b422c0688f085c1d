/** The engine: a thin wrapper around the WebAssembly module, in the words of `view.ts`. */

import init, { Session } from "../wasm/meshfront_wasm.js";
import type { Engine } from "./host.js";
import type { ModelView } from "./protocol.js";
import type { FlyByReport, FrameUpdate, ModelInfo, Region } from "./view.js";

const NO_LIMIT = 0xffffffff;

/** Starts WebAssembly (once); `module` is where the module's bytes are, if not beside this file. */
export async function startEngine(module?: BufferSource): Promise<Engine> {
  await init({ module_or_path: module ?? new URL("../wasm/meshfront_wasm_bg.wasm", import.meta.url) });
  const session = new Session();
  return {
    open(bytes, name) {
      const start = performance.now();
      const model = session.open(bytes, name);
      return { model, info: infoOf(session, model, bytes.length, performance.now() - start) };
    },
    adapt(views, { maxTriangles, deadlineMs }) {
      for (const view of views) look(session, view);
      session.adapt(Math.min(maxTriangles, NO_LIMIT), Math.round(Math.min(1000 * deadlineMs, NO_LIMIT)));
      return views.map(({ model }) => frameOf(session, model));
    },
    flyBy: (model) => flyBy(session, model),
    close: (model) => session.close(model),
  };
}

function infoOf(session: Session, model: number, bytes: number, decodeMs: number): ModelInfo {
  const info = session.info(model);
  const [x0, y0, z0, x1, y1, z1] = info.bounds as unknown as [number, number, number, number, number, number];
  const up = [...info.up] as unknown as ModelInfo["up"];
  const { updates, sourceVertices, sourceTriangles, baseTriangles, floorError, hasColors } = info;
  info.free();
  return {
    updates, sourceVertices, sourceTriangles, baseTriangles, floorError, hasColors, bytes, decodeMs, up,
    min: [x0, y0, z0],
    max: [x1, y1, z1],
  };
}

function look(session: Session, { model, view }: ModelView): void {
  const { eye, target, up, fovY, width, height, near, tolerancePx, frustum, orientation } = view;
  const camera = Float32Array.of(...eye, ...target, ...up, fovY, width, height, near);
  session.look(model, camera, tolerancePx, frustum, orientation, regionOf(view.region));
}

function frameOf(session: Session, model: number): FrameUpdate {
  const frame = session.frame(model);
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

function flyBy(session: Session, model: number): FlyByReport {
  const flight = session.flyBy(model);
  const { frames, updatesPerFrame, activeTriangles, evaluationsPerFrame, meanMs, p50Ms, p99Ms, maxMs } = flight;
  flight.free();
  return { frames, updatesPerFrame, activeTriangles, evaluationsPerFrame, meanMs, p50Ms, p99Ms, maxMs };
}
