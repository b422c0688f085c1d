export { applyRanges } from "./apply.js";
export { MeshfrontClient, type ClientModel, type OpenOptions, type WorkerPort } from "./client.js";
export { MeshfrontError, type ErrorKind } from "./errors.js";
export type { Progress } from "./fetch.js";
export type { ModelView } from "./protocol.js";
export type {
  FlyByReport, FrameStats, FrameUpdate, Limits, ModelInfo, Region, TriangleChanges, Vec3, VertexChanges, View,
} from "./view.js";
