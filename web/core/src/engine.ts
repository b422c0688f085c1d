/** The engine: a thin wrapper around the WebAssembly module, in the words of `view.ts`. */

import init, { baseOf, Session, Shade as ShadeNumber } from "../wasm/meshfront_wasm.js";
import { MeshfrontError } from "./errors.js";
import type { Engine } from "./host.js";
import type { BaseMesh, FlyByReport, FrameUpdate, ModelInfo, Region, Shade, Vec3, View } from "./view.js";

const NO_LIMIT = 0xffffffff;
const PAGE_BYTES = 1 << 16;
/** A browser that does not give this much more, half a gigabyte, was out of memory. */
const AMPLE_PAGES = (512 << 20) / PAGE_BYTES;

/** Starts WebAssembly (once); `module` is where the module's bytes are, if not beside this file. */
export async function startEngine(module?: BufferSource): Promise<Engine> {
  const { memory } = await init({ module_or_path: module ?? new URL("../wasm/meshfront_wasm_bg.wasm", import.meta.url) });
  const sessions = new Map<number, Session>();
  const places = new Map<number, Place>();
  let models = 0;
  const sessionOf = (group: number) => {
    const session = sessions.get(group) ?? new Session();
    sessions.set(group, session);
    return session;
  };
  const placeOf = (model: number) => {
    const place = places.get(model);
    if (!place) throw new RangeError("no such model is open");
    return place;
  };
  const added = (place: Place, bytes: number, decodeMs: number) => {
    const model = models++;
    places.set(model, place);
    return { model, info: infoOf(place, bytes, decodeMs) };
  };
  return {
    baseOf(start) {
      const base = baseOf(start);
      if (!base) return undefined;
      const { positions, normals, colors, triangles } = base;
      const [min, max] = corners(base.bounds);
      const up = [...base.up] as unknown as BaseMesh["up"];
      base.free();
      return { positions, normals, colors, triangles, min, max, up };
    },
    open(group, bytes, name, onProgress) {
      const start = performance.now();
      const session = sessionOf(group);
      const number = guarded(memory, name, () => session.open(bytes, name, onProgress));
      return added({ session, number }, bytes.length, performance.now() - start);
    },
    duplicate(group, model) {
      const session = sessionOf(group);
      const from = placeOf(model);
      const number = guarded(memory, "another front", () => session.join(from.session.another(from.number)));
      return added({ session, number }, 0, 0);
    },
    adapt(group, views, { maxTriangles, maxBytes, deadlineMs }) {
      const session = sessionOf(group);
      const asked = views.map(({ model, ...view }) => ({ ...view, place: placeOf(model) }));
      if (asked.some(({ place }) => place.session !== session)) throw new RangeError("a model of another group");
      for (const { place, views: each, shade } of asked) {
        for (const view of each) look(place, view);
        session.shade(place.number, shade && SHADES[shade]);
      }
      const deadlineUs = Math.round(Math.min(1000 * deadlineMs, NO_LIMIT));
      return guarded(memory, "the front", () => {
        session.adapt(Math.min(maxTriangles, NO_LIMIT), maxBytes, deadlineUs);
        return asked.map(({ place, shade }) => frameOf(place, shade));
      });
    },
    inspect(model, frame, triangle) {
      const { session, number } = placeOf(model);
      const found = session.lastFrame(number) === frame ? session.inspect(number, triangle) : undefined;
      if (!found) return undefined;
      const { update, error, level, coneAngle } = found;
      const [x, y, z, radius] = found.sphere as unknown as [number, number, number, number];
      found.free();
      return { update, error, level, coneAngle, center: [x, y, z], radius };
    },
    spheres(model, most) {
      const { session, number } = placeOf(model);
      return session.spheres(number, most);
    },
    memory: () => memory.buffer.byteLength,
    flyBy: (model) => flyBy(placeOf(model)),
    close(model) {
      const place = places.get(model);
      places.delete(model);
      place?.session.close(place.number);
    },
    leave(group) {
      const session = sessions.get(group);
      sessions.delete(group);
      for (const [model, place] of places) if (place.session === session) places.delete(model);
      session?.free();
    },
  };
}

/** Where a model is. */
interface Place {
  session: Session;
  number: number;
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

function infoOf({ session, number }: Place, bytes: number, decodeMs: number): ModelInfo {
  const info = session.info(number);
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

function look({ session, number }: Place, view: View): void {
  const { eye, target, up, fovY, width, height, near, tolerancePx, frustum, orientation } = view;
  const camera = Float32Array.of(...eye, ...target, ...up, fovY, width, height, near);
  session.look(number, camera, tolerancePx, frustum, orientation, regionOf(view.region));
}

function frameOf({ session, number }: Place, by: Shade | undefined): FrameUpdate {
  const frame = session.frame(number);
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

function flyBy({ session, number }: Place): FlyByReport {
  const flight = session.flyBy(number);
  const { frames, updatesPerFrame, activeTriangles, evaluationsPerFrame, meanMs, p50Ms, p99Ms, maxMs } = flight;
  flight.free();
  return { frames, updatesPerFrame, activeTriangles, evaluationsPerFrame, meanMs, p50Ms, p99Ms, maxMs };
}
