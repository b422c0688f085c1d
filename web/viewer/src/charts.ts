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
  const bar = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.append(bar);
  const values: number[] = [];
  return {
    svg,
    push(value) {
      values.push(value);
      if (values.length > SAMPLES) values.shift();
    },
    draw() {
      const most = Math.max(...values, Number.MIN_VALUE);
      const step = WIDTH / SAMPLES;
      const bars = values.map((value, i) => {
        const x = WIDTH - (values.length - i) * step;
        return `M${x.toFixed(1)} ${HEIGHT}v${(-HEIGHT * (value / most)).toFixed(1)}h${step.toFixed(1)}V${HEIGHT}Z`;
      });
      bar.setAttribute("d", bars.join(""));
    },
  };
}
