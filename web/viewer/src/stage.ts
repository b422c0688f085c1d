/** The picture: renderer, lights, camera, and the controls of the mouse, of fingers and of the keyboard. */

import {
  type Box3, Color, DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, type Sphere, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** How much of the picture's sides is covered, CSS pixels. */
export interface Covered {
  top: number;
  right: number;
  bottom: number;
}

export interface Stage {
  renderer: WebGLRenderer;
  scene: Scene;
  camera: PerspectiveCamera;
  controls: OrbitControls;
  /** Takes over the size of the canvas, part of which lies under the panel; whether it changed. */
  resize(covered: Covered): boolean;
  /** Puts the camera where all corners of the model's box are seen from. */
  showAll(box: Box3): void;
  /** Near and far plane around the model as it is seen now. */
  fitDepth(sphere: Sphere): void;
}

/** Vertical field of view, degrees. */
const FOV = 40;
/** Seen from a little to the right and above, as one would photograph a figure. */
const FIRST_LOOK = new Vector3(0.38, 0.28, 0.88).normalize();

export function makeStage(canvas: HTMLCanvasElement, pixelRatio: number): Stage {
  const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "high-performance" });
  renderer.setPixelRatio(pixelRatio);
  renderer.setClearColor(new Color(0), 0);
  const scene = new Scene();
  const camera = new PerspectiveCamera(FOV, 1, 0.01, 100);
  scene.add(camera);

  // The sky gives shape to what the key light does not reach; the key travels with the camera, so that relief always
  // shows, and a weak light from the other side keeps its shadows open.
  scene.add(new HemisphereLight(0xe4ecf5, 0x3a322c, 0.85));
  const key = new DirectionalLight(0xfff1e0, 2.5);
  key.position.set(-0.8, 1.0, 0.6);
  const fill = new DirectionalLight(0xcfe0ff, 0.5);
  fill.position.set(1, -0.2, 0.4);
  for (const light of [key, fill]) camera.add(light, light.target);
  for (const light of [key, fill]) light.target.position.set(0, 0, -1);

  const controls = new OrbitControls(camera, canvas);
  controls.enableDamping = true;
  controls.dampingFactor = 0.12;
  controls.zoomToCursor = true;
  controls.zoomSpeed = 1.4;
  let covered: Covered = { top: 0, right: 0, bottom: 0 };

  return {
    renderer,
    scene,
    camera,
    controls,
    resize(now) {
      const { clientWidth: width, clientHeight: height } = canvas;
      if (width === 0 || height === 0) return false;
      const ratio = renderer.getPixelRatio();
      const same = canvas.width === Math.floor(width * ratio) && canvas.height === Math.floor(height * ratio);
      if (same && covered.top === now.top && covered.right === now.right && covered.bottom === now.bottom) return false;
      covered = now;
      if (!same) renderer.setSize(width, height, false);
      camera.aspect = width / height;
      // The middle of the picture is the middle of what can be seen of it.
      camera.setViewOffset(width, height, covered.right / 2, (covered.bottom - covered.top) / 2, width, height);
      return true;
    },
    showAll(box) {
      const center = box.getCenter(new Vector3());
      camera.position.copy(center).add(FIRST_LOOK);
      camera.lookAt(center);
      camera.updateMatrixWorld();
      const right = new Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
      const up = new Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
      const { clientWidth, clientHeight } = canvas;
      const tanOfPixel = (2 * Math.tan((FOV * Math.PI) / 360)) / Math.max(clientHeight, 1);
      const tanAcross = (tanOfPixel * Math.max(clientWidth - covered.right, 1)) / 2;
      const tanUp = (tanOfPixel * Math.max(clientHeight - covered.top - covered.bottom, 1)) / 2;
      let distance = 0;
      for (let corner = 0; corner < 8; corner++) {
        const x = new Vector3(corner & 1, (corner >> 1) & 1, corner >> 2);
        const at = box.getSize(new Vector3()).multiply(x).add(box.min).sub(center);
        const needed = Math.max(Math.abs(at.dot(right)) / tanAcross, Math.abs(at.dot(up)) / tanUp);
        distance = Math.max(distance, needed + at.dot(FIRST_LOOK));
      }
      const radius = box.min.distanceTo(center);
      camera.position.copy(center).addScaledVector(FIRST_LOOK, Math.max(distance, radius * 0.1));
      controls.target.copy(center);
      controls.minDistance = radius * 2e-3;
      controls.maxDistance = radius * 40;
      controls.update();
    },
    fitDepth({ center, radius }) {
      const distance = camera.position.distanceTo(center);
      const near = Math.max(distance - radius, radius * 1e-3);
      const far = distance + radius;
      if (Math.abs(near - camera.near) < 1e-3 * near && Math.abs(far - camera.far) < 1e-3 * far) return;
      camera.near = near;
      camera.far = far;
      camera.updateProjectionMatrix();
    },
  };
}

/** Arrow keys turn, with Shift they move; plus and minus go nearer and farther. Returns whether the key meant something. */
export function moveByKey({ camera, controls }: Stage, event: KeyboardEvent): boolean {
  const offset = camera.position.clone().sub(controls.target);
  const distance = offset.length();
  const right = new Vector3().setFromMatrixColumn(camera.matrix, 0);
  const up = new Vector3().setFromMatrixColumn(camera.matrix, 1);
  const turn = (axis: Vector3, angle: number) => offset.applyAxisAngle(axis, angle);
  const move = (axis: Vector3, by: number) => controls.target.addScaledVector(axis, by * distance);
  // A twentieth of a right angle, a twentieth of the distance.
  const [angle, part] = [Math.PI / 40, 0.05];
  switch (event.key) {
    case "ArrowLeft": event.shiftKey ? move(right, -part) : turn(camera.up, -angle); break;
    case "ArrowRight": event.shiftKey ? move(right, part) : turn(camera.up, angle); break;
    case "ArrowUp": event.shiftKey ? move(up, part) : turn(right, -angle); break;
    case "ArrowDown": event.shiftKey ? move(up, -part) : turn(right, angle); break;
    case "+": case "=": offset.multiplyScalar(Math.max(0.9, controls.minDistance / distance)); break;
    case "-": case "_": offset.multiplyScalar(Math.min(1 / 0.9, controls.maxDistance / distance)); break;
    default: return false;
  }
  camera.position.copy(controls.target).add(offset);
  controls.update();
  return true;
}
