import { Euler, Matrix4, OrthographicCamera, PerspectiveCamera, Quaternion, Vector3 } from "three";
import { expect, test } from "vitest";
import { meshView, scales, type Quality } from "../src/view.js";

const QUALITY: Quality = {
  tolerancePx: 2, frustum: true, orientation: true, region: undefined,
};
const HEIGHT = 800;
const SIZE = { width: 1200, height: HEIGHT };

function cameraAt(eye: Vector3, target: Vector3): PerspectiveCamera {
  const camera = new PerspectiveCamera(50, 1.5, 0.1, 100);
  camera.position.copy(eye);
  camera.lookAt(target);
  camera.updateMatrixWorld();
  return camera;
}
const turned = new Quaternion().setFromEuler(new Euler(0.3, -1.1, 0.7));
const move = (scale: Vector3) => new Matrix4().compose(new Vector3(3, -2, 1), turned, scale);

/** Where a mesh-space point lies in the picture of a mesh-space view, pixels from the middle; by plain geometry. */
function pixels(view: ReturnType<typeof meshView>, point: Vector3): [number, number] {
  const eye = new Vector3(...view.eye);
  const forward = new Vector3(...view.target).sub(eye).normalize();
  const right = forward.clone().cross(new Vector3(...view.up)).normalize();
  const up = right.clone().cross(forward);
  const ray = point.clone().sub(eye);
  const scale = view.height / 2 / Math.tan(view.fovY / 2) / ray.dot(forward);
  return [ray.dot(right) * scale, ray.dot(up) * scale];
}

test.each([1, 0.01, 250])("a point lies where the camera sees it, whatever the mesh's place (scale %d)", (scale) => {
  const camera = cameraAt(new Vector3(5, 4, 6), new Vector3(3, -2, 1));
  const world = move(new Vector3(scale, scale, scale));
  const view = meshView(camera, world, SIZE, QUALITY);
  expect(view.width).toBeCloseTo(1200);
  expect(view.tolerancePx).toBeCloseTo(2, 3);
  expect(view.frustum).toBe(true);
  expect(view.near * scale).toBeLessThanOrEqual(0.1);
  expect(view.near * scale).toBeGreaterThan(0.04);
  for (const corner of [[0, 0, 0], [1, 0.5, -0.5], [-0.7, 1, 0.2]]) {
    const inMesh = new Vector3(...corner).divideScalar(scale);
    const ndc = inMesh.clone().applyMatrix4(world).project(camera);
    const [x, y] = pixels(view, inMesh);
    expect(x).toBeCloseTo((ndc.x * view.width) / 2, 1);
    expect(y).toBeCloseTo((ndc.y * HEIGHT) / 2, 1);
  }
});

test("an uneven scale asks for more, and culls nothing outside of the picture", () => {
  const camera = cameraAt(new Vector3(5, 4, 6), new Vector3());
  const view = meshView(camera, move(new Vector3(1, 4, 2)), SIZE, QUALITY);
  expect(view.frustum).toBe(false);
  expect(view.tolerancePx).toBeCloseTo(0.5);
});

test("the least and the greatest stretch", () => {
  expect(scales(move(new Vector3(3, 3, 3)))).toEqual({ smallest: expect.closeTo(3), largest: expect.closeTo(3) });
  const uneven = scales(move(new Vector3(-0.5, 7, 2)));
  expect(uneven).toEqual({ smallest: expect.closeTo(0.5), largest: expect.closeTo(7) });
  // A shear by 1: the golden ratio and its inverse.
  const shear = scales(new Matrix4().makeShear(1, 0, 0, 0, 0, 0));
  expect(shear).toEqual({ smallest: expect.closeTo(0.618, 3), largest: expect.closeTo(1.618, 3) });
});

test("an off-centre picture keeps its pixels, and what it shows lies within the view", () => {
  const camera = cameraAt(new Vector3(5, 4, 6), new Vector3());
  camera.setViewOffset(2400, 1600, 1300, 0, 1200, 800);
  camera.updateProjectionMatrix();
  const view = meshView(camera, new Matrix4(), SIZE, QUALITY);
  expect(view.frustum).toBe(true);
  // The middle of the whole picture, in device pixels of the tile.
  const [middleX, middleY] = [1200 - 1300, 800];
  for (const ndc of [[-1, -1], [1, 1], [0.2, -0.4]] as const) {
    const point = new Vector3(...ndc, 0.5).unproject(camera);
    const [x, y] = pixels(view, point);
    expect(middleX + x).toBeCloseTo(((ndc[0] + 1) / 2) * 1200, 1);
    expect(middleY - y).toBeCloseTo(((1 - ndc[1]) / 2) * 800, 1);
    expect(Math.abs(x)).toBeLessThanOrEqual(view.width / 2 + 0.1);
    expect(Math.abs(y)).toBeLessThanOrEqual(view.height / 2 + 0.1);
  }
});

test("where pixels are narrower than high, their width counts", () => {
  const camera = cameraAt(new Vector3(5, 4, 6), new Vector3());
  expect(meshView(camera, new Matrix4(), { width: 2400, height: HEIGHT }, QUALITY).height).toBeCloseTo(2 * HEIGHT);
  expect(meshView(camera, new Matrix4(), { width: 600, height: HEIGHT }, QUALITY).height).toBeCloseTo(HEIGHT);
});

test("an orthographic camera: all it sees lies within the view, in pixels hardly larger", () => {
  const camera = new OrthographicCamera(-3, 3, 2, -2, 0.1, 40);
  camera.position.set(5, 4, 6);
  camera.lookAt(3, -2, 1);
  camera.setViewOffset(2400, 1600, 1300, 0, 1200, 800);
  camera.updateMatrixWorld();
  const world = move(new Vector3(0.5, 0.5, 0.5));
  const view = meshView(camera, world, SIZE, QUALITY);
  const meshFromWorld = world.clone().invert();
  const inPicture = (x: number, y: number, z: number) => pixels(view, new Vector3(x, y, z).unproject(camera).applyMatrix4(meshFromWorld));
  for (const z of [-1, 0, 1]) {
    for (const [x, y] of [[-1, -1], [1, 1], [0.3, -0.6]] as const) {
      const [px, py] = inPicture(x, y, z);
      expect(Math.abs(px)).toBeLessThanOrEqual(view.width / 2 + 0.1);
      expect(Math.abs(py)).toBeLessThanOrEqual(view.height / 2 + 0.1);
      const [right, below] = inPicture(x + 0.01, y - 0.01, z);
      expect(right - px).toBeGreaterThan(0.0099 * 600);
      expect(right - px).toBeLessThan(0.0103 * 600);
      expect(py - below).toBeGreaterThan(0.0099 * 400);
      expect(py - below).toBeLessThan(0.0103 * 400);
    }
  }
});
