/** The panel: what the front is, and what is asked of it. */

import type { FrameStats, ModelInfo } from "@meshfront/three";

export interface Controls {
  setTolerance(px: number): void;
  setBudget(triangles: number): void;
  freeze(on: boolean): void;
  wireframe(on: boolean): void;
  levels(on: boolean): void;
  showAll(): void;
}

export interface Panel {
  /** Shows numbers of the last frame. */
  show(stats: FrameStats): void;
  /** Sets the sliders' ranges, once the models are known. */
  setModels(infos: ModelInfo[]): void;
  setTolerance(px: number): void;
  setBudget(triangles: number): void;
  setSwitch(name: "freeze" | "wireframe" | "levels", on: boolean): void;
}

/** The tolerance slider is logarithmic: each step is 1/20 of a factor of ten, from 0.1 to 10^4 × that. */
const FINEST_PX = 0.1;
const STEPS_PER_DECADE = 40;

export function element<T extends HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element "${id}"`);
  return found as T;
}

export function makePanel(controls: Controls): Panel {
  const tolerance = element<HTMLInputElement>("tolerance");
  const budget = element<HTMLInputElement>("budget");
  let base = 1;
  let full = 1;

  const pxOf = (step: number) => FINEST_PX * 10 ** (step / STEPS_PER_DECADE);
  const budgetOf = (step: number) => (step >= 100 ? Infinity : Math.round(base * (full / base) ** (step / 100)));
  const sayTolerance = (px: number) => {
    const text = `${round(px)} px`;
    element("tolerance-value").textContent = text;
    tolerance.setAttribute("aria-valuetext", text);
  };
  const sayBudget = (triangles: number) => {
    const text = triangles === Infinity ? "no limit" : count(triangles);
    element("budget-value").textContent = text;
    budget.setAttribute("aria-valuetext", text);
  };

  tolerance.addEventListener("input", () => {
    sayTolerance(pxOf(Number(tolerance.value)));
    controls.setTolerance(pxOf(Number(tolerance.value)));
  });
  budget.addEventListener("input", () => {
    sayBudget(budgetOf(Number(budget.value)));
    controls.setBudget(budgetOf(Number(budget.value)));
  });
  for (const name of ["freeze", "wireframe", "levels"] as const) {
    const box = element<HTMLInputElement>(name);
    box.addEventListener("change", () => controls[name](box.checked));
  }
  element("fit").addEventListener("click", () => controls.showAll());

  return {
    show(stats) {
      const part = full > 0 ? ` of ${count(full)}` : "";
      element("stat-triangles").textContent = `${count(stats.triangles)}${part}`;
      element("stat-error").textContent = `${round(stats.errorPx)} px`;
      element("stat-updates").textContent = `+${count(stats.refined)} −${count(stats.coarsened)}`;
      element("stat-engine").textContent = `${stats.engineMs.toFixed(2)} ms`;
      element("stat-upload").textContent = `${(stats.uploadBytes / 1000).toFixed(1)} kB`;
      element("stat-evaluations").textContent = count(stats.evaluations);
      element("digest").textContent = `${count(stats.triangles)} triangles · ${round(stats.errorPx)} px`;
    },
    setModels(infos) {
      base = Math.max(infos.reduce((sum, { baseTriangles }) => sum + baseTriangles, 0), 1);
      full = Math.max(infos.reduce((sum, { sourceTriangles }) => sum + sourceTriangles, 0), base);
    },
    setTolerance(px) {
      tolerance.value = String(Math.round(STEPS_PER_DECADE * Math.log10(Math.max(px, FINEST_PX) / FINEST_PX)));
      sayTolerance(px);
    },
    setBudget(triangles) {
      const step = (100 * Math.log(triangles / base)) / Math.log(full / base);
      budget.value = String(triangles === Infinity ? 100 : Math.min(99, Math.max(0, Math.round(step))));
      sayBudget(triangles);
    },
    setSwitch(name, on) {
      element<HTMLInputElement>(name).checked = on;
    },
  };
}

/** 871,414 */
export function count(n: number): string {
  return Math.round(n).toLocaleString("en");
}

/** Two figures that count: 0.098, 0.98, 9.8, 98. */
function round(n: number): string {
  if (n === 0) return "0";
  if (!Number.isFinite(n)) return "∞";
  return n >= 10 ? n.toFixed(0) : n.toPrecision(2);
}
