import type { Region, Vec3, View } from "@meshfront/core";
import { Matrix4, type Camera, Vector3 } from "three";

/** The parts of a view that a camera does not say. */
export interface Quality {
  tolerancePx: number;
  frustum: boolean;
  orientation: boolean;
  region: Region | undefined;
}

const meshFromWorld = new Matrix4();
const meshFromCamera = new Matrix4();
const point = new Vector3();

/** The size of a picture, device pixels. */
export interface Resolution {
  width: number;
  height: number;
}

/** An orthographic camera is a perspective one so many depths away: then pixels are at most 2 % smaller in front than behind. */
const DEPTHS_AWAY = 50;

/**
 * A camera as seen from the space of a mesh. Both world matrices must be up to date.
 *
 * Where the mesh is moved, turned, mirrored or scaled by one factor, the view is the camera's own. Where its axes are
 * scaled differently, no camera in mesh space makes the same picture: nothing is culled then, and the tolerance shrinks
 * by the ratio of the smallest to the largest scale, so that the promise in pixels still holds.
 *
 * An orthographic camera becomes a perspective one far behind it, whose picture holds all that it sees in pixels that are no
 * larger.
 */
export function meshView(camera: Camera, worldFromMesh: Matrix4, resolution: Resolution, quality: Quality): View {
  const p = camera.projectionMatrix.elements;
  const parallel = p[15] !== 0;
  const { smallest, largest } = scales(worldFromMesh);
  const similar = largest - smallest <= 1e-3 * largest;
  // An off-centre picture (setViewOffset, a tile of a larger image, one eye of a headset) is part of a larger one
  // that lies around the axis. It has the same pixels.
  const [shiftX, shiftY] = parallel ? [p[12]!, p[13]!] : [p[8]!, p[9]!];
  // Half of the picture, and pixels: at a distance of one, or anywhere.
  let [halfWidth, halfHeight] = [(1 + Math.abs(shiftX)) / p[0]!, (1 + Math.abs(shiftY)) / p[5]!];
  // Where pixels are not as wide as high, the smaller side counts.
  let pixels = Math.max(resolution.width * p[0]!, resolution.height * p[5]!) / 2;
  let { near = 0, far = 0 } = camera as { near?: number; far?: number };
  const back = parallel ? DEPTHS_AWAY * Math.max(far - near, 1e-6 * halfHeight) : 0;
  if (parallel) {
    [near, far] = [back + near, back + far];
    [halfWidth, halfHeight, pixels] = [halfWidth / near, halfHeight / near, pixels * far];
  }

  meshFromWorld.copy(worldFromMesh).invert();
  meshFromCamera.multiplyMatrices(meshFromWorld, camera.matrixWorld);
  const at = (x: number, y: number, z: number): Vec3 => point.set(x, y, z).applyMatrix4(meshFromCamera).toArray();
  const eye = at(0, 0, back);
  const above = at(0, 1, back);
  const view: View = {
    eye,
    target: at(0, 0, back - Math.max(1, back)),
    up: [above[0] - eye[0], above[1] - eye[1], above[2] - eye[2]],
    fovY: 2 * Math.atan(halfHeight),
    width: 2 * pixels * halfWidth,
    height: 2 * pixels * halfHeight,
    near: roundDown(near / largest),
    tolerancePx: (quality.tolerancePx * smallest) / largest,
    frustum: quality.frustum && similar,
    orientation: quality.orientation,
  };
  if (quality.region) view.region = quality.region;
  return view;
}

/**
 * To a power of two. Pages fit their near plane to the model in every frame; the engine need not look at every
 * decision again for that.
 */
function roundDown(length: number): number {
  return length > 0 ? 2 ** Math.floor(Math.log2(length)) : 0;
}

/** The least and the most that a transform stretches any direction (singular values of its linear part). */
export function scales(transform: Matrix4): { smallest: number; largest: number } {
  const m = transform.elements;
  // Gram matrix AᵀA; its eigenvalues are squares of the stretches (closed form for symmetric 3×3: Smith 1961).
  const dot = (i: number, j: number) => m[i]! * m[j]! + m[i + 1]! * m[j + 1]! + m[i + 2]! * m[j + 2]!;
  const [xx, yy, zz, xy, xz, yz] = [dot(0, 0), dot(4, 4), dot(8, 8), dot(0, 4), dot(0, 8), dot(4, 8)];
  const mean = (xx + yy + zz) / 3;
  const [dx, dy, dz] = [xx - mean, yy - mean, zz - mean];
  const spread = Math.sqrt((dx * dx + dy * dy + dz * dz + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
  if (spread <= 1e-12 * mean) return { smallest: Math.sqrt(mean), largest: Math.sqrt(mean) };
  const determinant = dx * (dy * dz - yz * yz) - xy * (xy * dz - yz * xz) + xz * (xy * yz - dy * xz);
  const angle = Math.acos(Math.min(1, Math.max(-1, determinant / (2 * spread ** 3)))) / 3;
  const largest = mean + 2 * spread * Math.cos(angle);
  const smallest = mean + 2 * spread * Math.cos(angle + (2 * Math.PI) / 3);
  return { smallest: Math.sqrt(Math.max(smallest, 0)), largest: Math.sqrt(largest) };
}

/** Whether two views, or two lists of them, ask for the same front. */
export function sameView<T extends View | readonly View[]>(a: T, b: T): boolean {
  return JSON.stringify(a) === JSON.stringify(b);
}
