export { MeshfrontError, type FrameStats, type ModelInfo, type Region } from "@meshfront/core";
export { MeshfrontBudget, totalStats, type BudgetOptions } from "./budget.js";
export { levelMaterial, TOP_LEVEL } from "./materials.js";
export { MeshfrontObject, type MeshfrontEventMap, type MeshfrontOptions } from "./object.js";
export { meshView, sameView, scales, type Quality } from "./view.js";
