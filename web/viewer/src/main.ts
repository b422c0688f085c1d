/** The page that `meshfront view` serves: models side by side, a front of each, one budget, one panel. */

import {
  levelMaterial, MeshfrontBudget, MeshfrontObject, totalStats, type FrameStats, type MeshfrontError, type ModelInfo,
} from "@meshfront/three";
import { Box3, Mesh, MeshBasicMaterial, MeshStandardMaterial, Sphere, Vector3 } from "three";
import { count, element, makePanel } from "./panel.js";
import { readCard, readParameters, type Card, type ModelCard, type Point } from "./parameters.js";
import { type Covered, makeStage, moveByKey } from "./stage.js";

const parameters = readParameters(location.search);
// Above two, more pixels cost more than they show.
const stage = makeStage(element<HTMLCanvasElement>("picture"), Math.min(devicePixelRatio, 2));
const { camera, controls, renderer, scene } = stage;

const CLAY = 0xd8c7b4;
const byLevel = levelMaterial({ polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
const lines = new MeshBasicMaterial({ color: 0x11161c, wireframe: true, transparent: true, opacity: 0.4 });

/** The same as in `style.css`, CSS pixels. */
const NARROW = 640;

// On a small screen the picture comes first.
const details = element<HTMLDetailsElement>("panel");
details.open = innerWidth > NARROW;

/** A model of the page, and how it looks when it is not coloured by level. */
interface Shown {
  object: MeshfrontObject;
  clay: MeshStandardMaterial;
}

let budget: MeshfrontBudget | undefined;
let shown: Shown[] = [];
let dirty = true;
let waiting: (() => void)[] = [];
const asked = { tolerancePx: parameters.tolerancePx, budget: parameters.budget, frozen: false };

const panel = makePanel({
  setTolerance,
  setBudget,
  freeze,
  wireframe: setWireframe,
  levels: setLevels,
  showAll,
});

function setTolerance(px: number): void {
  asked.tolerancePx = px;
  for (const { object } of shown) object.tolerancePx = px;
}

function setBudget(triangles: number): void {
  asked.budget = triangles;
  if (budget) budget.maxTriangles = triangles;
}

function freeze(on: boolean): void {
  asked.frozen = on;
  for (const { object } of shown) object.frozen = on;
  say(on ? "The front is frozen: it stays as it is while you look around." : "The front follows the view again.");
}

function setWireframe(on: boolean): void {
  lines.visible = on;
  dirty = true;
}

function setLevels(on: boolean): void {
  for (const { object, clay } of shown) object.material = on ? byLevel : clay;
  dirty = true;
}

function showAll(): void {
  const box = new Box3();
  for (const { object } of shown) {
    const { info } = object;
    if (info) box.union(new Box3(new Vector3(...info.min), new Vector3(...info.max)).applyMatrix4(object.matrixWorld));
  }
  if (!box.isEmpty()) stage.showAll(box);
  dirty = true;
}

/** The panel lies beside the picture, or under it where the page is narrow: then the title is above it. */
function covered(): Covered {
  const { offsetLeft, offsetTop, hidden, open } = details;
  if (hidden) return { top: 0, right: 0, bottom: 0 };
  if (innerWidth > NARROW) return { top: 0, right: open ? innerWidth - offsetLeft : 0, bottom: 0 };
  const title = element("title");
  return { top: title.offsetTop + title.offsetHeight, right: 0, bottom: innerHeight - offsetTop };
}

function setCamera(eye: Point, target: Point): void {
  camera.position.set(...eye);
  controls.target.set(...target);
  controls.update();
  dirty = true;
}

function say(text: string): void {
  element("status").textContent = text;
}

async function open(): Promise<void> {
  close();
  showTools(false);
  element("failure").hidden = true;
  element("loading").hidden = false;
  element<HTMLProgressElement>("loading-bar").removeAttribute("value");
  const card = await readCard(parameters.models);
  describe(card);
  const shared = new MeshfrontBudget({ maxTriangles: asked.budget });
  budget = shared;
  shown = card.models.map((model) => load(model, shared));
  const infos = await Promise.all(shown.map(({ object }) => object.ready)).catch(() => undefined);
  // A failure is told where it happened; and the page may have been asked to open again meanwhile.
  if (infos && budget === shared) ready(card, infos);
}

function load(card: ModelCard, budget: MeshfrontBudget): Shown {
  const clay = new MeshStandardMaterial({
    color: CLAY, roughness: 0.72, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
  const material = element<HTMLInputElement>("levels").checked ? byLevel : clay;
  const object = new MeshfrontObject(card.url, { name: card.name, material, tolerancePx: asked.tolerancePx, budget });
  object.frozen = asked.frozen;
  object.addEventListener("load-progress", ({ loaded, total }) => showProgress(card.name, loaded, total));
  object.addEventListener("load-error", ({ error }) => fail(error));
  object.addEventListener("needs-update", () => { dirty = true; });
  object.addEventListener("load", ({ info }) => {
    if (info.hasColors) {
      clay.color.set(0xffffff);
      clay.vertexColors = true;
    }
    // The page's own up is +y.
    object.quaternion.setFromUnitVectors(new Vector3(...info.up), new Vector3(0, 1, 0));
    if (card.at) object.position.set(...card.at);
    if (card.scale) object.scale.setScalar(card.scale);
    object.add(new Mesh(object.geometry, lines));
    scene.add(object);
    object.updateMatrixWorld();
  });
  return { object, clay };
}

function ready(card: Card, infos: ModelInfo[]): void {
  element("loading").hidden = true;
  showTools(parameters.panel);
  panel.setModels(infos);
  panel.setTolerance(asked.tolerancePx);
  panel.setBudget(asked.budget);
  const sum = (numbers: number[]) => numbers.reduce((total, n) => total + n, 0);
  const triangles = sum(card.models.map(({ source }, i) => source?.triangles ?? infos[i]!.sourceTriangles));
  const size = `${count(triangles)} triangles, ${(sum(infos.map(({ bytes }) => bytes)) / 1e6).toFixed(1)} MB`;
  element("subtitle").textContent = size;
  say(`${card.name} is loaded: ${size}.`);
  stage.resize(covered());
  showAll();
  if (parameters.eye) setCamera(parameters.eye, parameters.target ?? controls.target.toArray());
}

function close(): void {
  for (const { object, clay } of shown) {
    object.removeFromParent();
    object.dispose();
    clay.dispose();
  }
  budget?.dispose();
  budget = undefined;
  shown = [];
}

/** Of all fronts together, once each of them has been looked at. */
function stats(): FrameStats | undefined {
  const each = shown.flatMap(({ object }) => object.stats ?? []);
  return each.length === shown.length ? totalStats(each) : undefined;
}

/** Nothing can be set as long as nothing is shown. */
function showTools(on: boolean): void {
  details.hidden = !on;
  element("help").hidden = !on;
}

function describe(card: Card): void {
  document.title = `${card.name} – Meshfront`;
  element("name").textContent = card.name;
  element("credit").textContent = card.credit ?? "";
  element("credit").hidden = !card.credit;
}

function showProgress(name: string, loaded: number, total: number | undefined): void {
  const bar = element<HTMLProgressElement>("loading-bar");
  if (loaded === total) {
    // The worker checks the file and derives what is not stored: for millions of triangles that takes seconds.
    element("loading-text").textContent = `Opening ${name} …`;
    bar.removeAttribute("value");
    return;
  }
  const done = total ? `${Math.round((100 * loaded) / total)} %` : `${(loaded / 1e6).toFixed(1)} MB`;
  element("loading-text").textContent = `Loading ${name} … ${done}`;
  if (total) bar.value = loaded / total;
}

const TITLES: Record<MeshfrontError["kind"], string> = {
  missing: "There is no such file",
  network: "The file did not arrive",
  refused: "The server would not send the file",
  "not-front": "This is not a .front file",
  damaged: "The file is damaged",
  "too-new": "The file is too new",
  memory: "There is not enough memory",
  engine: "The engine stopped",
  closed: "The model was closed",
};

function fail(error: MeshfrontError): void {
  element("loading").hidden = true;
  element("failure-title").textContent = TITLES[error.kind];
  element("failure-what").textContent = error.message;
  // What stands between backticks is to be typed.
  const parts = error.remedy.split("`").map((part, i) => {
    const code = document.createElement("code");
    code.textContent = part;
    return i % 2 ? code : part;
  });
  element("failure-remedy").replaceChildren(...parts);
  element("failure").hidden = false;
}

function frame(): void {
  if (stage.resize(covered())) dirty = true;
  const moved = controls.update();
  const around = new Sphere().makeEmpty();
  for (const { object } of shown) {
    if (!object.info) continue;
    around.union(object.geometry.boundingSphere!.clone().applyMatrix4(object.matrixWorld));
    object.setResolutionFromRenderer(camera, renderer);
  }
  if (!around.isEmpty()) {
    if (moved || dirty) stage.fitDepth(around);
    budget?.update();
  }
  const now = stats();
  if (moved || dirty) {
    dirty = false;
    renderer.render(scene, camera);
    if (now) panel.show(now);
  }
  // Whether all is settled takes a look at every view: only where someone wants to know.
  if (waiting.length > 0 && now && (asked.frozen || budget?.settled) && !moved && !dirty) {
    for (const resolve of waiting) resolve();
    waiting = [];
  }
}

element("picture").addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "f" || event.key === "F") showAll();
  else if (!moveByKey(stage, event)) return;
  event.preventDefault();
  dirty = true;
});
element("retry").addEventListener("click", () => void open());

element("title").hidden = !parameters.panel;

lines.visible = parameters.wireframe;
panel.setSwitch("wireframe", parameters.wireframe);
panel.setSwitch("levels", parameters.levels);
panel.setTolerance(parameters.tolerancePx);
panel.setBudget(parameters.budget);

/** For consoles and tests. Points are in the page's space: that of a model whose y is up, unless it was moved. */
const meshfront = {
  /** Resolves once the front is all that the view asks for, and drawn. */
  settled: () => new Promise<FrameStats>((resolve) => waiting.push(() => resolve(stats()!))),
  stats,
  /** Of the first model. */
  info: () => shown[0]?.object.info,
  setCamera,
  setTolerance: (px: number) => { setTolerance(px); panel.setTolerance(px); },
  setBudget: (triangles: number) => { setBudget(triangles); panel.setBudget(triangles); },
  freeze: (on: boolean) => { freeze(on); panel.setSwitch("freeze", on); },
  /** Flies once around the first model in the worker, and tells what that took. */
  flyBy: () => shown[0]?.object.flyBy(),
  camera,
  get objects() { return shown.map(({ object }) => object); },
};
declare global {
  interface Window { meshfront: typeof meshfront }
}
window.meshfront = meshfront;

renderer.setAnimationLoop(frame);
void open();
