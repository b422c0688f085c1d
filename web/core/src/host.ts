/** The worker's side of the line: it owns the engine, and answers one request after the other. */

import { MeshfrontError } from "./errors.js";
import { fetchBytes } from "./fetch.js";
import type { Port, Reply, Request } from "./protocol.js";
import type { FlyByReport, FrameUpdate, ModelInfo, View } from "./view.js";

/** One opened model with one front. */
export interface Engine {
  readonly info: ModelInfo;
  adapt(view: View): FrameUpdate;
  flyBy(): FlyByReport;
}

/** Reads a `.front` file, `name` being what messages call it; throws what `MeshfrontError.from` understands. */
export type LoadEngine = (bytes: Uint8Array, name: string) => Promise<Engine>;

/** Answers the requests that arrive on `port`, for ever. */
export function serve(port: Port<Reply, Request>, load: LoadEngine, fetcher: typeof fetch = fetch): void {
  let engine: Engine | undefined;
  // Fetching is asynchronous: the queue keeps the answers in the order of the requests.
  let queue = Promise.resolve();
  const reply = (message: Reply, transfer: Transferable[] = []) => port.postMessage(message, transfer);

  async function answer(request: Request): Promise<void> {
    switch (request.type) {
      case "open": {
        const { source } = request;
        const progress = (loaded: number, total: number | undefined) => reply({ type: "progress", loaded, total });
        const bytes = typeof source === "string" ? await fetchBytes(source, progress, fetcher) : new Uint8Array(source);
        engine = await load(bytes, request.name);
        reply({ type: "opened", info: engine.info });
        return;
      }
      case "adapt": {
        const frame = opened(engine).adapt(request.view);
        reply({ type: "adapted", frame }, buffersOf(frame));
        return;
      }
      case "fly-by":
        reply({ type: "flown", report: opened(engine).flyBy() });
    }
  }

  port.onmessage = ({ data: request }) => {
    queue = queue.then(() => answer(request)).catch((thrown: unknown) => {
      const { kind, message } = MeshfrontError.from(thrown);
      reply({ type: "failed", kind, message });
    });
  };
}

function opened(engine: Engine | undefined): Engine {
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
