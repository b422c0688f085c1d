/** What the engine says beyond what `@meshfront/core` declares so far. */

import type { FrameStats, FrameUpdate, MeshfrontClient, ModelInfo, Vec3 } from "@meshfront/core";

/** A column to colour by, one number per vertex: mesh units, radians, frames. */
export type Shade = "error" | "cone" | "age";

export interface BaseMesh {
  positions: Float32Array;
  normals: Int16Array;
  colors: Uint8Array;
  triangles: Uint32Array;
  min: Vec3;
  max: Vec3;
  up: Vec3;
}

export interface Inspection {
  update: number | undefined;
  error: number;
  level: number;
  coneAngle: number;
  center: Vec3;
  radius: number;
}

export type Stats = FrameStats & { byteBound?: boolean; vertices?: number; frontBytes?: number };
export type Frame = FrameUpdate & {
  frame?: number;
  vertexCapacity?: number;
  triangleCapacity?: number;
  shade?: { by: Shade; values: Float32Array };
};
export type Info = ModelInfo & { baseError?: number };
export type Client = MeshfrontClient & {
  inspect?(model: number, frame: number, triangle: number): Promise<Inspection | undefined>;
  spheres?(model: number, most: number): Promise<Float32Array>;
  memory?(): Promise<number>;
};
