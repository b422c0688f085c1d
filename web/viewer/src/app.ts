/** What belongs together: models, what is asked of their fronts, what is said of them, and what is drawn. */

import { MeshfrontBudget, MeshfrontObject, totalStats, type FrameStats, type MeshfrontError, type ModelInfo } from "@meshfront/three";
import { Box3, Mesh, Sphere, Vector2, Vector3 } from "three";
import { type Address, type Point, writeAddress } from "./address.js";
import { makeAppearance } from "./appearance.js";
import { backgroundCss } from "./backgrounds.js";
import { readCard, sourceOf, type Card, type ModelCard } from "./card.js";
import { makeCompare } from "./compare.js";
import { makeControls } from "./controls.js";
import { copyText, download, element } from "./dom.js";
import { listenToDrops, type Refusal } from "./drop.js";
import { makeFailure, wordsOf } from "./failure.js";
import { makeLoading } from "./loading.js";
import { makeMeasuring } from "./measure.js";
import { figuresOf, totalOf, trianglesOf, type Figures, type Shown } from "./models.js";
import { makeNavigation, type Side } from "./navigation.js";
import { drawFrustum, drawSpheres, type Frustum, type Spheres } from "./overlays.js";
import { makePanel } from "./panel.js";
import { pick } from "./picking.js";
import { DEFAULTS, type Settings, type Up, type Values } from "./settings.js";
import { compose } from "./shot.js";
import { FOV, type Covered, type Stage } from "./stage.js";
import { tellView } from "./tell.js";
import { bytes, choose, count, label, texts, worded } from "./texts/index.js";
import { followTheme } from "./theme.js";
import { listenToKeys, makeToolbar, showKeys, type Actions } from "./toolbar.js";

/** The same as in `style.css`, CSS pixels. */
const NARROW = 640;
/** What is switched off is as coarse as it gets. */
const HIDDEN_PX = 1e9;
/** Numbers change faster than anybody reads: this often is enough, milliseconds. */
const FIGURES_MS = 100;
/** The address follows when the camera rests, milliseconds. */
const ADDRESS_MS = 300;
/** How long a message stays to be seen, milliseconds; it stays to be read aloud. */
const MESSAGE_MS = 5000;

/** Starts the page; what comes back is for consoles and tests. */
export function start(stage: Stage, settings: Settings, address: Address) {
  const { camera, canvas, renderer, scene } = stage;
  const appearance = makeAppearance(settings);
  const loading = makeLoading();
  const failure = makeFailure();
  const details = element<HTMLDetailsElement>("panel");
  // On a small screen the picture comes first.
  details.open = innerWidth > NARROW;

  let card: Card | undefined;
  let budget: MeshfrontBudget | undefined;
  let shown: Shown[] = [];
  let spheres: Spheres[] = [];
  let engineBytes: number | undefined;
  let dirty = true;
  /** The engine's answer changed what is drawn. */
  let answered = false;
  let framed = false;
  let opened = false;
  let waiting: (() => void)[] = [];
  let framesPerSecond: number | undefined;
  const changed = () => { dirty = true; };

  let isDark = true;
  followTheme(settings, (dark) => {
    isDark = dark;
    paint();
  });
  const visible = () => shown.filter((model) => model.visible).map(({ object }) => object);
  const navigation = makeNavigation(stage, (at) => pick(at, camera, visible())?.distance);
  const compare = makeCompare(settings, stage, changed);
  const measuring = makeMeasuring(settings, {
    canvas, camera, say,
    objects: visible,
    middle: () => new Vector2(-camera.projectionMatrix.elements[8]!, -camera.projectionMatrix.elements[9]!),
    errorAt: ({ object, distance }) => (object.stats?.errorPx ?? 0) * pixelAt(distance),
  });
  const panel = makePanel(settings, { setVisible, say });
  const controls = makeControls(settings, measuring.readings);

  const chooseFile = listenToDrops({
    canBuild: () => card?.build ?? false,
    building: loading.building,
    open: (models) => void open({ name: models.map(({ name }) => name).join(", "), models, build: card?.build ?? false }),
    refuse,
  });
  const actions: Actions = {
    fit: () => navigation.fit(boxOf(visible())),
    home: () => { settings.set("flying", false); home(); },
    look: (side) => { settings.set("flying", false); navigation.lookFrom(boxOf(visible()), side); },
    compare: () => settings.set("divider", settings.now.divider === undefined ? 0.5 : undefined),
    shot: () => void shot(),
    link: () => void link(),
    tell: () => say(tellView(camera, boxOf(visible()))),
    keys: showKeys,
    open: chooseFile,
  };
  makeToolbar(settings, actions);
  listenToKeys(canvas, settings, actions, (event) => {
    if (event.key === "Escape") {
      const wasOn = settings.now.flying || settings.now.measuring || settings.now.crosshair;
      for (const mode of ["flying", "measuring", "crosshair"] as const) settings.set(mode, false);
      return wasOn;
    }
    return navigation.key(event);
  });

  label(element("help"), (t) => t.hint);
  element("title").hidden = !address.panel;

  // What a person sets, and what follows from it.
  for (const key of ["tolerancePx", "frustum", "orientation", "frozen"] as const) settings.on(key, askOfAll);
  for (const key of ["maxTriangles", "maxBytes", "deadlineMs"] as const) settings.on(key, limit);
  for (const key of ["colorBy", "surface", "vertexColors"] as const) settings.on(key, dress);
  settings.follow("wireframe", (on) => { appearance.lines.visible = on; dirty = true; });
  settings.on("spheres", refreshSpheres);
  settings.on("background", paint);
  settings.on("up", () => { placeAll(); measuring.clear(); if (shown.length > 0) navigation.lookFrom(boxOf(visible()), "first", false); });
  settings.follow("flying", (on) => {
    navigation.fly(on);
    element("help").textContent = on ? texts().flyHint : texts().hint;
    dirty = true;
  });
  settings.on("flying", (on) => say(on ? texts().flyHint : texts().navigation.orbiting));
  let frustum: Frustum | undefined;
  settings.on("frozen", (on) => {
    frustum?.erase();
    frustum = on ? drawFrustum(camera, scene) : undefined;
    dirty = true;
    say(on ? texts().quality.frozen : texts().quality.thawed);
  });
  settings.onAny(rememberSoon);

  /** Asks of a front what is set, unless its model is switched off. */
  function ask({ object, visible }: Shown): void {
    const { tolerancePx, frustum, orientation, frozen, colorBy } = settings.now;
    object.tolerancePx = visible ? tolerancePx : HIDDEN_PX;
    object.cullFrustum = frustum;
    object.cullOrientation = orientation;
    object.frozen = frozen && visible;
    object.visible = visible;
    object.shade = colorBy === "none" || colorBy === "level" ? undefined : colorBy;
  }
  function askOfAll(): void {
    shown.forEach(ask);
    dirty = true;
  }
  function limit(): void {
    if (budget) Object.assign(budget, limits());
  }
  function limits() {
    const { maxTriangles, maxBytes, deadlineMs } = settings.now;
    return { maxTriangles, maxBytes, deadlineMs };
  }
  function dress(): void {
    for (const { object } of shown) object.material = appearance.material(object.geometry.hasAttribute("color"));
    askOfAll();
  }
  function paint(): void {
    canvas.style.background = backgroundCss(settings.now.background, isDark);
    dirty = true;
  }
  function setVisible(model: number, on: boolean): void {
    shown[model]!.visible = on;
    ask(shown[model]!);
    dirty = true;
  }
  function refreshSpheres(): void {
    for (const each of spheres) each.refresh();
    dirty = true;
  }

  /** Turns and moves a model to where it is to be shown; the page's own up is +y. */
  function place({ card, object }: Shown, own: readonly number[]): void {
    object.quaternion.setFromUnitVectors(upOf(settings.now.up, own), new Vector3(0, 1, 0));
    if (card.at) object.position.set(...card.at);
    if (card.scale) object.scale.setScalar(card.scale);
    scene.add(object);
    object.updateMatrixWorld();
    dirty = true;
  }
  function placeAll(): void {
    for (const model of shown) if (model.object.info) place(model, model.object.info.up);
  }

  /** The first look, once it is known where everything is. */
  function frameAll(): void {
    if (framed || !shown.every(({ object }) => object.parent === scene)) return;
    framed = true;
    stage.resize(covered());
    home(false);
  }
  function home(travel = true): void {
    const box = boxOf(shown.map(({ object }) => object));
    navigation.bound(box);
    const { eye, target } = address;
    const isOwn = card?.models.some(({ file }) => file) ?? false;
    if (eye && !isOwn) navigation.lookAt(eye, target ?? box.getCenter(new Vector3()).toArray(), travel);
    else navigation.lookFrom(boxOf(visible()), "first", travel);
    if (settings.now.flying) {
      // The speed suits what is ahead.
      navigation.fly(false);
      navigation.fly(true);
    }
    dirty = true;
  }

  let turn = 0;
  async function open(wanted?: Card): Promise<void> {
    const before = card;
    // The page may be asked to open something else before this is there.
    const mine = ++turn;
    close();
    // What is not there yet cannot stay as it is.
    settings.set("frozen", false);
    showTools(false);
    failure.hide();
    loading.begin(wanted?.models.length ?? 1);
    // Its worker gets ready while the page finds out what to open.
    const shared = new MeshfrontBudget(limits());
    budget = shared;
    const found = wanted ?? (await readCard(address.models));
    const sources = await Promise.all(found.models.map(sourceOf));
    if (mine !== turn) return;
    card = found;
    describe();
    loading.begin(found.models.length);
    const fail = (error: MeshfrontError) => {
      loading.end();
      // What is drawn stays, where the engine stopped in flight.
      const back = opened ? () => canvas.focus() : wanted && before ? () => void open(before) : undefined;
      failure.show(wordsOf(error), { retry: () => void open(wanted), ...(back ? { close: back } : {}) });
    };
    for (const [i, model] of found.models.entries()) load(model, i, sources[i]!, shared, fail);
    const infos = await Promise.all(shown.map(({ object }) => object.ready)).catch(() => undefined);
    // A failure is told where it happened.
    if (infos && mine === turn) ready(infos);
  }

  function load(card: ModelCard, i: number, source: string | ArrayBuffer, budget: MeshfrontBudget, fail: (error: MeshfrontError) => void): void {
    const { tolerancePx } = settings.now;
    const object = new MeshfrontObject(source, { name: card.name, material: appearance.material(false), tolerancePx, budget });
    const model: Shown = { card, object, visible: true };
    shown[i] = model;
    ask(model);
    object.add(new Mesh(object.geometry, appearance.lines));
    object.addEventListener("load-progress", (progress) => loading.progress(i, card.name, progress));
    object.addEventListener("load-error", ({ error }) => fail(error));
    object.addEventListener("needs-update", () => { answered = dirty = true; });
    object.addEventListener("load-base", ({ base }) => arrive(model, base.up));
    object.addEventListener("load", ({ info }) => arrive(model, info.up));
    object.addEventListener("front-settled", settledNow);
    spheres[i] = drawSpheres(object, () => settings.now.spheres, changed);
  }
  function arrive(model: Shown, up: readonly number[]): void {
    place(model, up);
    model.object.material = appearance.material(model.object.geometry.hasAttribute("color"));
    frameAll();
  }

  function ready(infos: ModelInfo[]): void {
    loading.end();
    opened = true;
    showTools(address.panel);
    panel.setModels(shown);
    controls.setRange(totalOf(infos, "baseTriangles"), totalOf(infos, "sourceTriangles"));
    controls.setErrors(appearance.errorRange(Math.max(...infos.map(({ baseError }) => baseError))));
    controls.setPainted(infos.some(({ hasColors }) => hasColors));
    describe();
    say(texts().title.loaded(card!.name, element("subtitle").textContent), true);
    // The panel is there now: the middle of the picture is elsewhere.
    framed = false;
    frameAll();
    compare.setModels(shown);
    refreshSpheres();
  }

  function settledNow(): void {
    refreshSpheres();
    void budget?.memory().then((memory) => { engineBytes = memory.engineBytes || undefined; dirty = true; }, () => {});
  }

  function close(): void {
    for (const each of spheres) each.dispose();
    for (const { object } of shown) {
      object.removeFromParent();
      object.dispose();
    }
    measuring.clear();
    compare.setModels([]);
    budget?.dispose();
    budget = undefined;
    [shown, spheres] = [[], []];
    [framed, opened] = [false, false];
  }

  /** Nothing can be set as long as nothing is shown. */
  function showTools(on: boolean): void {
    element("dock").hidden = !on;
    element("help").hidden = !on;
  }

  function describe(): void {
    canvas.setAttribute("aria-label", texts().pictureLabel(card?.name ?? "Meshfront"));
    if (!card) return;
    const { name, credit } = card;
    document.title = `${name} – Meshfront`;
    element("name").textContent = name;
    element("credit").textContent = credit ?? "";
    element("credit").hidden = !credit;
    if (!opened) return;
    const infos = shown.flatMap(({ object }) => object.info ?? []);
    const triangles = shown.reduce((sum, model) => sum + trianglesOf(model), 0);
    element("subtitle").textContent = texts().title.size(count(triangles), bytes(totalOf(infos, "bytes")));
  }
  worded(describe);

  let hush = 0;
  /** For all to read, and to be read aloud; `quietly`: the latter alone. */
  function say(text: string, quietly = false): void {
    const status = element("status");
    // The same words again are said again.
    status.textContent = status.textContent === text ? `${text} ` : text;
    status.classList.toggle("shown", !quietly);
    clearTimeout(hush);
    hush = window.setTimeout(() => status.classList.remove("shown"), MESSAGE_MS);
  }

  function refuse(refusal: Refusal): void {
    if (opened) loading.end();
    const { name } = refusal;
    failure.show(({ drop }) => {
      switch (refusal.why) {
        case "unknown": return [drop.notOpened, drop.unknown(name), drop.unknownRemedy];
        case "no-build": return [drop.notOpened, drop.noBuild(name), drop.noBuildRemedy];
        case "broken": return [drop.notBuilt, drop.broken, drop.brokenRemedy];
        case "not-built": return [drop.notBuilt, refusal.what, refusal.remedy];
      }
    }, { close: () => canvas.focus() });
  }

  /** The panel lies beside the picture, or under it where the page is narrow: then the title is above it. */
  function covered(): Covered {
    const dock = element("dock");
    if (dock.hidden) return { top: 0, right: 0, bottom: 0 };
    if (innerWidth > NARROW) return { top: 0, right: details.open ? innerWidth - details.offsetLeft : 0, bottom: 0 };
    const title = element("title");
    return { top: title.offsetTop + title.offsetHeight, right: 0, bottom: innerHeight - dock.offsetTop };
  }

  /** The size of a pixel at this distance, units of the page. */
  function pixelAt(distance: number): number {
    return (2 * Math.tan((FOV * Math.PI) / 360) * distance) / Math.max(canvas.height, 1);
  }

  /** Of all fronts that are to be seen together, once each of them has been looked at. */
  function stats(): FrameStats | undefined {
    const objects = visible();
    const each = objects.flatMap(({ stats }) => stats ?? []);
    return opened && each.length === objects.length ? totalStats(each) : undefined;
  }

  /** Of all models together: the engine is one. */
  function figures(stats: FrameStats): Figures {
    return figuresOf(shown, stats, { name: card!.name, engineBytes, framesPerSecond, pixel: pixelAt(pivotDistance()) });
  }
  function figuresOfEach(): (Figures | undefined)[] {
    return shown.map((model) => {
      const { stats, info } = model.object;
      if (!stats || !info) return undefined;
      const engineBytes = info.hierarchyBytes + stats.frontBytes;
      return figuresOf([model], stats, { name: model.card.name, engineBytes, framesPerSecond, pixel: pixelAt(pivotDistance()) });
    });
  }
  function pivotDistance(): number {
    return camera.position.distanceTo(navigation.target);
  }

  async function shot(): Promise<void> {
    download(`${card?.name ?? "meshfront"}.png`, await new Promise<Blob>((resolve) => {
      draw();
      compose(canvas, settings.now.background, isDark, measuring.lines()).toBlob((blob) => resolve(blob!), "image/png");
    }));
  }

  function query(forSomebody = false): string {
    const defaults = { ...DEFAULTS, language: choose(navigator.languages) };
    return writeAddress(location.search, settings.now, defaults, camera.position.toArray(), navigation.target.toArray(), forSomebody);
  }
  async function link(): Promise<void> {
    remember();
    const url = new URL(query(true), location.href).href;
    say((await copyText(url)) ? texts().panel.linkCopied : url);
  }
  let later = 0;
  function rememberSoon(): void {
    clearTimeout(later);
    later = window.setTimeout(remember, ADDRESS_MS);
  }
  function remember(): void {
    clearTimeout(later);
    // A file that a person dropped has no address.
    if (opened && !card!.models.some(({ file }) => file)) history.replaceState(null, "", query());
  }

  function draw(): void {
    if (compare.on) compare.draw();
    else stage.draw();
  }

  function fitDepth(): void {
    const around = new Sphere().makeEmpty();
    for (const { object, visible } of shown) {
      if (visible && object.parent === scene) around.union(object.geometry.boundingSphere!.clone().applyMatrix4(object.matrixWorld));
    }
    if (frustum) around.union(frustum.around);
    if (!around.isEmpty()) stage.fitDepth(around, pivotDistance());
  }

  let lastFrame = 0;
  let lastFigures = -Infinity;
  let figuresLate = false;
  function frame(now: number): void {
    const seconds = (now - lastFrame) / 1000;
    lastFrame = now;
    if (stage.resize(covered())) dirty = true;
    const moved = navigation.update(seconds);
    if (moved && opened) rememberSoon();
    const placed = shown.filter(({ object }) => object.parent === scene);
    for (const { object } of placed) object.setResolutionFromRenderer(camera, renderer);
    if (placed.length > 0) {
      if (moved || dirty) fitDepth();
      budget?.update();
      compare.update(camera, renderer);
    }
    const drawn = moved || dirty;
    dirty = false;
    if (drawn) {
      draw();
      // A pause is no slow frame.
      if (seconds < 1) framesPerSecond = 1 / (framesPerSecond ? 0.9 / framesPerSecond + 0.1 * seconds : seconds);
      figuresLate = true;
    } else if (framesPerSecond !== undefined) {
      framesPerSecond = undefined;
      figuresLate = true;
    }
    measuring.update(drawn);
    const isDue = figuresLate && now - lastFigures > FIGURES_MS;
    // Summing up is for those who look.
    const all = answered || isDue || waiting.length > 0 ? stats() : undefined;
    if (all && answered) {
      answered = false;
      panel.record(figures(all));
    }
    if (all && isDue) {
      figuresLate = false;
      lastFigures = now;
      panel.show(figures(all), figuresOfEach());
    }
    // Whether all is settled takes a look at every view: only where someone wants to know.
    if (waiting.length > 0 && all && (settings.now.frozen || budget?.settled) && !drawn && !dirty) {
      for (const resolve of waiting) resolve();
      waiting = [];
    }
  }

  canvas.addEventListener("webglcontextlost", () => {
    failure.show((t) => t.failures.lost, { reload: true });
  });
  canvas.addEventListener("webglcontextrestored", () => {
    failure.hide();
    say(texts().failures.restored);
    dirty = true;
  });
  document.addEventListener("visibilitychange", changed);

  function set<K extends keyof Values>(key: K, value: Values[K]): void {
    settings.set(key, value);
  }
  /** For consoles and tests. Points are in the page's space: that of a model whose y is up, unless it was moved. */
  const meshfront = {
    /** Resolves once the front is all that the view asks for, and drawn. */
    settled: () => new Promise<FrameStats>((resolve) => waiting.push(() => resolve(stats()!))),
    stats,
    /** Of the first model. */
    info: () => shown[0]?.object.info,
    setCamera(eye: Point, target: Point) {
      navigation.lookAt(eye, target);
      dirty = true;
    },
    setTolerance: (px: number) => set("tolerancePx", px),
    setBudget: (triangles: number) => set("maxTriangles", triangles),
    freeze: (on: boolean) => set("frozen", on),
    /** Any setting, by the names of `settings.ts`. */
    set,
    get settings() { return settings.now; },
    look: (side: Side) => navigation.lookFrom(boxOf(visible()), side, false),
    /** Draws, and gives the models without the background, as a PNG in a data URL. */
    picture() {
      camera.updateMatrixWorld();
      fitDepth();
      draw();
      return canvas.toDataURL("image/png");
    },
    /** Where one looks from, in words. */
    tell: () => tellView(camera, boxOf(visible())),
    /** What is read at the pointer or the crosshair. */
    get reading() { return measuring.reading; },
    /** Whether the original is there in full, where it is compared with. */
    get original() { return compare.complete; },
    /** Flies once around the first model in the worker, and tells what that took. */
    flyBy: () => shown[0]?.object.flyBy(),
    camera,
    renderer,
    get objects() { return shown.map(({ object }) => object); },
  };

  renderer.setAnimationLoop(frame);
  void open();
  return meshfront;
}

/** What the page offers to consoles and tests. */
export type Meshfront = ReturnType<typeof start>;

/** The box of models as they are shown. */
function boxOf(objects: readonly MeshfrontObject[]): Box3 {
  const box = new Box3();
  for (const { geometry, matrixWorld } of objects) box.union(geometry.boundingBox!.clone().applyMatrix4(matrixWorld));
  return box;
}

function upOf(up: Up, own: readonly number[]): Vector3 {
  if (up === "file") return new Vector3(...own);
  return new Vector3().setComponent("xyz".indexOf(up[1]!), up[0] === "-" ? -1 : 1);
}
