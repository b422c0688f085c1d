import type { ErrorKind } from "./errors.js";
import type {
  BaseMesh, FlyByReport, FrameUpdate, Inspection, Limits, ModelInfo, OpenProgress, Shade, View,
} from "./view.js";

/** A model of the group, by its number, where it is looked at from, and what it is to be coloured by. */
export interface ModelView {
  model: number;
  /** Of as many cameras as look at it: everywhere the finest counts. */
  views: View[];
  shade?: Shade;
}

/** What a page asks of its worker. */
export type Question =
  | { type: "open"; source: string | ArrayBuffer; name: string }
  | { type: "adapt"; views: ModelView[]; limits: Limits }
  | { type: "inspect"; model: number; frame: number; triangle: number }
  | { type: "spheres"; model: number; most: number }
  | { type: "duplicate"; model: number }
  | { type: "memory" }
  | { type: "fly-by"; model: number }
  | { type: "close"; model: number }
  | { type: "leave" };

/**
 * Page → worker. Every request is answered once, under its `id`; while a file is fetched others may be answered. Models belong to the
 * group that they were opened or duplicated in, and limits are those of a group.
 */
export type Request = Question & { id: number; group: number };

/** What a worker answers. `frames` are in the order of the views. */
export type Answer =
  | { type: "opened"; model: number; info: ModelInfo }
  | { type: "adapted"; frames: FrameUpdate[] }
  | { type: "inspected"; inspection: Inspection | undefined }
  | { type: "spheres"; spheres: Float32Array }
  | { type: "memory"; bytes: number }
  | { type: "flown"; report: FlyByReport }
  | { type: "closed" }
  | { type: "left" }
  | { type: "failed"; kind: ErrorKind; message: string };

/** Worker → page. While a model is opened, these come before the answer. */
export type Notice = { type: "progress"; progress: OpenProgress } | { type: "base"; base: BaseMesh };

/** Worker → page. */
export type Reply = (Answer | Notice) & { id: number };

/** One end of the line: a `Worker`, the global scope inside of one, or a `MessagePort`. */
export interface Port<Out, In> {
  postMessage(message: Out, transfer: Transferable[]): void;
  onmessage: ((event: MessageEvent<In>) => void) | null;
}
