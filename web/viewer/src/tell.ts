/** Where one looks from, in words: for those who do not see the picture, and for notes. */

import { type Box3, type PerspectiveCamera, Vector3 } from "three";
import { figures, texts } from "./texts/index.js";

/** "Seen from the front and a little above, filling two thirds of the picture." */
export function tellView(camera: PerspectiveCamera, box: Box3): string {
  const { tell } = texts();
  return tell.seen(side(camera)) + size(camera, box);
}

function side(camera: PerspectiveCamera): string {
  const { from, height, straight } = texts().tell;
  const back = camera.getWorldDirection(new Vector3()).negate();
  const up = (Math.asin(Math.min(1, Math.max(-1, back.y))) * 180) / Math.PI;
  if (Math.abs(up) > 75) return up > 0 ? straight.top : straight.bottom;
  const around = ["front", "frontRight", "right", "backRight", "back", "backLeft", "left", "frontLeft"] as const;
  const eighth = Math.round(Math.atan2(back.x, back.z) / (Math.PI / 4));
  const word = up > 40 ? "highAbove" : up > 8 ? "above" : up < -40 ? "farBelow" : up < -8 ? "below" : "level";
  return from[around[(eighth + 8) % 8]!] + height[word];
}

/** Up to which part of the picture each word goes: half way to the next. */
const PARTS = [
  [0.06, "speck"], [0.17, "tenth"], [0.29, "quarter"], [0.42, "third"], [0.58, "half"], [0.71, "twoThirds"],
  [0.87, "threeQuarters"], [1.1, "all"],
] as const;

function size(camera: PerspectiveCamera, box: Box3): string {
  const { tell } = texts();
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = low.clone().negate();
  let behind = 0;
  for (let corner = 0; corner < 8; corner++) {
    const at = new Vector3(corner & 1, (corner >> 1) & 1, corner >> 2).multiply(box.getSize(new Vector3())).add(box.min);
    at.applyMatrix4(camera.matrixWorldInverse);
    if (at.z >= -camera.near) {
      behind++;
      continue;
    }
    at.applyMatrix4(camera.projectionMatrix);
    low.min(at);
    high.max(at);
  }
  if (behind === 8 || low.x > 1 || low.y > 1 || high.x < -1 || high.y < -1) return tell.outside;
  let part = Math.max(high.x - low.x, high.y - low.y) / 2;
  if (behind > 0) {
    // The eye is inside of the box: as large as its longest side would be at a tenth of its length.
    part = Math.max(part, 10 / (2 * Math.tan((camera.fov * Math.PI) / 360)));
  }
  const named = PARTS.find(([most]) => part < most);
  return named ? tell.fills(tell.parts[named[1]]) : tell.close(figures(part));
}
