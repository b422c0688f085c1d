/** Picking, held against three.js's own on the same triangles. */

import {
  BackSide, BufferAttribute, BufferGeometry, DoubleSide, FrontSide, IcosahedronGeometry, type Intersection, Matrix4, Mesh,
  MeshBasicMaterial, PerspectiveCamera, Raycaster, type Side, TorusKnotGeometry, Vector3,
} from "three";
import { mergeVertices } from "three/addons/utils/BufferGeometryUtils.js";
import { afterAll, beforeAll, expect, test } from "vitest";
import { MeshfrontObject } from "../src/object.js";
import { hits, type Soup } from "../src/raycast.js";
import { fixture, localBudget } from "./worker.js";

/** The same numbers in every run (mulberry32). */
function dice(seed: number): () => number {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
const random = dice(7);
const anyPoint = (radius: number) =>
  new Vector3(random() - 0.5, random() - 0.5, random() - 0.5).normalize().multiplyScalar(radius * random());

const budget = localBudget();
const object = new MeshfrontObject(fixture("v1-knot-lossless-painted"), { budget, tolerancePx: 0.3 });

beforeAll(async () => {
  const { min, max } = await object.ready;
  const camera = new PerspectiveCamera(40, 1, 0.01, 100);
  const center = new Vector3(...min).add(new Vector3(...max)).multiplyScalar(0.5);
  camera.position.copy(center).add(new Vector3(0, 0, 2 * center.distanceTo(new Vector3(...max))));
  camera.lookAt(center);
  object.setResolution(camera, 600, 600);
  const settled = new Promise((done) => object.addEventListener("front-settled", done));
  object.update();
  await settled;
  // three.js skips what lies outside of the box, and the box is that of the source.
  object.geometry.boundingBox = null;
});
afterAll(() => budget.dispose());

const PLACES: [string, Matrix4][] = [
  ["in place", new Matrix4()],
  ["moved, turned, scaled", new Matrix4().makeRotationX(1).scale(new Vector3(0.02, 0.02, 0.02)).setPosition(30, -2, 5)],
  ["mirrored", new Matrix4().makeRotationY(2).scale(new Vector3(-1, 1, 1))],
  ["stretched and mirrored", new Matrix4().makeRotationZ(0.4).scale(new Vector3(3, -0.5, 1)).multiply(new Matrix4().makeRotationX(0.7))],
];

test.each(PLACES)("the same triangles as three.js, %s", (_, place) => {
  object.matrixAutoUpdate = false;
  object.matrix.copy(place);
  object.updateMatrixWorld(true);
  const { center, radius } = object.geometry.boundingSphere!.clone().applyMatrix4(place);
  const raycaster = new Raycaster();
  let [met, missed, odd] = [0, 0, 0];
  for (let i = 0; i < 3000; i++) {
    object.material.side = [FrontSide, BackSide, DoubleSide][i % 3] as Side;
    const from = center.clone().add(anyPoint(3 * radius));
    const to = center.clone().add(anyPoint(radius));
    raycaster.set(from, to.sub(from).normalize());
    [raycaster.near, raycaster.far] = i % 4 === 0 ? [0.5 * radius, 2 * radius] : [0, Infinity];
    const ours: Intersection[] = [];
    object.raycast(raycaster, ours);
    const theirs: Intersection[] = [];
    Mesh.prototype.raycast.call(object, raycaster, theirs);
    const faces = (all: Intersection[]) => all.map(({ faceIndex }) => faceIndex!).sort((a, b) => a - b);
    if (JSON.stringify(faces(ours)) !== JSON.stringify(faces(theirs))) {
      // Within rounding of an edge: theirs may slip through, or meet both neighbours.
      const differing = [...ours, ...theirs].filter(({ faceIndex }) =>
        faces(ours).includes(faceIndex!) !== faces(theirs).includes(faceIndex!));
      for (const { barycoord, distance } of differing) {
        const onEdge = Math.min(...barycoord!.toArray()) < 1e-6;
        const onPlane = [raycaster.near, raycaster.far].some((limit) => Math.abs(distance - limit) < 1e-9 * radius);
        expect(onEdge || onPlane).toBe(true);
      }
      odd++;
      continue;
    }
    met += ours.length;
    if (ours.length === 0) missed++;
    const byFace = new Map(theirs.map((hit) => [hit.faceIndex, hit]));
    for (const hit of ours) {
      const other = byFace.get(hit.faceIndex)!;
      expect(hit.distance).toBeCloseTo(other.distance, 5 - Math.round(Math.log10(radius)));
      expect(hit.point.distanceTo(other.point)).toBeLessThan(1e-6 * radius);
      expect(hit.face).toMatchObject({ a: other.face!.a, b: other.face!.b, c: other.face!.c });
      expect(hit.face!.normal.dot(other.face!.normal)).toBeGreaterThan(0.999999);
      expect(hit.normal!.distanceTo(other.normal!)).toBeLessThan(1e-3);
      expect(hit.object).toBe(object);
    }
  }
  expect(met).toBeGreaterThan(500);
  expect(missed).toBeGreaterThan(300);
  expect(odd).toBeLessThan(15);
});

test("what three.js's Raycaster says of a scene: the nearest first, and free slots never", () => {
  object.matrix.identity();
  object.updateMatrixWorld(true);
  object.material.side = DoubleSide;
  const { center, radius } = object.geometry.boundingSphere!;
  const raycaster = new Raycaster();
  for (let i = 0; i < 200; i++) {
    const from = center.clone().add(anyPoint(2 * radius));
    raycaster.set(from, center.clone().add(anyPoint(0.5 * radius)).sub(from).normalize());
    const found = raycaster.intersectObject(object);
    for (let k = 1; k < found.length; k++) expect(found[k]!.distance).toBeGreaterThanOrEqual(found[k - 1]!.distance);
    for (const { face } of found) expect(face!.a).not.toBe(face!.b);
  }
});

/** A closed surface around its middle, edges shared. */
function soupOf(geometry: BufferGeometry): Soup {
  geometry.deleteAttribute("normal");
  geometry.deleteAttribute("uv");
  const merged = mergeVertices(geometry, 1e-4);
  const positions = merged.getAttribute("position").array as Float32Array;
  const corners = Uint32Array.from(merged.index!.array);
  return { positions, vertices: positions.length / 3, corners, triangles: corners.length / 3 };
}

test("no ray falls through edges or vertices", () => {
  const sphere = soupOf(new IcosahedronGeometry(1, 7));
  const at = (vertex: number) => new Vector3().fromArray(sphere.positions, 3 * vertex);
  let rays = 0;
  for (let t = 0; t < sphere.triangles; t++) {
    for (let k = 0; k < 3; k++) {
      const [a, b] = [at(sphere.corners[3 * t + k]!), at(sphere.corners[3 * t + ((k + 1) % 3)]!)];
      for (const part of [0, 0.5, random()]) {
        const through = a.clone().lerp(b, part);
        // From the middle, and from outside along other directions.
        const outside = through.clone().multiplyScalar(2).add(anyPoint(0.5));
        for (const origin of [new Vector3(), outside]) {
          const direction = through.clone().sub(origin);
          const found = hits(sphere, origin.toArray(), direction.toArray(), DoubleSide).filter(({ along }) => along > 0);
          expect(found.length).toBeGreaterThan(0);
          expect(Math.min(...found.map(({ along }) => Math.abs(along - 1)))).toBeLessThan(1e-5);
          rays++;
        }
      }
    }
  }
  expect(rays).toBeGreaterThan(3_000);
});

test("a ray along an axis meets a grid whose vertices it goes through exactly", () => {
  const positions: number[] = [];
  const corners: number[] = [];
  for (let x = 0; x <= 4; x++) for (let y = 0; y <= 4; y++) positions.push(x, y, 1);
  for (let x = 0; x < 4; x++) {
    for (let y = 0; y < 4; y++) {
      const a = 5 * x + y;
      corners.push(a, a + 5, a + 6, a, a + 6, a + 1);
    }
  }
  const grid: Soup = { positions: Float32Array.from(positions), vertices: 25, corners: Uint32Array.from(corners), triangles: 32 };
  for (let x = 0.5; x < 4; x += 0.5) {
    for (let y = 0.5; y < 4; y += 0.5) {
      expect(hits(grid, [x, y, 0], [0, 0, 1], DoubleSide).length).toBeGreaterThan(0);
      expect(hits(grid, [x, y, 3], [0, 0, -2], FrontSide).length).toBeGreaterThan(0);
      expect(hits(grid, [x, y, 3], [0, 0, -2], BackSide)).toEqual([]);
    }
  }
  expect(hits(grid, [5, 2, 0], [0, 0, 1], DoubleSide)).toEqual([]);
  expect(hits(grid, [1, 1, 0], [0, 0, 0], DoubleSide)).toEqual([]);
});

test("points are where the weights say, on surfaces of all sorts", () => {
  const knot = soupOf(new TorusKnotGeometry(1, 0.3, 200, 24));
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(knot.positions, 3));
  geometry.setIndex(new BufferAttribute(knot.corners, 1));
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ side: DoubleSide }));
  for (let i = 0; i < 500; i++) {
    const [origin, target] = [anyPoint(4), anyPoint(1)];
    const direction = target.clone().sub(origin).normalize();
    const theirs = new Raycaster(origin, direction).intersectObject(mesh).map(({ distance }) => distance);
    const ours = hits(knot, origin.toArray(), direction.toArray(), DoubleSide)
      .map(({ along }) => along).filter((along) => along >= 0).sort((a, b) => a - b);
    expect(ours).toHaveLength(theirs.length);
    ours.forEach((along, k) => expect(along).toBeCloseTo(theirs[k]!, 6));
  }
});
