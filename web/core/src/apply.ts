/**
 * Writes the contents of changed slots into a column: `packed` holds them one range after the other, `itemSize`
 * numbers per slot.
 *
 * @throws RangeError where the column is too short
 */
export function applyRanges<T extends Float32Array | Int16Array | Uint8Array | Uint32Array>(
  column: T,
  ranges: Uint32Array,
  packed: T,
  itemSize: number,
): void {
  let from = 0;
  for (let i = 0; i < ranges.length; i += 2) {
    const length = ranges[i + 1]! * itemSize;
    column.set(packed.subarray(from, from + length), ranges[i]! * itemSize);
    from += length;
  }
}
