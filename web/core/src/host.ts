/** The worker's side of the line: it owns the engine, and answers what the page asks. */

import { MeshfrontError } from "./errors.js";
import { fetchBytes } from "./fetch.js";
import type { Answer, ModelView, Notice, Port, Reply, Request } from "./protocol.js";
import type { BaseMesh, FlyByReport, FrameUpdate, Inspection, Limits, ModelInfo } from "./view.js";

/** Opened models with one front each, in groups with limits of their own. Throws what `MeshfrontError.from` understands. */
export interface Engine {
  /** The base mesh, of a terrain its coarsest heights, once the first bytes of a file reach that far. */
  baseOf(start: Uint8Array): BaseMesh | undefined;
  /** Reads a `.front` file, `name` being what messages call it. `onProgress` is told which part of it is done. */
  open(group: number, bytes: Uint8Array, name: string, onProgress: (part: number) => void): { model: number; info: ModelInfo };
  /** Into this group, from whichever. */
  duplicate(group: number, model: number): { model: number; info: ModelInfo };
  inspect(model: number, frame: number, triangle: number): Inspection | undefined;
  spheres(model: number, most: number): Float32Array;
  memory(): number;
  /** All views are of models of this group. */
  adapt(group: number, views: ModelView[], limits: Limits): FrameUpdate[];
  flyBy(model: number): FlyByReport;
  close(model: number): void;
  /** Closes all models of a group. */
  leave(group: number): void;
}

/** Which part of the way to an open model is over when its file is there. */
const FETCHING = 0.4;

/** Answers the requests that arrive on `port`, for ever. The engine is started with the first of them. */
export function serve(port: Port<Reply, Request>, start: () => Promise<Engine>, fetcher: typeof fetch = fetch): void {
  let engine: Promise<Engine> | undefined;
  const left = new Set<number>();

  async function open(group: number, source: string | ArrayBuffer, name: string, tell: (notice: Notice) => void) {
    // WebAssembly is compiled while the file arrives.
    const starting = (engine ??= start());
    let started: Engine | undefined;
    starting.then((engine) => { started = engine; }, () => {});
    let based = false;
    let [loaded, total]: [number, number | undefined] = [0, undefined];
    const showBase = (start: () => Uint8Array | undefined) => {
      const bytes = based || !started ? undefined : start();
      const base = bytes && started!.baseOf(bytes);
      if (!base) return;
      based = true;
      tell({ type: "base", base });
    };
    const bytes = typeof source !== "string" ? new Uint8Array(source) : await fetchBytes(source, (now, of, start) => {
      [loaded, total] = [now, of];
      tell({ type: "progress", progress: { loaded, total, fraction: of === undefined ? undefined : (FETCHING * now) / of } });
      showBase(start);
    }, fetcher);
    const ready = await starting;
    started = ready;
    showBase(() => bytes);
    [loaded, total] = [bytes.length, bytes.length];
    const told = (part: number) => tell({ type: "progress", progress: { loaded, total, fraction: part } });
    told(FETCHING);
    // Nobody is there any more to close it.
    if (left.has(group)) throw new MeshfrontError("closed", "the model was closed");
    // The end is told when it is there.
    const model = ready.open(group, bytes, name, (part) => told(FETCHING + (1 - FETCHING) * Math.min(part, 0.999)));
    told(1);
    return model;
  }

  async function answer(request: Request): Promise<[Answer, Transferable[]]> {
    const { id, group } = request;
    switch (request.type) {
      case "open": {
        const tell = (notice: Notice) => port.postMessage({ id, ...notice }, noticeBuffers(notice));
        return [{ type: "opened", ...(await open(group, request.source, request.name, tell)) }, []];
      }
      case "inspect": {
        const { model, frame, triangle } = request;
        return [{ type: "inspected", inspection: (await opened(engine)).inspect(model, frame, triangle) }, []];
      }
      case "spheres": {
        const spheres = (await opened(engine)).spheres(request.model, request.most);
        return [{ type: "spheres", spheres }, [spheres.buffer as ArrayBuffer]];
      }
      case "duplicate":
        return [{ type: "opened", ...(await opened(engine)).duplicate(group, request.model) }, []];
      case "memory":
        return [{ type: "memory", bytes: engine ? (await engine).memory() : 0 }, []];
      case "adapt": {
        const frames = (await opened(engine)).adapt(group, request.views, request.limits);
        return [{ type: "adapted", frames }, frames.flatMap(buffersOf)];
      }
      case "fly-by":
        return [{ type: "flown", report: (await opened(engine)).flyBy(request.model) }, []];
      case "close":
        (await opened(engine)).close(request.model);
        return [{ type: "closed" }, []];
      case "leave":
        left.add(group);
        (await engine)?.leave(group);
        return [{ type: "left" }, []];
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
function buffersOf({ vertices, triangles, shade }: FrameUpdate): ArrayBuffer[] {
  return [
    vertices.ranges, vertices.positions, vertices.normals, vertices.colors, vertices.levels,
    triangles.ranges, triangles.corners, ...(shade ? [shade.values] : []),
  ].map((column) => column.buffer as ArrayBuffer);
}

function noticeBuffers(notice: Notice): ArrayBuffer[] {
  if (notice.type !== "base") return [];
  const { positions, normals, colors, triangles } = notice.base;
  return [positions, normals, colors, triangles].map((column) => column.buffer as ArrayBuffer);
}
