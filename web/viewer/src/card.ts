/** What the server says of its models: `model.json`, see `web/README.md`. */

import type { Point } from "./address.js";

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
  /** The file itself, where a person dropped it on the page. */
  file?: File;
}

export interface Card {
  name: string;
  credit?: string;
  models: ModelCard[];
  /** The server builds hierarchies from meshes that are dropped on the page. */
  build?: boolean;
}

/** The card of the models that the address names, or else of those that the server offers. */
export async function readCard(models: string[]): Promise<Card> {
  // A page without a card may still lie beside a file.
  const response = await fetch("model.json").catch(() => undefined);
  const value: unknown = response?.ok ? await response.json().catch(() => undefined) : undefined;
  const card: Card = isCard(value) ? value : { name: "model", models: [{ name: "model", url: "model.front" }] };
  if (models.length === 0) return card;
  const cards = models.map((url) => {
    const file = url.split(/[?#]/)[0]!.split("/").pop()!;
    return { name: file.replace(/\.front$/, "") || url, url };
  });
  return { name: cards.map(({ name }) => name).join(", "), models: cards, build: card.build ?? false };
}

function isCard(value: unknown): value is Card {
  const card = value as Partial<Card> | undefined | null;
  return typeof card?.name === "string" && Array.isArray(card.models) && card.models.length > 0 && card.models.every(isModel);
}

export function isModel(value: unknown): value is ModelCard {
  const card = value as Partial<ModelCard> | undefined | null;
  return typeof card?.name === "string" && typeof card.url === "string";
}

/** What a model is opened from: a file that was dropped has no address. */
export async function sourceOf({ url, file }: ModelCard): Promise<string | ArrayBuffer> {
  return file ? file.arrayBuffer() : url;
}
