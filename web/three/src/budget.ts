import { MeshfrontClient, MeshfrontError, type FrameStats, type FrameUpdate, type View } from "@meshfront/core";
import { sameView } from "./view.js";

/** What a budget asks of an object that shares it. */
export interface Member {
  /** The number of its model, once that is open. */
  readonly model: number | undefined;
  /** Where its front is to be; `undefined`: as it is. */
  wantedView(): View | undefined;
  /** What its last answer said, and for which view. */
  readonly last: { view: View; stats: FrameStats } | undefined;
  apply(frame: FrameUpdate, view: View): void;
  fail(error: MeshfrontError): void;
}

/** How a `MeshfrontBudget` starts. Both may be changed later. */
export interface BudgetOptions {
  /** The most triangles that all fronts together may hold; no limit by default. */
  maxTriangles?: number;
  /** Time in the worker per update, milliseconds; 6 by default. */
  deadlineMs?: number;
}

/**
 * One worker, one triangle budget and one deadline for several objects: what looks worst in any of them comes first.
 *
 * ```ts
 * const budget = new MeshfrontBudget({ maxTriangles: 1e6 });
 * scene.add(new MeshfrontObject("terrain.front", { budget }), new MeshfrontObject("statue.front", { budget }));
 * ```
 *
 * Each object's `update()` updates all of them; once per frame is enough. Dispose of it after its objects.
 */
export class MeshfrontBudget {
  maxTriangles: number;
  deadlineMs: number;
  /** The line to the worker, for what this class does not offer. */
  readonly client = new MeshfrontClient();

  private readonly members = new Set<Member>();
  private asked: { members: Member[]; maxTriangles: number } | undefined;
  private inFlight = false;
  private broken = false;

  constructor(options: BudgetOptions = {}) {
    this.maxTriangles = options.maxTriangles ?? Infinity;
    this.deadlineMs = options.deadlineMs ?? 6;
  }

  /** Whether every front is all that its camera asks for, as far as the budget allows. */
  get settled(): boolean {
    return !this.inFlight && this.isSettled(this.views());
  }

  /** Asks for the fronts of the objects' present views, where there is something to ask for. */
  update(): void {
    if (this.inFlight || this.broken) return;
    const views = this.views();
    if (views.length > 0 && !this.isSettled(views)) void this.adapt(views);
  }

  /** Ends the worker. */
  dispose(): void {
    this.broken = true;
    this.client.dispose();
  }

  /** @internal */
  join(member: Member): void {
    this.members.add(member);
  }
  /** @internal */
  leave(member: Member): void {
    this.members.delete(member);
    if (member.model !== undefined) this.client.close(member.model);
    // There may be room for the others now.
    this.asked = undefined;
  }

  private views(): { member: Member; model: number; view: View }[] {
    return [...this.members].flatMap((member) => {
      const view = member.model === undefined ? undefined : member.wantedView();
      return view ? [{ member, model: member.model!, view }] : [];
    });
  }

  private isSettled(views: { member: Member; view: View }[]): boolean {
    const { asked } = this;
    if (asked?.maxTriangles !== this.maxTriangles || asked.members.length !== views.length) return false;
    return views.every(({ member, view }, i) =>
      asked.members[i] === member && member.last?.stats.settled && sameView(member.last.view, view));
  }

  private async adapt(views: { member: Member; model: number; view: View }[]): Promise<void> {
    this.inFlight = true;
    const { maxTriangles, deadlineMs } = this;
    try {
      const frames = await this.client.adapt(views.map(({ model, view }) => ({ model, views: [view] })), { maxTriangles, maxBytes: Infinity, deadlineMs });
      this.asked = { members: views.map(({ member }) => member), maxTriangles };
      frames?.forEach((frame, i) => {
        const { member, view } = views[i]!;
        if (this.members.has(member)) member.apply(frame, view);
      });
    } catch (thrown) {
      this.broken = true;
      for (const member of this.members) member.fail(MeshfrontError.from(thrown));
    } finally {
      this.inFlight = false;
    }
    // Drawing may be slower than the engine: the worker need not wait for the next frame to go on.
    if (views.some(({ member }) => member.last?.stats.settled === false)) this.update();
  }
}

/** The statistics of several fronts as if they were one. */
export function totalStats(all: FrameStats[]): FrameStats | undefined {
  if (all.length === 0) return undefined;
  const sum = (key: "triangles" | "vertices" | "frontBytes" | "refined" | "coarsened" | "evaluations" | "gatherMs" | "uploadBytes") =>
    all.reduce((total, stats) => total + stats[key], 0);
  return {
    triangles: sum("triangles"),
    vertices: sum("vertices"),
    frontBytes: sum("frontBytes"),
    refined: sum("refined"),
    coarsened: sum("coarsened"),
    evaluations: sum("evaluations"),
    gatherMs: sum("gatherMs"),
    uploadBytes: sum("uploadBytes"),
    // One call for all of them.
    engineMs: Math.max(...all.map(({ engineMs }) => engineMs)),
    settled: all.every(({ settled }) => settled),
    budgetBound: all.some(({ budgetBound }) => budgetBound),
    byteBound: all.some(({ byteBound }) => byteBound),
    errorPx: Math.max(...all.map(({ errorPx }) => errorPx)),
  };
}
