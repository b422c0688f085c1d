/**
 * Why a model could not be opened.
 *
 * - `missing`: the server has no such file;
 * - `network`: no answer, or the connection broke;
 * - `refused`: the server answered with another error;
 * - `not-front`: the bytes are something else than a `.front` file;
 * - `damaged`: a `.front` file whose content does not hold together;
 * - `too-new`: written by a later version;
 * - `memory`: the browser does not give as much memory as the model needs;
 * - `engine`: the engine could not start or broke down (WebAssembly switched off, a fault in it);
 * - `closed`: the client was disposed of meanwhile.
 */
export type ErrorKind =
  | "missing" | "network" | "refused" | "not-front" | "damaged" | "too-new" | "memory" | "engine" | "closed";

const KINDS: readonly string[] = [
  "missing", "network", "refused", "not-front", "damaged", "too-new", "memory", "engine", "closed",
];

const REMEDIES: Record<ErrorKind, string> = {
  missing: "Check the address, or build the file with `meshfront build`.",
  network: "Check that the server is still running, then reload the page.",
  refused: "Check what the server's log says of this file.",
  "not-front": "Build a .front file from the mesh with `meshfront build`, and open that.",
  damaged: "Copy or download the file again, or rebuild it from its source with `meshfront build`.",
  "too-new": "Update Meshfront, or rebuild the file with this version.",
  memory: "Close other pages, or build the file again from a smaller mesh.",
  engine: "Reload the page; if that does not help, try a browser with WebAssembly.",
  closed: "",
};

/** A model that could not be opened, or an engine that broke down: what happened, and what to do about it. */
export class MeshfrontError extends Error {
  readonly kind: ErrorKind;
  /** One sentence: what a person can do. Empty where there is nothing to do. */
  readonly remedy: string;

  constructor(kind: ErrorKind, message: string, options?: ErrorOptions) {
    super(message, options);
    this.name = "MeshfrontError";
    this.kind = kind;
    this.remedy = REMEDIES[kind];
  }

  /** Any thrown value as a `MeshfrontError`; the reader in the engine says the kind in the error's `name`. */
  static from(thrown: unknown, otherwise: ErrorKind = "engine"): MeshfrontError {
    if (thrown instanceof MeshfrontError) return thrown;
    const error = thrown instanceof Error ? thrown : new Error(String(thrown));
    const kind = KINDS.includes(error.name) ? (error.name as ErrorKind) : otherwise;
    return new MeshfrontError(kind, error.message, { cause: thrown });
  }
}
