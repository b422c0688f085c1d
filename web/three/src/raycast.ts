/**
 * Which triangles a ray meets, all of them looked at.
 *
 * This work is based on: Woop, Benthin & Wald 2013, "Watertight Ray/Triangle Intersection". The ray becomes an axis: each
 * vertex is sheared into the plane across it, and a triangle is met where the axis is on the same side of its three
 * edges. Neighbours compute the side of the edge between them from the same numbers, so no ray slips through.
 *
 * We differ in how triangles that are not met are left out. A front changes with every frame, so a tree over it would be
 * rebuilt as often. Instead the vertices are sheared once, and of each a byte is kept: the quadrant it lies in. A
 * triangle whose corners share a half plane is not met, and few others are left. Both passes are tight loops over
 * typed arrays.
 */

import { BackSide, FrontSide, type Side } from "three";

/** A triangle that is met. */
export interface Hit {
  /** Where along the ray, in lengths of its direction. */
  along: number;
  /** Which triangle: its place in the index, divided by three. */
  triangle: number;
  /** Vertices. */
  corners: [number, number, number];
  /** What each corner contributes to the point that is met: three numbers that sum up to 1. */
  weights: [number, number, number];
  /** Whether the ray comes from where the corners run counterclockwise. */
  front: boolean;
}

/** What to look at, in the space of the mesh. */
export interface Soup {
  /** 3 numbers per vertex. */
  positions: Float32Array;
  /** Vertices from the first on; those behind are not looked at. */
  vertices: number;
  /** 3 vertices per triangle. */
  corners: Uint32Array;
  /** Triangles from the first on. Degenerate ones are never met. */
  triangles: number;
}

type Triple = readonly [number, number, number];

/** Of each vertex the quadrant that it lies in, seen along the ray: a bit for each of the half planes x < 0, x ≥ 0, y < 0, y ≥ 0. */
let quadrants = new Uint8Array();

/**
 * All triangles that the ray meets, in no order. What lies behind its origin counts too: `along` is negative there.
 *
 * Through shared edges and vertices a ray always meets one triangle at least, and more than one only where it meets the
 * edge exactly. `O(vertices + triangles)`: about 3 ns for each of them.
 */
export function hits({ positions, vertices, corners, triangles }: Soup, origin: Triple, direction: Triple, side: Side): Hit[] {
  const size = direction.map(Math.abs);
  const kz = size[0]! > size[1]! ? (size[0]! > size[2]! ? 0 : 2) : size[1]! > size[2]! ? 1 : 2;
  const dz = direction[kz]!;
  if (dz === 0 || !Number.isFinite(dz)) return [];
  // Turned against the axis, x and y change places: counterclockwise stays counterclockwise.
  const [kx, ky] = dz > 0 ? [(kz + 1) % 3, (kz + 2) % 3] : [(kz + 2) % 3, (kz + 1) % 3];
  const [sx, sy] = [direction[kx]! / dz, direction[ky]! / dz];
  const [ox, oy, oz] = [origin[kx]!, origin[ky]!, origin[kz]!];
  if (quadrants.length < vertices) quadrants = new Uint8Array(Math.ceil(1.5 * vertices));
  shear(positions, vertices, kx, ky, kz, ox, oy, oz, sx, sy, quadrants);

  const found: Hit[] = [];
  let at = candidate(corners, 0, 3 * triangles, quadrants);
  for (; at < 3 * triangles; at = candidate(corners, at + 3, 3 * triangles, quadrants)) {
    const [a, b, c] = [corners[at]!, corners[at + 1]!, corners[at + 2]!];
    const [pa, pb, pc] = [3 * a, 3 * b, 3 * c];
    // The same terms as in `shear`, or the sides would not fit the quadrants.
    const [az, bz, cz] = [positions[pa + kz]! - oz, positions[pb + kz]! - oz, positions[pc + kz]! - oz];
    const [ax, ay] = [positions[pa + kx]! - ox - sx * az, positions[pa + ky]! - oy - sy * az];
    const [bx, by] = [positions[pb + kx]! - ox - sx * bz, positions[pb + ky]! - oy - sy * bz];
    const [cx, cy] = [positions[pc + kx]! - ox - sx * cz, positions[pc + ky]! - oy - sy * cz];
    const [u, v, w] = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
    const area = u + v + w;
    if (area === 0) continue;
    const front = area > 0;
    if (front ? side === BackSide : side === FrontSide) continue;
    const weights: [number, number, number] = [u / area, v / area, w / area];
    const along = (weights[0] * az + weights[1] * bz + weights[2] * cz) / dz;
    found.push({ along, triangle: at / 3, corners: [a, b, c], weights, front });
  }
  return found;
}

/** The first place from `at` on, or `end`, of a triangle whose corners have no half plane in common. */
function candidate(corners: Uint32Array, at: number, end: number, quadrants: Uint8Array): number {
  for (; at < end; at += 3) {
    if ((quadrants[corners[at]!]! & quadrants[corners[at + 1]!]! & quadrants[corners[at + 2]!]!) === 0) return at;
  }
  return end;
}

function shear(
  positions: Float32Array, vertices: number, kx: number, ky: number, kz: number,
  ox: number, oy: number, oz: number, sx: number, sy: number, into: Uint8Array,
): void {
  for (let vertex = 0, at = 0; vertex < vertices; vertex++, at += 3) {
    const z = positions[at + kz]! - oz;
    const x = positions[at + kx]! - ox - sx * z;
    const y = positions[at + ky]! - oy - sy * z;
    into[vertex] = (x < 0 ? 1 : 2) | (y < 0 ? 4 : 8);
  }
}
