/** The panel's figures: what the front is, with charts of the last answers, and the models one by one. */

import { type Chart, makeChart } from "./charts.js";
import { copyText, element, make } from "./dom.js";
import type { Figures, Shown } from "./models.js";
import type { Settings } from "./settings.js";
import { bytes, count, fixed, label, length, pixels, texts, worded } from "./texts/index.js";

export interface Panel {
  /** The models are these now. */
  setModels(shown: readonly Shown[]): void;
  /** One answer of the engine, for the charts. */
  record(figures: Figures): void;
  show(figures: Figures, each: readonly (Figures | undefined)[]): void;
}

const ROWS = [
  "triangles", "vertices", "error", "errorAt", "updates", "evaluations", "engine", "upload", "engineMemory", "gpuMemory", "rate",
] as const;
type Row = (typeof ROWS)[number];

export interface PanelActions {
  /** A model was switched on or off. */
  setVisible(model: number, visible: boolean): void;
  say(text: string): void;
}

export function makePanel(settings: Settings, { setVisible, say }: PanelActions): Panel {
  const panel = element("panel");
  label(element("panel-name"), (t) => t.panel.name);
  const subject = make("select", { id: "figures-of" });
  const subjectField = make("div", { class: "field choice", hidden: true }, label(make("label", { for: "figures-of" }), (t) => t.panel.of), subject);
  const cells = new Map<Row, HTMLElement>();
  const charts: Partial<Record<Row, Chart>> = { updates: makeChart(), evaluations: makeChart(), engine: makeChart() };
  const rows = ROWS.map((row) => {
    const cell = make("dd", { id: `stat-${row}` });
    cells.set(row, cell);
    const name = label(make("dt"), (t) => t.panel[row]);
    const chart = charts[row];
    return chart ? make("div", {}, name, chart.svg, cell) : make("div", {}, name, cell);
  });
  const bites = make("p", { id: "bites", class: "bites", hidden: true });
  const list = make("ul", { class: "models" });
  const models = make("div", { hidden: true }, label(make("h3"), (t) => t.models.name), list);
  const copy = label(make("button", { type: "button", id: "copy" }), (t) => t.panel.copy);
  const byHand = make("textarea", { class: "by-hand", readonly: true, rows: 6, hidden: true });
  worded((t) => byHand.setAttribute("aria-label", t.panel.notCopied));
  const section = make("details", { class: "section", id: "figures", open: true }, label(make("summary"), (t) => t.panel.figures));
  section.append(subjectField, make("dl", {}, ...rows), bites, models, copy, byHand);
  panel.append(section);

  let latest: Figures | undefined;
  let latestOfEach: readonly (Figures | undefined)[] = [];
  let saidBites = "";
  copy.addEventListener("click", () => void copyFigures());

  async function copyFigures(): Promise<void> {
    const { tolerancePx, maxTriangles, maxBytes, deadlineMs } = settings.now;
    const report = {
      // JSON has no infinity: a limit that is none is left out.
      asked: { tolerancePx, deadlineMs, ...limit({ maxTriangles, maxBytes }) },
      sum: latest,
      models: latestOfEach.filter(Boolean),
      userAgent: navigator.userAgent,
      address: location.href,
    };
    const json = JSON.stringify(report, null, 2);
    const copied = await copyText(json);
    byHand.hidden = copied;
    if (copied) return say(texts().panel.copied);
    byHand.value = json;
    byHand.focus();
    byHand.select();
    say(texts().panel.notCopied);
  }

  let names: readonly string[] = [];
  const lines: HTMLElement[] = [];
  function name(): void {
    const chosen = subject.value;
    subject.replaceChildren(make("option", { value: "" }, texts().panel.all), ...names.map((name, i) => make("option", { value: i }, name)));
    subject.value = chosen;
  }
  worded(name);
  subject.addEventListener("change", () => again());
  const again = () => latest && show(latest, latestOfEach);
  worded(again);
  settings.on("unit", again);

  function show(figures: Figures, each: readonly (Figures | undefined)[]): void {
    [latest, latestOfEach] = [figures, each];
    const { panel: words, quality, models } = texts();
    const { unit } = settings.now;
    const one = subject.value === "" ? figures : (each[Number(subject.value)] ?? figures);
    const set = (row: Row, text: string) => {
      const cell = cells.get(row)!;
      if (cell.textContent !== text) cell.textContent = text;
    };
    set("triangles", words.partOf(count(one.triangles), count(one.sourceTriangles)));
    set("vertices", words.partOf(count(one.vertices), count(one.sourceVertices)));
    set("error", pixels(one.errorPx));
    set("errorAt", length(one.error, unit, 2));
    set("updates", `+${count(one.refined)} −${count(one.coarsened)}`);
    set("evaluations", count(one.evaluations));
    set("engine", `${fixed(one.engineMs, 2)} ms`);
    set("upload", bytes(one.uploadBytes));
    set("engineMemory", one.engineBytes === undefined ? "–" : bytes(one.engineBytes));
    set("gpuMemory", bytes(one.bufferBytes));
    set("rate", one.framesPerSecond === undefined ? words.still : words.perSecond(count(one.framesPerSecond)));
    for (const chart of Object.values(charts)) chart.draw();
    element("digest").textContent = words.digest(count(figures.triangles), pixels(figures.errorPx));
    each.forEach((figures, i) => {
      if (figures && lines[i]) lines[i].textContent = models.line(count(figures.triangles), pixels(figures.errorPx));
    });
    const [left, asked] = [pixels(figures.errorPx), pixels(settings.now.tolerancePx)];
    // Only what is final: while a front is on its way, its error says nothing about the budget.
    const biting = !figures.settled || !figures.budgetBound ? "" : figures.byteBound ? "bytes" : "triangles";
    const bytesBite = settings.now.maxBytes === Infinity ? quality.memoryEnds : quality.bytesBite;
    const text = biting === "bytes" ? bytesBite(left, asked) : biting ? quality.trianglesBite(left, asked) : "";
    if (!figures.settled && saidBites) return;
    bites.hidden = text === "";
    bites.textContent = text;
    if (biting !== saidBites && text) say(text);
    saidBites = biting;
  }

  return {
    setModels(shown) {
      names = shown.map(({ card }) => card.name);
      subject.value = "";
      name();
      subjectField.hidden = models.hidden = shown.length < 2;
      lines.length = 0;
      list.replaceChildren(...shown.map(({ card, visible }, i) => {
        const box = make("input", { type: "checkbox", checked: visible });
        box.setAttribute("aria-label", texts().models.visible(card.name));
        box.addEventListener("change", () => setVisible(i, box.checked));
        const line = make("span", { class: "quiet" });
        lines.push(line);
        return make("li", {}, make("label", {}, box, make("span", { class: "model-name" }, card.name)), line);
      }));
    },
    record(figures) {
      charts.updates!.push(figures.refined + figures.coarsened);
      charts.evaluations!.push(figures.evaluations);
      charts.engine!.push(figures.engineMs);
    },
    show,
  };
}

function limit(limits: Record<string, number>): Record<string, number> {
  return Object.fromEntries(Object.entries(limits).filter(([, value]) => Number.isFinite(value)));
}
