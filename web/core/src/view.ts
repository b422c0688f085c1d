/** A point or direction: x, y, z. */
export type Vec3 = readonly [number, number, number];

/**
 * Where the model is looked at from, and how good the picture must be.
 *
 * All points, directions and lengths are in the mesh's own space and units; a renderer that moves or scales the mesh
 * brings its camera there first.
 */
export interface View {
  eye: Vec3;
  /** Any point in front of the eye, on the axis of the picture. */
  target: Vec3;
  /** Any direction that points up in the picture. */
  up: Vec3;
  /** Vertical field of view, radians. */
  fovY: number;
  /** Size of the picture, device pixels. */
  width: number;
  height: number;
  /** Distance of the near plane: what is nearer counts as being there. */
  near: number;
  /** How far, in pixels, a drawn point may be from where the original surface would be drawn. */
  tolerancePx: number;
  /** Keep what lies outside of the picture coarse. */
  frustum: boolean;
  /** Keep what faces away coarse. */
  orientation: boolean;
  /** A part of the model with a tolerance of its own. */
  region?: Region;
}

/** What all models of a client have together. */
export interface Limits {
  /** The most triangles that their fronts may hold. */
  maxTriangles: number;
  /** How long one call may take, milliseconds; what is left over goes on in the next call, worst pixels first. */
  deadlineMs: number;
}

/** Inside: as the view says. Outside: up to an error in mesh units. */
export interface Region {
  /** A sphere or an axis-parallel box. */
  shape: { center: Vec3; radius: number } | { min: Vec3; max: Vec3 };
  outsideError: number;
}

/** Numbers of an opened model. Points and lengths in mesh units. */
export interface ModelInfo {
  /** Number of updates of the hierarchy. */
  updates: number;
  /** Size of the mesh that it was built from, after cleaning. */
  sourceVertices: number;
  sourceTriangles: number;
  /** Size of the base mesh. */
  baseTriangles: number;
  /** Axis-parallel box of the model. */
  min: Vec3;
  max: Vec3;
  /** Which way is up: a unit vector along an axis. */
  up: Vec3;
  /** The error that is left with every update applied (quantization). */
  floorError: number;
  hasColors: boolean;
  /** Bytes of the file, and how long reading it took, milliseconds, without the transfer. */
  bytes: number;
  decodeMs: number;
}

/** What one call of the engine did. */
export interface FrameStats {
  /** Triangles of the front. */
  triangles: number;
  /** Updates applied and undone in this call. */
  refined: number;
  coarsened: number;
  /** How often the criterion was asked. */
  evaluations: number;
  /** Time in the engine, milliseconds: of the whole call, which may be for several models. */
  engineMs: number;
  /** Time spent on gathering what changed, milliseconds. */
  gatherMs: number;
  /** Nothing is left to do for this view. */
  settled: boolean;
  /** The triangle budget keeps the front from its tolerance. */
  budgetBound: boolean;
  /** A bound on how wrong the front looks from here, pixels. */
  errorPx: number;
  /** Bytes to upload. */
  uploadBytes: number;
}

/**
 * Slots to write. `ranges` are pairs (first slot, number of slots), ascending and apart; the columns hold the
 * contents of these slots one range after the other.
 */
export interface VertexChanges {
  ranges: Uint32Array;
  /** 3 per slot. */
  positions: Float32Array;
  /** 4 per slot: a unit vector times 32767, and 0. */
  normals: Int16Array;
  /** 4 per slot (RGBA), or empty where the model has no colours. */
  colors: Uint8Array;
  /** 1 per slot: splits between the vertex and the base mesh, up to 255. */
  levels: Uint8Array;
}

/** Triangle slots to write: 3 vertex slots each. Free slots hold `0, 0, 0`. */
export interface TriangleChanges {
  ranges: Uint32Array;
  corners: Uint32Array;
}

/** What a renderer has to write into its buffers after one call. The first one of a model holds every slot. */
export interface FrameUpdate {
  /** Slots in use, free ones between them included: the length that the buffers need. */
  vertexSlots: number;
  triangleSlots: number;
  vertices: VertexChanges;
  triangles: TriangleChanges;
  stats: FrameStats;
}

/** A camera path over the model, run inside the worker. Milliseconds per frame, means per frame. */
export interface FlyByReport {
  frames: number;
  updatesPerFrame: number;
  activeTriangles: number;
  evaluationsPerFrame: number;
  meanMs: number;
  p50Ms: number;
  p99Ms: number;
  maxMs: number;
}
