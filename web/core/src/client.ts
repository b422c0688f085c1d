import { MeshfrontError } from "./errors.js";
import type { Progress } from "./fetch.js";
import type { Port, Reply, Request } from "./protocol.js";
import type { FlyByReport, FrameUpdate, ModelInfo, View } from "./view.js";

/** The page's end of the line to a worker. */
export interface WorkerPort extends Port<Request, Reply> {
  onerror?: ((event: ErrorEvent) => void) | null;
  terminate?(): void;
}

/** How to open a model. */
export interface OpenOptions {
  /** What messages call the file; by default the last part of its address. */
  name?: string;
  /** Told while the file arrives. */
  onProgress?: Progress;
  /** Gives up: `open` rejects with kind `closed`. */
  signal?: AbortSignal;
  /** Starts the worker; by default the one of this package. */
  startWorker?: () => WorkerPort;
}

interface Waiting {
  resolve(reply: Reply): void;
  reject(error: MeshfrontError): void;
}

interface PendingView {
  view: View;
  resolve(frame: FrameUpdate | undefined): void;
  reject(error: MeshfrontError): void;
}

/**
 * One model and one front, in a worker of its own.
 *
 * At most one view is on its way at a time. Views that come meanwhile wait, and only the last of them is asked for:
 * the worker never works off a queue of views that nobody looks from any more.
 */
export class MeshfrontClient {
  /** Numbers of the model. */
  readonly info: ModelInfo;
  private readonly line: Line;
  private busy = false;
  private pending: PendingView | undefined;

  private constructor(line: Line, info: ModelInfo) {
    this.line = line;
    this.info = info;
  }

  /**
   * Opens a `.front` file: an address (relative ones belong to the page), or its bytes, which are handed over to the
   * worker (the buffer is empty afterwards).
   *
   * @throws MeshfrontError of every kind
   */
  static async open(source: string | URL | ArrayBuffer, options: OpenOptions = {}): Promise<MeshfrontClient> {
    const line = new Line((options.startWorker ?? startWorker)(), options.onProgress);
    const giveUp = () => line.close();
    if (options.signal?.aborted) giveUp();
    options.signal?.addEventListener("abort", giveUp, { once: true });
    try {
      const name = options.name ?? (source instanceof ArrayBuffer ? "the file" : String(source).split("/").pop()!);
      const reply =
        source instanceof ArrayBuffer
          ? await line.ask({ type: "open", source, name }, [source])
          : await line.ask({ type: "open", source: new URL(source, document.baseURI).href, name });
      if (reply.type !== "opened") throw unexpected(reply);
      return new MeshfrontClient(line, reply.info);
    } catch (thrown) {
      line.close();
      throw MeshfrontError.from(thrown);
    } finally {
      options.signal?.removeEventListener("abort", giveUp);
    }
  }

  /**
   * Adapts the front to a view, within its deadline. Resolves with what changed, or with `undefined` where a later
   * call overtook this one. As long as `stats.settled` is false, ask again.
   *
   * Every update must be applied, in order: each holds only what changed since the one before.
   *
   * @throws MeshfrontError of kind `closed` or `engine`
   */
  adapt(view: View): Promise<FrameUpdate | undefined> {
    return new Promise((resolve, reject) => {
      this.pending?.resolve(undefined);
      this.pending = { view, resolve, reject };
      if (!this.busy) void this.next();
    });
  }

  /** Flies once around the model inside the worker; the front starts and ends as it was. Takes seconds. */
  async flyBy(): Promise<FlyByReport> {
    const reply = await this.line.ask({ type: "fly-by" });
    if (reply.type !== "flown") throw unexpected(reply);
    return reply.report;
  }

  /** Ends the worker. What is on its way is rejected with kind `closed`. */
  dispose(): void {
    this.line.close();
  }

  private async next(): Promise<void> {
    for (let job = this.pending; job; job = this.pending) {
      this.pending = undefined;
      this.busy = true;
      try {
        const reply = await this.line.ask({ type: "adapt", view: job.view });
        if (reply.type !== "adapted") throw unexpected(reply);
        this.busy = false;
        job.resolve(reply.frame);
      } catch (thrown) {
        this.busy = false;
        job.reject(MeshfrontError.from(thrown));
      }
    }
  }
}

/** Requests and replies, paired by their order. */
class Line {
  private readonly waiting: Waiting[] = [];
  private closed: MeshfrontError | undefined;

  constructor(private readonly worker: WorkerPort, onProgress: Progress | undefined) {
    worker.onmessage = ({ data: reply }) => {
      if (reply.type === "progress") onProgress?.(reply.loaded, reply.total);
      else if (reply.type === "failed") this.waiting.shift()?.reject(new MeshfrontError(reply.kind, reply.message));
      else this.waiting.shift()?.resolve(reply);
    };
    worker.onerror = (event) => this.close(new MeshfrontError("engine", event.message || "the worker did not start"));
  }

  ask(request: Request, transfer: Transferable[] = []): Promise<Reply> {
    if (this.closed) return Promise.reject(this.closed);
    return new Promise((resolve, reject) => {
      this.waiting.push({ resolve, reject });
      this.worker.postMessage(request, transfer);
    });
  }

  close(why = new MeshfrontError("closed", "the model was closed")): void {
    if (this.closed) return;
    this.closed = why;
    this.worker.onmessage = null;
    this.worker.terminate?.();
    for (const { reject } of this.waiting.splice(0)) reject(why);
  }
}

function unexpected(reply: Reply): MeshfrontError {
  return new MeshfrontError("engine", `the worker answered with an unexpected "${reply.type}"`);
}

function startWorker(): WorkerPort {
  return new Worker(new URL("./worker.js", import.meta.url), { type: "module", name: "meshfront" });
}
