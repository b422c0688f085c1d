/** The picture as a PNG: background, models and measured lines, at the size of the canvas. */

import { paintBackground } from "./backgrounds.js";
import type { Line } from "./measure.js";

/** @param canvas what was drawn, in the same task (afterwards browsers forget it) */
export function compose(canvas: HTMLCanvasElement, background: string, isDark: boolean, lines: readonly Line[]): HTMLCanvasElement {
  const { width, height, clientWidth } = canvas;
  const picture = Object.assign(document.createElement("canvas"), { width, height });
  const context = picture.getContext("2d")!;
  paintBackground(context, background, isDark);
  context.drawImage(canvas, 0, 0);
  context.scale(width / clientWidth, width / clientWidth);
  context.font = "600 14px system-ui, sans-serif";
  context.textAlign = "center";
  const [mark, halo] = isDark ? ["#ffc24d", "#12161c"] : ["#b34700", "#ffffff"];
  for (const { from, to, text } of lines) {
    context.strokeStyle = context.fillStyle = mark;
    context.lineWidth = 2;
    if (to) {
      context.beginPath();
      context.moveTo(from.x, from.y);
      context.lineTo(to.x, to.y);
      context.stroke();
    }
    for (const { x, y } of to ? [from, to] : [from]) {
      context.beginPath();
      context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fill();
    }
    if (!to) continue;
    const [x, y] = [(from.x + to.x) / 2, (from.y + to.y) / 2 - 8];
    context.strokeStyle = halo;
    context.lineWidth = 4;
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  }
  return picture;
}
