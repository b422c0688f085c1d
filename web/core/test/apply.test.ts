import { expect, test } from "vitest";
import { applyRanges } from "../src/apply.js";

test("ranges land in their slots and nothing else is touched", () => {
  const column = new Float32Array(15).fill(-1);
  applyRanges(column, Uint32Array.of(0, 1, 3, 2), Float32Array.of(1, 2, 3, 4, 5, 6, 7, 8, 9), 3);
  expect([...column]).toEqual([1, 2, 3, -1, -1, -1, -1, -1, -1, 4, 5, 6, 7, 8, 9]);
});

test("a range beyond the column is refused", () => {
  expect(() => applyRanges(new Uint8Array(4), Uint32Array.of(3, 2), Uint8Array.of(1, 2), 1)).toThrow(RangeError);
});
