/** Objects on the real engine, without a picture. */

import { DoubleSide, MeshBasicMaterial, OrthographicCamera, PerspectiveCamera, Vector3 } from "three";
import { afterEach, expect, test, vi } from "vitest";
import type { MeshfrontBudget } from "../src/budget.js";
import { MeshfrontObject, type MeshfrontOptions } from "../src/object.js";
import { fixture, localBudget } from "./worker.js";

let budgets: MeshfrontBudget[] = [];
afterEach(() => {
  for (const budget of budgets) budget.dispose();
  budgets = [];
});

async function open(name = "v1-scan-16-bits", options: MeshfrontOptions = {}): Promise<MeshfrontObject> {
  const budget = localBudget();
  budgets.push(budget);
  const object = new MeshfrontObject(fixture(name), { budget, tolerancePx: 0.5, ...options });
  await object.ready;
  return object;
}

/** A camera that looks at the middle of the model, so many of its radii away. */
function cameraAt(object: MeshfrontObject, direction: [number, number, number], distance: number): PerspectiveCamera {
  const { center, radius } = object.geometry.boundingSphere!;
  const camera = new PerspectiveCamera(45, 1, 0.01 * radius, 100 * radius);
  camera.position.copy(center).addScaledVector(new Vector3(...direction).normalize(), distance * radius);
  camera.lookAt(center);
  return camera;
}

async function settle(object: MeshfrontObject): Promise<void> {
  for (object.update(); !object.settled; object.update()) await new Promise((soon) => setTimeout(soon, 2));
}

test("settled is told once, and again after the front was not", async () => {
  const object = await open();
  const camera = cameraAt(object, [0, 0, 1], 4);
  object.setResolution(camera, 200, 200);
  const told = vi.fn();
  object.addEventListener("front-settled", told);
  await settle(object);
  expect(told).toHaveBeenCalledOnce();
  for (let i = 0; i < 5; i++) object.update();
  await settle(object);
  expect(told).toHaveBeenCalledOnce();
  camera.position.multiplyScalar(1.5);
  await settle(object);
  expect(told).toHaveBeenCalledTimes(2);
  object.maxTriangles = object.stats!.triangles - 50;
  await settle(object);
  expect(told).toHaveBeenCalledTimes(3);
});

test("a frame is asked for when something changed, and not when nothing did", async () => {
  const object = await open();
  const camera = cameraAt(object, [0, 0, 1], 4);
  object.setResolution(camera, 200, 200);
  const needed = vi.fn();
  object.addEventListener("needs-update", needed);
  await settle(object);
  expect(needed).toHaveBeenCalled();
  needed.mockClear();
  camera.position.x += 1e-7 * camera.position.length();
  await settle(object);
  expect(needed).not.toHaveBeenCalled();
});

test("a failure is told, with what to do, and the promise rejects", async () => {
  const budget = localBudget();
  budgets.push(budget);
  const object = new MeshfrontObject(Uint8Array.of(1, 2, 3).buffer, { budget, name: "letter" });
  const told = vi.fn();
  object.addEventListener("load-error", ({ error }) => told(error));
  await expect(object.ready).rejects.toMatchObject({ kind: "not-front" });
  expect(told).toHaveBeenCalledExactlyOnceWith(expect.objectContaining({ message: expect.stringContaining("letter") }));
  object.update();
});

test("backs are coarse only where nobody sees them: neither by the material, nor a light", async () => {
  const object = await open();
  object.setResolution(cameraAt(object, [0, 0, 1], 4), 400, 400);
  const adapt = vi.spyOn(object.budget.client, "adapt");
  const isCulled = async (): Promise<boolean> => {
    await settle(object);
    return adapt.mock.lastCall![0][0]!.view.orientation;
  };
  expect(await isCulled()).toBe(true);
  object.castShadow = true;
  expect(await isCulled()).toBe(false);
  object.castShadow = false;
  expect(await isCulled()).toBe(true);
  object.material.side = DoubleSide;
  expect(await isCulled()).toBe(false);
});

test("an orthographic camera is followed as well", async () => {
  const object = await open();
  const { center, radius } = object.geometry.boundingSphere!;
  const camera = new OrthographicCamera(-radius, radius, radius, -radius, 0.1 * radius, 10 * radius);
  camera.position.copy(center).add(new Vector3(0, 0, 3 * radius));
  object.setResolution(camera, 300, 300);
  await settle(object);
  const whole = object.stats!;
  expect(whole.errorPx).toBeLessThanOrEqual(0.5);
  camera.zoom = 0.1;
  camera.updateProjectionMatrix();
  await settle(object);
  expect(object.stats!.triangles).toBeLessThan(whole.triangles);
});

test("colours switch on in a material of its own, and never in somebody else's", async () => {
  const own = await open("v1-knot-lossless-painted");
  expect(own.material.vertexColors).toBe(true);
  const material = new MeshBasicMaterial();
  await open("v1-knot-lossless-painted", { material });
  expect(material.vertexColors).toBe(false);
});

test("the geometry is the same from the first moment on, and is freed in the end", async () => {
  const object = await open();
  const { geometry, material } = object;
  object.setResolution(cameraAt(object, [0, 0, 1], 2), 400, 400);
  await settle(object);
  expect(object.geometry).toBe(geometry);
  expect(object.bufferBytes).toBeGreaterThan(object.stats!.triangles * 12);
  const memory = await object.budget.memory();
  expect(memory.bufferBytes).toBe(object.bufferBytes);
  const [freed, freedMaterial] = [vi.fn(), vi.fn()];
  geometry.addEventListener("dispose", freed);
  material.addEventListener("dispose", freedMaterial);
  object.dispose();
  expect(freed).toHaveBeenCalled();
  expect(freedMaterial).toHaveBeenCalled();
  object.update();
});
