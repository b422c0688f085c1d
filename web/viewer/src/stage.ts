/** The picture: renderer, scene and camera. */

import { addLights } from "@meshfront/three";
import { Color, PerspectiveCamera, Scene, type Sphere, WebGLRenderer } from "three";

/** How much of the picture's sides is covered, CSS pixels. */
export interface Covered {
  top: number;
  right: number;
  bottom: number;
}

export interface Stage {
  canvas: HTMLCanvasElement;
  renderer: WebGLRenderer;
  scene: Scene;
  camera: PerspectiveCamera;
  /** What is covered as of the last `resize`. */
  readonly covered: Covered;
  /** Takes over the size of the canvas, part of which lies under the panel; whether anything changed. */
  resize(covered: Covered): boolean;
  /** Near and far plane around what is shown; `nearest` is how near something worth seeing is, world units. */
  fitDepth(around: Sphere, nearest: number): void;
  /** Clears and draws, within the scissor where one is set. */
  draw(): void;
}

/** Vertical field of view, degrees. */
export const FOV = 40;
/** Above two, more pixels cost more than they show. */
const MOST_PIXELS_PER_CSS_PIXEL = 2;
/**
 * Depth has 24 bits, most of them near the camera. Where far is more than this many times near, the picture is drawn in
 * slices, far ones first: at this ratio two surfaces are told apart that are 1/4000 of their distance from each other.
 */
const DEEPEST_SLICE = 4096;

/** @throws Error where the browser has no WebGL 2 */
export function makeStage(canvas: HTMLCanvasElement): Stage {
  const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "high-performance" });
  renderer.setClearColor(new Color(0), 0);
  renderer.autoClear = false;
  const scene = new Scene();
  const camera = new PerspectiveCamera(FOV, 1, 0.01, 100);
  addLights(scene, camera);

  let covered: Covered = { top: 0, right: 0, bottom: 0 };

  return {
    canvas,
    renderer,
    scene,
    camera,
    get covered() { return covered; },
    resize(now) {
      const { clientWidth: width, clientHeight: height } = canvas;
      if (width === 0 || height === 0) return false;
      const ratio = Math.min(devicePixelRatio, MOST_PIXELS_PER_CSS_PIXEL);
      const same = canvas.width === Math.floor(width * ratio) && canvas.height === Math.floor(height * ratio);
      if (same && covered.top === now.top && covered.right === now.right && covered.bottom === now.bottom) return false;
      covered = now;
      if (!same) {
        renderer.setPixelRatio(ratio);
        renderer.setSize(width, height, false);
      }
      camera.aspect = width / height;
      // The middle of the picture is the middle of what can be seen of it.
      camera.setViewOffset(width, height, covered.right / 2, (covered.bottom - covered.top) / 2, width, height);
      return true;
    },
    fitDepth({ center, radius }, nearest) {
      const distance = camera.position.distanceTo(center);
      const near = Math.max(distance - radius, Math.min(radius * 1e-3, nearest * 0.02), radius * 1e-8);
      const far = Math.max(distance + radius, near * 2);
      if (Math.abs(near - camera.near) < 1e-3 * near && Math.abs(far - camera.far) < 1e-3 * far) return;
      camera.near = near;
      camera.far = far;
      camera.updateProjectionMatrix();
    },
    draw() {
      const { near, far } = camera;
      const slices = Math.max(1, Math.ceil(Math.log(far / near) / Math.log(DEEPEST_SLICE)));
      renderer.clear();
      for (let slice = slices - 1; slice >= 0; slice--) {
        if (slices > 1) {
          const at = (i: number) => near * (far / near) ** (i / slices);
          // A hair of overlap, or there would be a seam.
          [camera.near, camera.far] = [at(slice), at(slice + 1) * 1.0005];
          camera.updateProjectionMatrix();
          renderer.clearDepth();
        }
        renderer.render(scene, camera);
      }
      if (slices === 1) return;
      [camera.near, camera.far] = [near, far];
      camera.updateProjectionMatrix();
    },
  };
}
