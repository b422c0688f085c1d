import { applyRanges, type BaseMesh, type FrameUpdate, type Vec3 } from "@meshfront/core";
import {
  Box3, BufferAttribute, BufferGeometry, DynamicDrawUsage, InterleavedBuffer, InterleavedBufferAttribute, Sphere, Vector3,
} from "three";

type Column = Float32Array | Int16Array | Uint8Array | Uint16Array | Uint32Array;

/** sRGB bytes as linear 16-bit numbers: three.js takes vertex colours as linear, scans have them as seen. */
const LINEAR = Uint16Array.from({ length: 256 }, (_, byte) => {
  const seen = byte / 255;
  return Math.round(65535 * (seen <= 0.04045 ? seen / 12.92 : ((seen + 0.055) / 1.055) ** 2.4));
});

/** Beyond this many ranges between two drawn frames, one whole upload is cheaper. */
const MOST_RANGES = 4096;

/**
 * A geometry whose attributes follow a front: `position`; `normal` (16-bit, normalized) and `level` (splits above the base
 * mesh), which share a buffer; where the model has colours `color` (linear); where a column is asked for `shade`; and the
 * index. An upload call costs as much as kilobytes: two per range of vertices are what is left.
 *
 * It has nothing in it, but its attributes all the same: three.js compiles a material's program for the attributes that it
 * meets first, and shades a mesh flat that had no normals then. Free triangle slots are degenerate, so the whole
 * range is drawn.
 */
export function frontGeometry(): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", column(new Float32Array(), 3, false));
  setNormals(geometry, new Int16Array());
  geometry.setIndex(column(new Uint32Array(), 1, false));
  geometry.setDrawRange(0, 0);
  setBounds(geometry, new Box3(), 0);
  return geometry;
}

/** Four numbers per vertex: the normal and the level. */
function setNormals(geometry: BufferGeometry, array: Int16Array): void {
  const shared = new InterleavedBuffer(array, 4).setUsage(DynamicDrawUsage);
  shared.onUpload(() => shared.clearUpdateRanges());
  geometry.setAttribute("normal", new InterleavedBufferAttribute(shared, 3, 0, true));
  geometry.setAttribute("level", new InterleavedBufferAttribute(shared, 1, 3, false));
}

function normalsOf(geometry: BufferGeometry): InterleavedBuffer {
  return (geometry.getAttribute("normal") as InterleavedBufferAttribute).data;
}

/** What is known of a model before the first frame. */
export interface Outline {
  min: Vec3;
  max: Vec3;
  hasColors: boolean;
  /** How far the base mesh may be from the surface, mesh units. */
  baseError?: number;
}

/** Says how large the model is: its box is that of the source, its sphere holds every front. */
export function outline(geometry: BufferGeometry, { min, max, hasColors, baseError }: Outline): void {
  const box = new Box3(new Vector3(...min), new Vector3(...max));
  if (hasColors && !geometry.hasAttribute("color")) {
    const { count } = attribute(geometry, "position");
    geometry.setAttribute("color", column(new Uint16Array(count * 4), 4, true));
  }
  // Vertices of a coarse front may lie outside of the box of the source, by no more than they are wrong.
  setBounds(geometry, box, baseError ?? 0.025 * box.min.distanceTo(box.max));
}

function setBounds(geometry: BufferGeometry, box: Box3, margin: number): void {
  geometry.boundingBox = box;
  geometry.boundingSphere = box.getBoundingSphere(new Sphere());
  geometry.boundingSphere.radius += margin;
}

/** What a frame says of slots. */
export type Slots = Omit<FrameUpdate, "frame" | "stats">;

/** Shows the base mesh, until the first frame takes its place. */
export function applyBase(geometry: BufferGeometry, base: BaseMesh): void {
  const [vertices, triangles] = [base.positions.length / 3, base.triangles.length / 3];
  outline(geometry, { ...base, hasColors: base.colors.length > 0 });
  applyFrame(geometry, {
    vertexSlots: vertices,
    triangleSlots: triangles,
    vertexCapacity: vertices,
    triangleCapacity: triangles,
    vertices: { ...base, ranges: Uint32Array.of(0, vertices), levels: new Uint8Array(vertices) },
    triangles: { ranges: Uint32Array.of(0, triangles), corners: base.triangles },
  });
}

/** Writes what changed into the attributes and marks just that for upload; makes them as long as the frame says. */
export function applyFrame(geometry: BufferGeometry, frame: Slots): void {
  const { vertices, triangles } = frame;
  reserve(geometry, frame);
  write(attribute(geometry, "position"), vertices.ranges, vertices.positions, 3);
  const normals = normalsOf(geometry);
  write(normals, vertices.ranges, vertices.normals, 4);
  writeLevels(normals.array as Int16Array, vertices.ranges, vertices.levels);
  if (geometry.hasAttribute("color")) write(attribute(geometry, "color"), vertices.ranges, linear(vertices.colors), 4);
  write(geometry.index!, triangles.ranges, triangles.corners, 3);
  geometry.setDrawRange(0, frame.triangleSlots * 3);
  if (frame.shade) {
    const { values } = frame.shade;
    if (!geometry.hasAttribute("shade")) {
      geometry.setAttribute("shade", column(new Float32Array(attribute(geometry, "position").count), 1, false));
    }
    const whole = values.length > 0 ? Uint32Array.of(0, values.length) : new Uint32Array();
    write(attribute(geometry, "shade"), whole, values, 1);
  }
}

/** Takes the column to colour by away. */
export function dropShade(geometry: BufferGeometry): void {
  if (!geometry.hasAttribute("shade")) return;
  // Frees the buffers on the graphics card; the others are made again when they are next drawn.
  geometry.dispose();
  geometry.deleteAttribute("shade");
}

/** Bytes of all buffers: as much on the graphics card as in memory. */
export function bufferBytes(geometry: BufferGeometry): number {
  const attributes = Object.values(geometry.attributes) as (BufferAttribute | InterleavedBufferAttribute)[];
  const arrays = new Set([...attributes, ...(geometry.index ? [geometry.index] : [])].map(({ array }) => array));
  return [...arrays].reduce((sum, { byteLength }) => sum + byteLength, 0);
}

function linear(colors: Uint8Array): Uint16Array {
  const all = new Uint16Array(colors.length);
  for (let i = 0; i < colors.length; i++) all[i] = i % 4 === 3 ? colors[i]! * 257 : LINEAR[colors[i]!]!;
  return all;
}

function attribute(geometry: BufferGeometry, name: string): BufferAttribute {
  return geometry.getAttribute(name) as BufferAttribute;
}

function write(target: BufferAttribute | InterleavedBuffer, ranges: Uint32Array, packed: Column, slotSize: number): void {
  if (ranges.length === 0) return;
  applyRanges(target.array as Float32Array, ranges, packed as Float32Array, slotSize);
  if (target.updateRanges.length + ranges.length / 2 > MOST_RANGES) {
    target.clearUpdateRanges();
    target.addUpdateRange(0, target.array.length);
  } else {
    for (let i = 0; i < ranges.length; i += 2) {
      target.addUpdateRange(ranges[i]! * slotSize, ranges[i + 1]! * slotSize);
    }
  }
  target.needsUpdate = true;
}

/** Levels lie where normals have a number too many. */
function writeLevels(normals: Int16Array, ranges: Uint32Array, levels: Uint8Array): void {
  let from = 0;
  for (let i = 0; i < ranges.length; i += 2) {
    const end = ranges[i]! + ranges[i + 1]!;
    for (let slot = ranges[i]!; slot < end; slot++) normals[4 * slot + 3] = levels[from++]!;
  }
}

/** A frame that makes buffers shorter holds every slot. */
function reserve(geometry: BufferGeometry, { vertexCapacity, triangleCapacity }: Slots): void {
  const isLong = attribute(geometry, "position").count === vertexCapacity;
  const isIndexLong = geometry.index!.count === 3 * triangleCapacity;
  if (isLong && isIndexLong) return;
  // Frees the buffers on the graphics card; those of the new attributes are made when they are first drawn.
  geometry.dispose();
  if (!isLong) {
    for (const name of ["position", "color", "shade"]) {
      if (geometry.hasAttribute(name)) geometry.setAttribute(name, resized(attribute(geometry, name), vertexCapacity));
    }
    setNormals(geometry, sized(normalsOf(geometry).array as Int16Array, 4 * vertexCapacity));
  }
  if (!isIndexLong) geometry.setIndex(resized(geometry.index!, 3 * triangleCapacity));
}

function resized({ array, itemSize, normalized }: BufferAttribute, count: number): BufferAttribute {
  return column(sized(array as Column, count * itemSize), itemSize, normalized);
}

/** The same numbers, as many as fit. */
function sized<T extends Column>(old: T, length: number): T {
  const array = new (old.constructor as new (length: number) => T)(length);
  array.set(old.subarray(0, length));
  return array;
}

function column(array: Column, itemSize: number, normalized: boolean): BufferAttribute {
  const attribute = new BufferAttribute(array, itemSize, normalized).setUsage(DynamicDrawUsage);
  // A buffer that is made anew has everything: what was marked until then need not be uploaded again.
  return attribute.onUpload(() => attribute.clearUpdateRanges());
}
