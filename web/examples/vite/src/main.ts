/** Several objects that share a budget, shadows, and picking. */

import { MeshfrontBudget, MeshfrontObject } from "@meshfront/three";
import {
  CircleGeometry, DirectionalLight, HemisphereLight, Mesh, MeshBasicMaterial, MeshStandardMaterial, PerspectiveCamera, Raycaster,
  Scene, SphereGeometry, Vector2, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const canvas = document.querySelector<HTMLCanvasElement>("#picture")!;
const said = document.querySelector<HTMLElement>("#said")!;
const range = document.querySelector<HTMLInputElement>("#budget")!;

const renderer = new WebGLRenderer({ canvas, antialias: true });
renderer.shadowMap.enabled = true;
renderer.setClearColor(0xb9c3cc);
const camera = new PerspectiveCamera(40, 1, 0.05, 60);
camera.position.set(0, 2.4, 6.5);
const controls = new OrbitControls(camera, canvas);
controls.target.set(0, 0.9, -0.8);

const scene = new Scene();
const sun = new DirectionalLight(0xfff1e0, 3);
sun.position.set(-4, 6, 3);
sun.castShadow = true;
sun.shadow.mapSize.set(1024, 1024);
const table = new Mesh(new CircleGeometry(6, 64).rotateX(-Math.PI / 2), new MeshStandardMaterial({ color: 0x8a9096 }));
table.receiveShadow = true;
const pin = new Mesh(new SphereGeometry(0.04), new MeshBasicMaterial({ color: 0xd03020 }));
pin.visible = false;
scene.add(sun, table, pin, new HemisphereLight(0xe4ecf5, 0x3a322c, 0.8));

// One worker and one budget: what looks worst in any of them gets the triangles.
const budget = new MeshfrontBudget({ maxTriangles: 10 ** range.valueAsNumber, maxBytes: 256e6 });
const first = new MeshfrontObject("model.front", { budget });
// Clones have fronts of their own over the same data.
const models = [first, first.clone(), first.clone()];
models.forEach((model, i) => {
  model.castShadow = model.receiveShadow = true;
  model.addEventListener("load-error", ({ error }) => { said.textContent = `${error.message}. ${error.remedy}`; });
  model.addEventListener("front-settled", () => {
    const drawn = models.reduce((sum, { stats }) => sum + (stats?.triangles ?? 0), 0);
    if (budget.settled) said.textContent = `${drawn.toLocaleString()} triangles are drawn`;
  });
  void model.ready.then(() => {
    // Two units high, its foot on the table.
    const box = model.geometry.boundingBox!;
    const scale = 2 / (box.max.y - box.min.y);
    model.scale.setScalar(scale);
    model.position.set(2.4 * (i - 1), -scale * box.min.y, -2.5 * Math.abs(i - 1));
    scene.add(model);
  });
});

range.addEventListener("input", () => { budget.maxTriangles = 10 ** range.valueAsNumber; });

canvas.addEventListener("click", async ({ clientX, clientY }) => {
  const raycaster = new Raycaster();
  raycaster.setFromCamera(new Vector2((2 * clientX) / innerWidth - 1, 1 - (2 * clientY) / innerHeight), camera);
  const hit = raycaster.intersectObjects(models)[0];
  pin.visible = hit !== undefined;
  if (!hit) return;
  pin.position.copy(hit.point);
  const found = await (hit.object as MeshfrontObject).inspect(hit.faceIndex!);
  said.textContent = `The original surface is within ${found?.error.toPrecision(2)} of this point, in units of the scan.`;
});

renderer.setAnimationLoop(() => {
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.setSize(innerWidth, innerHeight, false);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
  controls.update();
  for (const model of models) model.setResolutionFromRenderer(camera, renderer);
  budget.update();
  renderer.render(scene, camera);
});
