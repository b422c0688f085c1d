/** Everything that a person can set, in one place: controls write it, the rest of the page listens. */

import type { Language, Unit } from "./texts/index.js";

export const COLORINGS = ["none", "error", "level", "age", "cone"] as const;
export const SURFACES = ["lit", "matcap", "flat"] as const;
/** `file`: as each model says. */
export const UPS = ["file", "+x", "-x", "+y", "-y", "+z", "-z"] as const;
export const THEMES = ["auto", "light", "dark", "contrast"] as const;

export type Coloring = (typeof COLORINGS)[number];
export type Surface = (typeof SURFACES)[number];
export type Up = (typeof UPS)[number];
export type Theme = (typeof THEMES)[number];

export interface Values {
  /** Pixels of the picture that a drawn point may be from where the original would be drawn. */
  tolerancePx: number;
  /** Limits of all fronts together; `Infinity`: none. */
  maxTriangles: number;
  maxBytes: number;
  /** Time in the worker per update, milliseconds. */
  deadlineMs: number;
  /** Criteria: coarse outside of the picture, coarse where it faces away. */
  frustum: boolean;
  orientation: boolean;
  frozen: boolean;
  colorBy: Coloring;
  surface: Surface;
  vertexColors: boolean;
  wireframe: boolean;
  spheres: boolean;
  /** A name of `backgrounds.ts`, or `#rrggbb`. */
  background: string;
  up: Up;
  /** What one unit of the page is. */
  unit: Unit;
  flying: boolean;
  measuring: boolean;
  crosshair: boolean;
  /** Where the divider stands, part of the width; `undefined`: nothing is compared. */
  divider: number | undefined;
  /** The most triangles of all originals together that the fronts are compared with. */
  originalTriangles: number;
  theme: Theme;
  language: Language;
}

export const DEFAULTS: Values = {
  tolerancePx: 1, maxTriangles: Infinity, maxBytes: Infinity, deadlineMs: 6, frustum: true, orientation: true,
  frozen: false, colorBy: "none", surface: "lit", vertexColors: true, wireframe: false, spheres: false,
  background: "studio", up: "file", unit: "none", flying: false, measuring: false, crosshair: false, divider: undefined,
  // Browsers give buffers of so many bytes and no more.
  originalTriangles: 8e6, theme: "auto", language: "en",
};

type Listener<K extends keyof Values> = (value: Values[K]) => void;

/** Values that tell when they change. */
export class Settings {
  private readonly values: Values;
  private readonly listeners = new Map<keyof Values, Listener<any>[]>();
  private readonly always: (() => void)[] = [];

  constructor(values: Partial<Values>) {
    this.values = { ...DEFAULTS, ...values };
  }

  get now(): Readonly<Values> {
    return this.values;
  }

  set<K extends keyof Values>(key: K, value: Values[K]): void {
    if (Object.is(this.values[key], value)) return;
    this.values[key] = value;
    for (const listener of this.listeners.get(key) ?? []) listener(value);
    for (const listener of this.always) listener();
  }

  toggle(key: "frozen" | "wireframe" | "flying" | "measuring" | "crosshair"): void {
    this.set(key, !this.values[key]);
  }

  /** Calls `listener` now, and whenever the value changes. */
  follow<K extends keyof Values>(key: K, listener: Listener<K>): void {
    this.on(key, listener);
    listener(this.values[key]);
  }

  /** Calls `listener` whenever the value changes. */
  on<K extends keyof Values>(key: K, listener: Listener<K>): void {
    this.listeners.set(key, [...(this.listeners.get(key) ?? []), listener]);
  }

  /** Calls `listener` whenever anything changes. */
  onAny(listener: () => void): void {
    this.always.push(listener);
  }
}
