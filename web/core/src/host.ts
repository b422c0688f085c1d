/** The worker's side of the line: it owns the engine, and answers what the page asks. */

import { MeshfrontError } from "./errors.js";
import { fetchBytes } from "./fetch.js";
import type { Answer, ModelView, Port, Reply, Request } from "./protocol.js";
import type { FlyByReport, FrameUpdate, Limits, ModelInfo } from "./view.js";

/** Opened models with one front each. Throws what `MeshfrontError.from` understands. */
export interface Engine {
  /** Reads a `.front` file, `name` being what messages call it. */
  open(bytes: Uint8Array, name: string): { model: number; info: ModelInfo };
  adapt(views: ModelView[], limits: Limits): FrameUpdate[];
  flyBy(model: number): FlyByReport;
  close(model: number): void;
}

/** Answers the requests that arrive on `port`, for ever. The engine is started with the first of them. */
export function serve(port: Port<Reply, Request>, start: () => Promise<Engine>, fetcher: typeof fetch = fetch): void {
  let engine: Promise<Engine> | undefined;

  async function answer(request: Request): Promise<[Answer, Transferable[]]> {
    const { id } = request;
    switch (request.type) {
      case "open": {
        const { source, name } = request;
        const progress = (loaded: number, total: number | undefined) =>
          port.postMessage({ id, type: "progress", loaded, total }, []);
        const fetched = typeof source === "string" ? fetchBytes(source, progress, fetcher) : new Uint8Array(source);
        // WebAssembly is compiled while the file arrives.
        const [started, bytes] = await Promise.all([(engine ??= start()), fetched]);
        return [{ type: "opened", ...started.open(bytes, name) }, []];
      }
      case "adapt": {
        const frames = (await opened(engine)).adapt(request.views, request.limits);
        return [{ type: "adapted", frames }, frames.flatMap(buffersOf)];
      }
      case "fly-by":
        return [{ type: "flown", report: (await opened(engine)).flyBy(request.model) }, []];
      case "close":
        (await opened(engine)).close(request.model);
        return [{ type: "closed" }, []];
    }
  }

  port.onmessage = ({ data: request }) => {
    const { id } = request;
    answer(request).then(
      ([reply, transfer]) => port.postMessage({ id, ...reply }, transfer),
      (thrown: unknown) => {
        const { kind, message } = MeshfrontError.from(thrown);
        port.postMessage({ id, type: "failed", kind, message }, []);
      },
    );
  };
}

function opened(engine: Promise<Engine> | undefined): Promise<Engine> {
  if (!engine) throw new MeshfrontError("engine", "no model is open");
  return engine;
}

/** The columns are handed over, not copied. */
function buffersOf({ vertices, triangles }: FrameUpdate): ArrayBuffer[] {
  return [
    vertices.ranges, vertices.positions, vertices.normals, vertices.colors, vertices.levels,
    triangles.ranges, triangles.corners,
  ].map((column) => column.buffer as ArrayBuffer);
}
