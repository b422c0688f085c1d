/** Files that a person drops on the page, or chooses: opened here, or built by the local program first. */

import { isModel, type ModelCard } from "./card.js";
import { element, make } from "./dom.js";
import { label, texts } from "./texts/index.js";

/** Meshes and heights that the local program builds hierarchies from. A PNG may be heights too, but is a picture mostly. */
const SOURCES = /\.((ply|obj|stl|off|gltf|glb|dem|asc)(\.gz)?|tiff?)$/i;

/** Why a file was not opened. */
export type Refusal = { name: string; why: "unknown" | "no-build" | "broken" } | { name: string; why: "not-built"; what: string; remedy: string };

export interface DropOptions {
  /** Whether the server of the page builds hierarchies. */
  canBuild(): boolean;
  building(name: string, phase: string, fraction: number | undefined): void;
  open(models: ModelCard[]): void;
  refuse(refusal: Refusal): void;
}

/** Listens to drops on the window; the function that comes back lets a person choose files instead. */
export function listenToDrops(options: DropOptions): () => void {
  const overlay = element("drop");
  label(element("drop-here"), (t) => t.drop.here);
  const describe = () => { element("drop-what").textContent = options.canBuild() ? texts().drop.what : texts().drop.frontOnly; };
  const hasFiles = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;
  window.addEventListener("dragover", (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    describe();
    overlay.hidden = false;
  });
  window.addEventListener("dragleave", (event) => { if (event.relatedTarget === null) overlay.hidden = true; });
  window.addEventListener("drop", (event) => {
    overlay.hidden = true;
    if (!hasFiles(event)) return;
    event.preventDefault();
    void take([...event.dataTransfer!.files], options);
  });
  const chooser = make("input", { type: "file", id: "chooser", multiple: true, hidden: true });
  chooser.addEventListener("change", () => {
    void take([...(chooser.files ?? [])], options);
    chooser.value = "";
  });
  document.body.append(chooser);
  return () => chooser.click();
}

async function take(files: File[], options: DropOptions): Promise<void> {
  const models: ModelCard[] = [];
  for (const file of files) {
    const { name } = file;
    if (/\.front$/i.test(name)) {
      models.push({ name, url: name, file });
      continue;
    }
    if (!SOURCES.test(name)) return options.refuse({ name, why: "unknown" });
    if (!options.canBuild()) return options.refuse({ name, why: "no-build" });
    const built = await build(file, options.building);
    if ("why" in built) return options.refuse(built);
    models.push(built);
  }
  if (models.length > 0) options.open(models);
}

/** What the program says while it builds, one line each. */
interface Said {
  phase?: string;
  /** `null` where nobody knows. */
  fraction?: number | null;
  model?: unknown;
  error?: string;
  remedy?: string;
}

async function build(file: File, tell: DropOptions["building"]): Promise<ModelCard | Refusal> {
  const { name } = file;
  tell(name, "send", undefined);
  try {
    const response = await fetch(`build?name=${encodeURIComponent(name)}`, { method: "POST", headers: { "X-Meshfront": "build" }, body: file });
    if (!response.ok || !response.body) return { name, why: "broken" };
    for await (const said of lines(response.body)) {
      if (said.error !== undefined) return { name, why: "not-built", what: said.error, remedy: said.remedy ?? "" };
      if (isModel(said.model)) return said.model;
      if (said.phase !== undefined) tell(name, said.phase, said.fraction ?? undefined);
    }
  } catch {
    // Told below: a line that breaks off and a program that ended are the same to the reader.
  }
  return { name, why: "broken" };
}

async function* lines(body: ReadableStream<Uint8Array>): AsyncGenerator<Said> {
  const reader = body.pipeThrough(new TextDecoderStream() as ReadableWritablePair<string, Uint8Array>).getReader();
  let rest = "";
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    const whole = (rest + part.value).split("\n");
    rest = whole.pop()!;
    for (const line of whole) if (line.trim() !== "") yield JSON.parse(line) as Said;
  }
  if (rest.trim() !== "") yield JSON.parse(rest) as Said;
}
