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

/** What all models of a client have together; those of other clients of the same worker do not count. */
export interface Limits {
  /** The most triangles that their fronts may hold; `Infinity` for no limit. */
  maxTriangles: number;
  /**
   * The most bytes that their fronts may take: in the engine (`FrameStats.frontBytes`) and in buffers as long as
   * `FrameUpdate` says, once in the page's memory and once on the graphics card. No update goes beyond it, unless the base meshes
   * do. Hierarchies do not count. `Infinity` for no limit.
   */
  maxBytes: number;
  /** How long one call may take, milliseconds; what is left over goes on in the next call, worst pixels first. */
  deadlineMs: number;
}

/** Inside: as the view says. Outside: up to an error in mesh units. */
export interface Region {
  /** A sphere or an axis-parallel box. */
  shape: { center: Vec3; radius: number } | { min: Vec3; max: Vec3 };
  outsideError: number;
}

/** What a front can be coloured by, a number per vertex slot. */
export type Shade =
  /** How far the original surface may be from what is drawn there, mesh units. */
  | "error"
  /** Half angle of the normals of all that lies below, radians; π: all directions. */
  | "cone"
  /** Updates of the model (`FrameUpdate.frame`) since the slot was last written. */
  | "age";

/**
 * A base mesh, before its model is open; of a terrain, whose base mesh is two triangles, the grid of its coarsest heights stands for it. Columns
 * as in `VertexChanges` and `TriangleChanges`, without gaps.
 */
export interface BaseMesh {
  positions: Float32Array;
  normals: Int16Array;
  colors: Uint8Array;
  triangles: Uint32Array;
  /** Axis-parallel box of these positions, mesh units: not of what lies between the coarsest heights. */
  min: Vec3;
  max: Vec3;
  /** Which way is up: a unit vector along an axis. */
  up: Vec3;
}

/** How far opening is. */
export interface OpenProgress {
  /** Bytes so far, and of the whole where the server says so. */
  loaded: number;
  total: number | undefined;
  /** Part of all that has to be done, fetching and checking; 1 once, when the model is open. Missing where nobody knows. */
  fraction: number | undefined;
}

/** What is drawn in a triangle. Points and lengths in mesh space and units. */
export interface Inspection {
  /** The update that would replace it; `undefined` where it is one of the source's triangles. */
  update: number | undefined;
  /** How far the original surface may be from it. */
  error: number;
  /** Splits between it and the base mesh: of its finest corner. */
  level: number;
  /** Half angle of the normals of all that lies below, radians. */
  coneAngle: number;
  /** The sphere of the update, or around the triangle. */
  center: Vec3;
  radius: number;
}

/** Numbers of an opened model. Points and lengths in mesh units. */
export interface ModelInfo {
  /** Which model of multiresolution: `edge_collapse`, `right_triangles` and so on. */
  model: string;
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
  /** The error of the base mesh. */
  baseError: number;
  /** Memory of the hierarchy in the engine, which all its fronts share. */
  hierarchyBytes: number;
  hasColors: boolean;
  /** Bytes of the file, and how long reading it took, milliseconds, without the transfer. */
  bytes: number;
  decodeMs: number;
}

/** What one call of the engine did. */
export interface FrameStats {
  /** Triangles and vertices of the front. */
  triangles: number;
  vertices: number;
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
  /** A budget of triangles or bytes keeps the front from its tolerance: `errorPx` is what it allows. */
  budgetBound: boolean;
  /** It is the budget of bytes, or the end of what the browser gives. */
  byteBound: boolean;
  /** A bound on how wrong the front looks from here, pixels. */
  errorPx: number;
  /** Bytes to upload. */
  uploadBytes: number;
  /** Memory of the front in the engine, bytes. */
  frontBytes: number;
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
  /** Counts the updates of a model, from 1. */
  frame: number;
  /** Slots in use, free ones between them included: the length that the buffers need. */
  vertexSlots: number;
  triangleSlots: number;
  /**
   * How many slots the buffers are to have: some more than are in use, so that they need not grow with every update. Where they become
   * shorter, the update holds every slot.
   */
  vertexCapacity: number;
  triangleCapacity: number;
  vertices: VertexChanges;
  triangles: TriangleChanges;
  /** What to colour by, where it was asked for and something changed: a number for each of the vertex slots. */
  shade?: { by: Shade; values: Float32Array };
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
