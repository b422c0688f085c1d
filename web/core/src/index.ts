export { applyRanges } from "./apply.js";
export { MeshfrontClient, type OpenOptions, type WorkerPort } from "./client.js";
export { MeshfrontError, type ErrorKind } from "./errors.js";
export type { Progress } from "./fetch.js";
export type {
  FlyByReport, FrameStats, FrameUpdate, ModelInfo, Region, TriangleChanges, Vec3, VertexChanges, View,
} from "./view.js";
