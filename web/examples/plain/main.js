import "@meshfront/three/element";
import { MeshfrontObject } from "@meshfront/three";
import {
  DirectionalLight, HemisphereLight, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const canvas = document.getElementById("picture");
const said = document.getElementById("said");
const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
const camera = new PerspectiveCamera(40);
const controls = new OrbitControls(camera, canvas);
const light = new DirectionalLight(0xffffff, 2.5);
light.position.set(-0.8, 1, 0.6);
const scene = new Scene().add(camera.add(light, light.target), new HemisphereLight(0xe4ecf5, 0x3a322c));
light.target.position.set(0, 0, -1);

const model = new MeshfrontObject("model.front", { tolerancePx: 1 });
scene.add(model);
model.addEventListener("load", ({ info }) => {
  const { center, radius } = model.geometry.boundingSphere;
  camera.position.copy(center).add(new Vector3(0, 0, 3 * radius));
  [camera.near, camera.far] = [0.01 * radius, 10 * radius];
  controls.target.copy(center);
  said.textContent = `${info.sourceTriangles.toLocaleString()} triangles`;
});
model.addEventListener("load-error", ({ error }) => { said.textContent = `${error.message}. ${error.remedy}`; });
model.addEventListener("front-settled", ({ stats }) => { said.textContent = `${stats.triangles.toLocaleString()} triangles are drawn`; });

canvas.addEventListener("click", async ({ offsetX, offsetY }) => {
  const raycaster = new Raycaster();
  raycaster.setFromCamera(new Vector2((2 * offsetX) / canvas.clientWidth - 1, 1 - (2 * offsetY) / canvas.clientHeight), camera);
  const [hit] = raycaster.intersectObject(model);
  const found = hit && (await model.inspect(hit.faceIndex));
  if (hit) said.textContent = `${hit.point.toArray().map((x) => x.toFixed(3)).join(", ")}, within ${found?.error.toPrecision(2)}`;
});

renderer.setAnimationLoop(() => {
  const { clientWidth: width, clientHeight: height } = canvas;
  renderer.setPixelRatio(devicePixelRatio);
  renderer.setSize(width, height, false);
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
  controls.update();
  model.setResolutionFromRenderer(camera, renderer);
  model.update();
  renderer.render(scene, camera);
});
