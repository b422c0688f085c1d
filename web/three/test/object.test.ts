/** Objects on the real engine, without a picture. */

import { DoubleSide, MeshBasicMaterial, OrthographicCamera, PerspectiveCamera, Raycaster, Vector2, Vector3 } from "three";
import { afterEach, expect, test, vi } from "vitest";
import { MeshfrontBudget } from "../src/budget.js";
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

test("several cameras: the finest counts, and one that goes is not looked through any more", async () => {
  const object = await open();
  const [far, near] = [cameraAt(object, [0, 0, 1], 20), cameraAt(object, [0.1, 0, 1], 2)];
  expect(object.setCamera(far)).toBe(true);
  expect(object.setCamera(far)).toBe(false);
  object.update();
  expect(object.settled).toBe(false);
  object.setResolution(far, 300, 300);
  await settle(object);
  const coarse = object.stats!.triangles;
  object.setResolution(near, 300, 300);
  await settle(object);
  const fine = object.stats!.triangles;
  expect(fine).toBeGreaterThan(1.2 * coarse);
  expect(object.deleteCamera(far)).toBe(true);
  await settle(object);
  expect(object.stats!.triangles).toBeLessThanOrEqual(fine);
  object.setCamera(far);
  object.setResolution(far, 300, 300);
  expect(object.deleteCamera(near)).toBe(true);
  expect(object.hasCamera(near)).toBe(false);
  await settle(object);
  expect(object.stats!.triangles).toBe(coarse);
});

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

test("whoever is told that a front is settled finds it so", async () => {
  const object = await open();
  object.setResolution(cameraAt(object, [0, 0, 1], 4), 200, 200);
  const told = new Promise<boolean>((resolve) => object.addEventListener("front-settled", () => resolve(object.settled)));
  object.update();
  expect(await told).toBe(true);
});

test("a view that comes while an answer is on its way is not forgotten", async () => {
  const object = await open();
  const camera = cameraAt(object, [0, 0, 1], 20);
  object.setResolution(camera, 200, 200);
  object.update();
  camera.position.multiplyScalar(0.1);
  object.update();
  await vi.waitFor(() => expect(object.settled).toBe(true));
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
    return adapt.mock.lastCall![0][0]!.views[0]!.orientation;
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

test("the base mesh is drawn before the model is open, and progress ends with 1, once", async () => {
  const budget = localBudget();
  budgets.push(budget);
  const object = new MeshfrontObject(fixture("v1-scan-16-bits"), { budget });
  const told: string[] = [];
  const fractions: (number | undefined)[] = [];
  object.addEventListener("load-base", ({ base }) => {
    told.push("base");
    expect(object.geometry.drawRange.count).toBe(base.triangles.length);
    expect(object.geometry.boundingSphere!.radius).toBeGreaterThan(0);
    expect(object.info).toBeUndefined();
  });
  object.addEventListener("needs-update", () => told.push("draw"));
  object.addEventListener("load", () => told.push("load"));
  object.addEventListener("load-progress", ({ fraction }) => fractions.push(fraction));
  const info = await object.ready;
  expect(told).toEqual(["base", "draw", "load", "draw"]);
  expect(object.geometry.drawRange.count).toBe(3 * info.baseTriangles);
  expect(fractions.filter((fraction) => fraction === 1)).toHaveLength(1);
  expect(fractions.at(-1)).toBe(1);
});

test("what is coloured by arrives though nothing moves, and goes when it is not asked for", async () => {
  const object = await open();
  object.setResolution(cameraAt(object, [0, 0, 1], 4), 200, 200);
  await settle(object);
  for (const column of ["error", "cone", "age"] as const) {
    object.shade = column;
    await settle(object);
    const values = [...(object.geometry.getAttribute("shade").array as Float32Array).subarray(0, object.stats!.vertices)];
    expect(values.every((value) => value >= 0 && Number.isFinite(value))).toBe(true);
    if (column !== "age") expect(Math.max(...values)).toBeGreaterThan(0);
    if (column === "error") expect(Math.max(...values)).toBeLessThanOrEqual(object.info!.baseError);
    if (column === "cone") expect(Math.max(...values)).toBeLessThanOrEqual(Math.PI + 1e-6);
  }
  object.shade = undefined;
  expect(object.geometry.hasAttribute("shade")).toBe(false);
});

test("a triangle that is met tells its update; one of a former front does not", async () => {
  const object = await open();
  const camera = cameraAt(object, [0, 0, 1], 4);
  object.setResolution(camera, 200, 200);
  await settle(object);
  camera.updateMatrixWorld();
  const raycaster = new Raycaster();
  raycaster.setFromCamera(new Vector2(0.05, 0.02), camera);
  const [hit] = raycaster.intersectObject(object);
  const found = (await object.inspect(hit!.faceIndex!))!;
  expect(found.error).toBeGreaterThan(0);
  expect(found.error).toBeLessThanOrEqual(object.info!.baseError);
  const inMesh = object.worldToLocal(hit!.point.clone());
  expect(inMesh.distanceTo(new Vector3(...found.center))).toBeLessThanOrEqual(2 * found.radius);
  const frame = vi.spyOn(object.budget.client, "inspect").mockResolvedValueOnce(undefined);
  expect(await object.inspect(hit!.faceIndex!)).toBeUndefined();
  expect(frame).toHaveBeenCalledWith(expect.any(Number), expect.any(Number), hit!.faceIndex);
});

test("bytes are a hard cap", async () => {
  const object = await open();
  object.setResolution(cameraAt(object, [0, 0, 1], 1.5), 800, 800);
  await settle(object);
  const bytes = ({ stats, bufferBytes }: MeshfrontObject) => stats!.frontBytes + 2 * bufferBytes;
  const free = bytes(object);
  object.maxBytes = Math.round(0.7 * free);
  await settle(object);
  expect(object.stats!.byteBound).toBe(true);
  expect(bytes(object)).toBeLessThanOrEqual(0.7 * free);
});

test("a clone has a front of its own over the same hierarchy", async () => {
  const object = await open();
  object.position.set(1, 2, 3);
  object.setResolution(cameraAt(object, [0, 0, 1], 30), 200, 200);
  const before = await object.budget.memory();
  const twin = object.clone();
  await twin.ready;
  expect(twin.geometry).not.toBe(object.geometry);
  expect(twin.position.toArray()).toEqual([1, 2, 3]);
  expect(twin.info).toMatchObject({ sourceTriangles: object.info!.sourceTriangles });
  const near = cameraAt(object, [0, 0, 1], 1.2);
  near.position.add(twin.position);
  twin.setResolution(near, 600, 600);
  await settle(object);
  expect(twin.stats!.triangles).toBeGreaterThan(object.stats!.triangles);
  expect((await object.budget.memory()).engineBytes - before.engineBytes).toBeLessThan(1 << 20);
  twin.dispose();
  object.update();
  await settle(object);
});

test("beside others, in their worker, an object keeps to limits of its own", async () => {
  const object = await open();
  const camera = cameraAt(object, [0, 0, 1], 3);
  object.setResolution(camera, 300, 300);
  object.maxTriangles = Math.round(1.5 * object.info!.baseTriangles);
  const budget = new MeshfrontBudget({ worker: object.budget });
  const whole = new MeshfrontObject(object, { budget, tolerancePx: 0 });
  whole.cullFrustum = whole.cullOrientation = false;
  await whole.ready;
  whole.setResolution(camera, 300, 300);
  await settle(whole);
  // Asked for again, now that the other one is complete.
  object.tolerancePx = 0.4;
  await settle(object);
  expect(whole.stats!.triangles).toBe(object.info!.sourceTriangles);
  expect(object.stats!.triangles).toBeLessThanOrEqual(object.maxTriangles);
  expect(object.stats!.triangles).toBeGreaterThan(1.2 * object.info!.baseTriangles);
  budget.dispose();
  object.maxTriangles = Infinity;
  await settle(object);
  expect(object.stats!.budgetBound).toBe(false);
  const elsewhere = localBudget();
  budgets.push(elsewhere);
  await expect(new MeshfrontObject(object, { budget: elsewhere }).ready).rejects.toMatchObject({ message: /another worker/ });
});
