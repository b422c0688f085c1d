/** The panel's controls: each writes one setting, and shows what it is, whoever changed it. */

import { defaultScale, RAMP_CSS } from "@meshfront/three";
import { BACKGROUNDS } from "./backgrounds.js";
import { element, make } from "./dom.js";
import { COLORINGS, type Settings, SURFACES, THEMES, UPS, type Values } from "./settings.js";
import {
  attribute, bytes, count, fixed, label, LANGUAGES, length, pixels, texts, type Texts, UNITS, worded,
} from "./texts/index.js";

export interface Controls {
  /** How many triangles the models have at least and at most: what the budget's slider goes from and to. */
  setRange(base: number, full: number): void;
  /** The errors that the ramp begins and ends with, units of the page. */
  setErrors(range: readonly [number, number]): void;
  /** Nothing to be painted, nothing to switch. */
  setPainted(painted: boolean): void;
}

/** The tolerance slider is logarithmic: 40 steps for a factor of ten, from 0.1 px to 316 px. */
const FINEST_PX = 0.1;
const STEPS_PER_DECADE = 40;
/** A front in the engine and on the graphics card, bytes: what the slider for memory offers. */
const [LEAST_BYTES, MOST_BYTES] = [1e6, 4e9];
const [LEAST_MS, MOST_MS] = [1, 50];

type Flag = { [K in keyof Values]: Values[K] extends boolean ? K : never }[keyof Values];
type Read = (t: Texts) => string;

export function makeControls(settings: Settings, readings: HTMLElement): Controls {
  let [base, full] = [1, 2];

  /** A slider of 0 to 100 steps (or more) that stands for a number. */
  function slider(
    key: "tolerancePx" | "maxTriangles" | "maxBytes" | "deadlineMs",
    id: string,
    name: Read,
    { steps = 100, of, at, write }: { steps?: number; of(step: number): number; at(value: number): number; write(value: number): string },
  ): { field: HTMLElement; refresh(): void } {
    const input = make("input", { type: "range", id, min: 0, max: steps, step: 1 });
    const output = make("output", { id: `${id}-value`, for: id });
    const refresh = () => {
      const value = settings.now[key];
      input.value = String(Math.min(steps, Math.max(0, Math.round(at(value)))));
      output.textContent = write(value);
      input.setAttribute("aria-valuetext", write(value));
    };
    input.addEventListener("input", () => settings.set(key, of(Number(input.value))));
    // A finger that scrolls the panel has moved the slider it began on, before the browser takes it for scrolling.
    let before = settings.now[key];
    input.addEventListener("pointerdown", () => { before = settings.now[key]; });
    input.addEventListener("pointercancel", () => settings.set(key, before));
    settings.on(key, refresh);
    worded(refresh);
    return { field: make("div", { class: "field" }, label(make("label", { for: id }), name), output, input), refresh };
  }

  function flag(key: Flag, name: Read, id: string = key): HTMLElement {
    const input = make("input", { type: "checkbox", id });
    input.addEventListener("change", () => settings.set(key, input.checked));
    settings.follow(key, (on) => { input.checked = on; });
    return make("label", { class: "switch" }, input, label(make("span"), name));
  }

  function choice<K extends keyof Values, V extends Values[K] & string>(
    key: K, id: string, name: Read, values: readonly V[], names: (t: Texts, value: V) => string,
  ): HTMLElement {
    const select = make("select", { id });
    for (const value of values) select.append(label(make("option", { value }), (t) => names(t, value)));
    select.addEventListener("change", () => settings.set(key, select.value as V));
    settings.follow(key, (value) => { select.value = value as string; });
    return make("div", { class: "field choice" }, label(make("label", { for: id }), name), select);
  }

  function section(id: string, name: Read, isOpen: boolean, ...content: HTMLElement[]): void {
    const details = make("details", { class: "section", id, open: isOpen }, label(make("summary"), name), ...content);
    element("panel").append(details);
  }

  const none = (write: (value: number) => string) => (value: number) => (value === Infinity ? texts().quality.none : write(value));
  /** From `least` to `most` by equal factors; the last step is no limit. */
  const geometric = (least: () => number, most: () => number) => ({
    of: (step: number) => (step >= 100 ? Infinity : Math.round(least() * (most() / least()) ** (step / 100))),
    at: (value: number) => (value === Infinity ? 100 : Math.min(99, (100 * Math.log(value / least())) / Math.log(most() / least()))),
  });

  const tolerance = slider("tolerancePx", "tolerance", (t) => t.quality.tolerance, {
    steps: 140,
    of: (step) => FINEST_PX * 10 ** (step / STEPS_PER_DECADE),
    at: (px) => STEPS_PER_DECADE * Math.log10(Math.max(px, FINEST_PX) / FINEST_PX),
    write: pixels,
  });
  const triangles = slider("maxTriangles", "budget", (t) => t.quality.triangles, { ...geometric(() => base, () => full), write: none(count) });
  const memory = slider("maxBytes", "memory", (t) => t.quality.bytes, { ...geometric(() => LEAST_BYTES, () => MOST_BYTES), write: none(bytes) });
  const time = slider("deadlineMs", "time", (t) => t.quality.time, {
    steps: MOST_MS - LEAST_MS,
    of: (step) => step + LEAST_MS,
    at: (ms) => ms - LEAST_MS,
    write: (ms) => `${fixed(ms, 0)} ms`,
  });
  section("quality", (t) => t.quality.name, true,
    tolerance.field, triangles.field, memory.field, time.field,
    flag("frozen", (t) => t.quality.freeze, "freeze"), flag("frustum", (t) => t.quality.frustum), flag("orientation", (t) => t.quality.orientation));

  const ramp = make("div", { class: "ramp" });
  ramp.style.background = RAMP_CSS;
  const [from, to] = [make("span"), make("span")];
  const legend = make("div", { id: "legend", class: "legend", hidden: true }, ramp, make("div", {}, from, to));
  let errors: readonly [number, number] = [0, 0];
  const explain = () => {
    const { colorBy, unit } = settings.now;
    const words = texts().look.legend;
    legend.hidden = colorBy === "none";
    if (colorBy === "none") return;
    const [least, most] = {
      error: () => words.error(length(errors[0], unit, 2), length(errors[1], unit, 2)),
      level: () => words.level(count(defaultScale("level").to)),
      age: () => words.age(count(defaultScale("age").to)),
      cone: () => words.cone(),
    }[colorBy]();
    [from.textContent, to.textContent] = [least, most];
  };
  settings.on("colorBy", explain);
  settings.on("unit", explain);
  worded(explain);

  const vertexColors = flag("vertexColors", (t) => t.look.vertexColors);
  section("look", (t) => t.look.name, false,
    choice("colorBy", "color", (t) => t.look.colorBy, COLORINGS, (t, by) => t.look.colors[by]),
    legend,
    choice("surface", "surface", (t) => t.look.surface, SURFACES, (t, surface) => t.look.surfaces[surface]),
    vertexColors,
    flag("wireframe", (t) => t.look.wireframe),
    flag("spheres", (t) => t.look.spheres),
    background());

  /** Names, and a colour of one's own. */
  function background(): HTMLElement {
    const select = make("select", { id: "background" });
    for (const name of [...BACKGROUNDS, "custom"] as const) {
      select.append(label(make("option", { value: name }), (t) => t.look.backgrounds[name]));
    }
    const own = attribute(make("input", { type: "color", id: "own-background", hidden: true }), "aria-label", (t) => t.look.backgrounds.custom);
    select.addEventListener("change", () => settings.set("background", select.value === "custom" ? own.value : select.value));
    own.addEventListener("input", () => settings.set("background", own.value));
    settings.follow("background", (value) => {
      const isOwn = value.startsWith("#");
      select.value = isOwn ? "custom" : value;
      own.hidden = !isOwn;
      if (isOwn) own.value = value;
    });
    const name = label(make("label", { for: "background" }), (t) => t.look.background);
    return make("div", { class: "field choice" }, name, make("span", {}, select, own));
  }

  section("comparison", (t) => t.compare.name, false, divider(), originalTriangles());

  function divider(): HTMLElement {
    const input = make("input", { type: "checkbox", id: "comparing" });
    input.addEventListener("change", () => settings.set("divider", input.checked ? 0.5 : undefined));
    settings.follow("divider", (at) => { input.checked = at !== undefined; });
    return make("label", { class: "switch" }, input, label(make("span"), (t) => t.compare.on));
  }

  function originalTriangles(): HTMLElement {
    const input = make("input", { type: "number", id: "original-triangles", min: 1, step: 1, inputmode: "numeric" });
    const refresh = () => { input.value = String(settings.now.originalTriangles); };
    input.addEventListener("change", () => {
      const most = Math.round(input.valueAsNumber);
      if (most >= 1) settings.set("originalTriangles", most);
      // What makes no sense is as if it were not said.
      refresh();
    });
    settings.follow("originalTriangles", refresh);
    return make("div", { class: "field choice" }, label(make("label", { for: "original-triangles" }), (t) => t.compare.most), input);
  }

  const upName = (t: Texts, up: Values["up"]) => (up === "file" ? t.navigation.asInFile : up.replace("-", "−"));
  section("axes", (t) => t.navigation.name, false,
    choice("up", "up", (t) => t.navigation.up, UPS, upName),
    choice("unit", "unit", (t) => t.navigation.unit, Object.keys(UNITS) as (keyof typeof UNITS)[], (t, unit) => t.navigation.units[unit]));

  section("measure", (t) => t.measure.name, false,
    flag("measuring", (t) => t.measure.on), flag("crosshair", (t) => t.measure.crosshair), readings);

  section("page", (t) => t.page.name, false,
    choice("language", "language", (t) => t.language, Object.keys(LANGUAGES) as (keyof typeof LANGUAGES)[], (_, language) => LANGUAGES[language]),
    choice("theme", "theme", (t) => t.tools.theme, THEMES, (t, theme) => t.page.themes[theme]));

  return {
    setRange(least, most) {
      base = Math.max(least, 1);
      full = Math.max(most, base + 1);
      triangles.refresh();
    },
    setErrors(range) {
      errors = range;
      explain();
    },
    setPainted: (painted) => { vertexColors.hidden = !painted; },
  };
}
