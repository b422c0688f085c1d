/** Where things are, and the servers that tests start. */

import { type ChildProcess, spawn } from "node:child_process";
import { existsSync, mkdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("../..", import.meta.url));
const target = process.env.CARGO_TARGET_DIR ? resolve(root, process.env.CARGO_TARGET_DIR) : join(root, "target");

/** The binary under test. */
export const binary = process.env.MESHFRONT_BIN ?? join(target, "release", process.platform === "win32" ? "meshfront.exe" : "meshfront");
/** Pictures that a person should look at. */
export const screenshots = join(target, "screenshots");
/** Models that the tests look at, made by the binary. */
export const models = join(target, "e2e");
/** A bumpy surface as a scanner sees it: 120,000 triangles. */
export const model = join(models, "scan.front");
/** The same in small, for pictures that are drawn in software by the dozen: 20,000 triangles. */
export const small = join(models, "small.front");

/** A made-up terrain: 513 × 513 heights. */
export const terrain = join(models, "terrain.front");

/** `meshfront view FILE` on a free port. */
export interface Server {
  url: string;
  stop(): void;
}

export async function view(file: string, ...args: string[]): Promise<Server> {
  const server: ChildProcess = spawn(binary, ["view", file, "--no-open", "--port", "0", ...args]);
  let said = "";
  const url = await new Promise<string>((found, failed) => {
    server.stdout!.on("data", (text) => {
      said += text;
      const address = /http:\/\/\S+/.exec(said);
      if (address) found(address[0]);
    });
    server.stderr!.on("data", (text) => { said += text; });
    server.on("error", failed);
    server.on("exit", (code) => failed(new Error(`meshfront view ended with ${code}: ${said}`)));
  });
  return { url, stop: () => void server.kill() };
}

export function prepareFolders(): void {
  if (!existsSync(binary)) throw new Error(`${binary} is missing: run \`cargo xtask web\`, then \`cargo build --release\``);
  for (const folder of [screenshots, models]) mkdirSync(folder, { recursive: true });
}
