import { applyRanges, type FrameUpdate, type ModelInfo } from "@meshfront/core";
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Sphere, Vector3 } from "three";

type Column = Float32Array | Int16Array | Uint8Array | Uint16Array | Uint32Array;

/** sRGB bytes as linear 16-bit numbers: three.js takes vertex colours as linear, scans have them as seen. */
const LINEAR = Uint16Array.from({ length: 256 }, (_, byte) => {
  const seen = byte / 255;
  return Math.round(65535 * (seen <= 0.04045 ? seen / 12.92 : ((seen + 0.055) / 1.055) ** 2.4));
});

/** Beyond this many ranges between two drawn frames, one whole upload is cheaper. */
const MOST_RANGES = 4096;

/**
 * A geometry whose attributes follow a front: `position`, `normal` (16-bit, normalized, padded to four numbers),
 * `color` (where the model has colours; linear), `level` (splits above the base mesh), and the index.
 *
 * Free triangle slots are degenerate, so the whole range is drawn. The bounding sphere is that of the model.
 */
export function frontGeometry(info: ModelInfo): BufferGeometry {
  const geometry = emptyGeometry();
  if (info.hasColors) geometry.setAttribute("color", new BufferAttribute(new Uint16Array(), 4, true));
  const [min, max] = [new Vector3(...info.min), new Vector3(...info.max)];
  // Vertices of a coarse front may lie outside of the box of the source, by no more than they are wrong.
  const center = min.clone().add(max).multiplyScalar(0.5);
  geometry.boundingSphere = new Sphere(center, 1.05 * min.distanceTo(max) * 0.5);
  return geometry;
}

/**
 * A geometry with nothing in it that has its attributes all the same: three.js compiles a material's program for the
 * attributes that it meets first, and shades a mesh flat that had no normals then.
 */
export function emptyGeometry(): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(), 3));
  geometry.setAttribute("normal", new BufferAttribute(new Int16Array(), 4, true));
  geometry.setAttribute("level", new BufferAttribute(new Uint8Array(), 1));
  geometry.setIndex(new BufferAttribute(new Uint32Array(), 1));
  return geometry;
}

/** Writes what changed into the attributes and marks just that for upload; makes them larger where they are too short. */
export function applyFrame(geometry: BufferGeometry, frame: FrameUpdate): void {
  const { vertices, triangles } = frame;
  reserve(geometry, frame);
  write(attribute(geometry, "position"), vertices.ranges, vertices.positions);
  write(attribute(geometry, "normal"), vertices.ranges, vertices.normals);
  write(attribute(geometry, "level"), vertices.ranges, vertices.levels);
  if (geometry.hasAttribute("color")) {
    const linear = Uint16Array.from(vertices.colors, (byte, i) => (i % 4 === 3 ? byte * 257 : LINEAR[byte]!));
    write(attribute(geometry, "color"), vertices.ranges, linear);
  }
  write(geometry.index!, triangles.ranges, triangles.corners, 3);
  geometry.setDrawRange(0, frame.triangleSlots * 3);
}

function attribute(geometry: BufferGeometry, name: string): BufferAttribute {
  return geometry.getAttribute(name) as BufferAttribute;
}

function write(target: BufferAttribute, ranges: Uint32Array, packed: Column, slotSize = target.itemSize): void {
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

function reserve(geometry: BufferGeometry, { vertexSlots, triangleSlots }: FrameUpdate): void {
  const slots = attribute(geometry, "position").count;
  const index = geometry.index!;
  if (slots >= vertexSlots && index.count >= triangleSlots * 3) return;
  // Frees the buffers on the graphics card; those of the new attributes are made when they are first drawn.
  geometry.dispose();
  if (slots < vertexSlots) {
    for (const name of Object.keys(geometry.attributes)) {
      geometry.setAttribute(name, longer(attribute(geometry, name), grown(vertexSlots)));
    }
  }
  if (index.count < triangleSlots * 3) geometry.setIndex(longer(index, grown(triangleSlots) * 3));
}

/** Half as much again: fronts grow over many frames, and every growth uploads everything. */
function grown(slots: number): number {
  return Math.ceil(slots * 1.5);
}

function longer(old: BufferAttribute, count: number): BufferAttribute {
  const Array = old.array.constructor as new (length: number) => Column;
  const array = new Array(count * old.itemSize);
  array.set(old.array);
  return new BufferAttribute(array, old.itemSize, old.normalized).setUsage(DynamicDrawUsage);
}
