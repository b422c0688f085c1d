import type { BufferAttribute, BufferGeometry, InterleavedBufferAttribute } from "three";
import { expect, test, vi } from "vitest";
import {
  applyBase, applyFrame, bufferBytes, dropShade, frontGeometry, outline, type Outline, type Slots,
} from "../src/buffers.js";

const BOUNDS: Outline = { min: [-1, -2, -3], max: [1, 2, 3], hasColors: false, baseError: 0.1 };

function geometryOf(outlined: Outline = BOUNDS): BufferGeometry {
  const geometry = frontGeometry();
  outline(geometry, outlined);
  return geometry;
}
/** As three.js does when a buffer is made anew. */
function upload(geometry: BufferGeometry): void {
  for (const column of [...Object.values(geometry.attributes), geometry.index!]) {
    ((column as InterleavedBufferAttribute).data ?? (column as BufferAttribute)).onUploadCallback();
  }
}

/** An update of some vertex and triangle slots, each number telling its slot. */
function update(vertexSlots: number, vertexRanges: number[], triangleSlots: number, triangleRanges: number[]): Slots {
  const slots = (ranges: number[]) =>
    ranges.flatMap((first, i) => (i % 2 ? [] : Array.from({ length: ranges[i + 1]! }, (_, k) => first + k)));
  const [v, t] = [slots(vertexRanges), slots(triangleRanges)];
  const repeat = (n: number) => v.flatMap((slot) => Array<number>(n).fill(slot));
  return {
    vertexSlots,
    triangleSlots,
    vertexCapacity: 2 * vertexSlots,
    triangleCapacity: 2 * triangleSlots,
    vertices: {
      ranges: Uint32Array.from(vertexRanges),
      positions: Float32Array.from(repeat(3)),
      normals: Int16Array.from(repeat(4)),
      colors: Uint8Array.from(repeat(4)),
      levels: Uint8Array.from(v),
    },
    triangles: { ranges: Uint32Array.from(triangleRanges), corners: Uint32Array.from(t.flatMap((s) => [s, s + 1, s + 2])) },
  };
}

test("only the changed ranges are marked for upload, in every buffer", () => {
  const geometry = geometryOf();
  applyFrame(geometry, update(100, [0, 100], 200, [0, 200]));
  upload(geometry);
  applyFrame(geometry, update(100, [10, 2, 50, 1], 200, [30, 4]));
  expect(geometry.getAttribute("position")).toHaveProperty("updateRanges", [{ start: 30, count: 6 }, { start: 150, count: 3 }]);
  expect(geometry.getAttribute("normal")).toHaveProperty("data.updateRanges", [{ start: 40, count: 8 }, { start: 200, count: 4 }]);
  expect([11, 50, 51].map((slot) => geometry.getAttribute("level").getX(slot))).toEqual([11, 50, 51]);
  expect(geometry.getAttribute("normal").getY(50)).toBeCloseTo(50 / 32767, 6);
  expect(geometry.index).toHaveProperty("updateRanges", [{ start: 90, count: 12 }]);
  expect(geometry.drawRange).toEqual({ start: 0, count: 600 });
});

test("longer fronts get longer buffers, and keep what was there", () => {
  const geometry = geometryOf();
  const freed = vi.fn();
  applyFrame(geometry, update(10, [0, 10], 10, [0, 10]));
  geometry.addEventListener("dispose", freed);
  applyFrame(geometry, update(40, [39, 1], 12, [11, 1]));
  expect(freed).toHaveBeenCalledOnce();
  const position = geometry.getAttribute("position");
  expect([position.getX(9), position.getX(39)]).toEqual([9, 39]);
  expect(geometry.index!.getX(9 * 3)).toBe(9);
  expect(geometry.index!.getX(11 * 3 + 2)).toBe(13);
  applyFrame(geometry, { ...update(41, [40, 1], 13, [12, 1]), vertexCapacity: 80, triangleCapacity: 24 });
  expect(freed).toHaveBeenCalledOnce();
});

test("buffers are as long as the engine says, shorter ones too, and their bytes are told", () => {
  const geometry = geometryOf();
  applyFrame(geometry, { ...update(90, [0, 90], 50, [0, 50]), vertexCapacity: 100, triangleCapacity: 60 });
  expect([geometry.getAttribute("level").count, geometry.index!.count]).toEqual([100, 180]);
  expect(bufferBytes(geometry)).toBe(100 * (12 + 8) + 180 * 4);
  applyFrame(geometry, { ...update(20, [0, 20], 10, [0, 10]), vertexCapacity: 30, triangleCapacity: 20 });
  expect([geometry.getAttribute("level").count, geometry.index!.count]).toEqual([30, 60]);
  expect(geometry.getAttribute("position").getX(19)).toBe(19);
  expect(bufferBytes(geometry)).toBe(30 * 20 + 60 * 4);
});

test("colours become linear, opacity does not", () => {
  const geometry = geometryOf({ ...BOUNDS, hasColors: true });
  const frame = update(2, [0, 2], 1, [0, 1]);
  frame.vertices.colors = Uint8Array.of(255, 0, 188, 128, 0, 0, 0, 255);
  applyFrame(geometry, frame);
  const color = geometry.getAttribute("color");
  expect(color.getX(0)).toBeCloseTo(1);
  expect(color.getZ(0)).toBeCloseTo(0.503, 2);
  expect(color.getW(0)).toBeCloseTo(128 / 255, 3);
});

test("normals are declared before anything is there, or the first program has none", () => {
  expect(Object.keys(frontGeometry().attributes).sort()).toEqual(["level", "normal", "position"]);
  expect(Object.keys(geometryOf({ ...BOUNDS, hasColors: true }).attributes)).toContain("color");
});

test("the bounding sphere holds the model's box, and nothing while there is no model", () => {
  const { center, radius } = geometryOf().boundingSphere!;
  expect(center.toArray()).toEqual([0, 0, 0]);
  expect(radius).toBeGreaterThan(Math.sqrt(14));
  expect(geometryOf({ ...BOUNDS, baseError: 2 }).boundingSphere!.radius).toBeCloseTo(Math.sqrt(14) + 2);
  expect(frontGeometry().boundingSphere!.radius).toBeLessThan(0);
});

test("the base mesh is drawn until the first frame takes its place", () => {
  const geometry = frontGeometry();
  applyBase(geometry, {
    positions: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0), normals: new Int16Array(12), colors: new Uint8Array(12).fill(255),
    triangles: Uint32Array.of(0, 1, 2), min: [0, 0, 0], max: [1, 1, 0], up: [0, 1, 0],
  });
  expect(geometry.drawRange.count).toBe(3);
  expect([...geometry.index!.array]).toEqual([0, 1, 2]);
  expect(geometry.getAttribute("color").getX(2)).toBe(1);
  applyFrame(geometry, update(4, [0, 4], 2, [0, 2]));
  expect(geometry.drawRange.count).toBe(6);
  expect(geometry.getAttribute("position").getX(3)).toBe(3);
});

test("a column to colour by comes and goes, and grows with the others", () => {
  const geometry = geometryOf();
  applyFrame(geometry, { ...update(3, [0, 3], 1, [0, 1]), shade: { by: "error", values: Float32Array.of(3, 4, 5) } });
  expect(geometry.getAttribute("shade").getX(2)).toBe(5);
  applyFrame(geometry, { ...update(50, [3, 47], 1, []), shade: { by: "error", values: new Float32Array(50).fill(7) } });
  expect(geometry.getAttribute("shade").count).toBe(geometry.getAttribute("position").count);
  expect(geometry.getAttribute("shade").getX(49)).toBe(7);
  dropShade(geometry);
  expect(geometry.hasAttribute("shade")).toBe(false);
});
