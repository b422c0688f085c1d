import { MeshfrontClient, MeshfrontError, type FrameStats, type ModelInfo, type Region, type View } from "@meshfront/core";
import {
  type BufferGeometry, FrontSide, type Material, Mesh, MeshStandardMaterial, type Object3DEventMap, type PerspectiveCamera,
  Vector2, type WebGLRenderer,
} from "three";
import { applyFrame, emptyGeometry, frontGeometry } from "./buffers.js";
import { meshView, sameView } from "./view.js";

/** How a `MeshfrontObject` starts. Qualities may be changed later on the object. */
export interface MeshfrontOptions {
  /** What messages call the file; by default the last part of its address. */
  name?: string;
  /** By default a standard material; vertex colours are switched on in it where the model has some. */
  material?: Material;
  /** Pixels that a drawn point may be from where the original surface would be drawn; 1 by default. */
  tolerancePx?: number;
  /** The most triangles that the front may hold; no limit by default. */
  maxTriangles?: number;
  /** Time in the worker per update, milliseconds; 6 by default. */
  deadlineMs?: number;
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
  tolerancePx: number;
  maxTriangles: number;
  deadlineMs: number;
  /** Keep what lies outside of the picture coarse. */
  cullFrustum = true;
  /** Keep what faces away coarse. Without effect where the material shows the backs of triangles. */
  cullOrientation = true;
  /** A part of the model, in mesh space, outside of which another tolerance holds. */
  region: Region | undefined;
  /** Leaves the front as it is, wherever the camera goes. */
  frozen = false;

  private client: MeshfrontClient | undefined;
  private camera: PerspectiveCamera | undefined;
  private height = 0;
  private lastView: View | undefined;
  private lastStats: FrameStats | undefined;
  private busy = false;
  private readonly closing = new AbortController();

  /** Starts loading a `.front` file: an address, or its bytes (handed over; the buffer is empty afterwards). */
  constructor(source: string | URL | ArrayBuffer, options: MeshfrontOptions = {}) {
    super(emptyGeometry(), options.material ?? new MeshStandardMaterial({ color: 0xd9d0c5, roughness: 0.75 }));
    this.tolerancePx = options.tolerancePx ?? 1;
    this.maxTriangles = options.maxTriangles ?? Infinity;
    this.deadlineMs = options.deadlineMs ?? 6;
    this.name = options.name ?? "";
    this.ready = this.open(source, options.name);
    // Who listens to `load-error` need not catch `ready` as well.
    this.ready.catch(() => {});
  }

  /** Numbers of the model, once it is open. */
  get info(): ModelInfo | undefined {
    return this.client?.info;
  }

  /** What the last answer of the engine said. */
  get stats(): FrameStats | undefined {
    return this.lastStats;
  }

  /** Whether the front is all that the camera asks for, as of the last `update()`. */
  get settled(): boolean {
    return !this.busy && (this.lastStats?.settled ?? false) && (this.frozen || !this.viewChanged());
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
    if (!this.client || this.busy || this.frozen) return;
    const view = this.view();
    if (!view || (this.lastStats?.settled && this.lastView && sameView(view, this.lastView))) return;
    void this.adapt(this.client, view);
  }

  /** Ends the worker and frees the buffers; the material is the caller's. */
  override dispose(): void {
    this.closing.abort();
    this.client?.dispose();
    this.client = undefined;
    this.geometry.dispose();
    super.dispose();
  }

  /** The client below, for what this object does not offer. */
  get engine(): MeshfrontClient | undefined {
    return this.client;
  }

  private async open(source: string | URL | ArrayBuffer, name: string | undefined): Promise<ModelInfo> {
    try {
      const client = await MeshfrontClient.open(source, {
        onProgress: (loaded, total) => this.dispatchEvent({ type: "load-progress", loaded, total }),
        signal: this.closing.signal,
        ...(name === undefined ? {} : { name }),
      });
      this.client = client;
      this.geometry = frontGeometry(client.info);
      if (client.info.hasColors && "vertexColors" in this.material) this.material.vertexColors = true;
      this.dispatchEvent({ type: "load", info: client.info });
      return client.info;
    } catch (thrown) {
      throw this.report(thrown);
    }
  }

  private async adapt(client: MeshfrontClient, view: View): Promise<void> {
    this.busy = true;
    try {
      const frame = await client.adapt(view);
      if (!frame || this.client !== client) return;
      applyFrame(this.geometry, frame);
      this.lastView = view;
      this.lastStats = frame.stats;
      this.dispatchEvent({ type: "needs-update" });
    } catch (thrown) {
      this.client = undefined;
      this.report(thrown);
    } finally {
      this.busy = false;
    }
    // Drawing may be slower than the engine: the worker need not wait for the next frame to go on.
    if (this.lastStats?.settled === false) this.update();
  }

  private report(thrown: unknown): MeshfrontError {
    const error = MeshfrontError.from(thrown);
    if (!this.closing.signal.aborted) this.dispatchEvent({ type: "load-error", error });
    return error;
  }

  private viewChanged(): boolean {
    const view = this.view();
    return view !== undefined && !(this.lastView && sameView(view, this.lastView));
  }

  private view(): View | undefined {
    if (!this.camera || this.height <= 0) return undefined;
    this.updateWorldMatrix(true, false);
    this.camera.updateWorldMatrix(true, false);
    return meshView(this.camera, this.matrixWorld, this.height, {
      tolerancePx: this.tolerancePx,
      maxTriangles: this.maxTriangles,
      deadlineMs: this.deadlineMs,
      frustum: this.cullFrustum,
      orientation: this.cullOrientation && this.material.side === FrontSide,
      region: this.region,
    });
  }
}
