import { describe, expect, test } from "vitest";
import { readAddress, writeAddress } from "../src/address.js";
import { DEFAULTS, type Values } from "../src/settings.js";
import { choose } from "../src/texts/index.js";

const values: Values = {
  ...DEFAULTS, tolerancePx: 2.5, maxTriangles: 123_456, maxBytes: 64e6, frustum: false, colorBy: "cone", surface: "matcap",
  vertexColors: false, wireframe: true, background: "#336699", up: "+z", unit: "km", divider: 0.25, originalTriangles: 2e6, theme: "contrast", language: "pt",
};

describe("the address", () => {
  test("says all that was set, and nothing else", () => {
    const query = writeAddress("?model=a.front&model=b.front&credit=kept", values, DEFAULTS, [1, -2.5, 1e-7], [0, 0, 3]);
    const back = readAddress(query, ["en"]);
    expect({ ...DEFAULTS, ...back.values }).toEqual(values);
    expect(back).toMatchObject({ models: ["a.front", "b.front"], eye: [1, -2.5, 1e-7], target: [0, 0, 3], panel: true });
    expect(query).toContain("credit=kept");
    expect(writeAddress("", DEFAULTS, DEFAULTS, [0, 0, 1], [0, 0, 0])).toBe("?eye=0,0,1&target=0,0,0");
  });

  test("a default that was said is taken away again", () => {
    expect(writeAddress("?tolerance=3&levels=1&lang=pt", DEFAULTS, DEFAULTS, [0, 0, 1], [0, 0, 0])).toBe("?eye=0,0,1&target=0,0,0");
  });

  test("for somebody else it leaves language and theme to them", () => {
    expect(writeAddress("?lang=pt&theme=dark", values, DEFAULTS, [0, 0, 1], [0, 0, 0], true)).not.toMatch(/lang|theme/);
  });

  test("what makes no sense is as if it were not said", () => {
    const { values } = readAddress("?tolerance=-1&budget=&color=mauve&compare=2&up=q&background=red", ["fr"]);
    expect(values).toEqual({ language: "en" });
  });
});

test("the first language that there are texts for", () => {
  expect(choose(["fr-FR", "pt-BR", "en"])).toBe("pt");
  expect(choose(["EN-gb"])).toBe("en");
  expect(choose([])).toBe("en");
});
