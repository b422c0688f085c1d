import { MeshStandardMaterial, type MeshStandardMaterialParameters } from "three";

/** The level that is shown in the last colour of the ramp. Levels grow with the logarithm of the size. */
export const TOP_LEVEL = 20;

/**
 * A standard material that shows how fine a front is: from blue for the base mesh over green to yellow for
 * vertices `TOP_LEVEL` splits above it.
 */
export function levelMaterial(parameters: MeshStandardMaterialParameters = {}): MeshStandardMaterial {
  const material = new MeshStandardMaterial({ roughness: 0.8, ...parameters });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float level;\nvarying float vLevel;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvLevel = level;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>\nvarying float vLevel;\n${RAMP}`)
      .replace(
        "#include <color_fragment>",
        `#include <color_fragment>\ndiffuseColor.rgb *= levelRamp(vLevel / ${TOP_LEVEL.toFixed(1)});`,
      );
  };
  material.customProgramCacheKey = () => "meshfront-level";
  return material;
}

/**
 * Five stops, linear light: the order of viridis (van der Walt & Smith 2015), even in lightness and readable without
 * red and green, but starting at a lighter blue, since shading darkens it.
 */
const RAMP = /* glsl */ `
vec3 levelRamp(float t) {
  float x = clamp(t, 0.0, 1.0) * 4.0;
  vec3 c = mix(vec3(0.095, 0.075, 0.330), vec3(0.050, 0.170, 0.420), clamp(x, 0.0, 1.0));
  c = mix(c, vec3(0.015, 0.340, 0.330), clamp(x - 1.0, 0.0, 1.0));
  c = mix(c, vec3(0.150, 0.640, 0.130), clamp(x - 2.0, 0.0, 1.0));
  return mix(c, vec3(0.984, 0.799, 0.030), clamp(x - 3.0, 0.0, 1.0));
}`;
