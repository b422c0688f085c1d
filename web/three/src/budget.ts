import {
  MeshfrontClient, MeshfrontError, type FrameStats, type FrameUpdate, type Shade, type View, type WorkerPort,
} from "@meshfront/core";
import { sameView } from "./view.js";

/** What an object wants its front to be. */
export interface Wanted {
  /** From where it is looked at; the finest counts everywhere. Never empty. */
  views: View[];
  /** The column to colour by. */
  shade: Shade | undefined;
}

/** What a budget asks of an object that shares it. */
export interface Member {
  /** The number of its model, once that is open. */
  readonly model: number | undefined;
  /** What its front is to be; `undefined`: as it is. */
  wanted(): Wanted | undefined;
  /** What its last answer said, and to what. */
  readonly last: { wanted: Wanted; stats: FrameStats } | undefined;
  /** Bytes of its buffers. */
  readonly bufferBytes: number;
  apply(frame: FrameUpdate, wanted: Wanted): void;
  /** Tells who listens what the last `apply` brought. */
  announce(): void;
  fail(error: MeshfrontError): void;
}

/** How a `MeshfrontBudget` starts. All but the worker may be changed later. */
export interface BudgetOptions {
  /** The most triangles that all fronts together may hold; no limit by default. */
  maxTriangles?: number;
  /**
   * The most bytes that all fronts together may take: in the engine, and in buffers, once in memory and once on the graphics
   * card. Hierarchies do not count. No limit by default.
   */
  maxBytes?: number;
  /** Time in the worker per update, milliseconds; 6 by default. */
  deadlineMs?: number;
  /** Starts the worker, by default the one of `@meshfront/core`; or another budget, whose worker is used: its limits stay its own. */
  worker?: (() => WorkerPort) | MeshfrontBudget;
}

/**
 * One worker, one budget and one deadline for several objects: what looks worst in any of them comes first.
 *
 * ```ts
 * const budget = new MeshfrontBudget({ maxTriangles: 1e6 });
 * scene.add(new MeshfrontObject("terrain.front", { budget }), new MeshfrontObject("statue.front", { budget }));
 * ```
 *
 * Each object's `update()` updates all of them; once per frame is enough. Dispose of it after its objects.
 */
export class MeshfrontBudget {
  deadlineMs: number;
  /** The line to the worker, for what this class does not offer. */
  readonly client: MeshfrontClient;

  private readonly most: { triangles: number; bytes: number };
  private readonly members = new Set<Member>();
  private asked: { members: Member[]; maxTriangles: number; maxBytes: number } | undefined;
  private inFlight = false;
  private again = false;
  private broken = false;
  /** Memory was given back since it was last asked. */
  private freed = false;
  /** All budgets of the worker. */
  private readonly beside: Set<MeshfrontBudget>;

  constructor(options: BudgetOptions = {}) {
    this.most = { triangles: options.maxTriangles ?? Infinity, bytes: options.maxBytes ?? Infinity };
    this.deadlineMs = options.deadlineMs ?? 6;
    const { worker } = options;
    this.client = new MeshfrontClient(worker instanceof MeshfrontBudget ? worker.client : worker);
    this.beside = worker instanceof MeshfrontBudget ? worker.beside : new Set();
    this.beside.add(this);
  }

  /** The most triangles that all fronts together may hold. A change is asked for at once. */
  get maxTriangles(): number {
    return this.most.triangles;
  }
  set maxTriangles(triangles: number) {
    this.most.triangles = triangles;
    this.update();
  }

  /** The most bytes that all fronts together may take. A change is asked for at once. */
  get maxBytes(): number {
    return this.most.bytes;
  }
  set maxBytes(bytes: number) {
    this.most.bytes = bytes;
    this.update();
  }

  /** Whether every front is all that its cameras ask for, as far as the budget allows. */
  get settled(): boolean {
    return !this.inFlight && this.isSettled(this.jobs());
  }

  /** Whether every front was all that its cameras asked for in the last answer, and that was to the present limits. */
  get answered(): boolean {
    return this.isAnswered(this.jobs());
  }

  /**
   * Asks for the fronts of the objects' present views, where there is something to ask for. While an answer is on its way, it asks
   * when that is there.
   */
  update(): void {
    this.again = this.inFlight;
    if (this.inFlight || this.broken) return;
    const jobs = this.jobs();
    if (jobs.length > 0 && !this.isSettled(jobs)) void this.adapt(jobs);
  }

  /** Bytes: of the engine, hierarchies and fronts of all models included; and of the buffers of all objects. */
  async memory(): Promise<{ engineBytes: number; bufferBytes: number }> {
    const engineBytes = await this.client.memory();
    return { engineBytes, bufferBytes: [...this.members].reduce((sum, { bufferBytes }) => sum + bufferBytes, 0) };
  }

  /** Ends the worker, if it was not that of another budget. */
  dispose(): void {
    this.broken = true;
    this.client.dispose();
    this.beside.delete(this);
    this.tellFreed();
  }

  /** @internal */
  join(member: Member): void {
    this.members.add(member);
  }
  /** @internal */
  leave(member: Member): void {
    if (!this.members.delete(member)) return;
    if (member.model !== undefined) this.client.close(member.model);
    // There may be room for the others now.
    this.asked = undefined;
    this.tellFreed();
  }

  /** Who has not enough memory in the same worker asks again. */
  private tellFreed(): void {
    for (const budget of this.beside) {
      if (budget === this) continue;
      budget.freed ||= budget.inFlight || [...budget.members].some(({ last }) => last?.stats.byteBound);
      if (budget.freed) budget.update();
    }
  }

  private jobs(): Job[] {
    return [...this.members].flatMap((member) => {
      const wanted = member.model === undefined ? undefined : member.wanted();
      return wanted ? [{ member, model: member.model!, wanted }] : [];
    });
  }

  private isSettled(jobs: Job[]): boolean {
    return this.isAnswered(jobs) && jobs.every(({ member, wanted }) => sameWanted(member.last!.wanted, wanted));
  }

  private isAnswered(jobs: Job[]): boolean {
    const { asked } = this;
    if (this.freed) return false;
    if (asked?.maxTriangles !== this.maxTriangles || asked.maxBytes !== this.maxBytes) return false;
    if (asked.members.length !== jobs.length) return false;
    return jobs.every(({ member }, i) => asked.members[i] === member && member.last?.stats.settled);
  }

  private async adapt(jobs: Job[]): Promise<void> {
    this.inFlight = true;
    this.freed = false;
    const { maxTriangles, maxBytes, deadlineMs } = this;
    let frames: FrameUpdate[] | undefined;
    try {
      const views = jobs.map(({ model, wanted: { views, shade } }) => ({ model, views, ...(shade ? { shade } : {}) }));
      frames = await this.client.adapt(views, { maxTriangles, maxBytes, deadlineMs });
    } catch (thrown) {
      this.broken = true;
      for (const member of this.members) member.fail(MeshfrontError.from(thrown));
      return;
    } finally {
      this.inFlight = false;
    }
    this.asked = { members: jobs.map(({ member }) => member), maxTriangles, maxBytes };
    const present = jobs.map((job, i) => ({ ...job, frame: frames?.[i] })).filter(({ member }) => this.members.has(member));
    for (const { member, frame, wanted } of present) if (frame) member.apply(frame, wanted);
    // Drawing may be slower than the engine: the worker need not wait for the next frame to go on.
    if (this.again || present.some(({ member }) => member.last?.stats.settled === false)) this.update();
    for (const { member } of present) member.announce();
  }
}

interface Job {
  member: Member;
  model: number;
  wanted: Wanted;
}

/** Whether two fronts would be the same. */
export function sameWanted(a: Wanted, b: Wanted): boolean {
  return a.shade === b.shade && sameView(a.views, b.views);
}

/** The statistics of several fronts as if they were one. */
export function totalStats(all: FrameStats[]): FrameStats | undefined {
  if (all.length === 0) return undefined;
  type Summed = "triangles" | "vertices" | "frontBytes" | "refined" | "coarsened" | "evaluations" | "gatherMs" | "uploadBytes";
  const sum = (key: Summed) => all.reduce((total, stats) => total + stats[key], 0);
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
