import type { ErrorKind } from "./errors.js";
import type { FlyByReport, FrameUpdate, Limits, ModelInfo, View } from "./view.js";

/** A model of the session, by its number, and where it is looked at from. */
export interface ModelView {
  model: number;
  view: View;
}

/** What a page asks of its worker. */
export type Question =
  | { type: "open"; source: string | ArrayBuffer; name: string }
  | { type: "adapt"; views: ModelView[]; limits: Limits }
  | { type: "fly-by"; model: number }
  | { type: "close"; model: number };

/** Page → worker. Every request is answered once, under its `id`; while a file is fetched others may be answered. */
export type Request = Question & { id: number };

/** What a worker answers. `frames` are in the order of the views. */
export type Answer =
  | { type: "opened"; model: number; info: ModelInfo }
  | { type: "adapted"; frames: FrameUpdate[] }
  | { type: "flown"; report: FlyByReport }
  | { type: "closed" }
  | { type: "failed"; kind: ErrorKind; message: string };

/** Worker → page. While a file arrives, `progress` comes before the answer. */
export type Reply = (Answer | { type: "progress"; loaded: number; total: number | undefined }) & { id: number };

/** One end of the line: a `Worker`, the global scope inside of one, or a `MessagePort`. */
export interface Port<Out, In> {
  postMessage(message: Out, transfer: Transferable[]): void;
  onmessage: ((event: MessageEvent<In>) => void) | null;
}
