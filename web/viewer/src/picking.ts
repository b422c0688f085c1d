/** What is drawn at a point of the picture. */

import type { MeshfrontObject } from "@meshfront/three";
import { type Camera, Raycaster, type Vector2, Vector3 } from "three";

/** A point of a drawn surface; places and directions are those of the page. */
export interface Hit {
  object: MeshfrontObject;
  point: Vector3;
  normal: Vector3;
  distance: number;
  /** The triangle slot. */
  triangle: number;
}

const caster = new Raycaster();

/** @param at from -1 to 1, y upwards */
export function pick(at: Vector2, camera: Camera, objects: readonly MeshfrontObject[]): Hit | undefined {
  camera.updateMatrixWorld();
  caster.setFromCamera(at, camera);
  const [first] = caster.intersectObjects(objects.filter(({ visible }) => visible), false);
  if (!first?.face) return undefined;
  const object = first.object as MeshfrontObject;
  const normal = (first.normal ?? first.face.normal).clone().transformDirection(object.matrixWorld);
  return { object, point: first.point, normal, distance: first.distance, triangle: first.faceIndex! };
}
