/** What the address of the page asks for, and what the server says of its model. */

export interface Parameters {
  model: string | undefined;
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
    model: query.get("model") ?? undefined,
    tolerancePx: number("tolerance", 1),
    budget: number("budget", Infinity),
    eye: point("eye"),
    target: point("target"),
    panel: query.get("panel") !== "0",
    wireframe: query.get("wireframe") === "1",
    levels: query.get("levels") === "1",
  };
}

/** `model.json`: see `web/README.md`. */
export interface ModelCard {
  name: string;
  url: string;
  source?: { vertices: number; triangles: number };
  credit?: string;
}

/** The card of the model that the address names, or else of the one that the server offers. */
export async function readCard(model: string | undefined): Promise<ModelCard> {
  if (model !== undefined) {
    const file = model.split(/[?#]/)[0]!.split("/").pop()!;
    return { name: file.replace(/\.front$/, "") || model, url: model };
  }
  // A page without a card may still lie beside a file.
  const response = await fetch("model.json").catch(() => undefined);
  const card: unknown = response?.ok ? await response.json().catch(() => undefined) : undefined;
  return isCard(card) ? card : { name: "model", url: "model.front" };
}

function isCard(value: unknown): value is ModelCard {
  const card = value as Partial<ModelCard> | undefined;
  return typeof card === "object" && card !== null && typeof card.name === "string" && typeof card.url === "string";
}
