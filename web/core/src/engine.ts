/** The engine: a thin wrapper around the WebAssembly module, in the words of `view.ts`. */

import init, { baseOf, Session, Shade as ShadeNumber } from "../wasm/meshfront_wasm.js";
import { MeshfrontError } from "./errors.js";
import type { Engine } from "./host.js";
import type { FlyByReport, FrameUpdate, ModelInfo, Region, Shade, Vec3, View } from "./view.js";

const NO_LIMIT = 0xffffffff;
const PAGE_BYTES = 1 << 16;
/** A browser that does not give this much more, half a gigabyte, was out of memory. */
const AMPLE_PAGES = (512 << 20) / PAGE_BYTES;

/** Starts WebAssembly (once); `module` is where the module's bytes are, if not beside this file. */
export async function startEngine(module?: BufferSource): Promise<Engine> {
  const { memory } = await init({ module_or_path: module ?? new URL("../wasm/meshfront_wasm_bg.wasm", import.meta.url) });
  const session = new Session();
  return {
    baseOf(start) {
      const base = baseOf(start);
      if (!base) return undefined;
      const { positions, normals, colors, triangles } = base;
      const [min, max] = corners(base.bounds);
      base.free();
      return { positions, normals, colors, triangles, min, max };
    },
    open(bytes, name, onProgress) {
      const start = performance.now();
      const model = guarded(memory, name, () => session.open(bytes, name, onProgress));
      return { model, info: infoOf(session, model, bytes.length, performance.now() - start) };
    },
    duplicate(of) {
      const model = session.duplicate(of);
      return { model, info: infoOf(session, model, 0, 0) };
    },
    adapt(views, { maxTriangles, maxBytes, deadlineMs }) {
      for (const { model, views: each, shade } of views) {
        for (const view of each) look(session, model, view);
        session.shade(model, shade && SHADES[shade]);
      }
      const deadlineUs = Math.round(Math.min(1000 * deadlineMs, NO_LIMIT));
      return guarded(memory, "the front", () => {
        session.adapt(Math.min(maxTriangles, NO_LIMIT), maxBytes, deadlineUs);
        return views.map(({ model, shade }) => frameOf(session, model, shade));
      });
    },
    inspect(model, frame, triangle) {
      const found = session.lastFrame(model) === frame ? session.inspect(model, triangle) : undefined;
      if (!found) return undefined;
      const { update, error, level, coneAngle } = found;
      const [x, y, z, radius] = found.sphere as unknown as [number, number, number, number];
      found.free();
      return { update, error, level, coneAngle, center: [x, y, z], radius };
    },
    spheres: (model, most) => session.spheres(model, most),
    memory: () => memory.buffer.byteLength,
    flyBy: (model) => flyBy(session, model),
    close: (model) => session.close(model),
  };
}

const SHADES: Record<Shade, ShadeNumber> = {
  error: ShadeNumber.Error,
  cone: ShadeNumber.Cone,
  age: ShadeNumber.Age,
};

/** What breaks down for want of memory says so. */
function guarded<T>(memory: WebAssembly.Memory, name: string, act: () => T): T {
  try {
    return act();
  } catch (cause) {
    const refused = cause instanceof RangeError && /alloc|memory|length/i.test(cause.message);
    if (refused || (cause instanceof WebAssembly.RuntimeError && isFull(memory))) {
      throw new MeshfrontError("memory", `${name} needs more memory than the browser gives`, { cause });
    }
    throw cause;
  }
}

function isFull(memory: WebAssembly.Memory): boolean {
  try {
    memory.grow(AMPLE_PAGES);
    return false;
  } catch {
    return true;
  }
}

function corners(bounds: Float32Array): [Vec3, Vec3] {
  const [x0, y0, z0, x1, y1, z1] = bounds as unknown as [number, number, number, number, number, number];
  return [[x0, y0, z0], [x1, y1, z1]];
}

function infoOf(session: Session, model: number, bytes: number, decodeMs: number): ModelInfo {
  const info = session.info(model);
  const [min, max] = corners(info.bounds);
  const up = [...info.up] as unknown as ModelInfo["up"];
  const {
    model: kind, updates, sourceVertices, sourceTriangles, baseTriangles, floorError, baseError, hierarchyBytes, hasColors,
  } = info;
  info.free();
  return {
    model: kind, updates, sourceVertices, sourceTriangles, baseTriangles, floorError, baseError, hierarchyBytes, hasColors,
    bytes, decodeMs, up, min, max,
  };
}

function look(session: Session, model: number, view: View): void {
  const { eye, target, up, fovY, width, height, near, tolerancePx, frustum, orientation } = view;
  const camera = Float32Array.of(...eye, ...target, ...up, fovY, width, height, near);
  session.look(model, camera, tolerancePx, frustum, orientation, regionOf(view.region));
}

function frameOf(session: Session, model: number, by: Shade | undefined): FrameUpdate {
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
  const shade = frame.takeShade();
  const columns = [positions, normals, colors, levels, triangles.corners];
  const update: FrameUpdate = {
    frame: frame.frame,
    vertexSlots: frame.vertexSlots,
    triangleSlots: frame.triangleSlots,
    vertexCapacity: frame.vertexCapacity,
    triangleCapacity: frame.triangleCapacity,
    vertices,
    triangles,
    stats: {
      triangles: frame.triangles,
      vertices: frame.vertices,
      refined: frame.refined,
      coarsened: frame.coarsened,
      evaluations: frame.evaluations,
      engineMs: frame.engineMs,
      gatherMs: frame.gatherMs,
      settled: frame.settled,
      budgetBound: frame.budgetBound,
      byteBound: frame.byteBound,
      errorPx: frame.errorPx,
      uploadBytes: columns.reduce((sum, column) => sum + column.byteLength, 0),
      frontBytes: frame.frontBytes,
    },
    ...(by && shade.length > 0 ? { shade: { by, values: shade } } : {}),
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
