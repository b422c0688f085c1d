/** What is drawn beside the models: the view that a frozen front was made for, and the spheres of updates. */

import type { MeshfrontObject } from "@meshfront/three";
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, type PerspectiveCamera, type Scene, Sphere, Vector3 } from "three";

const ORANGE = 0xd9822b;

export interface Frustum {
  /** Around all of it. */
  around: Sphere;
  erase(): void;
}

/** Draws what a camera sees now, from its eye as far as the models reach. */
export function drawFrustum(camera: PerspectiveCamera, scene: Scene): Frustum {
  const corner = (x: number, y: number) => new Vector3(x, y, 1).unproject(camera);
  // `unproject` counts depth from -1 to 1: 1 is the far plane.
  const far = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
  const middle = far.map((at) => at.clone().lerp(camera.position, 0.5));
  const segments = [far, middle].flatMap((ring) => ring.flatMap((at, i) => [at, ring[(i + 1) % 4]!]));
  for (const at of far) segments.push(camera.position, at);
  const lines = new LineSegments(new BufferGeometry().setFromPoints(segments), new LineBasicMaterial({ color: ORANGE }));
  lines.frustumCulled = false;
  scene.add(lines);
  return {
    around: new Sphere().setFromPoints(segments),
    erase() {
      lines.removeFromParent();
      lines.geometry.dispose();
      lines.material.dispose();
    },
  };
}

/** The most spheres that are drawn of a model: more would hide it. */
const MOST_SPHERES = 48;
const STEPS = 32;

export interface Spheres {
  /** Asks for the spheres anew, where they are wanted. */
  refresh(): void;
  dispose(): void;
}

/** Three great circles for each update that would be applied next. */
export function drawSpheres(object: MeshfrontObject, wanted: () => boolean, changed: () => void): Spheres {
  const lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: ORANGE, transparent: true, opacity: 0.7 }));
  lines.frustumCulled = false;
  object.add(lines);
  let isAsking = false;
  let again = false;

  async function refresh(): Promise<void> {
    lines.visible = wanted();
    again = isAsking;
    if (!wanted() || isAsking) return;
    isAsking = true;
    const circles = await object.spheres(MOST_SPHERES).catch(() => new Float32Array());
    isAsking = false;
    lines.geometry.dispose();
    lines.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(circlesOf(circles), 3));
    changed();
    if (again) void refresh();
  }
  return {
    refresh: () => void refresh(),
    dispose() {
      lines.removeFromParent();
      lines.geometry.dispose();
      lines.material.dispose();
    },
  };
}

/** Segments of great circles around the three axes; `spheres` are centre and radius, four numbers each. */
function circlesOf(spheres: Float32Array): Float32Array {
  const positions: number[] = [];
  for (let i = 0; i + 3 < spheres.length; i += 4) {
    const center = spheres.subarray(i, i + 3);
    const radius = spheres[i + 3]!;
    for (let axis = 0; axis < 3; axis++) {
      for (let step = 0; step < STEPS; step++) {
        for (const end of [step, step + 1]) {
          const angle = (2 * Math.PI * end) / STEPS;
          const at = [...center];
          at[(axis + 1) % 3]! += radius * Math.cos(angle);
          at[(axis + 2) % 3]! += radius * Math.sin(angle);
          positions.push(...at);
        }
      }
    }
  }
  return Float32Array.from(positions);
}
