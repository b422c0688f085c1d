/** How far the models are: one bar for all of them, that only grows, and is full when everything is there. */

import { element } from "./dom.js";
import { bytes, percent, texts, worded, type Texts } from "./texts/index.js";

export interface Loading {
  /** So many models are about to arrive. */
  begin(models: number): void;
  /** How far one of them is. */
  progress(model: number, name: string, progress: { loaded: number; total: number | undefined; fraction: number | undefined }): void;
  /** How far the local program is with a mesh; `phase` is its own word. */
  building(name: string, phase: string, fraction: number | undefined): void;
  /** All is there: full, and gone. */
  end(): void;
}

/** Without a word on how long checking takes, the transfer is this part of the work. */
const TRANSFER = 0.8;

export function makeLoading(): Loading {
  const bar = element<HTMLProgressElement>("loading-bar");
  let parts: number[] = [];
  let line = (t: Texts) => t.loading.start;
  const write = () => { element("loading-text").textContent = line(texts()); };
  worded(write);

  /** Until it is done it is not done: rounding does not make it so. */
  function show(part: number | undefined): void {
    if (part === undefined) bar.removeAttribute("value");
    else bar.value = Math.max(bar.hasAttribute("value") ? bar.value : 0, Math.min(part, 0.99));
  }

  return {
    begin(models) {
      parts = Array.from({ length: models }, () => 0);
      bar.removeAttribute("value");
      line = (t) => t.loading.start;
      write();
      element("loading").hidden = false;
    },
    progress(model, name, { loaded, total, fraction }) {
      const part = fraction ?? (total === undefined ? undefined : (TRANSFER * loaded) / total);
      parts[model] = Math.max(parts[model] ?? 0, part ?? 0);
      const all = parts.reduce((sum, part) => sum + part, 0) / parts.length;
      show(part === undefined && parts.length === 1 ? undefined : all);
      line = (t) => t.loading.fetching(name, part === undefined ? bytes(loaded) : percent(Math.min(part, 0.99)));
      write();
    },
    building(name, phase, fraction) {
      element("loading").hidden = false;
      // Every phase has a bar of its own: nobody knows how long the next will take.
      bar.removeAttribute("value");
      show(fraction);
      line = (t) => t.loading.building(name, `${t.loading.phases[phase] ?? phase}${fraction === undefined ? "" : ` ${percent(fraction)}`}`);
      write();
    },
    end() {
      bar.value = 1;
      element("loading").hidden = true;
    },
  };
}
