export { applyRanges } from "./apply.js";
export { MeshfrontClient, type ClientModel, type OpenOptions, type WorkerPort } from "./client.js";
export { MeshfrontError, type ErrorKind } from "./errors.js";
export type { ModelView } from "./protocol.js";
export type {
  BaseMesh, FlyByReport, FrameStats, FrameUpdate, Inspection, Limits, ModelInfo, OpenProgress, Region, Shade,
  TriangleChanges, Vec3, VertexChanges, View,
} from "./view.js";
