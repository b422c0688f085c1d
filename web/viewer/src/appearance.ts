/** How models look: surfaces, colours that tell of the front, lines. */

import { defaultScale, type Scale, shadeMaterial, type ShadeMaterial } from "@meshfront/three";
import {
  CanvasTexture, type Material, MeshBasicMaterial, MeshMatcapMaterial, MeshStandardMaterial, SRGBColorSpace,
} from "three";
import type { Settings } from "./settings.js";

const CLAY = 0xd8c7b4;

export interface Appearance {
  /** What a model is to be drawn with now. */
  material(hasColors: boolean): Material;
  /** Of the triangles' sides. */
  readonly lines: MeshBasicMaterial;
  /** What the colours of errors begin and end with, mesh units, where the largest error of all models is this. */
  errorRange(most: number): [from: number, to: number];
}

export function makeAppearance(settings: Settings): Appearance {
  const made = new Map<string, Material>();
  let errors = defaultScale("error");
  const lines = new MeshBasicMaterial({ color: 0x11161c, wireframe: true, transparent: true, opacity: 0.4 });
  // A hair nearer to the eye than the surface, along the same ray.
  lines.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace(
      "#include <project_vertex>",
      "#include <project_vertex>\nmvPosition.xyz *= 0.9995;\ngl_Position = projectionMatrix * mvPosition;",
    );
  };

  function plain(painted: boolean): Material {
    const { surface } = settings.now;
    const color = painted ? 0xffffff : CLAY;
    if (surface === "matcap") return new MeshMatcapMaterial({ color, matcap: matcap(), vertexColors: painted });
    return new MeshStandardMaterial({ color, roughness: 0.72, vertexColors: painted, flatShading: surface === "flat" });
  }

  function scale(): Scale {
    const { colorBy } = settings.now;
    if (colorBy === "error") return errors;
    // Coarse fronts have cones of all sizes.
    return colorBy === "cone" ? { ...defaultScale("cone"), to: Math.PI } : defaultScale(colorBy as "level" | "age");
  }

  function colored(): Material & Partial<Pick<ShadeMaterial, "scale">> {
    const { surface } = settings.now;
    const shade = shadeMaterial(scale(), { flatShading: surface === "flat" });
    if (surface !== "matcap") return shade;
    const { onBeforeCompile, customProgramCacheKey, scale: live } = shade;
    return Object.assign(new MeshMatcapMaterial({ matcap: matcap() }), { onBeforeCompile, customProgramCacheKey, scale: live });
  }

  return {
    lines,
    material(hasColors) {
      const { surface, colorBy, vertexColors } = settings.now;
      const painted = hasColors && vertexColors && colorBy === "none";
      const key = `${surface} ${colorBy} ${painted}`;
      const material = made.get(key) ?? (colorBy === "none" ? plain(painted) : colored());
      made.set(key, material);
      return material;
    },
    errorRange(most) {
      errors = defaultScale("error", most);
      for (const material of made.values()) {
        const { scale } = material as Partial<ShadeMaterial>;
        if (scale?.by === "error") Object.assign(scale, errors);
      }
      return [errors.from, errors.to];
    },
  };
}

let ball: CanvasTexture | undefined;

/** A lit ball, painted: light from above left, a cool rim from below right, a soft highlight. */
function matcap(): CanvasTexture {
  if (ball) return ball;
  const size = 256;
  const canvas = Object.assign(document.createElement("canvas"), { width: size, height: size });
  const context = canvas.getContext("2d")!;
  const shade = (x: number, y: number, radius: number, stops: [number, string][]) => {
    const gradient = context.createRadialGradient(x * size, y * size, 0, x * size, y * size, radius * size);
    for (const [at, color] of stops) gradient.addColorStop(at, color);
    context.fillStyle = gradient;
    context.fillRect(0, 0, size, size);
  };
  shade(0.38, 0.3, 0.85, [[0, "#ffffff"], [0.35, "#d5d2ce"], [0.7, "#77716c"], [1, "#2e2b2b"]]);
  shade(0.85, 0.85, 0.45, [[0, "#8fb4e060"], [1, "#8fb4e000"]]);
  shade(0.36, 0.26, 0.16, [[0, "#ffffffc0"], [1, "#ffffff00"]]);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return (ball = texture);
}
