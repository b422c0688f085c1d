import { execFileSync } from "node:child_process";
import { existsSync, statSync } from "node:fs";
import { join } from "node:path";
import { binary, model, models, prepareFolders } from "./files.js";

/** Makes the model with the binary under test, unless this very binary made it before. */
export default function setup(): void {
  prepareFolders();
  if (existsSync(model) && statSync(model).mtimeMs > statSync(binary).mtimeMs) return;
  const source = join(models, "scan.ply");
  const run = (...args: string[]) => execFileSync(binary, args, { stdio: ["ignore", "ignore", "inherit"] });
  run("sample", "scan", "-o", source, "--triangles", "120000", "--force");
  run("build", source, "-o", model, "--force");
}
