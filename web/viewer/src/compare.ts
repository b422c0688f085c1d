/** The divider: on its left the front, on its right the original, seen from the same place. */

import { MeshfrontBudget, MeshfrontObject } from "@meshfront/three";
import type { PerspectiveCamera, WebGLRenderer } from "three";
import { element, make } from "./dom.js";
import { type Shown, trianglesOf } from "./models.js";
import type { Settings } from "./settings.js";
import type { Stage } from "./stage.js";
import { attribute, count, percent, texts, worded } from "./texts/index.js";

/** The fronts wait as long for their turn in the worker, and no longer. */
const DEADLINE_MS = 5;

export interface Compare {
  /** Whether both are to be drawn. */
  readonly on: boolean;
  /** Opens the originals of these models when they are asked for. */
  setModels(shown: readonly Shown[]): void;
  /** Lets the originals follow the fronts' places and looks. */
  update(camera: PerspectiveCamera, renderer: WebGLRenderer): void;
  /** Draws one on each side. */
  draw(): void;
  /** Whether every triangle of the originals is there, or as many as are allowed. */
  readonly complete: boolean;
}

export function makeCompare(settings: Settings, stage: Stage, changed: () => void): Compare {
  const { canvas, renderer, scene } = stage;
  const handle = attribute(
    make("div", {
      id: "divider", class: "divider", role: "slider", tabindex: 0, "aria-valuemin": 0, "aria-valuemax": 100, hidden: true,
    }),
    "aria-label", (t) => t.compare.handle,
  );
  const [left, right] = [make("span", { class: "left" }), make("span", { class: "right" })];
  handle.append(left, right);
  element("dock").before(handle);

  let shown: readonly Shown[] = [];
  let originals: MeshfrontObject[] = [];
  let budget: MeshfrontBudget | undefined;
  let complete = false;
  let failed: string | undefined;
  /** Where one looked from when they met a limit: there they are chosen for, or they would be chosen anew with each move. */
  let still: PerspectiveCamera | undefined;

  settings.follow("divider", (at) => {
    handle.hidden = at === undefined;
    if (at === undefined) close();
    else {
      if (!budget && shown.length > 0) open();
      place(at);
    }
    changed();
  });
  settings.on("originalTriangles", (most) => {
    if (!budget) return;
    budget.maxTriangles = most;
    for (const original of originals) original.frozen = false;
    complete = false;
    for (const original of originals) if (still) original.deleteCamera(still);
    still = undefined;
    tell();
    changed();
  });
  worded(() => { place(settings.now.divider ?? 0.5); tell(); });

  function place(at: number): void {
    handle.style.left = `${100 * at}%`;
    handle.setAttribute("aria-valuenow", String(Math.round(100 * at)));
    handle.setAttribute("aria-valuetext", texts().compare.at(percent(at)));
  }
  const move = (to: number) => settings.set("divider", Math.min(1, Math.max(0, to)));
  handle.addEventListener("pointerdown", (event) => {
    handle.setPointerCapture(event.pointerId);
    handle.focus();
    event.preventDefault();
  });
  handle.addEventListener("pointermove", (event) => {
    if (handle.hasPointerCapture(event.pointerId)) move(event.clientX / canvas.clientWidth);
  });
  handle.addEventListener("keydown", (event) => {
    const at = settings.now.divider ?? 0.5;
    const to = {
      ArrowLeft: at - 0.01, ArrowDown: at - 0.01, ArrowRight: at + 0.01, ArrowUp: at + 0.01,
      PageUp: at + 0.1, PageDown: at - 0.1, Home: 0, End: 1,
    }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    move(to);
  });

  /** Fronts of the same hierarchies in the same worker, with limits of their own. */
  function open(): void {
    const { originalTriangles: maxTriangles } = settings.now;
    const shared = new MeshfrontBudget({ worker: shown[0]!.object.budget, maxTriangles, deadlineMs: DEADLINE_MS });
    budget = shared;
    originals = shown.map(({ object, card: { name } }) => {
      const original = new MeshfrontObject(object, { budget: shared, tolerancePx: 0, material: object.material, name });
      original.cullFrustum = original.cullOrientation = false;
      original.visible = false;
      original.addEventListener("needs-update", changed);
      original.addEventListener("load-error", ({ error }) => {
        failed = error.message;
        tell();
      });
      scene.add(original);
      return original;
    });
    tell();
  }

  function close(): void {
    for (const original of originals) {
      original.removeFromParent();
      original.dispose();
    }
    originals = [];
    budget?.dispose();
    budget = undefined;
    complete = false;
    failed = undefined;
    still = undefined;
  }

  function tell(): void {
    const { compare } = texts();
    left.textContent = compare.front;
    const triangles = originals.reduce((sum, original) => sum + (original.stats?.triangles ?? 0), 0);
    const whole = shown.reduce((sum, model) => sum + trianglesOf(model), 0);
    const limited = originals.some((original) => original.stats?.budgetBound);
    if (failed) right.textContent = compare.failed(failed);
    else if (!complete) right.textContent = compare.loading;
    else right.textContent = limited ? compare.limited(count(triangles), count(whole)) : compare.original(count(triangles));
  }

  return {
    get on() { return settings.now.divider !== undefined && budget !== undefined; },
    get complete() { return complete; },
    setModels(models) {
      close();
      shown = models;
      if (settings.now.divider !== undefined && shown.length > 0) open();
    },
    update(camera, renderer) {
      if (!budget) return;
      if (!complete && !still && originals.some(({ stats }) => stats?.budgetBound)) {
        for (const original of originals) original.deleteCamera(camera);
        still = camera.clone();
      }
      originals.forEach((original, i) => {
        follow(original, shown[i]!);
        if (original.info && !complete) original.setResolutionFromRenderer(still ?? camera, renderer);
      });
      budget.update();
      if (complete) return;
      if (!budget.answered || !originals.every(({ stats }) => stats?.settled)) return;
      // All there is, from wherever one looks, and also where one looks from elsewhere by now: the engine need not be asked again.
      for (const original of originals) original.frozen = true;
      complete = true;
      tell();
      changed();
    },
    draw() {
      const at = settings.now.divider ?? 1;
      const { clientWidth: width, clientHeight: height } = canvas;
      const middle = Math.round(at * width);
      const visible = shown.map(({ object }) => object.visible);
      renderer.setScissorTest(true);
      renderer.setScissor(0, 0, middle, height);
      if (middle > 0) stage.draw();
      shown.forEach(({ object }, i) => {
        object.visible = false;
        originals[i]!.visible = visible[i]!;
      });
      renderer.setScissor(middle, 0, width - middle, height);
      if (middle < width) stage.draw();
      renderer.setScissorTest(false);
      shown.forEach(({ object }, i) => {
        object.visible = visible[i]!;
        originals[i]!.visible = false;
      });
    },
  };
}

function follow(original: MeshfrontObject, { object }: Shown): void {
  original.position.copy(object.position);
  original.quaternion.copy(object.quaternion);
  original.scale.copy(object.scale);
  original.material = object.material;
  original.shade = object.shade;
}
