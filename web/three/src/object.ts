import {
  MeshfrontError, type BaseMesh, type ClientModel, type FlyByReport, type FrameStats, type FrameUpdate, type Inspection,
  type ModelInfo, type OpenProgress, type Region, type Shade,
} from "@meshfront/core";
import {
  type BufferGeometry, type Camera, FrontSide, type Intersection, type Material, Mesh, MeshStandardMaterial,
  Object3D, type Object3DEventMap, Matrix4, type Raycaster, Sphere, Triangle, Vector2, Vector3, type WebGLRenderer,
} from "three";
import { MeshfrontBudget, sameWanted, type Member, type Wanted } from "./budget.js";
import { applyBase, applyFrame, bufferBytes, dropShade, frontGeometry, outline } from "./buffers.js";
import { hits } from "./raycast.js";
import { meshView, type Resolution } from "./view.js";

/** How a `MeshfrontObject` starts. Qualities may be changed later on the object. */
export interface MeshfrontOptions {
  /** What messages call the file; by default the last part of its address. */
  name?: string;
  /** By default a standard material of the object's own, with vertex colours where the model has some. */
  material?: Material;
  /** Pixels that a drawn point may be from where the original surface would be drawn; 1 by default. */
  tolerancePx?: number;
  /** The most triangles that the front may hold; no limit by default. Not together with `budget`. */
  maxTriangles?: number;
  /** The most bytes that the front may take, in the engine and in buffers; no limit by default. Not together with `budget`. */
  maxBytes?: number;
  /** Time in the worker per update, milliseconds; 6 by default. Not together with `budget`. */
  deadlineMs?: number;
  /** Shared with other objects; by default the object has a worker and limits of its own. */
  budget?: MeshfrontBudget;
}

/** What a `MeshfrontObject` dispatches beside the events of every object. */
export interface MeshfrontEventMap extends Object3DEventMap {
  /** The file is arriving, or is checked. `fraction` is 1 once, when all is done. */
  "load-progress": OpenProgress;
  /** The base mesh is shown, while the rest still arrives or is checked; of a terrain the heights that come first. */
  "load-base": { base: BaseMesh };
  /** The model is open: from here on it follows its cameras. */
  load: { info: ModelInfo };
  /** The model cannot be opened, or the engine broke down. */
  "load-error": { error: MeshfrontError };
  /** What is drawn changed, or the model is open: call `update()` and draw a frame. */
  "needs-update": object;
  /** The front has become all that its cameras ask for, as far as the budget allows: once, after it was not. */
  "front-settled": { stats: FrameStats };
}

const size = new Vector2();
const sphere = new Sphere();
const meshFromWorld = new Matrix4();
const [origin, direction] = [new Vector3(), new Vector3()];
const corners = [new Vector3(), new Vector3(), new Vector3()] as const;

/**
 * A mesh that is as fine as its cameras need it.
 *
 * ```ts
 * const dragon = new MeshfrontObject("dragon.front");
 * scene.add(dragon);
 * dragon.setCamera(camera);
 * dragon.setResolutionFromRenderer(camera, renderer);
 * renderer.setAnimationLoop(() => { dragon.update(); renderer.render(scene, camera); });
 * ```
 *
 * The engine runs in a worker; `update()` sends it the views and returns at once. What changed is written into the
 * geometry when the answer arrives, and three.js uploads those ranges with the next frame. The object may be moved,
 * turned, mirrored and scaled like any other, and take any material but a list of them.
 *
 * `geometry` is the same for the object's whole life, but its attributes and its index are replaced when their length
 * changes. They are read only: `position`, `normal` (16-bit, normalized), `level` (splits above the base mesh), `color`
 * (linear) where the model has colours, `shade` while a column is asked for. A material of your own may use all of them.
 *
 * With `castShadow`, triangles that face away are kept fine as well: a light may see them. What lies outside of the
 * picture still is coarse, and so may be its shadow; where that matters, add the light's camera:
 * `setCamera(light.shadow.camera)`, `setResolution(light.shadow.camera, light.shadow.mapSize.x, light.shadow.mapSize.y)`.
 */
export class MeshfrontObject extends Mesh<BufferGeometry, Material, MeshfrontEventMap> {
  /** Resolves once the model is open; rejects with a `MeshfrontError`. */
  readonly ready: Promise<ModelInfo>;
  /** Worker and limits. */
  readonly budget: MeshfrontBudget;
  tolerancePx: number;
  /** Keep what lies outside of all pictures coarse. */
  cullFrustum = true;
  /**
   * Keep what faces away from all cameras coarse. Without effect where backs may be seen: by the material's `side`, or by a
   * light (`castShadow`).
   */
  cullOrientation = true;
  /** A part of the model, in mesh space, outside of which another tolerance holds. */
  region: Region | undefined;
  /** Leaves the front as it is, wherever the cameras go. */
  frozen = false;

  private opened: ClientModel | undefined;
  private readonly cameras = new Map<Camera, Resolution>();
  private last: { wanted: Wanted; stats: FrameStats } | undefined;
  private frame: number | undefined;
  private changed = false;
  private announced = false;
  private vertexSlots = 0;
  private column: Shade | undefined;
  private readonly ownsBudget: boolean;
  private readonly ownMaterial: Material | undefined;
  private readonly closing = new AbortController();
  private readonly member: Member;

  /**
   * Starts loading a `.front` file: an address, or its bytes (handed over; the buffer is empty afterwards). Another object is shown
   * once more, with a front of its own: they share the hierarchy, the worker and the budget, which lasts as long as the first. Where
   * `options` name another budget, that has to be one on the same worker.
   */
  constructor(source: string | URL | ArrayBuffer | MeshfrontObject, options: MeshfrontOptions = {}) {
    const own = options.material ? undefined : new MeshStandardMaterial({ color: 0xd9d0c5, roughness: 0.75 });
    super(frontGeometry(), options.material ?? own);
    this.ownMaterial = own;
    this.tolerancePx = options.tolerancePx ?? 1;
    const budget = options.budget ?? (source instanceof MeshfrontObject ? source.budget : undefined);
    this.ownsBudget = budget === undefined;
    this.budget = budget ?? new MeshfrontBudget(options);
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

  /** The most bytes that the front, or all that share its budget, may take: in the engine and in buffers. */
  get maxBytes(): number {
    return this.budget.maxBytes;
  }
  set maxBytes(bytes: number) {
    this.budget.maxBytes = bytes;
  }

  /** Bytes of its buffers on the graphics card. The copies in memory take as much. */
  get bufferBytes(): number {
    return bufferBytes(this.geometry);
  }

  /**
   * A column to colour by, in the attribute `shade`: what `shadeMaterial` shows, or a material of your own. `error` is in mesh
   * units, `cone` in radians, `age` in calls of the engine. None by default: it is sent whole with every change.
   */
  get shade(): Shade | undefined {
    return this.column;
  }
  set shade(column: Shade | undefined) {
    this.column = column;
    if (!column) dropShade(this.geometry);
  }

  /** Whether the front is all that its cameras ask for, as of the last `update()`; if it shares a budget, all of them. */
  get settled(): boolean {
    return this.last !== undefined && (this.frozen || this.budget.settled);
  }

  /**
   * Adds a camera that the front follows; of several, the one that needs a place finest counts there. It takes part once it has
   * a resolution. Returns whether it is a new one.
   */
  setCamera(camera: Camera): boolean {
    if (this.cameras.has(camera)) return false;
    this.cameras.set(camera, { width: 0, height: 0 });
    return true;
  }

  /** Follows a camera no more. Returns whether it did. */
  deleteCamera(camera: Camera): boolean {
    return this.cameras.delete(camera);
  }

  /** Whether the front follows this camera. */
  hasCamera(camera: Camera): boolean {
    return this.cameras.has(camera);
  }

  /** The size of a camera's picture, device pixels. Adds the camera where it is a new one. */
  setResolution(camera: Camera, width: number, height: number): void {
    this.cameras.set(camera, { width, height });
  }

  /**
   * The size of a camera's picture as the renderer draws it, its pixel ratio included. Call it again after a resize. Adds
   * the camera where it is a new one.
   */
  setResolutionFromRenderer(camera: Camera, renderer: WebGLRenderer): void {
    const { x, y } = renderer.getDrawingBufferSize(size);
    this.setResolution(camera, x, y);
  }

  /**
   * Asks for the front of the cameras' present views, where there is something to ask for. Call it once per frame; it
   * costs microseconds. A view that takes more than one deadline goes on by itself.
   */
  update(): void {
    this.budget.update();
  }

  /**
   * Adds all triangles that the ray meets to `intersects`, for three.js's `Raycaster`: exact against what is drawn, the front of
   * the last answer, and without holes at edges. `faceIndex` is the triangle slot, which `inspect` takes.
   */
  override raycast(raycaster: Raycaster, intersects: Intersection[]): void {
    const { geometry, material, matrixWorld } = this;
    const { ray, near, far } = raycaster;
    if (this.vertexSlots === 0 || !ray.intersectsSphere(sphere.copy(geometry.boundingSphere!).applyMatrix4(matrixWorld))) return;
    meshFromWorld.copy(matrixWorld).invert();
    origin.copy(ray.origin).applyMatrix4(meshFromWorld);
    // Not made a unit vector: lengths along the ray stay those of the world.
    direction.copy(ray.origin).add(ray.direction).applyMatrix4(meshFromWorld).sub(origin);
    const position = geometry.getAttribute("position");
    const soup = {
      positions: position.array as Float32Array,
      vertices: this.vertexSlots,
      corners: geometry.index!.array as Uint32Array,
      triangles: geometry.drawRange.count / 3,
    };
    for (const hit of hits(soup, origin.toArray(), direction.toArray(), material.side)) {
      if (hit.along < 0) continue;
      const [a, b, c] = hit.corners;
      hit.corners.forEach((vertex, i) => corners[i]!.fromBufferAttribute(position, vertex));
      const barycoord = new Vector3(...hit.weights);
      const point = blend(corners, barycoord).applyMatrix4(matrixWorld);
      const distance = ray.origin.distanceTo(point);
      if (distance < near || distance > far) continue;
      const face = { a, b, c, normal: Triangle.getNormal(...corners, new Vector3()), materialIndex: 0 };
      hit.corners.forEach((vertex, i) => corners[i]!.fromBufferAttribute(geometry.getAttribute("normal"), vertex));
      const normal = blend(corners, barycoord);
      // As three.js has it: towards where the ray comes from.
      if (normal.dot(direction) > 0) normal.negate();
      intersects.push({ distance, point, object: this, face, faceIndex: hit.triangle, normal, barycoord });
    }
  }

  /**
   * What stands behind a triangle that is drawn, `faceIndex` being that of an intersection. `undefined` where the front
   * has changed since.
   */
  async inspect(faceIndex: number): Promise<Inspection | undefined> {
    if (!this.opened || this.frame === undefined) return undefined;
    return this.budget.client.inspect(this.opened.model, this.frame, faceIndex);
  }

  /**
   * The spheres of the updates that would be applied next, worst first, in mesh space: centre and radius, four numbers each, of
   * `most` updates at most.
   */
  async spheres(most: number): Promise<Float32Array> {
    return this.opened ? this.budget.client.spheres(this.opened.model, most) : new Float32Array();
  }

  /** Ends its worker, unless others share it, and frees the buffers; a material that was given is the caller's. */
  override dispose(): void {
    this.closing.abort();
    this.budget.leave(this.member);
    this.opened = undefined;
    if (this.ownsBudget) this.budget.dispose();
    this.geometry.dispose();
    this.ownMaterial?.dispose();
    // Older versions of three.js have no such method of objects.
    (super.dispose as (() => void) | undefined)?.call(this);
  }

  /** Flies once around the model inside the worker; its front starts and ends as it was. Takes seconds. */
  async flyBy(): Promise<FlyByReport | undefined> {
    return this.opened && this.budget.client.flyBy(this.opened.model);
  }

  /** Another object of the same model, with the same material and qualities. It follows no camera yet. */
  override clone(recursive = true): this {
    const { material, tolerancePx } = this;
    const twin = new MeshfrontObject(this, this.ownMaterial === material ? { tolerancePx } : { tolerancePx, material });
    const { cullFrustum, cullOrientation, region, frozen, shade } = this;
    Object.assign(twin, { cullFrustum, cullOrientation, region, frozen, shade });
    // A mesh would take the other's geometry as well.
    return Object3D.prototype.copy.call(twin, this, recursive) as this;
  }

  private async open(source: string | URL | ArrayBuffer | MeshfrontObject, name: string | undefined): Promise<ModelInfo> {
    try {
      const opened = source instanceof MeshfrontObject ? await this.twin(source) : await this.budget.client.open(source, {
        onProgress: (progress) => this.dispatchEvent({ type: "load-progress", ...progress }),
        onBase: (base) => this.showBase(base),
        signal: this.closing.signal,
        ...(name === undefined ? {} : { name }),
      });
      this.opened = opened;
      outline(this.geometry, opened.info);
      this.useColors(opened.info.hasColors);
      this.dispatchEvent({ type: "load", info: opened.info });
      this.dispatchEvent({ type: "needs-update" });
      return opened.info;
    } catch (thrown) {
      this.budget.leave(this.member);
      if (this.ownsBudget) this.budget.dispose();
      throw this.report(thrown);
    }
  }

  private async twin(source: MeshfrontObject): Promise<ClientModel> {
    await source.ready;
    const { client } = this.budget;
    if (!client.isBeside(source.budget.client)) throw new MeshfrontError("engine", "the budget has another worker than the model");
    const twin = source.opened && (await client.duplicate(source.opened.model));
    if (twin && !this.closing.signal.aborted) return twin;
    if (twin) client.close(twin.model);
    throw new MeshfrontError("closed", "the model was closed");
  }

  private showBase(base: BaseMesh): void {
    if (this.last || this.closing.signal.aborted) return;
    applyBase(this.geometry, base);
    this.vertexSlots = base.positions.length / 3;
    this.useColors(base.colors.length > 0);
    this.dispatchEvent({ type: "load-base", base });
    this.dispatchEvent({ type: "needs-update" });
  }

  private useColors(has: boolean): void {
    if (!has || !this.ownMaterial || this.ownMaterial.vertexColors) return;
    this.ownMaterial.vertexColors = true;
    this.ownMaterial.needsUpdate = true;
  }

  private asMember(): Member {
    const object = this;
    return {
      get model() { return object.opened?.model; },
      get last() { return object.last; },
      get bufferBytes() { return object.bufferBytes; },
      wanted: () => (object.frozen ? object.recolored() : object.wanted()),
      apply: (frame, wanted) => object.apply(frame, wanted),
      announce: () => object.announce(),
      fail(error: MeshfrontError) {
        object.opened = undefined;
        object.report(error);
      },
    };
  }

  private apply(frame: FrameUpdate, wanted: Wanted): void {
    const { stats, vertices, triangles } = frame;
    const shade = frame.shade?.by === this.column ? frame.shade : undefined;
    applyFrame(this.geometry, { ...frame, shade });
    this.vertexSlots = frame.vertexSlots;
    this.frame = frame.frame;
    this.changed = vertices.ranges.length > 0 || triangles.ranges.length > 0 || shade !== undefined;
    if (this.changed || !this.last || !sameWanted(this.last.wanted, wanted)) this.announced = false;
    this.last = { wanted, stats };
  }

  private announce(): void {
    if (this.changed) this.dispatchEvent({ type: "needs-update" });
    this.changed = false;
    if (!this.last || this.announced) return;
    const { wanted, stats } = this.last;
    // An answer to where the cameras were a moment ago is none to where they are.
    if (!stats.settled || !sameWanted(wanted, this.wanted() ?? wanted)) return;
    this.announced = true;
    this.dispatchEvent({ type: "front-settled", stats });
  }

  private report(thrown: unknown): MeshfrontError {
    const error = MeshfrontError.from(thrown);
    if (!this.closing.signal.aborted) this.dispatchEvent({ type: "load-error", error });
    return error;
  }

  /** What it was made for, in other colours: a frozen front can be looked at that way, too. */
  private recolored(): Wanted | undefined {
    return this.last && this.last.wanted.shade !== this.column ? { ...this.last.wanted, shade: this.column } : undefined;
  }

  private wanted(): Wanted | undefined {
    const seen = [...this.cameras].filter(([, { width, height }]) => width > 0 && height > 0);
    if (seen.length === 0) return undefined;
    this.updateWorldMatrix(true, false);
    const quality = {
      tolerancePx: this.tolerancePx,
      frustum: this.cullFrustum,
      orientation: this.cullOrientation && !this.castShadow && this.material.side === FrontSide,
      region: this.region,
    };
    const views = seen.map(([camera, resolution]) => {
      camera.updateWorldMatrix(true, false);
      return meshView(camera, this.matrixWorld, resolution, quality);
    });
    return { views, shade: this.column };
  }
}

/** The sum of three vectors, each by its weight. */
function blend([a, b, c]: readonly [Vector3, Vector3, Vector3], { x, y, z }: Vector3): Vector3 {
  return new Vector3().addScaledVector(a, x).addScaledVector(b, y).addScaledVector(c, z);
}
