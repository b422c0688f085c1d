import type { Shade } from "@meshfront/core";
import { Color, MeshStandardMaterial, type MeshStandardMaterialParameters, Vector4 } from "three";
import { RAMP } from "./ramp.js";

/** The level that is shown in the last colour of the ramp by default. Levels grow with the logarithm of the size. */
export const TOP_LEVEL = 20;

/** What a `shadeMaterial` shows: a column that the object is asked for (`object.shade`), or the level, which is always there. */
export type ShadeBy = Shade | "level";

/** Which numbers have which colours. All may be changed at any time. */
export interface Scale {
  by: ShadeBy;
  /** What has the first colour, and all below it. Above 0 where the scale is logarithmic. */
  from: number;
  /** What has the last colour, and all above it. */
  to: number;
  /** Whether equal steps of the ramp are equal ratios. */
  logarithmic: boolean;
}

/** A standard material with a scale. */
export type ShadeMaterial = MeshStandardMaterial & { readonly scale: Scale };

/**
 * A scale that suits a column: levels up to `TOP_LEVEL`, cones up to a right angle, ages up to 60 calls of the engine, errors over
 * three powers of ten up to `largestError` (mesh units; the base mesh's, say).
 */
export function defaultScale(by: ShadeBy, largestError = 1): Scale {
  switch (by) {
    case "level": return { by, from: 0, to: TOP_LEVEL, logarithmic: false };
    case "cone": return { by, from: 0, to: Math.PI / 2, logarithmic: false };
    case "age": return { by, from: 0, to: 60, logarithmic: false };
    case "error": return { by, from: largestError / 1000, to: largestError, logarithmic: true };
  }
}

/**
 * A standard material coloured by what stands behind the front.
 *
 * ```ts
 * object.shade = "error";
 * object.material = shadeMaterial(defaultScale("error", object.info.baseError));
 * legend.style.background = RAMP_CSS;
 * ```
 */
export function shadeMaterial(scale: Scale, parameters: MeshStandardMaterialParameters = {}): ShadeMaterial {
  const material = new MeshStandardMaterial({ roughness: 0.8, ...parameters });
  /** First and last number of the ramp (or their logarithms), whether by level, whether logarithmic. */
  const shading = { value: new Vector4() };
  const live = { ...scale };
  const use = () => {
    const [from, to] = live.logarithmic ? [Math.log(live.from), Math.log(live.to)] : [live.from, live.to];
    shading.value.set(from, to, live.by === "level" ? 1 : 0, live.logarithmic ? 1 : 0);
  };
  use();
  const changed: Partial<Scale> = {};
  for (const key of ["by", "from", "to", "logarithmic"] as const) {
    Object.defineProperty(changed, key, {
      enumerable: true,
      get: () => live[key],
      set(value: never) {
        live[key] = value;
        use();
      },
    });
  }
  material.onBeforeCompile = (shader) => {
    shader.uniforms.shading = shading;
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", `#include <common>\n${ATTRIBUTES}`)
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvShade = shading.z > 0.5 ? level : shade;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>\nuniform vec4 shading;\nvarying float vShade;\n${GLSL}`)
      .replace("#include <color_fragment>", "#include <color_fragment>\ndiffuseColor.rgb *= shadeRamp(vShade);");
  };
  material.customProgramCacheKey = () => "meshfront-shade";
  return Object.assign(material, { scale: changed as Scale });
}

/** A standard material that shows how fine a front is: from blue for the base mesh to yellow, `TOP_LEVEL` splits above it. */
export function levelMaterial(parameters: MeshStandardMaterialParameters = {}): ShadeMaterial {
  return shadeMaterial(defaultScale("level"), parameters);
}

const ATTRIBUTES = /* glsl */ `
attribute float level;
attribute float shade;
uniform vec4 shading;
varying float vShade;`;

const GLSL = /* glsl */ `
const vec3 RAMP[${RAMP.length}] = vec3[](${RAMP.map(vec3).join(", ")});
vec3 shadeRamp(float number) {
  float at = shading.w > 0.5 ? log(max(number, 1e-37)) : number;
  float t = clamp((at - shading.x) / max(shading.y - shading.x, 1e-37), 0.0, 1.0) * ${(RAMP.length - 1).toFixed(1)};
  int i = min(int(t), ${RAMP.length - 2});
  vec3 seen = mix(RAMP[i], RAMP[i + 1], t - float(i));
  return mix(seen / 12.92, pow((seen + 0.055) / 1.055, vec3(2.4)), step(0.04045, seen));
}`;

/** A colour as it is written, sRGB. */
function vec3(css: string): string {
  const { r, g, b } = new Color(css).convertLinearToSRGB();
  return `vec3(${[r, g, b].map((part) => part.toFixed(4)).join(", ")})`;
}
