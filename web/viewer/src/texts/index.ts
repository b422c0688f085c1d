/** Words and numbers in the language of the reader. */

import { en, type Texts } from "./en.js";
import { pt } from "./pt.js";

export type { Texts } from "./en.js";

const ALL = { en, pt } satisfies Record<string, Texts>;

export type Language = keyof typeof ALL;

/** Each under its own name. */
export const LANGUAGES: Record<Language, string> = { en: "English", pt: "Português" };

/** What a person would say one mesh unit is. */
export const UNITS = { none: 1, mm: 1e-3, cm: 1e-2, m: 1, km: 1e3, in: 0.0254, ft: 0.3048 } as const;
export type Unit = keyof typeof UNITS;

let language: Language = "en";
let listeners: ((texts: Texts) => void)[] = [];

/** The texts of the present language. */
export const texts = (): Texts => ALL[language];

/** The first of the tags (as browsers name languages) that there are texts for. */
export function choose(tags: readonly string[]): Language {
  for (const tag of tags) {
    const short = tag.toLowerCase().split("-")[0]!;
    if (short in ALL) return short as Language;
  }
  return "en";
}

/** Changes the language of everything that `worded` wrote. */
export function setLanguage(to: Language): void {
  language = to;
  document.documentElement.lang = to;
  for (const write of listeners) write(texts());
}

/** Calls `write` now and whenever the language changes. */
export function worded(write: (texts: Texts) => void): void {
  listeners.push(write);
  write(texts());
}

/** Gives a node a text that follows the language. */
export function label<T extends Node>(node: T, read: (texts: Texts) => string): T {
  worded((texts) => { node.textContent = read(texts); });
  return node;
}

/** Gives an element an attribute that follows the language. */
export function attribute<T extends Element>(element: T, name: string, read: (texts: Texts) => string): T {
  worded((texts) => element.setAttribute(name, read(texts)));
  return element;
}

function number(n: number, options: Intl.NumberFormatOptions): string {
  return n.toLocaleString(language, options);
}

/** 871,414 */
export const count = (n: number): string => number(Math.round(n), {});

/** Figures that count: with two of them 0.098, 0.98, 9.8, 98, 980. */
export function figures(n: number, digits = 2): string {
  if (!Number.isFinite(n)) return "∞";
  const whole = 10 ** (digits - 1);
  return Math.abs(n) >= whole ? number(n, { maximumFractionDigits: 0 }) : number(n, { maximumSignificantDigits: digits });
}

export const fixed = (n: number, digits: number): string =>
  number(n, { minimumFractionDigits: digits, maximumFractionDigits: digits });

export const percent = (part: number): string => number(part, { style: "percent", maximumFractionDigits: 0 });

/** 1.5 px */
export const pixels = (n: number): string => `${figures(n)} px`;

/** Decimal prefixes, as files are measured: 3.4 MB. */
export function bytes(n: number): string {
  if (!Number.isFinite(n)) return "∞";
  const [size, name] = n >= 1e9 ? [1e9, "GB"] : n >= 1e6 ? [1e6, "MB"] : [1e3, "kB"];
  return `${fixed(n / size, 1)} ${name}`;
}

/** Metres and the prefix that leaves one to three figures before the point; inches and feet stay as they are. */
const METRIC = [["km", 1e3], ["m", 1], ["cm", 1e-2], ["mm", 1e-3], ["µm", 1e-6]] as const;

/** A length of `n` units of the page, in words that suit its size. */
export function length(n: number, unit: Unit, digits = 3): string {
  if (unit === "none") return exact(n, digits);
  if (unit === "in" || unit === "ft") return `${exact(n, digits)} ${unit}`;
  const metres = n * UNITS[unit];
  const [name, size] = METRIC.find(([, size]) => Math.abs(metres) >= size) ?? (metres === 0 ? [unit, 1] : METRIC[4]);
  return `${exact(metres / size, digits)} ${name}`;
}

/** Coordinates are long where the place is far from the origin: as many figures as say something. */
function exact(n: number, digits: number): string {
  const size = Math.abs(n);
  if (size !== 0 && (size < 1e-6 || size >= 1e9)) return number(n, { notation: "scientific", maximumSignificantDigits: digits });
  return number(n, { maximumSignificantDigits: Math.max(digits, Math.min(9, Math.floor(Math.log10(size || 1)) + 1)) });
}
