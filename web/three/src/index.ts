export {
  MeshfrontError, type BaseMesh, type FrameStats, type Inspection, type ModelInfo, type OpenProgress, type Region, type Shade,
} from "@meshfront/core";
export { MeshfrontBudget, totalStats, type BudgetOptions } from "./budget.js";
export {
  defaultScale, levelMaterial, shadeMaterial, TOP_LEVEL, type Scale, type ShadeBy, type ShadeMaterial,
} from "./materials.js";
export { addLights } from "./lights.js";
export { RAMP, RAMP_CSS } from "./ramp.js";
export { MeshfrontObject, type MeshfrontEventMap, type MeshfrontOptions } from "./object.js";
export { meshView, sameView, scales, type Quality, type Resolution } from "./view.js";
