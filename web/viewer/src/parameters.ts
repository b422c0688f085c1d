/** What the address of the page asks for, and what the server says of its model. */

export interface Parameters {
  models: string[];
  tolerancePx: number;
  budget: number;
  eye: Point | undefined;
  target: Point | undefined;
  panel: boolean;
  wireframe: boolean;
  levels: boolean;
}

export type Point = [number, number, number];

/** Numbers that make no sense are taken as not said. */
export function readParameters(search: string): Parameters {
  const query = new URLSearchParams(search);
  const number = (name: string, otherwise: number) => {
    const text = query.get(name);
    const value = Number(text);
    return text !== null && text !== "" && Number.isFinite(value) && value >= 0 ? value : otherwise;
  };
  const point = (name: string): Point | undefined => {
    const parts = (query.get(name) ?? "").split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
    return parts.length === 3 && parts.every(Number.isFinite) ? (parts as Point) : undefined;
  };
  return {
    models: query.getAll("model"),
    tolerancePx: number("tolerance", 1),
    budget: number("budget", Infinity),
    eye: point("eye"),
    target: point("target"),
    panel: query.get("panel") !== "0",
    wireframe: query.get("wireframe") === "1",
    levels: query.get("levels") === "1",
  };
}

/** A model of the page. */
export interface ModelCard {
  name: string;
  /** The `.front` file, relative to the page. */
  url: string;
  /** Size of the source before cleaning. */
  source?: { vertices: number; triangles: number };
  /** Where its origin is, in the page's space, whose y is up. */
  at?: Point;
  /** How many times larger it is shown than it is. */
  scale?: number;
}

/** `model.json`: see `web/README.md`. */
export interface Card {
  name: string;
  credit?: string;
  models: ModelCard[];
}

/** The card of the models that the address names, or else of those that the server offers. */
export async function readCard(models: string[]): Promise<Card> {
  if (models.length > 0) {
    const cards = models.map((url) => {
      const file = url.split(/[?#]/)[0]!.split("/").pop()!;
      return { name: file.replace(/\.front$/, "") || url, url };
    });
    return { name: cards.map(({ name }) => name).join(", "), models: cards };
  }
  // A page without a card may still lie beside a file.
  const response = await fetch("model.json").catch(() => undefined);
  const card: unknown = response?.ok ? await response.json().catch(() => undefined) : undefined;
  return isCard(card) ? card : { name: "model", models: [{ name: "model", url: "model.front" }] };
}

function isCard(value: unknown): value is Card {
  const card = value as Partial<Card> | undefined | null;
  return typeof card?.name === "string" && Array.isArray(card.models) && card.models.length > 0 && card.models.every(isModel);
}

function isModel(value: unknown): value is ModelCard {
  const card = value as Partial<ModelCard> | undefined | null;
  return typeof card?.name === "string" && typeof card.url === "string";
}
