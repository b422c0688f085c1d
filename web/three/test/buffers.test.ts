import type { FrameUpdate, ModelInfo } from "@meshfront/core";
import { expect, test, vi } from "vitest";
import { applyFrame, frontGeometry } from "../src/buffers.js";

const INFO = { min: [-1, -2, -3], max: [1, 2, 3] } as unknown as ModelInfo;

/** An update of some vertex and triangle slots, each number telling its slot. */
function update(vertexSlots: number, vertexRanges: number[], triangleSlots: number, triangleRanges: number[]): FrameUpdate {
  const slots = (ranges: number[]) =>
    ranges.flatMap((first, i) => (i % 2 ? [] : Array.from({ length: ranges[i + 1]! }, (_, k) => first + k)));
  const [v, t] = [slots(vertexRanges), slots(triangleRanges)];
  const repeat = (n: number) => v.flatMap((slot) => Array<number>(n).fill(slot));
  return {
    vertexSlots,
    triangleSlots,
    vertices: {
      ranges: Uint32Array.from(vertexRanges),
      positions: Float32Array.from(repeat(3)),
      normals: Int16Array.from(repeat(4)),
      colors: Uint8Array.from(repeat(4)),
      levels: Uint8Array.from(v),
    },
    triangles: { ranges: Uint32Array.from(triangleRanges), corners: Uint32Array.from(t.flatMap((s) => [s, s + 1, s + 2])) },
    stats: {} as FrameUpdate["stats"],
  };
}

test("only the changed ranges are marked for upload, in every column and the index", () => {
  const geometry = frontGeometry(INFO);
  applyFrame(geometry, update(100, [0, 100], 200, [0, 200]));
  const columns = () => [...Object.values(geometry.attributes), geometry.index!] as never as {
    itemSize: number; updateRanges: { start: number; count: number }[]; clearUpdateRanges(): void; array: Float32Array;
  }[];
  for (const column of columns()) column.clearUpdateRanges();
  applyFrame(geometry, update(100, [10, 2, 50, 1], 200, [30, 4]));
  expect(geometry.getAttribute("position")).toHaveProperty("updateRanges", [{ start: 30, count: 6 }, { start: 150, count: 3 }]);
  expect(geometry.getAttribute("normal")).toHaveProperty("updateRanges", [{ start: 40, count: 8 }, { start: 200, count: 4 }]);
  expect(geometry.getAttribute("level")).toHaveProperty("updateRanges", [{ start: 10, count: 2 }, { start: 50, count: 1 }]);
  expect(geometry.index).toHaveProperty("updateRanges", [{ start: 90, count: 12 }]);
  expect(geometry.drawRange).toEqual({ start: 0, count: 600 });
});

test("longer fronts get longer buffers, and keep what was there", () => {
  const geometry = frontGeometry(INFO);
  const freed = vi.fn();
  applyFrame(geometry, update(10, [0, 10], 10, [0, 10]));
  geometry.addEventListener("dispose", freed);
  applyFrame(geometry, update(40, [39, 1], 12, [11, 1]));
  expect(freed).toHaveBeenCalledOnce();
  const position = geometry.getAttribute("position");
  expect(position.count).toBeGreaterThanOrEqual(40);
  expect([position.getX(9), position.getX(39)]).toEqual([9, 39]);
  expect(geometry.index!.getX(9 * 3)).toBe(9);
  expect(geometry.index!.getX(11 * 3 + 2)).toBe(13);
  applyFrame(geometry, update(41, [40, 1], 13, [12, 1]));
  expect(freed).toHaveBeenCalledOnce();
});

test("colours become linear, opacity does not", () => {
  const geometry = frontGeometry({ ...INFO, up: [0, 1, 0], hasColors: true });
  const frame = update(2, [0, 2], 1, [0, 1]);
  frame.vertices.colors = Uint8Array.of(255, 0, 188, 128, 0, 0, 0, 255);
  applyFrame(geometry, frame);
  const color = geometry.getAttribute("color");
  expect(color.getX(0)).toBeCloseTo(1);
  expect(color.getZ(0)).toBeCloseTo(0.503, 2);
  expect(color.getW(0)).toBeCloseTo(128 / 255, 3);
});

test("normals and colours are declared before the first frame, or the first program has none", () => {
  const geometry = frontGeometry({ ...INFO, up: [0, 1, 0], hasColors: true });
  expect(Object.keys(geometry.attributes).sort()).toEqual(["color", "level", "normal", "position"]);
});

test("the bounding sphere holds the model's box", () => {
  const { center, radius } = frontGeometry(INFO).boundingSphere!;
  expect(center.toArray()).toEqual([0, 0, 0]);
  expect(radius).toBeGreaterThan(Math.sqrt(14));
});
