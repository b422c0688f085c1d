import { execFileSync } from "node:child_process";
import { existsSync, statSync } from "node:fs";
import { join } from "node:path";
import { binary, model, models, prepareFolders, small, terrain } from "./files.js";

/** Makes the models with the binary under test, unless this very binary made them before. */
export default function setup(): void {
  prepareFolders();
  const isFresh = (file: string) => existsSync(file) && statSync(file).mtimeMs > statSync(binary).mtimeMs;
  if ([model, small, terrain].every(isFresh)) return;
  const run = (...args: string[]) => execFileSync(binary, args, { stdio: ["ignore", "ignore", "inherit"] });
  for (const [file, triangles] of [[model, "120000"], [small, "20000"]] as const) {
    const source = file.replace(/front$/, "ply");
    run("sample", "scan", "-o", source, "--triangles", triangles, "--force");
    run("build", source, "-o", file, "--force");
  }
  const heights = join(models, "terrain.tif");
  run("sample", "terrain", "-o", heights, "--triangles", "524288", "--force");
  run("build", heights, "-o", terrain, "--force");
}
