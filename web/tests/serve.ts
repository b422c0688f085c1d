/** A web server for a folder, on a free port of this machine. */

import { createReadStream, existsSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";

const TYPES: Record<string, string> = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript",
  ".mjs": "text/javascript",
  ".css": "text/css",
  ".json": "application/json",
  ".wasm": "application/wasm",
  ".svg": "image/svg+xml",
  ".png": "image/png",
  ".front": "application/octet-stream",
};

const ISOLATION = [["Cross-Origin-Opener-Policy", "same-origin"], ["Cross-Origin-Embedder-Policy", "require-corp"]] as const;

export interface FolderServer {
  /** With a slash at the end. */
  url: string;
  stop(): void;
}

/**
 * Serves what lies in the folder, and nothing above it; to pages of other origins too where `shared` says so. Where it does not, workers have
 * a fine clock, as they have with `meshfront view`.
 */
export async function serveFolder(folder: string, shared = false): Promise<FolderServer> {
  const server = createServer((request, response) => {
    const path = decodeURIComponent(new URL(request.url!, "http://localhost").pathname);
    let file = join(folder, normalize(path));
    if (existsSync(file) && statSync(file).isDirectory()) file = join(file, "index.html");
    if (shared) response.setHeader("Access-Control-Allow-Origin", "*");
    else for (const [name, value] of ISOLATION) response.setHeader(name, value);
    if (path === "/favicon.ico") {
      response.writeHead(204).end();
    } else if (!file.startsWith(folder) || !existsSync(file)) {
      response.writeHead(404).end();
    } else {
      response.setHeader("Content-Type", TYPES[extname(file)] ?? "application/octet-stream");
      response.setHeader("Content-Length", statSync(file).size);
      createReadStream(file).pipe(response);
    }
  });
  await new Promise<void>((ready) => server.listen(0, "127.0.0.1", ready));
  const address = server.address();
  if (typeof address !== "object" || address === null) throw new Error("the server has no port");
  return {
    url: `http://127.0.0.1:${address.port}/`,
    stop: () => {
      server.closeAllConnections();
      server.close();
    },
  };
}
