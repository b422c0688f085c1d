/** What is under the pointer or the crosshair, and distances between two points with what is not known of them. */

import type { MeshfrontObject } from "@meshfront/three";
import { type PerspectiveCamera, Vector2, Vector3 } from "three";
import { element, make } from "./dom.js";
import { type Hit, pick } from "./picking.js";
import type { Settings } from "./settings.js";
import { attribute, count, figures, label, length, texts, worded } from "./texts/index.js";

/** A point that was set; it stays on its model. */
interface Mark {
  object: MeshfrontObject;
  /** In the space of the object. */
  local: Vector3;
  /** How far the original surface may be from it, units of the page. */
  error: number;
}

/** A line between two points of the picture, CSS pixels, with what it says: for pictures that are saved. */
export interface Line {
  from: Vector2;
  to: Vector2 | undefined;
  text: string;
}

export interface Measuring {
  /** Where results are listed. */
  readonly readings: HTMLElement;
  /** Looks again, and moves what is drawn over the picture to where it is now. */
  update(moved: boolean): void;
  /** Forgets what was measured. */
  clear(): void;
  /** What is drawn over the picture. */
  lines(): Line[];
  /** What was read last. */
  readonly reading: Reading | undefined;
}

/** What is known of a point. Units of the page. */
export interface Reading {
  position: Vector3;
  normal: Vector3;
  error: number | undefined;
  /** That would replace the triangle; none where it is one of the source's. */
  update: number | undefined;
  level: number | undefined;
}

export interface Scenery {
  canvas: HTMLCanvasElement;
  camera: PerspectiveCamera;
  objects(): MeshfrontObject[];
  /** The middle of what can be seen of the picture, -1 to 1. */
  middle(): Vector2;
  /** How wrong a front may be at a point: from its figures, where the engine does not say it for the point. */
  errorAt(hit: Hit): number;
  say(text: string): void;
}

/** A press that moves farther than this is a drag, CSS pixels: fingers roll. */
const CLICK = { finger: 10, other: 4 };

export function makeMeasuring(settings: Settings, scenery: Scenery): Measuring {
  const { canvas, camera, say } = scenery;
  const overlay = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  overlay.setAttribute("class", "overlay");
  overlay.setAttribute("aria-hidden", "true");
  canvas.after(overlay);
  const readout = element("readout");

  const results = make("ul", { id: "distances", class: "distances" });
  const advice = make("p", { class: "quiet" });
  const clearing = label(make("button", { type: "button", id: "clear", hidden: true }), (t) => t.measure.clear);
  const readings = make("div", {}, advice, attribute(results, "aria-label", (t) => t.measure.distance), clearing);

  let marks: Mark[] = [];
  let pointer: Vector2 | undefined;
  let reading: Reading | undefined;
  /** A finger pointed there, and hides nothing any more. */
  let tapped = false;
  let looked = true;
  let asked = 0;

  const inPicture = ({ clientX, clientY }: MouseEvent) => {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return new Vector2((2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height);
  };
  let pressed: { at: Vector2; id: number } | undefined;
  const isFinger = ({ pointerType }: PointerEvent) => pointerType === "touch";
  canvas.addEventListener("pointermove", (event) => {
    pointer = event.buttons === 0 && !isFinger(event) ? inPicture(event) : undefined;
    tapped = false;
    looked = false;
  });
  canvas.addEventListener("pointerleave", (event) => {
    // A finger that is lifted leaves as well, but what it pointed at stays.
    if (isFinger(event)) return;
    pointer = undefined;
    looked = false;
  });
  canvas.addEventListener("pointerdown", (event) => {
    pressed = event.isPrimary && event.button === 0 ? { at: new Vector2(event.clientX, event.clientY), id: event.pointerId } : undefined;
  });
  canvas.addEventListener("pointerup", (event) => {
    const steady = isFinger(event) ? CLICK.finger : CLICK.other;
    const isClick = pressed?.id === event.pointerId && pressed.at.distanceTo(new Vector2(event.clientX, event.clientY)) <= steady;
    pressed = undefined;
    if (isFinger(event)) {
      // It has nothing to hover with: a tap asks.
      pointer = isClick ? inPicture(event) : undefined;
      tapped = isClick;
      looked = false;
    }
    if (isClick && settings.now.measuring) void mark(inPicture(event));
  });
  canvas.addEventListener("keydown", ({ key }) => {
    if (key === "Enter" && settings.now.measuring) void mark(scenery.middle());
    if ((key === "Backspace" || key === "Delete") && marks.length > 0) clear();
  });
  clearing.addEventListener("click", clear);

  settings.on("measuring", (on) => {
    advise();
    if (on) say(advice.textContent);
  });
  settings.on("crosshair", () => { looked = false; });
  settings.on("unit", () => { tell(); looked = false; });
  worded(() => { advise(); tell(); looked = false; });

  function advise(): void {
    advice.textContent = settings.now.measuring ? (marks.length % 2 === 0 ? texts().measure.first : texts().measure.second) : "";
    advice.hidden = !settings.now.measuring;
    clearing.hidden = marks.length === 0;
  }

  async function inspect(hit: Hit): Promise<Omit<Reading, "position" | "normal">> {
    const known = await hit.object.inspect(hit.triangle).catch(() => undefined);
    return { error: known && known.error * hit.object.matrixWorld.getMaxScaleOnAxis(), update: known?.update, level: known?.level };
  }

  async function mark(at: Vector2): Promise<void> {
    const hit = pick(at, camera, scenery.objects());
    if (!hit) return say(texts().measure.none);
    const { object, point } = hit;
    const local = object.worldToLocal(point.clone());
    const { error } = await inspect(hit);
    marks.push({ object, local, error: error ?? scenery.errorAt(hit) });
    tell();
    advise();
    if (marks.length % 2) return say(texts().measure.second);
    const { distance, uncertainty } = between(marks.length - 2);
    say(texts().measure.said(distance, uncertainty));
  }

  function clear(): void {
    marks = [];
    tell();
    advise();
    drawLines();
    say(texts().measure.cleared);
  }

  const place = ({ object, local }: Mark) => object.localToWorld(local.clone());
  function between(first: number): { distance: string; uncertainty: string } {
    const { unit } = settings.now;
    const [a, b] = [marks[first]!, marks[first + 1]!];
    return { distance: length(place(a).distanceTo(place(b)), unit, 4), uncertainty: length(a.error + b.error, unit, 2) };
  }

  /** Of each pair. */
  function tell(): void {
    const lines = [];
    for (let i = 0; i + 1 < marks.length; i += 2) {
      const { distance, uncertainty } = between(i);
      lines.push(make("li", {}, texts().measure.between(distance, uncertainty)));
    }
    results.replaceChildren(...lines);
  }

  function lines(): Line[] {
    const project = (mark: Mark): Vector2 | undefined => {
      const at = place(mark).project(camera);
      const inFront = place(mark).sub(camera.position).dot(camera.getWorldDirection(new Vector3())) > 0;
      return inFront ? new Vector2(((at.x + 1) / 2) * canvas.clientWidth, ((1 - at.y) / 2) * canvas.clientHeight) : undefined;
    };
    const drawn: Line[] = [];
    for (let i = 0; i < marks.length; i += 2) {
      const from = project(marks[i]!);
      const to = marks[i + 1] && project(marks[i + 1]!);
      if (!from || (marks[i + 1] && !to)) continue;
      drawn.push({ from, to, text: to ? between(i).distance : "" });
    }
    return drawn;
  }

  function drawLines(): void {
    const shapes = lines().map(({ from, to, text }) => {
      const dot = (at: Vector2) => `<circle cx="${at.x.toFixed(1)}" cy="${at.y.toFixed(1)}" r="4"/>`;
      if (!to) return dot(from);
      const [x, y] = [(from.x + to.x) / 2, (from.y + to.y) / 2 - 8];
      return `<line x1="${from.x.toFixed(1)}" y1="${from.y.toFixed(1)}" x2="${to.x.toFixed(1)}" y2="${to.y.toFixed(1)}"/>` +
        `${dot(from)}${dot(to)}<text x="${x.toFixed(1)}" y="${y.toFixed(1)}">${text}</text>`;
    });
    const onScreen = ({ x, y }: Vector2) => [((x + 1) / 2) * canvas.clientWidth, ((1 - y) / 2) * canvas.clientHeight] as const;
    if (tapped && pointer) {
      const [x, y] = onScreen(pointer);
      shapes.push(`<circle cx="${x.toFixed(1)}" cy="${y.toFixed(1)}" r="4"/>`);
    }
    if (settings.now.crosshair || settings.now.measuring) {
      const [x, y] = onScreen(scenery.middle());
      shapes.push(`<path d="M${x - 12} ${y}h8m8 0h8M${x} ${y - 12}v8m0 8v8"/>`);
    }
    const all = shapes.join("");
    if (overlay.innerHTML !== all) overlay.innerHTML = all;
  }

  function look(): void {
    const at = settings.now.crosshair ? scenery.middle() : pointer;
    const hit = at && pick(at, camera, scenery.objects());
    const question = ++asked;
    reading = hit && { position: hit.point, normal: hit.normal, error: undefined, update: undefined, level: undefined };
    if (!hit) return write();
    void inspect(hit).then((known) => {
      // The pointer may be elsewhere by now.
      if (question !== asked) return;
      reading = { position: hit.point, normal: hit.normal, ...known };
      write();
    });
  }

  function write(): void {
    readout.hidden = reading === undefined;
    if (!reading) return;
    const { measure } = texts();
    const { unit } = settings.now;
    const { position, normal, error, update, level } = reading;
    const row = (name: string, text: string) => make("div", {}, make("dt", {}, name), make("dd", {}, text));
    const rows = [
      row(measure.position, position.toArray().map((x) => length(x, unit, 4)).join("; ")),
      row(measure.normal, normal.toArray().map((x) => figures(x, 2)).join("; ")),
    ];
    if (error !== undefined) rows.push(row(measure.error, length(error, unit, 2)));
    if (level !== undefined) {
      rows.push(row(measure.update, update === undefined ? measure.finest : `${count(update)}, ${measure.level(count(level))}`));
    }
    readout.replaceChildren(...rows);
  }

  return {
    readings,
    clear() {
      if (marks.length > 0) clear();
    },
    lines,
    get reading() { return reading; },
    update(moved) {
      if (moved || !looked) drawLines();
      if (looked && !(moved && (settings.now.crosshair || pointer))) return;
      looked = true;
      look();
    },
  };
}
