/** Small live charts: the last answers of the engine, newest at the right. */

const SAMPLES = 120;
const [WIDTH, HEIGHT] = [96, 18];

export interface Chart {
  readonly svg: SVGSVGElement;
  push(value: number): void;
  /** Draws what was pushed. */
  draw(): void;
}

/** The number beside it says the last value in words; the chart is for the eye. */
export function makeChart(): Chart {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
  svg.setAttribute("preserveAspectRatio", "none");
  svg.setAttribute("class", "chart");
  svg.setAttribute("aria-hidden", "true");
  const area = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.append(area);
  const values: number[] = [];
  return {
    svg,
    push(value) {
      values.push(value);
      if (values.length > SAMPLES) values.shift();
    },
    draw() {
      const most = Math.max(...values, Number.MIN_VALUE);
      const step = WIDTH / (SAMPLES - 1);
      const start = WIDTH - (values.length - 1) * step;
      const points = values.map((value, i) => `L${(start + i * step).toFixed(1)} ${(HEIGHT * (1 - value / most)).toFixed(1)}`);
      area.setAttribute("d", values.length ? `M${start.toFixed(1)} ${HEIGHT}${points.join("")}L${WIDTH} ${HEIGHT}Z` : "");
    },
  };
}
