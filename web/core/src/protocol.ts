import type { ErrorKind } from "./errors.js";
import type { FlyByReport, FrameUpdate, ModelInfo, View } from "./view.js";

/** Page → worker. One `open` comes first; every `adapt` and `fly-by` is answered once, in order. */
export type Request =
  | { type: "open"; source: string | ArrayBuffer; name: string }
  | { type: "adapt"; view: View }
  | { type: "fly-by" };

/** Worker → page. */
export type Reply =
  | { type: "progress"; loaded: number; total: number | undefined }
  | { type: "opened"; info: ModelInfo }
  | { type: "adapted"; frame: FrameUpdate }
  | { type: "flown"; report: FlyByReport }
  | { type: "failed"; kind: ErrorKind; message: string };

/** One end of the line: a `Worker`, the global scope inside of one, or a `MessagePort`. */
export interface Port<Out, In> {
  postMessage(message: Out, transfer: Transferable[]): void;
  onmessage: ((event: MessageEvent<In>) => void) | null;
}
