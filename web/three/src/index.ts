export { MeshfrontError, type FrameStats, type ModelInfo, type Region } from "@meshfront/core";
export { MeshfrontBudget, totalStats, type BudgetOptions } from "./budget.js";
export type { BaseMesh, Inspection, Shade } from "./contract.js";
export {
  defaultScale, levelMaterial, RAMP, RAMP_CSS, shadeMaterial, TOP_LEVEL, type Scale, type ShadeBy, type ShadeMaterial,
} from "./materials.js";
export { MeshfrontObject, type MeshfrontEventMap, type MeshfrontOptions } from "./object.js";
export { meshView, sameView, scales, type Quality, type Resolution } from "./view.js";
