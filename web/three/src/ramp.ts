/**
 * From low to high, as seen (sRGB): blue over green to yellow, evenly spaced on a helix in Oklab (Ottosson 2020; lightness 0.45
 * to 0.92, chroma 0.11, hue 280° to 100°). Equal steps look equally large, the order can be told without red and
 * green and without any colour, and even the lowest is light enough to be shaded.
 */
export const RAMP = [
  "#4a4c90", "#3b66a4", "#1f80ae", "#0099af", "#28afa9", "#5dc29e", "#91d292", "#c4dd8b", "#f5e78f",
] as const;

/** The same for a legend: `element.style.background = RAMP_CSS`. */
export const RAMP_CSS = `linear-gradient(to right, ${RAMP.join(", ")})`;
