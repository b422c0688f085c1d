/**
 * `<mesh-front>`: a model on a page in one line of HTML. Importing this module registers it.
 *
 * ```html
 * <mesh-front src="dragon.front" alt="A dragon" poster="dragon.webp" camera-controls auto-rotate></mesh-front>
 * ```
 *
 * Attributes, events, slots and custom properties are those that users of `<model-viewer>` know, where they mean the
 * same; the README of the package lists them.
 */

import { MeshfrontError, type Vec3 } from "@meshfront/core";
import {
  type Intersection, MathUtils, PerspectiveCamera, Raycaster, Scene, type Sphere, Spherical,
  Vector2, Vector3,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { type BudgetOptions, MeshfrontBudget } from "./budget.js";
import { addLights } from "./lights.js";
import { MeshfrontObject } from "./object.js";
import { type Actor, enter, leave, wake } from "./stage.js";

/** What the element says to people. Change it before the first element is made, for other languages. */
export const texts = {
  /** The name of a model without `alt`. */
  model: "3D model",
  help: "Arrow keys turn it, with Shift they move it; plus and minus go nearer and farther; Home shows all of it.",
  loading: "Loading",
  pause: "Pause turning",
  noWebgl: "The picture needs WebGL 2, which this browser does not offer.",
};

/** What an `error` event of the element tells. */
export interface ElementFailure {
  /** `webgl`: there is no WebGL 2; else as in `MeshfrontError`. */
  kind: MeshfrontError["kind"] | "webgl";
  message: string;
  /** What a person can do; may be empty. */
  remedy: string;
}

/** The events of a `<mesh-front>`. They do not bubble. */
export interface MeshFrontEventMap extends HTMLElementEventMap {
  /** `detail`: bytes, and the part of all the work that is done, where that is known; 1 once, at the end. */
  progress: CustomEvent<{ loaded: number; total: number | undefined; totalProgress: number | undefined }> & ProgressEvent;
  /** The model is open and follows the camera. */
  load: CustomEvent<{ url: string }>;
  error: CustomEvent<ElementFailure> & ErrorEvent;
  /** The picture is as fine as asked for. */
  "front-settled": CustomEvent<object>;
  /** The camera moved, by a person or by turning. */
  "camera-change": CustomEvent<{ source: "user-interaction" | "none" }>;
  /** The poster is gone: the model is seen. */
  "poster-dismissed": CustomEvent<object>;
}

const STYLE = /* css */ `
:host { display: block; position: relative; width: 300px; height: 150px; overflow: hidden; contain: strict;
  background: var(--mesh-front-background, transparent); }
:host([hidden]) { display: none; }
canvas, .poster { position: absolute; inset: 0; width: 100%; height: 100%; }
canvas:focus-visible, button:focus-visible { outline: 3px solid var(--mesh-front-focus-color, Highlight); outline-offset: -3px; }
canvas.controlled { cursor: grab; }
canvas.controlled:active { cursor: grabbing; }
.poster { background: var(--mesh-front-poster-background, var(--mesh-front-background, transparent)); pointer-events: none;
  transition: opacity 0.3s, visibility 0.3s; }
.poster img, ::slotted([slot="poster"]) { width: 100%; height: 100%; object-fit: contain; }
.poster.gone { opacity: 0; visibility: hidden; }
.progress { position: absolute; inset: auto 0 0 0; height: 4px;
  background: var(--mesh-front-progress-background, rgb(127 127 127 / 0.3)); }
.progress div { height: 100%; width: 0; background: var(--mesh-front-progress-color, Highlight); }
.error { position: absolute; inset: 0; margin: 0; padding: 1em; display: grid; align-content: center; overflow: auto;
  font: 1rem/1.4 system-ui, sans-serif; color: CanvasText; background: Canvas; }
button { position: absolute; right: 8px; bottom: 12px; width: 32px; height: 32px; padding: 0; border: 0; border-radius: 50%;
  color: CanvasText; background: Canvas; opacity: 0.8; cursor: pointer; }
button::before { content: ""; display: block; width: 4px; height: 12px; margin: auto;
  border: solid currentColor; border-width: 0 4px; }
button[aria-pressed="true"]::before { width: 0; height: 0; translate: 2px;
  border-width: 7px 0 7px 12px; border-color: transparent transparent transparent currentColor; }
.hidden { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); white-space: nowrap; }
[hidden] { display: none !important; }
@media (prefers-reduced-motion: reduce) { .poster { transition: none; } }
`;

const MARKUP = /* html */ `
<canvas part="canvas" width="0" height="0"></canvas>
<p class="hidden" id="help"></p>
<div class="poster" part="poster"><slot name="poster"></slot></div>
<button type="button" part="pause" aria-pressed="false" hidden></button>
<slot name="progress"><div class="progress" part="progress" role="progressbar" hidden><div></div></div></slot>
<div class="error" part="error" role="alert" hidden></div>
<slot></slot>
`;

/** As `<model-viewer>` has it: from the front, a little from above, just all of it. */
const ORBIT = "0deg 75deg 105%";
/** Vertical, degrees. */
const FIELD_OF_VIEW = 30;
/** More pixels cost more than they show. */
const MOST_PIXEL_RATIO = 2;
/** How far outside of the window an element may be and is loaded all the same. */
const NEAR_WINDOW = "50%";
/** What an arrow key turns, radians, and moves, parts of the distance. */
const [KEY_TURN, KEY_MOVE, KEY_ZOOM] = [Math.PI / 24, 0.05, 1.12];

/** Properties that may be set before the element is known. */
const UPGRADED = ["src", "alt", "poster", "cameraControls", "autoRotate", "loading", "tolerance", "budget"] as const;

/** All elements without a budget of their own share one, and with it a worker. */
let shared: { budget: MeshfrontBudget; users: Set<MeshFrontElement> } | undefined;
/** What the last of them allowed: a page that shows no element for a while need not say it again. */
let limits: BudgetOptions = {};

// Where pages are prepared on a server there are no elements.
const Base = globalThis.HTMLElement ?? (class {} as unknown as typeof HTMLElement);

export class MeshFrontElement extends Base {
  static readonly observedAttributes = [
    "src", "alt", "poster", "camera-controls", "disable-zoom", "disable-pan", "touch-action", "auto-rotate", "auto-rotate-delay",
    "rotation-per-second", "camera-orbit", "field-of-view", "tolerance", "loading",
  ];

  /** What is drawn; put lights and meshes of your own here, and call `invalidate()`. */
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);

  private readonly root: ShadowRoot;
  private readonly canvas: HTMLCanvasElement;
  private readonly actor: Actor;
  private controls: OrbitControls | undefined;
  private shown: MeshfrontObject | undefined;
  private own: MeshfrontBudget | undefined;
  private disconnect: (() => void) | undefined;
  private visible = false;
  private nearby = false;
  private isLoaded = false;
  private touched = false;
  private paused = false;
  private dirty = true;
  private posterGone = false;
  /** Time until turning goes on, seconds. */
  private rest = 0;
  private touching = false;

  constructor() {
    super();
    this.root = this.attachShadow({ mode: "open" });
    this.root.innerHTML = `<style>${STYLE}</style>${MARKUP}`;
    this.canvas = this.piece("canvas") as HTMLCanvasElement;
    this.piece("progress").setAttribute("aria-label", texts.loading);
    this.root.getElementById("help")!.textContent = texts.help;
    const pause = this.piece("pause");
    pause.setAttribute("aria-label", texts.pause);
    pause.addEventListener("click", () => {
      this.paused = !this.paused;
      this.rest = 0;
      pause.setAttribute("aria-pressed", String(this.paused));
      wake();
    });
    this.canvas.addEventListener("keydown", (event) => this.pressed(event));
    addLights(this.scene, this.camera);
    const element = this;
    this.actor = {
      scene: this.scene,
      camera: this.camera,
      canvas: this.canvas,
      tick: (seconds) => element.tick(seconds),
      drawn: () => element.drawn(),
      invalidate: () => element.invalidate(),
    };
  }

  /** The address of a `.front` file. */
  get src(): string { return this.getAttribute("src") ?? ""; }
  set src(value: string) { this.setAttribute("src", value); }

  /** What the picture shows, for who does not see it. */
  get alt(): string { return this.getAttribute("alt") ?? ""; }
  set alt(value: string) { this.setAttribute("alt", value); }

  /** A picture that is shown until the model is there. */
  get poster(): string { return this.getAttribute("poster") ?? ""; }
  set poster(value: string) { this.setAttribute("poster", value); }

  /** Whether it can be turned, moved and approached. */
  get cameraControls(): boolean { return this.hasAttribute("camera-controls"); }
  set cameraControls(on: boolean) { this.toggleAttribute("camera-controls", on); }

  /** Whether it turns by itself; never where people asked for less motion. */
  get autoRotate(): boolean { return this.hasAttribute("auto-rotate"); }
  set autoRotate(on: boolean) { this.toggleAttribute("auto-rotate", on); }

  /** `eager` loads at once, else the model is loaded when the element comes near the window. */
  get loading(): string { return this.getAttribute("loading") ?? "auto"; }
  set loading(value: string) { this.setAttribute("loading", value); }

  /** Pixels of the screen that a drawn point may be from where the original surface would be drawn; 1 by default. */
  get tolerance(): number { return this.number("tolerance", 1); }
  set tolerance(px: number) { this.setAttribute("tolerance", String(px)); }

  /**
   * Worker and limits: those of all elements on the page, unless one of your own is set. Set it before `src`; dispose of it
   * yourself.
   */
  get budget(): MeshfrontBudget {
    if (this.own) return this.own;
    shared ??= { budget: new MeshfrontBudget(limits), users: new Set() };
    return shared.budget;
  }
  set budget(budget: MeshfrontBudget) {
    this.own = budget;
    if (this.shown) this.reload();
  }

  /** The model, once it is being loaded: its material, statistics and events. */
  get object(): MeshfrontObject | undefined { return this.shown; }

  /** Whether the model is open. */
  get loaded(): boolean { return this.isLoaded; }

  /** The controls, where there are `camera-controls`. */
  get orbitControls(): OrbitControls | undefined { return this.controls; }

  /** Draws once more, because something was changed from outside. */
  invalidate(): void {
    this.dirty = true;
    wake();
  }

  /** Looks at the whole model again, as `camera-orbit` says. */
  showAll(): void {
    const sphere = this.sphere();
    if (!sphere) return;
    const { camera } = this;
    camera.fov = Math.min(Math.max(angle(this.getAttribute("field-of-view"), FIELD_OF_VIEW), 1), 170);
    const { canvas } = this;
    camera.aspect = canvas.width > 0 && canvas.height > 0 ? canvas.width / canvas.height : 1;
    camera.updateProjectionMatrix();
    const half = MathUtils.degToRad(camera.fov) / 2;
    const whole = this.reach(sphere) / Math.sin(Math.min(half, Math.atan(Math.tan(half) * camera.aspect)));
    const [theta = "", phi = "", radius = ""] = (this.getAttribute("camera-orbit") ?? ORBIT).trim().split(/\s+/);
    const distance = radius.endsWith("%") ? (whole * parseFloat(radius)) / 100 : parseFloat(radius);
    const orbit = new Spherical(
      Number.isFinite(distance) && distance > 0 ? distance : 1.05 * whole,
      MathUtils.degToRad(angle(phi, 75)),
      MathUtils.degToRad(angle(theta, 0)),
    ).makeSafe();
    camera.position.setFromSpherical(orbit).add(sphere.center);
    camera.lookAt(sphere.center);
    if (this.controls) {
      this.controls.target.copy(sphere.center);
      this.controls.minDistance = 0.01 * sphere.radius;
      this.controls.maxDistance = 4 * whole;
      this.controls.update();
    }
    this.touched = false;
    this.invalidate();
  }

  /** What is drawn at a place of the window, CSS pixels; exact. */
  pick(clientX: number, clientY: number): Intersection | undefined {
    if (!this.shown) return undefined;
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new Vector2((2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height);
    this.camera.updateMatrixWorld();
    this.shown.updateWorldMatrix(true, false);
    const raycaster = new Raycaster();
    raycaster.setFromCamera(at, this.camera);
    return raycaster.intersectObject(this.shown, false)[0];
  }

  /** The picture as it is seen, without the background. */
  toBlob(type = "image/png", quality?: number): Promise<Blob> {
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("there is no picture yet"))), type, quality);
    });
  }

  /** @internal */
  connectedCallback(): void {
    for (const key of UPGRADED) this.upgrade(key);
    if (this.disconnect) return;
    this.describe();
    try {
      enter(this.actor);
    } catch {
      this.fail({ kind: "webgl", message: texts.noWebgl, remedy: "" });
      return;
    }
    const resizing = new ResizeObserver(() => this.resize());
    resizing.observe(this);
    const seeing = new IntersectionObserver(([...entries]) => {
      this.visible = entries.at(-1)!.isIntersecting;
      if (this.shown) this.shown.frozen = !this.visible;
      if (this.visible) this.invalidate();
    });
    seeing.observe(this);
    const nearing = new IntersectionObserver(([...entries]) => {
      this.nearby = entries.at(-1)!.isIntersecting;
      this.load();
    }, { rootMargin: NEAR_WINDOW });
    nearing.observe(this);
    const calm = matchMedia("(prefers-reduced-motion: reduce)");
    const calmed = () => this.describe();
    calm.addEventListener("change", calmed);
    this.disconnect = () => {
      for (const observer of [resizing, seeing, nearing]) observer.disconnect();
      calm.removeEventListener("change", calmed);
      this.controls?.dispose();
      this.controls = undefined;
      this.unload();
      leave(this.actor);
    };
    this.control();
    this.resize();
    this.load();
  }

  /** @internal */
  disconnectedCallback(): void {
    // An element that is moved within a page comes back at once, and need not load again.
    queueMicrotask(() => {
      if (this.isConnected) return;
      this.disconnect?.();
      this.disconnect = undefined;
    });
  }

  /** @internal */
  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (before === now || !this.disconnect) return;
    switch (name) {
      case "src": this.reload(); break;
      case "loading": this.load(); break;
      case "tolerance":
        if (this.shown) this.shown.tolerancePx = this.tolerance;
        break;
      case "camera-orbit": case "field-of-view": this.showAll(); break;
      case "camera-controls": case "disable-zoom": case "disable-pan": case "touch-action": this.control(); break;
    }
    this.describe();
    this.invalidate();
  }

  override addEventListener<K extends keyof MeshFrontEventMap>(
    type: K, listener: (event: MeshFrontEventMap[K]) => void, options?: boolean | AddEventListenerOptions,
  ): void;
  override addEventListener(
    type: string, listener: EventListenerOrEventListenerObject | null, options?: boolean | AddEventListenerOptions,
  ): void;
  override addEventListener(type: string, listener: never, options?: boolean | AddEventListenerOptions): void {
    super.addEventListener(type, listener, options);
  }

  private load(): void {
    const { src } = this;
    if (this.shown || !this.disconnect || src === "" || !(this.nearby || this.loading === "eager")) return;
    const { budget } = this;
    if (budget === shared?.budget) shared.users.add(this);
    const object = new MeshfrontObject(new URL(src, document.baseURI), { budget, tolerancePx: this.tolerance });
    this.shown = object;
    object.frozen = !this.visible;
    object.setCamera(this.camera);
    this.setProgress(0);
    object.addEventListener("load-progress", ({ loaded, total, fraction }) => {
      this.setProgress(fraction);
      this.tell("progress", { loaded, total, totalProgress: fraction });
    });
    // The page's own up is +y.
    const stand = (up: Vec3) => object.quaternion.setFromUnitVectors(new Vector3(...up), new Vector3(0, 1, 0));
    object.addEventListener("load-base", ({ base }) => {
      stand(base.up);
      this.enterScene();
    });
    object.addEventListener("load", ({ info }) => {
      stand(info.up);
      this.isLoaded = true;
      this.setProgress(1);
      this.enterScene();
      this.tell("load", { url: src });
    });
    object.addEventListener("load-error", ({ error: { kind, message, remedy } }) => this.fail({ kind, message, remedy }));
    object.addEventListener("needs-update", () => this.invalidate());
    object.addEventListener("front-settled", () => {
      this.posterGone = true;
      this.invalidate();
      this.tell("front-settled", {});
    });
  }

  private enterScene(): void {
    const { shown } = this;
    if (!shown) return;
    this.scene.add(shown);
    shown.updateMatrixWorld();
    this.setSize();
    if (!this.touched) this.showAll();
    this.invalidate();
  }

  private unload(): void {
    const object = this.shown;
    this.shown = undefined;
    this.isLoaded = false;
    this.touched = false;
    this.posterGone = false;
    this.piece("error").hidden = true;
    this.piece("progress").hidden = true;
    object?.removeFromParent();
    object?.dispose();
    if (shared?.users.delete(this) && shared.users.size === 0) {
      const { maxTriangles, maxBytes, deadlineMs } = shared.budget;
      limits = { maxTriangles, maxBytes, deadlineMs };
      shared.budget.dispose();
      shared = undefined;
    }
  }

  private reload(): void {
    this.unload();
    this.load();
    // The former model is not to be seen under the name of the next.
    this.canvas.getContext("2d")!.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.describe();
    this.invalidate();
  }

  /** Attributes into what is seen and said. */
  private describe(): void {
    const { alt, canvas, cameraControls, poster } = this;
    canvas.setAttribute("aria-label", alt || texts.model);
    // Within an application keys are left to it.
    canvas.setAttribute("role", cameraControls ? "application" : "img");
    if (cameraControls) {
      canvas.tabIndex = 0;
      canvas.setAttribute("aria-describedby", "help");
    } else {
      canvas.removeAttribute("tabindex");
      canvas.removeAttribute("aria-describedby");
    }
    this.piece("pause").hidden = !this.turns();
    const slot = this.root.querySelector<HTMLSlotElement>('slot[name="poster"]')!;
    let image = slot.querySelector("img");
    if (poster === "") {
      image?.remove();
    } else {
      if (!image) {
        image = document.createElement("img");
        // The canvas has the name.
        image.alt = "";
        slot.append(image);
      }
      const { href } = new URL(poster, document.baseURI);
      if (image.src !== href) image.src = href;
    }
    this.piece("poster").classList.toggle("gone", this.posterGone);
  }

  private control(): void {
    const wanted = this.cameraControls;
    if (wanted && !this.controls) {
      const controls = new OrbitControls(this.camera, this.canvas);
      controls.enableDamping = true;
      controls.dampingFactor = 0.12;
      controls.zoomToCursor = true;
      controls.addEventListener("start", () => {
        this.touching = true;
        this.userMoved();
      });
      controls.addEventListener("end", () => {
        this.touching = false;
        this.userMoved();
      });
      controls.addEventListener("change", () => wake());
      const sphere = this.sphere();
      if (sphere) controls.target.copy(sphere.center);
      this.controls = controls;
    } else if (!wanted && this.controls) {
      this.controls.dispose();
      this.controls = undefined;
      this.canvas.style.touchAction = "";
    }
    this.canvas.classList.toggle("controlled", wanted);
    if (!this.controls) return;
    this.controls.enableZoom = !this.hasAttribute("disable-zoom");
    this.controls.enablePan = !this.hasAttribute("disable-pan");
    // One finger up or down moves the page, unless that is said otherwise.
    this.canvas.style.touchAction = this.getAttribute("touch-action") ?? "pan-y";
  }

  private userMoved(): void {
    this.touched = true;
    this.rest = this.number("auto-rotate-delay", 3000) / 1000;
    wake();
  }

  private pressed(event: KeyboardEvent): void {
    const { camera, controls } = this;
    if (!controls || event.ctrlKey || event.metaKey || event.altKey) return;
    const offset = camera.position.clone().sub(controls.target);
    const orbit = new Spherical().setFromVector3(offset);
    const along = (axis: number, by: number) => {
      const step = new Vector3().setFromMatrixColumn(camera.matrix, axis).multiplyScalar(by * KEY_MOVE * orbit.radius);
      controls.target.add(step);
    };
    const shifts = event.shiftKey && controls.enablePan;
    switch (event.key) {
      case "ArrowLeft": shifts ? along(0, -1) : (orbit.theta -= KEY_TURN); break;
      case "ArrowRight": shifts ? along(0, 1) : (orbit.theta += KEY_TURN); break;
      case "ArrowUp": shifts ? along(1, 1) : (orbit.phi -= KEY_TURN); break;
      case "ArrowDown": shifts ? along(1, -1) : (orbit.phi += KEY_TURN); break;
      case "+": case "=": if (controls.enableZoom) orbit.radius /= KEY_ZOOM; break;
      case "-": case "_": if (controls.enableZoom) orbit.radius *= KEY_ZOOM; break;
      case "Home":
        this.showAll();
        event.preventDefault();
        return;
      default: return;
    }
    event.preventDefault();
    orbit.radius = Math.min(Math.max(orbit.radius, controls.minDistance), controls.maxDistance);
    camera.position.setFromSpherical(orbit.makeSafe()).add(controls.target);
    controls.update();
    this.userMoved();
    this.tell("camera-change", { source: "user-interaction" });
    this.invalidate();
  }

  private tick(seconds: number): { moves: boolean; draws: boolean } {
    const { camera, controls, shown } = this;
    if (!this.visible || !shown || !this.sphere()) return { moves: false, draws: false };
    let moved = controls?.update() ?? false;
    if (moved) this.tell("camera-change", { source: "user-interaction" });
    const turns = this.turns() && !this.paused;
    if (this.touching) this.rest = Math.max(this.rest, this.number("auto-rotate-delay", 3000) / 1000);
    else if (turns && this.rest > 0) this.rest -= seconds;
    else if (turns) {
      this.turn(MathUtils.degToRad(angle(this.getAttribute("rotation-per-second"), 18)) * seconds);
      this.tell("camera-change", { source: "none" });
      moved = true;
    }
    const draws = moved || this.dirty;
    if (draws) {
      this.dirty = false;
      this.fitDepth();
      camera.updateMatrixWorld();
      shown.setResolution(camera, this.canvas.width, this.canvas.height);
      shown.update();
    }
    return { moves: moved || turns, draws };
  }

  private turn(by: number): void {
    const center = this.controls?.target ?? this.sphere()!.center;
    const { camera } = this;
    camera.position.sub(center).applyAxisAngle(camera.up, by).add(center);
    camera.lookAt(center);
    // Or the controls would take it for a move of their own.
    this.controls?.update();
  }

  private turns(): boolean {
    return this.autoRotate && !matchMedia("(prefers-reduced-motion: reduce)").matches;
  }

  private drawn(): void {
    const poster = this.piece("poster");
    const covered = poster.querySelector("img") !== null || this.querySelector('[slot="poster"]') !== null;
    // A coarse base mesh is better than nothing, but not better than a poster.
    if ((!covered || this.posterGone) && !poster.classList.contains("gone")) {
      this.posterGone = true;
      poster.classList.add("gone");
      this.tell("poster-dismissed", {});
    }
  }

  private resize(): void {
    if (this.setSize()) this.invalidate();
  }

  /** Takes over the size of the element; whether it changed. */
  private setSize(): boolean {
    const { canvas, camera } = this;
    const ratio = Math.min(devicePixelRatio, MOST_PIXEL_RATIO);
    const [width, height] = [Math.round(this.clientWidth * ratio), Math.round(this.clientHeight * ratio)];
    if (width === 0 || height === 0 || (canvas.width === width && canvas.height === height)) return false;
    [canvas.width, canvas.height] = [width, height];
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    if (!this.touched) this.showAll();
    return true;
  }

  private fitDepth(): void {
    const { center, radius } = this.sphere()!;
    const { camera } = this;
    const distance = camera.position.distanceTo(center);
    camera.near = Math.max(distance - radius, radius * 1e-3);
    camera.far = Math.max(distance + radius, 2 * camera.near);
    camera.updateProjectionMatrix();
  }

  /** Around the model, once something of it is there. */
  private sphere(): Sphere | undefined {
    const sphere = this.shown?.geometry.boundingSphere;
    return sphere && sphere.radius > 0 ? sphere.clone().applyMatrix4(this.shown!.matrixWorld) : undefined;
  }

  /** How far from its middle anything of the model is: the sphere is that of a box, and mostly too large for a good picture. */
  private reach({ center, radius }: Sphere): number {
    const { geometry, matrixWorld } = this.shown!;
    const middle = center.clone().applyMatrix4(matrixWorld.clone().invert());
    const { array } = geometry.getAttribute("position");
    let farthest = 0;
    for (let i = 0; i < geometry.drawRange.count; i++) {
      const at = 3 * geometry.index!.array[i]!;
      farthest = Math.max(farthest, Math.hypot(array[at]! - middle.x, array[at + 1]! - middle.y, array[at + 2]! - middle.z));
    }
    return farthest > 0 ? Math.min(farthest, radius) : radius;
  }

  private setProgress(fraction: number | undefined): void {
    const progress = this.piece("progress");
    progress.hidden = fraction === 1;
    if (fraction === undefined) progress.removeAttribute("aria-valuenow");
    else progress.setAttribute("aria-valuenow", String(Math.round(100 * fraction)));
    (progress.firstElementChild as HTMLElement).style.width = `${100 * (fraction ?? 0)}%`;
  }

  private fail(failure: ElementFailure): void {
    this.piece("progress").hidden = true;
    const error = this.piece("error");
    // What stands between backticks is to be typed.
    error.textContent = `${failure.message}. ${failure.remedy}`.replace(/\.\. /, ". ").replaceAll("`", "").trim();
    error.hidden = false;
    this.tell("error", failure);
  }

  private tell(type: string, detail: object): void {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  /** A property that was set before the element was known is taken over. */
  private upgrade(key: (typeof UPGRADED)[number]): void {
    if (!Object.hasOwn(this, key)) return;
    const value = this[key];
    delete (this as Partial<this>)[key];
    this[key] = value as never;
  }

  private number(name: string, otherwise: number): number {
    const value = parseFloat(this.getAttribute(name) ?? "");
    return Number.isFinite(value) && value >= 0 ? value : otherwise;
  }

  private piece(name: string): HTMLElement {
    return this.root.querySelector<HTMLElement>(`[part="${name}"]`)!;
  }
}

/** `30deg`, `0.5rad` or `30`, in degrees. */
function angle(text: string | null, otherwise: number): number {
  const value = parseFloat(text ?? "");
  if (!Number.isFinite(value)) return otherwise;
  return text!.trim().endsWith("rad") ? MathUtils.radToDeg(value) : value;
}

if (globalThis.customElements && !customElements.get("mesh-front")) customElements.define("mesh-front", MeshFrontElement);

declare global {
  interface HTMLElementTagNameMap {
    "mesh-front": MeshFrontElement;
  }
}
