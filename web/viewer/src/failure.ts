/** What went wrong, and what to do about it, in words. */

import type { MeshfrontError } from "@meshfront/three";
import { element, withCode } from "./dom.js";
import type { Failed } from "./texts/en.js";
import { label, texts, type Texts, worded } from "./texts/index.js";

export interface Failure {
  /** Shows what went wrong, with the buttons that can help. */
  show(words: (t: Texts) => Failed, ways: { retry?: () => void; close?: () => void; reload?: boolean }): void;
  hide(): void;
}

export function makeFailure(): Failure {
  const box = element("failure");
  const retry = label(element<HTMLButtonElement>("retry"), (t) => t.failures.retry);
  const close = label(element<HTMLButtonElement>("close-failure"), (t) => t.failures.close);
  const reload = label(element<HTMLButtonElement>("reload"), (t) => t.failures.reload);
  reload.addEventListener("click", () => location.reload());
  let words: ((t: Texts) => Failed) | undefined;
  const write = () => {
    if (!words) return;
    const [title, what, remedy] = words(texts());
    element("failure-title").textContent = title;
    element("failure-what").textContent = what;
    element("failure-remedy").replaceChildren(...withCode(remedy));
  };
  worded(write);
  const hide = () => {
    box.hidden = true;
    words = undefined;
  };
  return {
    hide,
    show(said, ways) {
      words = said;
      write();
      retry.hidden = !ways.retry;
      close.hidden = !ways.close;
      reload.hidden = !ways.reload;
      retry.onclick = () => { hide(); ways.retry?.(); };
      close.onclick = () => { hide(); ways.close?.(); };
      box.hidden = false;
    },
  };
}

/** What an error means: the engine's own words say where in the file it is. */
export function wordsOf(error: MeshfrontError): (t: Texts) => Failed {
  return ({ failures: { kinds } }) => {
    const [title, remedy] = kinds[error.kind];
    return [title, error.message, remedy];
  };
}
