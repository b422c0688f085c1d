import {
  MeshfrontError, type ClientModel, type FrameStats, type FrameUpdate, type FlyByReport, type ModelInfo, type Region, type View,
} from "@meshfront/core";
import {
  type BufferGeometry, FrontSide, type Material, Mesh, MeshStandardMaterial, type Object3DEventMap, type PerspectiveCamera,
  Vector2, type WebGLRenderer,
} from "three";
import { MeshfrontBudget, type Member } from "./budget.js";
import { applyFrame, emptyGeometry, frontGeometry } from "./buffers.js";
import { meshView } from "./view.js";

/** How a `MeshfrontObject` starts. Qualities may be changed later on the object. */
export interface MeshfrontOptions {
  /** What messages call the file; by default the last part of its address. */
  name?: string;
  /** By default a standard material; vertex colours are switched on in it where the model has some. */
  material?: Material;
  /** Pixels that a drawn point may be from where the original surface would be drawn; 1 by default. */
  tolerancePx?: number;
  /** The most triangles that the front may hold; no limit by default. Not together with `budget`. */
  maxTriangles?: number;
  /** Time in the worker per update, milliseconds; 6 by default. Not together with `budget`. */
  deadlineMs?: number;
  /** Shared with other objects; by default the object has a worker and limits of its own. */
  budget?: MeshfrontBudget;
}

/** What a `MeshfrontObject` dispatches beside the events of every object. */
export interface MeshfrontEventMap extends Object3DEventMap {
  /** The file is arriving; `total` is missing where the server does not say it. */
  "load-progress": { loaded: number; total: number | undefined };
  /** The base mesh is there. */
  load: { info: ModelInfo };
  /** The model cannot be opened, or the engine broke down. */
  "load-error": { error: MeshfrontError };
  /** The front changed: draw a frame. */
  "needs-update": object;
}

const size = new Vector2();

/**
 * A mesh that is as fine as its camera needs it.
 *
 * ```ts
 * const dragon = new MeshfrontObject("dragon.front");
 * scene.add(dragon);
 * dragon.setCamera(camera);
 * dragon.setResolutionFromRenderer(camera, renderer);
 * renderer.setAnimationLoop(() => { dragon.update(); renderer.render(scene, camera); });
 * ```
 *
 * The engine runs in a worker; `update()` sends it the view and returns at once. What changed is written into the
 * geometry when the answer arrives, and three.js uploads those ranges with the next frame. The object may be moved,
 * turned and scaled like any other.
 */
export class MeshfrontObject extends Mesh<BufferGeometry, Material, MeshfrontEventMap> {
  /** Resolves once the base mesh is there; rejects with a `MeshfrontError`. */
  readonly ready: Promise<ModelInfo>;
  /** Worker and limits. */
  readonly budget: MeshfrontBudget;
  tolerancePx: number;
  /** Keep what lies outside of the picture coarse. */
  cullFrustum = true;
  /** Keep what faces away coarse. Without effect where the material shows the backs of triangles. */
  cullOrientation = true;
  /** A part of the model, in mesh space, outside of which another tolerance holds. */
  region: Region | undefined;
  /** Leaves the front as it is, wherever the camera goes. */
  frozen = false;

  private opened: ClientModel | undefined;
  private camera: PerspectiveCamera | undefined;
  private height = 0;
  private last: { view: View; stats: FrameStats } | undefined;
  private readonly ownsBudget: boolean;
  private readonly closing = new AbortController();
  private readonly member: Member;

  /** Starts loading a `.front` file: an address, or its bytes (handed over; the buffer is empty afterwards). */
  constructor(source: string | URL | ArrayBuffer, options: MeshfrontOptions = {}) {
    super(emptyGeometry(), options.material ?? new MeshStandardMaterial({ color: 0xd9d0c5, roughness: 0.75 }));
    this.tolerancePx = options.tolerancePx ?? 1;
    this.ownsBudget = options.budget === undefined;
    this.budget = options.budget ?? new MeshfrontBudget(options);
    this.member = this.asMember();
    this.budget.join(this.member);
    this.name = options.name ?? "";
    this.ready = this.open(source, options.name);
    // Who listens to `load-error` need not catch `ready` as well.
    this.ready.catch(() => {});
  }

  /** Numbers of the model, once it is open. */
  get info(): ModelInfo | undefined {
    return this.opened?.info;
  }

  /** What the last answer of the engine said. */
  get stats(): FrameStats | undefined {
    return this.last?.stats;
  }

  /** The most triangles that the front, or all that share its budget, may hold. */
  get maxTriangles(): number {
    return this.budget.maxTriangles;
  }
  set maxTriangles(triangles: number) {
    this.budget.maxTriangles = triangles;
  }

  /** Whether the front is all that the camera asks for, as of the last `update()`; if it shares a budget, all of them. */
  get settled(): boolean {
    return this.last !== undefined && (this.frozen || this.budget.settled);
  }

  /** The camera that the front follows. */
  setCamera(camera: PerspectiveCamera): void {
    this.camera = camera;
  }

  /** The height of the picture, device pixels. */
  setResolution(height: number): void {
    this.height = height;
  }

  /** The size of the picture as the renderer draws it, its pixel ratio included. Call it again after a resize. */
  setResolutionFromRenderer(camera: PerspectiveCamera, renderer: WebGLRenderer): void {
    this.setCamera(camera);
    this.setResolution(renderer.getDrawingBufferSize(size).y);
  }

  /**
   * Asks for the front of the camera's present view, where there is something to ask for. Call it once per frame; it
   * costs microseconds. A view that takes more than one deadline goes on by itself.
   */
  update(): void {
    this.budget.update();
  }

  /** Ends its worker, unless others share it, and frees the buffers; the material is the caller's. */
  override dispose(): void {
    this.closing.abort();
    this.budget.leave(this.member);
    this.opened = undefined;
    if (this.ownsBudget) this.budget.dispose();
    this.geometry.dispose();
    super.dispose();
  }

  /** Flies once around the model inside the worker; its front starts and ends as it was. Takes seconds. */
  async flyBy(): Promise<FlyByReport | undefined> {
    return this.opened && this.budget.client.flyBy(this.opened.model);
  }

  private async open(source: string | URL | ArrayBuffer, name: string | undefined): Promise<ModelInfo> {
    try {
      const opened = await this.budget.client.open(source, {
        onProgress: ({ loaded, total }) => this.dispatchEvent({ type: "load-progress", loaded, total }),
        signal: this.closing.signal,
        ...(name === undefined ? {} : { name }),
      });
      this.opened = opened;
      this.geometry = frontGeometry(opened.info);
      if (opened.info.hasColors && "vertexColors" in this.material) this.material.vertexColors = true;
      this.dispatchEvent({ type: "load", info: opened.info });
      return opened.info;
    } catch (thrown) {
      this.budget.leave(this.member);
      if (this.ownsBudget) this.budget.dispose();
      throw this.report(thrown);
    }
  }

  private asMember(): Member {
    const object = this;
    return {
      get model() { return object.opened?.model; },
      get last() { return object.last; },
      wantedView: () => (object.frozen ? undefined : object.view()),
      apply(frame: FrameUpdate, view: View) {
        applyFrame(object.geometry, frame);
        object.last = { view, stats: frame.stats };
        object.dispatchEvent({ type: "needs-update" });
      },
      fail(error: MeshfrontError) {
        object.opened = undefined;
        object.report(error);
      },
    };
  }

  private report(thrown: unknown): MeshfrontError {
    const error = MeshfrontError.from(thrown);
    if (!this.closing.signal.aborted) this.dispatchEvent({ type: "load-error", error });
    return error;
  }

  private view(): View | undefined {
    if (!this.camera || this.height <= 0) return undefined;
    this.updateWorldMatrix(true, false);
    this.camera.updateWorldMatrix(true, false);
    return meshView(this.camera, this.matrixWorld, this.height, {
      tolerancePx: this.tolerancePx,
      frustum: this.cullFrustum,
      orientation: this.cullOrientation && this.material.side === FrontSide,
      region: this.region,
    });
  }
}
