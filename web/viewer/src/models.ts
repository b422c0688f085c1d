/** The models of the page, and numbers of them. */

import type { FrameStats, MeshfrontObject, ModelInfo } from "@meshfront/three";
import type { ModelCard } from "./card.js";

/** A model of the page. */
export interface Shown {
  card: ModelCard;
  object: MeshfrontObject;
  visible: boolean;
}

/** What the panel says of one model, or of all together. Bytes, milliseconds; errors in pixels and units of the page. */
export interface Figures {
  name: string;
  triangles: number;
  sourceTriangles: number;
  vertices: number;
  sourceVertices: number;
  errorPx: number;
  error: number;
  refined: number;
  coarsened: number;
  evaluations: number;
  engineMs: number;
  gatherMs: number;
  uploadBytes: number;
  engineBytes: number | undefined;
  bufferBytes: number;
  framesPerSecond: number | undefined;
  settled: boolean;
  budgetBound: boolean;
  byteBound: boolean;
}

/** What is known of several models; the parts of the page that the engine does not know come with them. */
export function figuresOf(
  shown: readonly Shown[],
  stats: FrameStats,
  rest: Pick<Figures, "name" | "engineBytes" | "framesPerSecond"> & { pixel: number },
): Figures {
  const infos = shown.flatMap(({ object }) => object.info ?? []);
  const sum = (numbers: number[]) => numbers.reduce((total, n) => total + n, 0);
  const { pixel, ...others } = rest;
  return {
    ...others,
    triangles: stats.triangles,
    sourceTriangles: sum(infos.map(({ sourceTriangles }) => sourceTriangles)),
    vertices: stats.vertices,
    sourceVertices: sum(infos.map(({ sourceVertices }) => sourceVertices)),
    errorPx: stats.errorPx,
    error: stats.errorPx * pixel,
    refined: stats.refined,
    coarsened: stats.coarsened,
    evaluations: stats.evaluations,
    engineMs: stats.engineMs,
    gatherMs: stats.gatherMs,
    uploadBytes: stats.uploadBytes,
    bufferBytes: sum(shown.map(({ object }) => object.bufferBytes)),
    settled: stats.settled,
    budgetBound: stats.budgetBound,
    byteBound: stats.byteBound,
  };
}

/** The size that a person would say a model has: that of its source, before cleaning. */
export function trianglesOf({ card, object }: Shown): number {
  return card.source?.triangles ?? object.info?.sourceTriangles ?? 0;
}

/** Together. */
export function totalOf(infos: readonly ModelInfo[], key: "baseTriangles" | "sourceTriangles" | "bytes"): number {
  return infos.reduce((total, info) => total + info[key], 0);
}
