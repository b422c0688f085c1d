/** Objects on the real engine where memory ends. */

import type { View } from "@meshfront/core";
import { PerspectiveCamera } from "three";
import { expect, test } from "vitest";
import { MeshfrontBudget } from "../src/budget.js";
import { MeshfrontObject } from "../src/object.js";
import { fixture, localBudget } from "./worker.js";

test("memory that another budget of the worker gives back is asked for, though nothing moves", async () => {
  const budget = localBudget({}, 12e6);
  const object = new MeshfrontObject(fixture("v1-knot-lossless-painted"), { budget, tolerancePx: 0 });
  object.cullFrustum = object.cullOrientation = false;
  const { sourceTriangles } = await object.ready;
  const { center, radius } = object.geometry.boundingSphere!;
  const beside = new MeshfrontBudget({ worker: budget });
  const { model } = await beside.client.duplicate(numberOf(object));
  const others = [model];
  const failure = await (async () => {
    for (;;) others.push((await beside.client.duplicate(model)).model);
  })().catch((thrown: unknown) => thrown);
  expect(failure).toMatchObject({ kind: "memory" });
  const view: View = {
    eye: [center.x, center.y, center.z + 2 * radius], target: center.toArray(), up: [0, 1, 0], fovY: 0.8, width: 300, height: 300, near: 0.01 * radius,
    tolerancePx: 0, frustum: false, orientation: false,
  };
  const limits = { maxTriangles: Infinity, maxBytes: Infinity, deadlineMs: 1000 };
  for (const model of others) {
    const [frame] = (await beside.client.adapt([{ model, views: [view] }], limits))!;
    if (frame!.stats.byteBound) break;
  }
  const camera = new PerspectiveCamera(45, 1, 0.01 * radius, 100 * radius);
  camera.position.copy(center).setZ(center.z + 3 * radius);
  object.setResolution(camera, 300, 300);
  object.update();
  await expect.poll(() => object.settled).toBe(true);
  expect(object.stats).toMatchObject({ byteBound: true });
  expect(object.stats!.triangles).toBeLessThan(sourceTriangles);
  // It asks by itself.
  beside.dispose();
  await expect.poll(() => object.settled && object.stats).toMatchObject({ byteBound: false, triangles: sourceTriangles });
  budget.dispose();
});

/** What the worker calls its model. */
function numberOf(object: MeshfrontObject): number {
  return (object as unknown as { opened: { model: number } }).opened.model;
}
