/** What somebody would write who has just installed the packages; and what the tests look at. */

import { defaultScale, MeshfrontObject, shadeMaterial } from "@meshfront/three";
import {
  Color, DirectionalLight, HemisphereLight, type Intersection, type Material, Mesh, MeshStandardMaterial, PerspectiveCamera,
  PlaneGeometry, Raycaster, REVISION, Scene, ShaderMaterial, Vector2, Vector3, WebGLRenderer,
} from "three";

const canvas = document.querySelector("canvas")!;
const renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
renderer.setSize(innerWidth, innerHeight, false);
renderer.setClearColor(0x0000ff);
renderer.shadowMap.enabled = true;
const scene = new Scene();
const camera = new PerspectiveCamera(40, innerWidth / innerHeight, 0.1, 1000);
const sun = new DirectionalLight(0xffffff, 3);
scene.add(sun, sun.target, new HemisphereLight(0xffffff, 0x808080, 1));

const events: string[] = [];
const fractions: (number | undefined)[] = [];
const object = new MeshfrontObject("model.front", { tolerancePx: 1 });
scene.add(object);
object.addEventListener("load-progress", ({ fraction }) => fractions.push(fraction));
object.addEventListener("load-base", () => events.push("load-base"));
object.addEventListener("load-error", ({ error }) => events.push(`load-error ${error.kind}`));
object.addEventListener("front-settled", () => events.push("front-settled"));
object.addEventListener("load", () => {
  events.push("load");
  const { center, radius } = object.geometry.boundingSphere!;
  camera.position.copy(center).add(new Vector3(0, 0, 2.5 * radius));
  [camera.near, camera.far] = [0.1 * radius, 10 * radius];
  camera.updateProjectionMatrix();
});
object.setResolutionFromRenderer(camera, renderer);
renderer.setAnimationLoop(() => {
  if (object.info) object.update();
  renderer.render(scene, camera);
});

/** A material of one's own that writes a colour for each level. */
const own = new ShaderMaterial({
  vertexShader: `attribute float level;
    varying float v;
    void main() {
      v = level;
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    }`,
  fragmentShader: "varying float v; void main() { gl_FragColor = vec4(1.0, v / 40.0, 0.0, 1.0); }",
});
/** One that takes part in three.js's own. */
const patched = new MeshStandardMaterial();
patched.onBeforeCompile = (shader) => {
  shader.fragmentShader = shader.fragmentShader.replace("#include <dithering_fragment>", "gl_FragColor = vec4(0.0, 1.0, 0.0, 1.0);");
};

/** The colour in the middle of the picture, or beside it: parts of its size. */
function colour(x = 0, y = 0): number[] {
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const bytes = new Uint8Array(4);
  const at = (part: number, size: number) => Math.round((0.5 + part / 2) * size);
  gl.readPixels(at(x, canvas.width), at(y, canvas.height), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  return [...bytes];
}

const fresh = {
  revision: REVISION,
  events,
  fractions,
  object,
  settled: () => object.settled,
  pick(): Intersection | undefined {
    const raycaster = new Raycaster();
    raycaster.setFromCamera(new Vector2(0.02, 0.03), camera);
    return raycaster.intersectObject(object)[0];
  },
  colour,
  /** The colour in the middle with each of the materials. */
  materials(): number[][] {
    const before = object.material;
    const shade = shadeMaterial(defaultScale("level"));
    const seen = [own, patched, shade].map((material: Material) => {
      object.material = material;
      return colour();
    });
    object.material = before;
    return seen;
  },
  /** How bright a wall behind the object is in its shadow, without and with it. */
  shadows(): [number, number] {
    const { center, radius } = object.geometry.boundingSphere!;
    const wall = new Mesh(new PlaneGeometry(20 * radius, 20 * radius), new MeshStandardMaterial({ color: new Color(0xffffff) }));
    wall.position.copy(center).z -= 1.5 * radius;
    wall.receiveShadow = true;
    scene.add(wall);
    sun.position.copy(center).add(new Vector3(-1, 0, 1).multiplyScalar(4 * radius));
    sun.target.position.copy(center);
    sun.castShadow = true;
    const view = sun.shadow.camera;
    const wide = 2 * radius;
    Object.assign(view, { left: -wide, right: wide, top: wide, bottom: -wide, near: radius, far: 12 * radius });
    view.updateProjectionMatrix();
    // Far to the right of the object, where its shadow falls on the wall.
    const there = new Vector3(1.6, 0, -1.5).multiplyScalar(radius).add(center).project(camera);
    object.castShadow = false;
    const without = colour(there.x, there.y)[0]!;
    object.castShadow = true;
    const within = colour(there.x, there.y)[0]!;
    scene.remove(wall);
    sun.castShadow = object.castShadow = false;
    return [without, within];
  },
  dispose: () => object.dispose(),
};
declare global {
  interface Window { fresh: typeof fresh }
}
window.fresh = fresh;
