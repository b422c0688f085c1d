/** The buttons beside the picture, and the list of keys. */

import { attribute, label, texts, worded } from "./texts/index.js";
import { element, icon, make } from "./dom.js";
import { SIDES, type Side } from "./navigation.js";
import type { Settings } from "./settings.js";

/** What can be done with a button or a key. */
export interface Actions {
  fit(): void;
  home(): void;
  look(side: Side): void;
  compare(): void;
  shot(): void;
  link(): void;
  tell(): void;
  keys(): void;
  open(): void;
}

const ICONS = {
  fit: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5M9 9h6v6H9z",
  home: "M4 11l8-7 8 7M6 10v10h12V10",
  fly: "M21 3L3 11l7 3 3 7zM10 14l4-4",
  measure: "M3 16L16 3l5 5L8 21zM7 12l2 2M10 9l2 2M13 6l2 2",
  crosshair: "M12 3v6M12 15v6M3 12h6M15 12h6",
  compare: "M12 3v18M4 6h5v12H4M15 6h5v12h-5",
  shot: "M4 8h4l2-3h4l2 3h4v11H4zM12 10a3 3 0 1 0 0 6 3 3 0 0 0 0-6z",
  link: "M10 14a4 4 0 0 0 6 0l3-3a4 4 0 0 0-6-6l-1 1M14 10a4 4 0 0 0-6 0l-3 3a4 4 0 0 0 6 6l1-1",
  tell: "M4 5h16v11h-9l-4 4v-4H4zM8 9h8M8 12h5",
  open: "M3 6h6l2 2h10v11H3zM12 11v5M9.500 13.500L12 11l2.500 2.500",
  keys: "M9 9a3 3 0 1 1 4 3c-1 .5-1 1-1 2M12 18v.5",
} as const;

export function makeToolbar(settings: Settings, actions: Actions): void {
  const bar = attribute(element("tools"), "aria-label", (t) => t.tools.name);
  const button = (name: keyof typeof ICONS, act: () => void) => {
    const made = make("button", { type: "button", id: `tool-${name}` });
    made.append(icon(ICONS[name]));
    worded(({ tools }) => {
      made.setAttribute("aria-label", tools[name]);
      made.title = tools[name];
    });
    made.addEventListener("click", act);
    return made;
  };
  const toggle = (name: "fly" | "measure" | "crosshair", key: "flying" | "measuring" | "crosshair") => {
    const made = button(name, () => settings.toggle(key));
    settings.follow(key, (on) => made.setAttribute("aria-pressed", String(on)));
    return made;
  };
  const sides = attribute(make("select", { id: "sides" }), "aria-label", (t) => t.tools.sides);
  sides.append(label(make("option", { value: "" }), (t) => t.tools.sides));
  for (const side of SIDES) sides.append(label(make("option", { value: side }), (t) => t.sides[side]));
  sides.addEventListener("change", () => {
    if (sides.value) actions.look(sides.value as Side);
    // The picture may be turned on from there: then it is no side any more.
    sides.value = "";
  });
  const compare = button("compare", actions.compare);
  settings.follow("divider", (at) => compare.setAttribute("aria-pressed", String(at !== undefined)));
  bar.append(
    button("fit", actions.fit), button("home", actions.home), sides, toggle("fly", "flying"), toggle("measure", "measuring"),
    toggle("crosshair", "crosshair"), compare, button("shot", actions.shot), button("link", actions.link),
    button("tell", actions.tell), button("open", actions.open), button("keys", actions.keys),
  );
}

/** Opens the list of keys; Escape closes it, as any dialog. */
export function showKeys(): void {
  const { keys } = texts();
  const list = make("dl", {}, ...keys.list.map(([key, what]) => make("div", {}, make("dt", {}, make("kbd", {}, key)), make("dd", {}, what))));
  const close = make("button", { type: "button" }, keys.close);
  const dialog = make("dialog", { id: "keys", "aria-labelledby": "keys-title" },
    make("h2", { id: "keys-title" }, keys.title), make("p", {}, keys.where), list, close);
  const before = document.activeElement;
  close.addEventListener("click", () => dialog.close());
  dialog.addEventListener("close", () => {
    dialog.remove();
    if (before instanceof HTMLElement) before.focus();
  });
  document.body.append(dialog);
  dialog.showModal();
}

/** Keys of the picture: only while it has the focus, so that no key is taken from anybody else. */
export function listenToKeys(canvas: HTMLElement, settings: Settings, actions: Actions, moves: (event: KeyboardEvent) => boolean): void {
  const meanings: Record<string, () => void> = {
    f: actions.fit,
    h: actions.home,
    Home: actions.home,
    g: () => settings.toggle("flying"),
    x: () => settings.toggle("crosshair"),
    m: () => settings.toggle("measuring"),
    c: actions.compare,
    z: () => settings.toggle("frozen"),
    p: actions.shot,
    l: actions.link,
    t: actions.tell,
    o: actions.open,
    "?": actions.keys,
  };
  SIDES.forEach((side, i) => { meanings[String(i + 1)] = () => actions.look(side); });
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const meaning = meanings[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    // Flying has letters of its own.
    if (moves(event)) event.preventDefault();
    else if (meaning) {
      event.preventDefault();
      if (!event.repeat) meaning();
    }
  });
}
