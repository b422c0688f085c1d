import { execFileSync } from "node:child_process";
import { existsSync, statSync } from "node:fs";
import { join } from "node:path";
import { binary, model, models, prepareFolders, terrain } from "./files.js";

/** Makes the model with the binary under test, unless this very binary made it before. */
export default function setup(): void {
  prepareFolders();
  const isFresh = (file: string) => existsSync(file) && statSync(file).mtimeMs > statSync(binary).mtimeMs;
  if (isFresh(model) && isFresh(terrain)) return;
  const source = join(models, "scan.ply");
  const run = (...args: string[]) => execFileSync(binary, args, { stdio: ["ignore", "ignore", "inherit"] });
  run("sample", "scan", "-o", source, "--triangles", "120000", "--force");
  run("build", source, "-o", model, "--force");
  const heights = join(models, "terrain.tif");
  run("sample", "terrain", "-o", heights, "--triangles", "524288", "--force");
  run("build", heights, "-o", terrain, "--force");
}
