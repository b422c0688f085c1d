/** How one gets around: turning around the model, flying, the six sides, by mouse, pen, fingers and keys. */

import { type Box3, MathUtils, Spherical, Vector2, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Point } from "./address.js";
import { FOV, type Stage } from "./stage.js";

export const SIDES = ["front", "back", "left", "right", "top", "bottom"] as const;
export type Side = (typeof SIDES)[number];

/** From where, y being up. Seen from the top, the front is at the bottom of the picture. */
const DIRECTIONS: Record<Side, Vector3> = {
  front: new Vector3(0, 0, 1),
  back: new Vector3(0, 0, -1),
  left: new Vector3(-1, 0, 0),
  right: new Vector3(1, 0, 0),
  top: new Vector3(0, 1, 1e-5).normalize(),
  bottom: new Vector3(0, -1, 1e-5).normalize(),
};
/** Seen from a little to the right and above, as one would photograph a figure. */
const FIRST_LOOK = new Vector3(0.38, 0.28, 0.88).normalize();

/** A change of view takes this long, seconds. */
const TRAVEL_S = 0.4;
/** A wheel that rests this long starts anew, milliseconds. */
const WHEEL_REST_MS = 250;
/** How fast a turn comes to rest, and flying to speed and to rest again, 1/s. */
const BRAKE = 7;

export interface Navigation {
  /** What the camera turns around, and the axis of the picture leads through. */
  readonly target: Vector3;
  /** Lets time pass; whether the camera moved or will. */
  update(seconds: number): boolean;
  /** Keeps moves within what makes sense for models in this box. */
  bound(box: Box3): void;
  /** All of the box, from where one looks now. */
  fit(box: Box3): void;
  /** All of the box from one side, or as at first. */
  lookFrom(box: Box3, side: Side | "first", travel?: boolean): void;
  lookAt(eye: Point, target: Point, travel?: boolean): void;
  fly(on: boolean): void;
  /** Whether the key meant something. */
  key(event: KeyboardEvent): boolean;
}

/** @param pick distance along the ray through a point of the picture to what is drawn there, the point from -1 to 1 */
export function makeNavigation(stage: Stage, pick: (at: Vector2) => number | undefined): Navigation {
  const { camera, canvas } = stage;
  const orbit = new OrbitControls(camera, canvas);
  orbit.zoomToCursor = true;
  orbit.zoomSpeed = 1.4;
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const follow = () => { orbit.enableDamping = !still.matches; };
  still.addEventListener("change", follow);
  follow();

  const forward = () => camera.getWorldDirection(new Vector3());
  let travel: { from: Pose; to: Pose; done: number } | undefined;
  let flight: Flight | undefined;

  /** Turning, moving and nearing are measured at what is drawn at this point of the picture, if anything is. */
  function pivot(at: Vector2): void {
    const distance = pick(at);
    if (distance === undefined) return;
    const ray = new Vector3(at.x, at.y, 0.5).unproject(camera).sub(camera.position).normalize();
    const depth = Math.max(distance * ray.dot(forward()), orbit.minDistance * 1.5);
    orbit.target.copy(camera.position).addScaledVector(forward(), depth);
  }

  const inPicture = ({ clientX, clientY }: MouseEvent) => {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return new Vector2((2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height);
  };
  let lastWheel = -Infinity;
  // Before the controls see them.
  canvas.addEventListener("pointerdown", (event) => {
    travel = undefined;
    if (event.isPrimary && !flight) pivot(inPicture(event));
  }, { capture: true });
  canvas.addEventListener("wheel", (event) => {
    travel = undefined;
    if (event.timeStamp - lastWheel > WHEEL_REST_MS && !flight) pivot(inPicture(event));
    lastWheel = event.timeStamp;
  }, { capture: true, passive: true });

  function go(to: Pose, animate = true): void {
    flight?.rest();
    if (!animate || still.matches) {
      travel = undefined;
      place(to);
    } else {
      travel = { from: { eye: camera.position.clone(), target: orbit.target.clone() }, to, done: 0 };
    }
  }

  function place({ eye, target }: Pose): void {
    camera.position.copy(eye);
    orbit.target.copy(target);
    camera.lookAt(target);
    orbit.update();
  }

  /** Where all corners of the box are seen from in this direction, in the part of the picture that is not covered. */
  function poseFor(box: Box3, direction: Vector3): Pose {
    const { covered } = stage;
    const target = box.getCenter(new Vector3());
    const [right, up] = axes(direction);
    const { clientWidth, clientHeight } = canvas;
    const tanOfPixel = (2 * Math.tan((FOV * Math.PI) / 360)) / Math.max(clientHeight, 1);
    const tanAcross = (tanOfPixel * Math.max(clientWidth - covered.right, 1)) / 2;
    const tanUp = (tanOfPixel * Math.max(clientHeight - covered.top - covered.bottom, 1)) / 2;
    let distance = 0;
    for (let corner = 0; corner < 8; corner++) {
      const x = new Vector3(corner & 1, (corner >> 1) & 1, corner >> 2);
      const at = box.getSize(new Vector3()).multiply(x).add(box.min).sub(target);
      const needed = Math.max(Math.abs(at.dot(right)) / tanAcross, Math.abs(at.dot(up)) / tanUp);
      distance = Math.max(distance, needed + at.dot(direction));
    }
    distance = Math.max(distance, box.min.distanceTo(target) * 0.1);
    return { eye: target.clone().addScaledVector(direction, distance), target };
  }

  function turn(left: number, up: number): void {
    const offset = new Spherical().setFromVector3(camera.position.clone().sub(orbit.target));
    offset.theta += left;
    offset.phi += up;
    offset.makeSafe();
    place({ eye: new Vector3().setFromSpherical(offset).add(orbit.target), target: orbit.target });
  }

  function move(right: number, up: number): void {
    pivot(new Vector2(-camera.projectionMatrix.elements[8]!, -camera.projectionMatrix.elements[9]!));
    const distance = camera.position.distanceTo(orbit.target);
    const by = new Vector3(right * distance, up * distance, 0).applyQuaternion(camera.quaternion);
    place({ eye: camera.position.clone().add(by), target: orbit.target.clone().add(by) });
  }

  function near(factor: number): void {
    // The axis of the picture; its middle is elsewhere where the panel covers a part of it.
    pivot(new Vector2(-camera.projectionMatrix.elements[8]!, -camera.projectionMatrix.elements[9]!));
    const offset = camera.position.clone().sub(orbit.target);
    offset.setLength(MathUtils.clamp(offset.length() * factor, orbit.minDistance, orbit.maxDistance));
    place({ eye: offset.add(orbit.target), target: orbit.target });
  }

  return {
    target: orbit.target,
    update(seconds) {
      if (travel) {
        travel.done = Math.min(1, travel.done + seconds / TRAVEL_S);
        place(between(travel.from, travel.to, travel.done * travel.done * (3 - 2 * travel.done)));
        if (travel.done === 1) travel = undefined;
        return true;
      }
      if (flight) return flight.update(seconds, still.matches);
      // The controls count frames; time is what a hand feels.
      orbit.dampingFactor = MathUtils.clamp(1 - Math.exp(-BRAKE * seconds), 0.02, 0.9);
      return orbit.update();
    },
    bound(box) {
      const radius = box.min.distanceTo(box.max) / 2;
      orbit.minDistance = radius * 1e-6;
      orbit.maxDistance = radius * 40;
    },
    fit: (box) => go(poseFor(box, forward().negate())),
    lookFrom: (box, side, animate = true) => go(poseFor(box, side === "first" ? FIRST_LOOK : DIRECTIONS[side]), animate),
    lookAt: (eye, target, animate = false) => go({ eye: new Vector3(...eye), target: new Vector3(...target) }, animate),
    fly(on) {
      if (on === (flight !== undefined)) return;
      travel = undefined;
      orbit.enabled = !on;
      if (on) {
        flight = takeOff(stage, camera.position.distanceTo(orbit.target));
        return;
      }
      flight!.land();
      flight = undefined;
      // What is in the middle is what one goes on turning around.
      const distance = pick(new Vector2()) ?? camera.position.distanceTo(orbit.target);
      place({ eye: camera.position, target: camera.position.clone().addScaledVector(forward(), distance) });
    },
    key(event) {
      if (flight) return flight.key(event);
      travel = undefined;
      // A twentieth of a right angle, a twentieth of the distance.
      const [angle, part] = [Math.PI / 40, 0.05];
      const { key, shiftKey } = event;
      switch (key) {
        case "ArrowLeft": shiftKey ? move(-part, 0) : turn(-angle, 0); break;
        case "ArrowRight": shiftKey ? move(part, 0) : turn(angle, 0); break;
        case "ArrowUp": shiftKey ? move(0, part) : turn(0, -angle); break;
        case "ArrowDown": shiftKey ? move(0, -part) : turn(0, angle); break;
        case "+": case "=": near(0.9); break;
        case "-": case "_": near(1 / 0.9); break;
        default: return false;
      }
      return true;
    },
  };
}

/** Where the camera is and what it looks at. */
interface Pose {
  eye: Vector3;
  target: Vector3;
}

/** Right and up in the picture of a camera that looks against this direction. */
function axes(direction: Vector3): [Vector3, Vector3] {
  const right = new Vector3(0, 1, 0).cross(direction);
  if (right.lengthSq() < 1e-12) right.set(1, 0, 0);
  right.normalize();
  return [right, direction.clone().cross(right)];
}

/** Around what is looked at, on an arc; distances grow by factors. */
function between(from: Pose, to: Pose, part: number): Pose {
  const spherical = ({ eye, target }: Pose) => new Spherical().setFromVector3(eye.clone().sub(target));
  const [a, b] = [spherical(from), spherical(to)];
  // The short way around.
  const turn = MathUtils.euclideanModulo(b.theta - a.theta + Math.PI, 2 * Math.PI) - Math.PI;
  const target = from.target.clone().lerp(to.target, part);
  if (part === 1) return to;
  const offset = new Spherical(a.radius * (b.radius / a.radius) ** part, MathUtils.lerp(a.phi, b.phi, part), a.theta + turn * part);
  return { eye: new Vector3().setFromSpherical(offset.makeSafe()).add(target), target };
}

interface Flight {
  update(seconds: number, still: boolean): boolean;
  key(event: KeyboardEvent): boolean;
  rest(): void;
  land(): void;
}

/** Which way keys move: right, up, back. */
const WAYS: Record<string, Vector3> = {
  KeyW: new Vector3(0, 0, -1), ArrowUp: new Vector3(0, 0, -1), KeyS: new Vector3(0, 0, 1), ArrowDown: new Vector3(0, 0, 1),
  KeyA: new Vector3(-1, 0, 0), ArrowLeft: new Vector3(-1, 0, 0), KeyD: new Vector3(1, 0, 0), ArrowRight: new Vector3(1, 0, 0),
  KeyE: new Vector3(0, 1, 0), KeyQ: new Vector3(0, -1, 0),
};

/** Flying, from where the camera is. `distance` is how far the surface is: one second's way at the start is a part of it. */
function takeOff({ camera, canvas }: Stage, distance: number): Flight {
  let speed = distance * 0.5;
  const pressed = new Set<string>();
  const velocity = new Vector3();
  const pointers = new Map<number, Vector2>();
  const ended = new AbortController();
  let turned = false;

  function look(left: number, up: number): void {
    const [yaw, pitch] = [new Vector3(0, 1, 0), new Vector3(1, 0, 0)];
    const direction = camera.getWorldDirection(new Vector3());
    const height = Math.asin(MathUtils.clamp(direction.y, -1, 1));
    const most = MathUtils.degToRad(88);
    camera.rotateOnAxis(pitch, MathUtils.clamp(height + up, -most, most) - height);
    camera.rotateOnWorldAxis(yaw, left);
    camera.updateMatrixWorld();
    turned = true;
  }
  const faster = (factor: number) => { speed = MathUtils.clamp(speed * factor, distance * 1e-6, distance * 1e3); };

  const listen = <K extends keyof HTMLElementEventMap>(type: K, listener: (event: HTMLElementEventMap[K]) => void) =>
    canvas.addEventListener(type, listener, { signal: ended.signal, passive: false });
  listen("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, new Vector2(event.clientX, event.clientY));
  });
  listen("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const [x, y] = [event.clientX - last.x, event.clientY - last.y];
    last.set(event.clientX, event.clientY);
    // A drag across the height of the picture turns by what the picture shows.
    const angle = MathUtils.degToRad(FOV) / canvas.clientHeight;
    // Two fingers push.
    if (pointers.size > 1) camera.translateZ((2 * y * speed) / canvas.clientHeight), (turned = true);
    else look(x * angle, y * angle);
  });
  for (const type of ["pointerup", "pointercancel"] as const) listen(type, ({ pointerId }) => pointers.delete(pointerId));
  listen("wheel", (event) => {
    event.preventDefault();
    faster(1.2 ** -Math.sign(event.deltaY));
  });
  listen("keyup", ({ code }) => pressed.delete(code));
  listen("blur", () => pressed.clear());

  return {
    update(seconds, still) {
      const wanted = new Vector3();
      for (const code of pressed) wanted.add(WAYS[code]!);
      if (wanted.lengthSq() > 0) wanted.setLength(speed);
      velocity.lerp(wanted, still ? 1 : 1 - Math.exp(-BRAKE * seconds));
      const moved = turned || velocity.length() > 1e-3 * speed;
      turned = false;
      if (velocity.length() <= 1e-3 * speed) velocity.set(0, 0, 0);
      // A frame that took long is no leap.
      const by = velocity.clone().multiplyScalar(Math.min(seconds, 0.1)).applyQuaternion(camera.quaternion);
      camera.position.add(by);
      camera.updateMatrixWorld();
      return moved;
    },
    key({ key, code, shiftKey }) {
      const angle = Math.PI / 80;
      if (key === "+" || key === "=") faster(1.25);
      else if (key === "-" || key === "_") faster(0.8);
      else if (shiftKey && key.startsWith("Arrow")) {
        look(angle * (Number(key === "ArrowLeft") - Number(key === "ArrowRight")), angle * (Number(key === "ArrowUp") - Number(key === "ArrowDown")));
      } else if (code in WAYS) pressed.add(code);
      else return false;
      return true;
    },
    rest() {
      velocity.set(0, 0, 0);
      pressed.clear();
      turned = true;
    },
    land: () => ended.abort(),
  };
}
