import { MeshfrontError } from "./errors.js";
import type { Answer, ModelView, Notice, Port, Question, Reply, Request } from "./protocol.js";
import type { BaseMesh, FlyByReport, FrameUpdate, Inspection, Limits, ModelInfo, OpenProgress } from "./view.js";

/** The page's end of the line to a worker. */
export interface WorkerPort extends Port<Request, Reply> {
  onerror?: ((event: ErrorEvent) => void) | null;
  terminate?(): void;
}

/** How to open a model. */
export interface OpenOptions {
  /** What messages call the file; by default the last part of its address. */
  name?: string;
  /** Told while the file arrives and is checked. */
  onProgress?: (progress: OpenProgress) => void;
  /** Given the base mesh, of a terrain its coarsest heights, as soon as that is there, once, before the model is open. */
  onBase?: (base: BaseMesh) => void;
  /** Gives up: `open` rejects with kind `closed`. */
  signal?: AbortSignal;
}

/** An opened model with one front. */
export interface ClientModel {
  /** What `adapt` calls it. */
  readonly model: number;
  /** Numbers of it. */
  readonly info: ModelInfo;
}

interface Waiting {
  group: number;
  resolve(answer: Answer): void;
  reject(error: MeshfrontError): void;
  onNotice: ((notice: Notice) => void) | undefined;
}

interface Pending {
  views: ModelView[];
  limits: Limits;
  resolve(frames: FrameUpdate[] | undefined): void;
  reject(error: MeshfrontError): void;
}

/**
 * Models in a worker that share a triangle budget and a deadline. The worker may have more of them, for other clients, whose limits are
 * their own: `new MeshfrontClient(another)`.
 *
 * At most one `adapt` is on its way at a time. Those that come meanwhile wait, and only the last of them is asked for:
 * the worker never works off a queue of views that nobody looks from any more.
 */
export class MeshfrontClient {
  private readonly line: Line;
  private readonly group: number;
  private busy = false;
  private pending: Pending | undefined;

  /** @param worker starts it, by default the one of this package; or another client, whose worker is used */
  constructor(worker: (() => WorkerPort) | MeshfrontClient = startWorker) {
    this.line = worker instanceof MeshfrontClient ? worker.line : new Line(worker());
    this.group = this.line.join();
  }

  /**
   * Opens a `.front` file: an address (relative ones belong to the page), or its bytes, which are handed over to the
   * worker (the buffer is empty afterwards).
   *
   * @throws MeshfrontError of every kind
   */
  async open(source: string | URL | ArrayBuffer, options: OpenOptions = {}): Promise<ClientModel> {
    const { onProgress, onBase, signal } = options;
    if (signal?.aborted) throw closed();
    const name = options.name ?? (source instanceof ArrayBuffer ? "the file" : String(source).split("/").pop()!);
    const onNotice = (notice: Notice) => {
      if (signal?.aborted) return;
      if (notice.type === "base") onBase?.(notice.base);
      else onProgress?.(notice.progress);
    };
    const answer =
      source instanceof ArrayBuffer
        ? this.ask({ type: "open", source, name }, [source], onNotice)
        : this.ask({ type: "open", source: new URL(source, document.baseURI).href, name }, [], onNotice);
    const opened = answer.then((answer) => expected(answer, "opened"));
    if (!signal) return opened;
    return new Promise((resolve, reject) => {
      signal.addEventListener("abort", () => reject(closed()), { once: true });
      opened.then((model) => {
        // Nobody waits for it any more.
        if (signal.aborted) this.close(model.model);
        else resolve(model);
      }, reject);
    });
  }

  /**
   * Adapts fronts to views, within limits that hold for all models together: what is worst in any of them comes first. Models without a view
   * stay as they are. Resolves with what changed, in the order of the views, or with `undefined` where a later
   * call overtook this one. As long as `stats.settled` is false, ask again.
   *
   * Every update must be applied, in order: each holds only what changed since the one before.
   *
   * @throws MeshfrontError of kind `closed` or `engine`
   */
  adapt(views: ModelView[], limits: Limits): Promise<FrameUpdate[] | undefined> {
    return new Promise((resolve, reject) => {
      this.pending?.resolve(undefined);
      this.pending = { views, limits, resolve, reject };
      if (!this.busy) void this.next();
    });
  }

  /**
   * What is drawn in a triangle slot, as of an update (`FrameUpdate.frame`) of a model; `undefined` where the front has changed since, or
   * the slot is free.
   */
  async inspect(model: number, frame: number, triangle: number): Promise<Inspection | undefined> {
    return expected(await this.ask({ type: "inspect", model, frame, triangle }), "inspected").inspection;
  }

  /**
   * Spheres of the updates that would come next, worst first as seen from the last view, at most `most`: centre and radius, four
   * numbers each, mesh space. Looks at the whole front.
   */
  async spheres(model: number, most: number): Promise<Float32Array> {
    return expected(await this.ask({ type: "spheres", model, most }), "spheres").spheres;
  }

  /** Another front of a model that this client or another of the same worker has open, at the base mesh. They share the hierarchy. */
  async duplicate(model: number): Promise<ClientModel> {
    return expected(await this.ask({ type: "duplicate", model }), "opened");
  }

  /**
   * Memory of the engine as a whole, bytes: hierarchies, fronts of all clients, and what was freed, or asked for and not used: that
   * is used again, but WebAssembly keeps it as long as the worker lives.
   */
  async memory(): Promise<number> {
    return expected(await this.ask({ type: "memory" }), "memory").bytes;
  }

  /** Flies once around a model inside the worker; its front starts and ends as it was. Takes seconds. */
  async flyBy(model: number): Promise<FlyByReport> {
    return expected(await this.ask({ type: "fly-by", model }), "flown").report;
  }

  /** Forgets a model. */
  close(model: number): void {
    this.ask({ type: "close", model }).catch(() => {});
  }

  /** Whether the other client's models are in the same worker. */
  isBeside(other: MeshfrontClient): boolean {
    return this.line === other.line;
  }

  /** Forgets all models; the client that started the worker ends it. What is on its way is rejected with kind `closed`. */
  dispose(): void {
    this.line.leave(this.group);
  }

  private ask(question: Question, transfer?: Transferable[], onNotice?: (notice: Notice) => void): Promise<Answer> {
    return this.line.ask(this.group, question, transfer, onNotice);
  }

  private async next(): Promise<void> {
    for (let job = this.pending; job; job = this.pending) {
      this.pending = undefined;
      this.busy = true;
      try {
        const answer = await this.ask({ type: "adapt", views: job.views, limits: job.limits });
        this.busy = false;
        job.resolve(expected(answer, "adapted").frames);
      } catch (thrown) {
        this.busy = false;
        job.reject(MeshfrontError.from(thrown));
      }
    }
  }
}

/** Requests and answers, paired by their numbers. */
class Line {
  private readonly waiting = new Map<number, Waiting>();
  private asked = 0;
  private readonly groups = new Set<number>();
  private joined = 0;
  private closed: MeshfrontError | undefined;

  constructor(private readonly worker: WorkerPort) {
    worker.onmessage = ({ data: reply }) => {
      const waiting = this.waiting.get(reply.id);
      if (reply.type === "progress" || reply.type === "base") {
        waiting?.onNotice?.(reply);
        return;
      }
      this.waiting.delete(reply.id);
      if (reply.type === "failed") waiting?.reject(new MeshfrontError(reply.kind, reply.message));
      else waiting?.resolve(reply);
    };
    worker.onerror = (event) => this.close(new MeshfrontError("engine", event.message || "the worker did not start"));
  }

  /** A number for a client; the first one has 0. */
  join(): number {
    this.groups.add(this.joined);
    return this.joined++;
  }

  /** Without the first client the line is closed. */
  leave(group: number): void {
    if (group === 0) return this.close();
    if (!this.groups.has(group)) return;
    this.ask(group, { type: "leave" }).catch(() => {});
    this.groups.delete(group);
    for (const [id, waiting] of this.waiting) {
      if (waiting.group !== group) continue;
      this.waiting.delete(id);
      waiting.reject(closed());
    }
  }

  ask(group: number, question: Question, transfer: Transferable[] = [], onNotice?: (notice: Notice) => void): Promise<Answer> {
    if (this.closed) return Promise.reject(this.closed);
    if (!this.groups.has(group)) return Promise.reject(closed());
    const id = this.asked++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { group, resolve, reject, onNotice });
      this.worker.postMessage({ id, group, ...question }, transfer);
    });
  }

  private close(why = closed()): void {
    if (this.closed) return;
    this.closed = why;
    this.worker.onmessage = null;
    this.worker.terminate?.();
    for (const { reject } of this.waiting.values()) reject(why);
    this.waiting.clear();
  }
}

function closed(): MeshfrontError {
  return new MeshfrontError("closed", "the model was closed");
}

function expected<T extends Answer["type"]>(answer: Answer, type: T): Extract<Answer, { type: T }> {
  if (answer.type === type) return answer as Extract<Answer, { type: T }>;
  throw new MeshfrontError("engine", `the worker answered with an unexpected "${answer.type}"`);
}

function startWorker(): WorkerPort {
  const { protocol, origin } = new URL(import.meta.url);
  // Some bundlers write the place on the disk here, and the right one where the worker is started.
  if (protocol.startsWith("http") && origin !== location.origin) return startFromElsewhere();
  return new Worker(new URL("./worker.js", import.meta.url), { type: "module", name: "meshfront" });
}

/** A worker may not come from another origin, a server for packages say; but one of this origin may import from there. */
function startFromElsewhere(): WorkerPort {
  const Worker = function (address: URL, options: WorkerOptions) {
    const script = new Blob([`import ${JSON.stringify(address.href)};`], { type: "text/javascript" });
    return new globalThis.Worker(URL.createObjectURL(script), options);
  } as unknown as new (address: URL, options: WorkerOptions) => Worker;
  // The same words as above: bundlers look for them, and put the worker where they say.
  return new Worker(new URL("./worker.js", import.meta.url), { type: "module", name: "meshfront" });
}
