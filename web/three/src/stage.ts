/**
 * One WebGL context for any number of pictures on a page: browsers allow sixteen, and take the oldest away beyond that. Each
 * picture is drawn into the corner of a common canvas and copied from there to the one that is seen, which keeps it: also
 * while the context is lost.
 */

import { type Camera, type Scene, WebGLRenderer } from "three";

/** What is drawn on the stage. */
export interface Actor {
  /** Called once per frame of the screen as long as it says that something moves. */
  tick(seconds: number): { moves: boolean; draws: boolean };
  readonly scene: Scene;
  readonly camera: Camera;
  /** Where it is seen; its size is that of the picture. */
  readonly canvas: HTMLCanvasElement;
  /** What was drawn is seen now. */
  drawn(): void;
  /** What was drawn is gone. */
  invalidate(): void;
}

/** A frame that took longer than this does not turn things farther, seconds. */
const LONGEST_STEP = 0.1;

let renderer: WebGLRenderer | undefined;
let lost = false;
const actors = new Set<Actor>();
let request: number | undefined;
let before: number | undefined;

/**
 * Takes part from now on.
 *
 * @throws Error where there is no WebGL 2
 */
export function enter(actor: Actor): void {
  renderer ??= makeRenderer();
  actors.add(actor);
  wake();
}

/** Takes part no more. Without anybody the context is given back. */
export function leave(actor: Actor): void {
  actors.delete(actor);
  if (actors.size > 0 || !renderer) return;
  if (request !== undefined) cancelAnimationFrame(request);
  request = before = undefined;
  renderer.domElement.removeEventListener("webglcontextlost", lose);
  renderer.domElement.removeEventListener("webglcontextrestored", restore);
  renderer.dispose();
  renderer.forceContextLoss();
  renderer = undefined;
  lost = false;
}

/** Something changed: the next frame looks at all actors. */
export function wake(): void {
  if (request === undefined && renderer) request = requestAnimationFrame(frame);
}

function makeRenderer(): WebGLRenderer {
  const made = new WebGLRenderer({ canvas: document.createElement("canvas"), antialias: true, alpha: true });
  made.setClearColor(0, 0);
  made.domElement.addEventListener("webglcontextlost", lose);
  made.domElement.addEventListener("webglcontextrestored", restore);
  return made;
}

function lose(event: Event): void {
  // Says that it is to be restored.
  event.preventDefault();
  lost = true;
}

function restore(): void {
  lost = false;
  for (const actor of actors) actor.invalidate();
}

function frame(now: number): void {
  request = undefined;
  const seconds = before === undefined ? 0 : Math.min((now - before) / 1000, LONGEST_STEP);
  let moves = false;
  for (const actor of actors) {
    const next = actor.tick(seconds);
    moves ||= next.moves;
    if (next.draws && !lost) draw(actor);
  }
  before = moves ? now : undefined;
  if (moves) wake();
}

function draw(actor: Actor): void {
  const { canvas, scene, camera } = actor;
  const { width, height } = canvas;
  if (!renderer || width === 0 || height === 0) return;
  const stage = renderer.domElement;
  if (stage.width < width || stage.height < height) {
    renderer.setSize(Math.max(stage.width, width), Math.max(stage.height, height), false);
  }
  renderer.setScissorTest(true);
  renderer.setScissor(0, 0, width, height);
  renderer.setViewport(0, 0, width, height);
  renderer.render(scene, camera);
  const picture = canvas.getContext("2d")!;
  picture.globalCompositeOperation = "copy";
  // The corner of the viewport is below, that of the canvas above.
  picture.drawImage(stage, 0, stage.height - height, width, height, 0, 0, width, height);
  actor.drawn();
}
