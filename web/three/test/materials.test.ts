import { Color } from "three";
import { expect, test } from "vitest";
import { defaultScale, shadeMaterial } from "../src/materials.js";
import { RAMP, RAMP_CSS } from "../src/ramp.js";

/** Oklab (Ottosson 2020). */
function oklab(css: string): [number, number, number] {
  const { r, g, b } = new Color(css);
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

test("equal steps of the ramp look equally large, and each is lighter than the one before", () => {
  const colors = RAMP.map(oklab);
  const steps = colors.slice(1).map((color, i) => Math.hypot(...color.map((part, k) => part - colors[i]![k]!)));
  expect(Math.max(...steps) / Math.min(...steps)).toBeLessThan(1.06);
  for (let i = 1; i < colors.length; i++) expect(colors[i]![0]).toBeGreaterThan(colors[i - 1]![0] + 0.04);
});

test("the legend has the colours of the ramp, in order", () => {
  expect(RAMP_CSS.match(/#\w{6}/g)).toEqual([...RAMP]);
});

test("a scale may be changed while it is shown", () => {
  const material = shadeMaterial(defaultScale("error", 2));
  const shader = { uniforms: {} as Record<string, { value: { x: number; y: number; z: number; w: number } }>, vertexShader: "", fragmentShader: "" };
  material.onBeforeCompile(shader as never, undefined as never);
  const { shading } = shader.uniforms;
  expect([shading!.value.x, shading!.value.y, shading!.value.z, shading!.value.w]).toEqual([Math.log(0.002), Math.log(2), 0, 1]);
  Object.assign(material.scale, defaultScale("level"));
  expect([shading!.value.x, shading!.value.y, shading!.value.z, shading!.value.w]).toEqual([0, 20, 1, 0]);
  material.scale.to = 8;
  expect(shading!.value.y).toBe(8);
});
