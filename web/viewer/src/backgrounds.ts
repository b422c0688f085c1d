/** What lies behind the models: the same in the page and in saved pictures. */

/** Colours from the middle to the corners. */
type Stops = readonly (readonly [at: number, color: string])[];

export const BACKGROUNDS = ["studio", "white", "grey", "black"] as const;

const NAMED: Record<string, { light: Stops; dark: Stops }> = {
  studio: {
    light: [[0, "#f7f8fa"], [0.55, "#dfe4ea"], [1, "#c3cbd4"]],
    dark: [[0, "#3a444f"], [0.55, "#20272f"], [1, "#12161c"]],
  },
  white: { light: [[0, "#ffffff"]], dark: [[0, "#ffffff"]] },
  grey: { light: [[0, "#808080"]], dark: [[0, "#808080"]] },
  black: { light: [[0, "#000000"]], dark: [[0, "#000000"]] },
};

/** Where the middle is, and how far it is to the last colour: parts of width and height. */
const MIDDLE = [0.5, 0.35] as const;
const REACH = [1.2, 0.9] as const;

function stops(background: string, isDark: boolean): Stops {
  const named = NAMED[background];
  return named ? (isDark ? named.dark : named.light) : [[0, background]];
}

/** As the CSS property `background`. */
export function backgroundCss(background: string, isDark: boolean): string {
  const colors = stops(background, isDark);
  if (colors.length === 1) return colors[0]![1];
  const list = colors.map(([at, color]) => `${color} ${100 * at}%`).join(", ");
  return `radial-gradient(${REACH.map((x) => `${100 * x}%`).join(" ")} at ${MIDDLE.map((x) => `${100 * x}%`).join(" ")}, ${list})`;
}

/** Fills a picture. */
export function paintBackground(context: CanvasRenderingContext2D, background: string, isDark: boolean): void {
  const { width, height } = context.canvas;
  context.save();
  context.translate(MIDDLE[0] * width, MIDDLE[1] * height);
  context.scale(REACH[0] * width, REACH[1] * height);
  const gradient = context.createRadialGradient(0, 0, 0, 0, 0, 1);
  for (const [at, color] of stops(background, isDark)) gradient.addColorStop(at, color);
  context.fillStyle = gradient;
  context.fillRect(-1, -1, 2, 2);
  context.restore();
}
