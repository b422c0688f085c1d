// Terrain with @mapbox/martini: `node martini.mjs MODULE HEIGHTS.asc ERROR…` prints, as JSON, what it took to prepare the grid,
// and for each error the triangles, how far they really are from the samples (vertically), and the milliseconds.

import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [, , module, heights, ...errors] = process.argv;
const { default: Martini } = await import(pathToFileURL(module).href);
const words = readFileSync(heights, "utf8").split(/\s+/);
let columns = 0;
let at = 0;
for (; /^[a-z]/i.test(words[at]); at += 2) {
  if (words[at].toLowerCase() === "ncols") columns = Number(words[at + 1]);
}
const grid = Float32Array.from(words.slice(at, at + columns * columns), Number);

const start = performance.now();
const tile = new Martini(columns).createTile(grid);
const prepareMs = performance.now() - start;

/** The greatest vertical distance of a sample from the triangle above or below it. */
function measure({ vertices, triangles }) {
  let worst = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [0, 1, 2].map((k) => {
      const [x, y] = [vertices[2 * triangles[t + k]], vertices[2 * triangles[t + k] + 1]];
      return [x, y, grid[y * columns + x]];
    });
    const twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    for (let y = Math.min(ay, by, cy); y <= Math.max(ay, by, cy); y++) {
      for (let x = Math.min(ax, bx, cx); x <= Math.max(ax, bx, cx); x++) {
        const u = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / twice;
        const v = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / twice;
        if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9) continue;
        worst = Math.max(worst, Math.abs(az + u * (bz - az) + v * (cz - az) - grid[y * columns + x]));
      }
    }
  }
  return worst;
}

const meshes = errors.map((asked) => {
  const start = performance.now();
  const mesh = tile.getMesh(Number(asked));
  const ms = performance.now() - start;
  return { asked: Number(asked), triangles: mesh.triangles.length / 3, measured: measure(mesh), ms };
});
console.log(JSON.stringify({ prepareMs, meshes }));
