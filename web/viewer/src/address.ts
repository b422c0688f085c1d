/** The address of the page: what it asks for, and how a view is written into it to be sent to somebody. */

import { COLORINGS, SURFACES, THEMES, UPS, type Values } from "./settings.js";
import { choose, LANGUAGES, type Language, UNITS, type Unit } from "./texts/index.js";

export type Point = [number, number, number];

/** What an address says. Points are in the page's space, whose y is up. */
export interface Address {
  models: string[];
  eye: Point | undefined;
  target: Point | undefined;
  /** Without it there is the picture and nothing else. */
  panel: boolean;
  values: Partial<Values>;
}

interface Parameter<T> {
  name: string;
  /** `undefined` where the text makes no sense: then it counts as not said. */
  read(text: string): T | undefined;
  write(value: T): string;
}

const numbered = (name: string, unit = 1): Parameter<number> => ({
  name,
  read: (text) => {
    const value = text.trim() === "" ? NaN : Number(text);
    return Number.isFinite(value) && value >= 0 ? value * unit : undefined;
  },
  write: (value) => String(Number((value / unit).toPrecision(4))),
});
const whole = (name: string): Parameter<number> => ({ ...numbered(name), write: (value) => String(Math.round(value)) });
const flag = (name: string): Parameter<boolean> => ({
  name,
  read: (text) => (text === "1" ? true : text === "0" ? false : undefined),
  write: (value) => (value ? "1" : "0"),
});
const oneOf = <T extends string>(name: string, choices: readonly T[]): Parameter<T> => ({
  name,
  read: (text) => choices.find((choice) => choice === text),
  write: (value) => value,
});

/** Where each setting stands. What is only about this moment (frozen, measuring) does not. */
const PARAMETERS: { [K in keyof Values]?: Parameter<Values[K]> } = {
  tolerancePx: numbered("tolerance"),
  maxTriangles: whole("budget"),
  maxBytes: numbered("memory", 1e6),
  deadlineMs: numbered("time"),
  frustum: flag("frustum"),
  orientation: flag("orientation"),
  colorBy: oneOf("color", COLORINGS),
  surface: oneOf("surface", SURFACES),
  vertexColors: flag("colors"),
  wireframe: flag("wireframe"),
  spheres: flag("spheres"),
  background: {
    name: "background",
    read: (text) => (/^(#[0-9a-f]{6}|white|grey|black|studio)$/i.test(text) ? text.toLowerCase() : undefined),
    write: (value) => value,
  },
  // A plus sign would be a space.
  up: { name: "up", read: (text) => UPS.find((up) => up === text || up === `+${text.trim()}`), write: (up) => up.replace("+", "") },
  unit: oneOf("unit", Object.keys(UNITS) as Unit[]),
  flying: flag("fly"),
  divider: { name: "compare", read: part, write: (value) => (value === undefined ? "" : value.toFixed(3)) },
  originalTriangles: whole("original"),
  theme: oneOf("theme", THEMES),
  language: oneOf("lang", Object.keys(LANGUAGES) as Language[]),
};

/** The reader's own: not for somebody else. */
const OWN: readonly (keyof Values)[] = ["theme", "language"];

function part(text: string): number | undefined {
  const value = text === "" ? NaN : Number(text);
  return value >= 0 && value <= 1 ? value : undefined;
}

export function readAddress(search: string, languages: readonly string[]): Address {
  const query = new URLSearchParams(search);
  const values: Partial<Values> = { language: choose(languages) };
  for (const [key, parameter] of entries()) {
    const text = query.get(parameter.name);
    const value = text === null ? undefined : parameter.read(text);
    if (value !== undefined) Object.assign(values, { [key]: value });
  }
  // The shorter way of saying `color=level`.
  if (query.get("levels") === "1" && !values.colorBy) values.colorBy = "level";
  return {
    models: query.getAll("model"),
    eye: point(query.get("eye")),
    target: point(query.get("target")),
    panel: query.get("panel") !== "0",
    values,
  };
}

/**
 * The query that brings this view back: what the page was asked for, and what differs from `defaults`, which is what the page
 * would be without it. `forSomebody` leaves out what is the reader's own.
 */
export function writeAddress(
  search: string, values: Values, defaults: Values, eye: Point, target: Point, forSomebody = false,
): string {
  const query = new URLSearchParams(search);
  query.delete("levels");
  for (const [key, parameter] of entries()) {
    if (values[key] === defaults[key] || (forSomebody && OWN.includes(key))) query.delete(parameter.name);
    else query.set(parameter.name, parameter.write(values[key] as never));
  }
  query.set("eye", written(eye));
  query.set("target", written(target));
  // Commas are safe there, and people read addresses.
  return `?${query.toString().replaceAll("%2C", ",")}`;
}

function entries(): [keyof Values, Parameter<unknown>][] {
  return Object.entries(PARAMETERS) as [keyof Values, Parameter<unknown>][];
}

function point(text: string | null): Point | undefined {
  const parts = (text ?? "").split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
  return parts.length === 3 && parts.every(Number.isFinite) ? (parts as Point) : undefined;
}

/** As many figures as a 32-bit number has. */
function written(point: Point): string {
  return point.map((x) => String(Number(x.toPrecision(8)))).join(",");
}
