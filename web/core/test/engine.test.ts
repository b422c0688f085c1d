/** The real module on small real files. */

import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { applyRanges } from "../src/apply.js";
import { startEngine } from "../src/engine.js";
import { MeshfrontError } from "../src/errors.js";
import type { Engine } from "../src/host.js";
import type { FrameUpdate, Limits, ModelInfo, Region, Shade, View } from "../src/view.js";

const module = readFileSync(new URL("../wasm/meshfront_wasm_bg.wasm", import.meta.url));
const front = readFileSync(new URL("../../../testdata/front/v1-knot-lossless-painted.front", import.meta.url));

const nobody = () => {};

/** One model in an engine of its own. */
interface Alone {
  engine: Engine;
  model: number;
  info: ModelInfo;
  adapt(view: View | View[], maxTriangles?: number, deadlineMs?: number, maxBytes?: number, shade?: Shade): FrameUpdate;
}
async function load(bytes: Uint8Array): Promise<Alone> {
  const engine = await startEngine(module);
  const { model, info } = engine.open(0, bytes, "scan", nobody);
  return {
    engine,
    model,
    info,
    adapt: (view, maxTriangles = Infinity, deadlineMs = Infinity, maxBytes = Infinity, shade) =>
      engine.adapt(
        0,
        [{ model, views: [view].flat(), ...(shade ? { shade } : {}) }],
        { maxTriangles, maxBytes, deadlineMs },
      )[0]!,
  };
}

const kindOf = async (bytes: Uint8Array) => {
  const error = MeshfrontError.from(await load(bytes).catch((thrown: unknown) => thrown));
  expect(error.message).toMatch(/^scan: /);
  expect(error.remedy).not.toBe("");
  return error.kind;
};

/** A view of the whole model from a direction, so many half diagonals away. */
function lookAt({ info }: { info: ModelInfo }, direction: [number, number, number], distance: number, tolerancePx = 0.1): View {
  const center = info.min.map((low, i) => (low + info.max[i]!) / 2);
  const radius = Math.hypot(...info.max.map((high, i) => high - center[i]!));
  return {
    eye: direction.map((d, i) => center[i]! + d * radius * distance) as unknown as View["eye"],
    target: center as unknown as View["target"],
    up: [0, 1, 0],
    fovY: 0.8, width: 800, height: 600, near: 0.01 * radius,
    tolerancePx, frustum: true, orientation: true,
  };
}

/** What a renderer holds: columns that only ever get changed ranges. */
class Mirror {
  positions = new Float32Array(3e5);
  normals = new Int16Array(4e5);
  colors = new Uint8Array(4e5);
  corners = new Uint32Array(6e5);
  slots = 0;

  apply({ vertices, triangles, triangleSlots }: FrameUpdate): void {
    applyRanges(this.positions, vertices.ranges, vertices.positions, 3);
    applyRanges(this.normals, vertices.ranges, vertices.normals, 4);
    applyRanges(this.colors, vertices.ranges, vertices.colors, 4);
    applyRanges(this.corners, triangles.ranges, triangles.corners, 3);
    this.slots = triangleSlots;
  }

  /** Each triangle by the content of its corners, the first one first in order: the same whatever the slots. */
  triangles(): string[] {
    const corner = (slot: number) =>
      [
        ...this.positions.subarray(3 * slot, 3 * slot + 3),
        ...this.normals.subarray(4 * slot, 4 * slot + 3),
        ...this.colors.subarray(4 * slot, 4 * slot + 4),
      ].join();
    const all: string[] = [];
    for (let t = 0; t < this.slots; t++) {
      const [a, b, c] = this.corners.subarray(3 * t, 3 * t + 3) as unknown as [number, number, number];
      if (a === b) continue;
      const [x, y, z] = [corner(a), corner(b), corner(c)];
      all.push([[x, y, z], [y, z, x], [z, x, y]].map((turned) => turned.join(" ")).sort()[0]!);
    }
    return all.sort();
  }
}

test("changed ranges, one after the other, make the same mesh as one upload of everything", async () => {
  const [walking, fresh] = [await load(front), await load(front)];
  const mirror = new Mirror();
  const walk: [View, number?][] = [
    [lookAt(walking, [0, 0, 1], 30)],
    [lookAt(walking, [0, 0, 1], 2)],
    [lookAt(walking, [0.7, 0.1, 0.7], 1.2)],
    [lookAt(walking, [0, 1, 0.1], 1.5), 200],
    [lookAt(walking, [0, 1, 0.1], 1.5, 1)],
    [lookAt(walking, [-1, 0, 0], 1.1)],
  ];
  let [updates, calls] = [0, 0];
  for (const [view, maxTriangles] of walk) {
    for (let settled = false; !settled;) {
      // So little time that most views take several calls.
      const frame = walking.adapt(view, maxTriangles, 0.02);
      mirror.apply(frame);
      updates += frame.stats.refined + frame.stats.coarsened;
      settled = frame.stats.settled;
      calls++;
    }
  }
  const straight = new Mirror();
  const frame = fresh.adapt(walk.at(-1)![0]);
  straight.apply(frame);
  expect(calls).toBeGreaterThan(walk.length);
  expect(updates).toBeGreaterThan(1.5 * frame.stats.refined);
  expect(mirror.triangles()).toHaveLength(frame.stats.triangles);
  expect(mirror.triangles()).toEqual(straight.triangles());
});

test("a view that is settled uploads nothing", async () => {
  const engine = await load(front);
  const view = lookAt(engine, [0, 0, 1], 2);
  engine.adapt(view);
  const again = engine.adapt(view);
  expect(again.stats).toMatchObject({ settled: true, refined: 0, coarsened: 0, uploadBytes: 0 });
});

test("a budget and a tolerance are kept", async () => {
  const engine = await load(front);
  const view = lookAt(engine, [0, 0, 1], 1.5, 0.2);
  const budget = Math.round(1.5 * engine.info.baseTriangles);
  const bound = engine.adapt(view, budget).stats;
  expect(bound.budgetBound).toBe(true);
  expect(bound.triangles).toBeLessThanOrEqual(budget);
  const free = engine.adapt(view).stats;
  expect(free.triangles).toBeGreaterThan(budget);
  expect(free.errorPx).toBeLessThanOrEqual(0.2);
});

test("outside of a region another tolerance holds", async () => {
  const all = await load(front);
  const { info } = all;
  const view = { ...lookAt(all, [0, 0, 1], 3, 0), orientation: false };
  const trianglesWith = async (shape: Region["shape"], outsideError: number) =>
    (await load(front)).adapt({ ...view, region: { shape, outsideError } }).stats.triangles;
  const everything = all.adapt(view).stats.triangles;
  const aside = { center: [1e6, 0, 0], radius: 1 } as const;
  expect(everything).toBeGreaterThan(info.baseTriangles);
  expect(await trianglesWith({ min: info.min, max: info.max }, Infinity)).toBe(everything);
  expect(await trianglesWith(aside, Infinity)).toBe(info.baseTriangles);
  expect(await trianglesWith(aside, 0)).toBe(everything);
  const size = Math.hypot(...info.max.map((high, i) => high - info.min[i]!));
  const between = await trianglesWith(aside, 0.02 * size);
  expect(between).toBeGreaterThan(info.baseTriangles);
  expect(between).toBeLessThan(everything);
});

test("something else, a page for example, is no .front file", async () => {
  expect(await kindOf(new TextEncoder().encode("<!doctype html><title>404</title>"))).toBe("not-front");
  expect(await kindOf(new Uint8Array())).toBe("not-front");
});

test("a file that is cut off or altered is damaged, wherever", async () => {
  for (const part of [0.1, 0.5, 0.99]) {
    expect(await kindOf(front.subarray(0, Math.floor(part * front.length)))).toBe("damaged");
    const altered = Uint8Array.from(front);
    altered[Math.floor(part * front.length)]! ^= 1;
    expect(await kindOf(altered)).toBe("damaged");
  }
});

test("models share a budget: the one that looks worse gets more of it", async () => {
  const engine = await startEngine(module);
  const [near, far] = [engine.open(0, front, "near", nobody), engine.open(0, front, "far", nobody)];
  const look = (distances: [number, number], maxTriangles: number) =>
    engine.adapt(
      0,
      [near, far].map(({ model, info }, i) => ({ model, views: [lookAt({ info }, [0, 0, 1], distances[i]!, 0.05)] })),
      { maxTriangles, maxBytes: Infinity, deadlineMs: Infinity },
    ).map(({ stats }) => stats);
  const free = look([1.5, 6], Infinity);
  const limit = Math.round(0.6 * (free[0]!.triangles + free[1]!.triangles));
  const [a, b] = look([1.5, 6], limit);
  expect(a!.budgetBound && b!.budgetBound).toBe(true);
  expect(a!.triangles + b!.triangles).toBeLessThanOrEqual(limit);
  expect(a!.triangles).toBeGreaterThan(b!.triangles);
  // No model has what the other one needs more: what waits looks about as wrong in both.
  expect(Math.max(a!.errorPx, b!.errorPx)).toBeLessThan(1.5 * Math.min(a!.errorPx, b!.errorPx));
  const [c, d] = look([6, 1.5], limit);
  expect(d!.triangles).toBeGreaterThan(c!.triangles);
  engine.close(near.model);
  const alone = engine.adapt(
    0,
    [{ model: far.model, views: [lookAt(far, [0, 0, 1], 1.5, 0.05)] }],
    { maxTriangles: limit, maxBytes: Infinity, deadlineMs: Infinity },
  );
  expect(alone[0]!.stats.triangles).toBeGreaterThan(d!.triangles);
  expect(() => engine.flyBy(near.model)).toThrow("no such model");
});

test("the base mesh is there with the first bytes, and no sooner", async () => {
  const { engine, info } = await load(front);
  let reaches = front.length;
  for (let length = 0; length < front.length; length++) {
    const base = engine.baseOf(front.subarray(0, length));
    if (!base) continue;
    reaches = length;
    expect(base.triangles).toHaveLength(3 * info.baseTriangles);
    expect(base.normals).toHaveLength((base.positions.length / 3) * 4);
    expect(base.colors).toHaveLength((base.positions.length / 3) * 4);
    expect(Math.max(...base.triangles)).toBe(base.positions.length / 3 - 1);
    base.min.forEach((low, axis) => expect(low).toBeGreaterThanOrEqual(info.min[axis]! - 1e-6));
    break;
  }
  expect(reaches).toBeGreaterThan(100);
  expect(reaches).toBeLessThan(0.2 * front.length);
  // The base mesh of a front, corner by corner.
  const untouched = (await load(front)).adapt({ ...lookAt({ info }, [0, 0, 1], 2), tolerancePx: 1e9 });
  const base = engine.baseOf(front)!;
  expect([...untouched.triangles.corners]).toEqual([...base.triangles]);
  expect([...untouched.vertices.positions]).toEqual([...base.positions]);
});

test("opening tells how far it is, and ends", async () => {
  const engine = await startEngine(module);
  const parts: number[] = [];
  engine.open(0, front, "scan", (part) => parts.push(part));
  expect(parts.length).toBeGreaterThan(1);
  expect(parts).toEqual([...parts].sort((a, b) => a - b));
  expect(parts.at(-1)).toBeLessThanOrEqual(1);
});

test("of several cameras the finest counts everywhere", async () => {
  const [left, right, both] = [await load(front), await load(front), await load(front)];
  const [a, b] = [lookAt(left, [-1, 0, 0], 1.2, 6), lookAt(left, [1, 0, 0], 1.2, 6)];
  const [of_a, of_b] = [left.adapt(a).stats.triangles, right.adapt(b).stats.triangles];
  const of_both = both.adapt([a, b]).stats;
  expect(of_both.triangles).toBeGreaterThan(Math.max(of_a, of_b));
  expect(of_both).toMatchObject({ settled: true });
  // Neither of them alone wants anything more.
  for (const view of [a, b]) {
    const alone = await load(front);
    alone.adapt([a, b]);
    expect(alone.adapt(view).stats.refined).toBe(0);
  }
});

test("a cap of bytes is never exceeded, and fronts come to rest under it", async () => {
  const scan = await load(front);
  const view = lookAt(scan, [0, 0, 1], 1.5, 0.01);
  const bytesOf = ({ stats, vertexCapacity, triangleCapacity }: FrameUpdate) =>
    stats.frontBytes + 2 * (vertexCapacity * 28 + triangleCapacity * 12);
  const free = scan.adapt(view);
  const base = bytesOf((await load(front)).adapt({ ...view, tolerancePx: 1e9 }));
  const whole = bytesOf(free);
  for (const part of [0.9, 0.4, 0.7, 0.25]) {
    const cap = base + part * (whole - base);
    const mirror = new Mirror();
    let calls = 0;
    let last: FrameUpdate | undefined;
    // Around the model, then at rest: what was found once is kept.
    for (let settled = false, turn = 0; !settled || turn < 13; turn++) {
      const eye = turn < 12 ? lookAt(scan, [Math.sin(turn), 0.2, Math.cos(turn)], 1.5, 0.01) : view;
      last = scan.adapt(eye, Infinity, Infinity, cap);
      mirror.apply(last);
      expect(bytesOf(last)).toBeLessThanOrEqual(cap);
      settled = last.stats.settled;
      expect(calls++).toBeLessThan(60);
    }
    expect(last!.stats).toMatchObject({ budgetBound: true, byteBound: true });
    expect(last!.stats.triangles).toBeLessThan(free.stats.triangles);
    expect(bytesOf(last!)).toBeGreaterThan(0.6 * cap);
    expect(scan.adapt(view, Infinity, Infinity, cap).stats).toMatchObject({ settled: true, refined: 0, coarsened: 0 });
    expect(mirror.triangles()).toHaveLength(last!.stats.triangles);
  }
  // Without the cap everything comes back.
  expect(scan.adapt(view).stats).toMatchObject({ triangles: free.stats.triangles, byteBound: false });
});

test("what is drawn can be asked for, as long as it is drawn", async () => {
  const { engine, model, info, adapt } = await load(front);
  const coarse = adapt(lookAt({ info }, [0, 0, 1], 6, 4), Infinity, Infinity, Infinity, "error");
  const { values } = coarse.shade!;
  expect(values).toHaveLength(coarse.vertexSlots);
  const mirror = new Mirror();
  mirror.apply(coarse);
  for (let t = 0; t < coarse.triangleSlots; t++) {
    const [a, b, c] = mirror.corners.subarray(3 * t, 3 * t + 3) as unknown as [number, number, number];
    const found = engine.inspect(model, coarse.frame, t);
    if (a === b) {
      expect(found).toBeUndefined();
      continue;
    }
    // Of the triangles around a vertex the worst counts.
    expect(Math.min(values[a]!, values[b]!, values[c]!)).toBeGreaterThanOrEqual(found!.error);
    expect(found!.error).toBeGreaterThanOrEqual(info.floorError);
    expect(found!.error).toBeLessThanOrEqual(info.baseError);
    const centroid = [0, 1, 2].map((axis) => ([a, b, c].reduce((sum, v) => sum + mirror.positions[3 * v + axis]!, 0)) / 3);
    const away = Math.hypot(...centroid.map((x, axis) => x - found!.center[axis]!));
    expect(away).toBeLessThanOrEqual(found!.radius * 1.001);
  }
  const spheres = engine.spheres(model, 20);
  expect(spheres).toHaveLength(80);
  const fine = adapt({ ...lookAt({ info }, [0, 0, 1], 1, 0), orientation: false, frustum: false });
  expect(engine.inspect(model, coarse.frame, 0)).toBeUndefined();
  // Nothing is left that could be replaced: what is drawn is the source.
  const drawn = Array.from({ length: fine.triangleSlots }, (_, t) => engine.inspect(model, fine.frame, t)).filter(Boolean);
  expect(drawn).toHaveLength(info.sourceTriangles);
  expect(drawn.every((found) => found!.update === undefined && found!.error === info.floorError)).toBe(true);
  expect(engine.spheres(model, 20)).toHaveLength(0);
});

test("ages and cones are columns of every slot", async () => {
  const { info, adapt } = await load(front);
  const near = lookAt({ info }, [0, 0, 1], 2, 1);
  const first = adapt(near, Infinity, Infinity, Infinity, "age");
  expect(new Set(first.shade!.values)).toEqual(new Set([0]));
  const second = adapt(lookAt({ info }, [0, 0, 1], 1.5, 1), Infinity, Infinity, Infinity, "age");
  expect(new Set(second.shade!.values)).toEqual(new Set([0, 1]));
  // Nothing changed, nothing to send.
  expect(adapt(lookAt({ info }, [0, 0, 1], 1.5, 1), Infinity, Infinity, Infinity, "age").shade).toBeUndefined();
  const cones = adapt(lookAt({ info }, [0, 0, 1], 1.5, 1), Infinity, Infinity, Infinity, "cone").shade!;
  expect(cones.values).toHaveLength(second.vertexSlots);
  expect(Math.max(...cones.values)).toBeLessThanOrEqual(Math.fround(Math.PI));
  expect(Math.max(...cones.values)).toBeGreaterThan(0.1);
});

test("two fronts of one model share its hierarchy and nothing else", async () => {
  const { engine, model, info, adapt } = await load(front);
  const before = engine.memory();
  const twin = engine.duplicate(0, model);
  expect(twin.info).toMatchObject({ sourceTriangles: info.sourceTriangles, hierarchyBytes: info.hierarchyBytes });
  const near = adapt(lookAt({ info }, [0, 0, 1], 1.5, 0.1)).stats.triangles;
  const limits = { maxTriangles: Infinity, maxBytes: Infinity, deadlineMs: Infinity };
  const far = engine.adapt(0, [{ model: twin.model, views: [lookAt({ info }, [0, 0, 1], 40, 1)] }], limits)[0]!.stats.triangles;
  expect(far).toBeLessThan(near);
  engine.close(model);
  const stays = engine.adapt(0, [{ model: twin.model, views: [lookAt({ info }, [0, 0, 1], 1.5, 0.1)] }], limits)[0]!;
  expect(stays.stats.triangles).toBe(near);
  expect(engine.memory()).toBeLessThan(before + info.hierarchyBytes + 4e6);
});

test("a group has limits of its own, and takes nothing from another's", async () => {
  const [alone, beside] = [await load(front), await load(front)];
  const { engine, model, info } = beside;
  const near = lookAt({ info }, [0, 0, 1], 1.5, 0.2);
  const whole = { ...lookAt({ info }, [0, 0, 1], 2, 0), frustum: false, orientation: false };
  const [most, bytes] = [Math.round(2.5 * info.baseTriangles), 200_000];
  const twin = engine.duplicate(1, model);
  const all = (limits: Partial<Limits> = {}) =>
    engine.adapt(1, [{ model: twin.model, views: [whole] }], { maxTriangles: Infinity, maxBytes: Infinity, deadlineMs: Infinity, ...limits })[0]!;
  const asked: [View, number, number][] = [
    [near, most, Infinity], [{ ...near, tolerancePx: 5 }, most, Infinity], [near, Infinity, bytes], [near, Infinity, bytes], [near, Infinity, Infinity],
  ];
  for (const [view, maxTriangles, maxBytes] of asked) {
    // Complete, whatever the others may hold; and they get as much as without it.
    expect(all().stats).toMatchObject({ triangles: info.sourceTriangles, settled: true, budgetBound: false });
    const { engineMs: _, gatherMs: __, ...stats } = beside.adapt(view, maxTriangles, Infinity, maxBytes).stats;
    expect(alone.adapt(view, maxTriangles, Infinity, maxBytes).stats).toMatchObject(stats);
  }
  expect(all({ maxTriangles: most }).stats.triangles).toBeLessThanOrEqual(most);
  expect(beside.adapt(near).stats.triangles).toBeGreaterThan(most);
  expect(() => engine.adapt(0, [{ model: twin.model, views: [whole] }], { maxTriangles: 1, maxBytes: 1, deadlineMs: 1 })).toThrow("another group");
});

test("what a group held is used again when it has left", async () => {
  const { engine, model, info } = await load(front);
  const view = { ...lookAt({ info }, [0, 0, 1], 2, 0), frustum: false, orientation: false };
  const sizes: number[] = [];
  for (let group = 1; group <= 30; group++) {
    const twin = engine.duplicate(group, model);
    const { stats } = engine.adapt(group, [{ model: twin.model, views: [view] }], { maxTriangles: Infinity, maxBytes: Infinity, deadlineMs: Infinity })[0]!;
    expect(stats.triangles).toBe(info.sourceTriangles);
    engine.leave(group);
    expect(() => engine.spheres(twin.model, 1)).toThrow("no such model");
    sizes.push(engine.memory());
  }
  expect(sizes.at(-1)).toBe(sizes[1]);
});
