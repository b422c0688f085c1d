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

/**
 * A perspective camera as seen from the space of a mesh. Both world matrices must be up to date.
 *
 * Where the mesh is moved, turned, mirrored or scaled by one factor, the view is the camera's own. Where its axes are
 * scaled differently, no camera in mesh space makes the same picture: nothing is culled then, and the tolerance shrinks
 * by the ratio of the smallest to the largest scale, so that the promise in pixels still holds.
 *
 * @param height of the picture, device pixels; its width follows from the camera's aspect
 * @throws TypeError where the camera is not a perspective one
 */
export function meshView(camera: Camera, worldFromMesh: Matrix4, height: number, quality: Quality): View {
  const p = camera.projectionMatrix.elements;
  if (p[15] !== 0) throw new TypeError("a pixel tolerance needs a perspective camera");
  const { smallest, largest } = scales(worldFromMesh);
  const similar = largest - smallest <= 1e-3 * largest;
  // An off-centre picture (setViewOffset, a tile of a larger image, one eye of a headset) is part of a larger one
  // that lies around the axis. It has the same pixels.
  const [halfWidth, halfHeight] = [(1 + Math.abs(p[8]!)) / p[0]!, (1 + Math.abs(p[9]!)) / p[5]!];
  const pixels = (height / 2) * p[5]!;

  meshFromWorld.copy(worldFromMesh).invert();
  meshFromCamera.multiplyMatrices(meshFromWorld, camera.matrixWorld);
  const at = (x: number, y: number, z: number): Vec3 => point.set(x, y, z).applyMatrix4(meshFromCamera).toArray();
  const eye = at(0, 0, 0);
  const above = at(0, 1, 0);
  const view: View = {
    eye,
    target: at(0, 0, -1),
    up: [above[0] - eye[0], above[1] - eye[1], above[2] - eye[2]],
    fovY: 2 * Math.atan(halfHeight),
    width: 2 * pixels * halfWidth,
    height: 2 * pixels * halfHeight,
    near: roundDown(((camera as { near?: number }).near ?? 0) / largest),
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

/** Whether two views ask for the same front. */
export function sameView(a: View, b: View): boolean {
  return JSON.stringify(a) === JSON.stringify(b);
}
