/** Client and host, joined by a real message channel; the engine between them is a script that can be held. */

import { afterEach, expect, test, vi } from "vitest";
import { MeshfrontClient, type WorkerPort } from "../src/client.js";
import { serve, type Engine } from "../src/host.js";
import type { ModelView, Port, Reply, Request } from "../src/protocol.js";
import type { BaseMesh, FrameUpdate, Limits, ModelInfo, OpenProgress, View } from "../src/view.js";

const VIEW: View = {
  eye: [0, 0, 5], target: [0, 0, 0], up: [0, 1, 0], fovY: 1, width: 100, height: 100, near: 0.1,
  tolerancePx: 1, frustum: true, orientation: true,
};
const LIMITS: Limits = { maxTriangles: Infinity, maxBytes: Infinity, deadlineMs: 5 };
const at = (x: number): ModelView[] => [{ model: 7, views: [{ ...VIEW, eye: [x, 0, 5] }] }];

const INFO = { updates: 3, bytes: 4 } as ModelInfo;

function frameOf(view: View): FrameUpdate {
  return {
    frame: 1,
    vertexSlots: 1,
    triangleSlots: 1,
    vertexCapacity: 1,
    triangleCapacity: 1,
    vertices: {
      ranges: Uint32Array.of(0, 1),
      positions: Float32Array.from(view.eye),
      normals: new Int16Array(4),
      colors: new Uint8Array(0),
      levels: new Uint8Array(1),
    },
    triangles: { ranges: Uint32Array.of(0, 1), corners: new Uint32Array(3) },
    stats: {
      triangles: 1, vertices: 1, refined: 1, coarsened: 0, evaluations: 1, engineMs: 0, gatherMs: 0, settled: true,
      budgetBound: false, byteBound: false, errorPx: 0, uploadBytes: 33, frontBytes: 100,
    },
  };
}

const channels: MessageChannel[] = [];
afterEach(() => {
  for (const { port1, port2 } of channels.splice(0)) {
    port1.close();
    port2.close();
  }
});

/** A worker whose engine notes the views that reach it. */
function worker(engine: Partial<Engine> = {}, fetcher?: typeof fetch) {
  const channel = new MessageChannel();
  channels.push(channel);
  const views: View[] = [];
  const open = vi.fn((_group: number, bytes: Uint8Array, name: string, onProgress: (part: number) => void) => {
    if (bytes[0] !== 77) throw Object.assign(new Error(`${name}: byte 0 is wrong`), { name: "damaged" });
    onProgress(0.5);
    onProgress(1);
    return { model: 7, info: INFO };
  });
  const adapt = (_group: number, asked: ModelView[]) => asked.map(({ views: [view] }) => {
    views.push(view!);
    return frameOf(view!);
  });
  const no = () => { throw new Error("no"); };
  const [close, leave] = [vi.fn(), vi.fn()];
  const rest = { duplicate: no, inspect: no, spheres: no, memory: () => 65536, flyBy: no };
  const baseOf = (start: Uint8Array) => (start.length >= 3 ? BASE() : undefined);
  const whole: Engine = { baseOf, open, adapt, close, leave, ...rest, ...engine };
  serve(channel.port2 as unknown as Port<Reply, Request>, async () => whole, fetcher);
  const port = channel.port1 as unknown as WorkerPort;
  port.terminate = vi.fn(() => channel.port1.close());
  return { client: new MeshfrontClient(() => port), views, open, close, leave, port };
}
const BASE = (): BaseMesh => ({
  positions: Float32Array.of(1, 2, 3), normals: new Int16Array(4), colors: new Uint8Array(0), triangles: new Uint32Array(3),
  min: [1, 2, 3], max: [1, 2, 3], up: [0, 1, 0],
});
const good = () => Uint8Array.of(77, 1, 2, 3).buffer;


test("opens bytes, which are handed over and not copied", async () => {
  const { client, open } = worker();
  const bytes = good();
  await expect(client.open(bytes)).resolves.toMatchObject({ model: 7, info: INFO });
  expect(open).toHaveBeenCalledOnce();
  expect(bytes.byteLength).toBe(0);
});

test("opens an address, and tells how far it is", async () => {
  vi.stubGlobal("document", { baseURI: "http://localhost/page/" });
  const asked: string[] = [];
  const fetcher = (async (url: string) => {
    asked.push(url);
    return new Response(good(), { headers: { "content-length": "4" } });
  }) as typeof fetch;
  const { client } = worker({}, fetcher);
  const seen: OpenProgress[] = [];
  await client.open("a.front", { onProgress: (progress) => seen.push(progress) });
  vi.unstubAllGlobals();
  expect(asked).toEqual(["http://localhost/page/a.front"]);
  expect(seen.map(({ loaded }) => loaded)).toEqual([0, 4, 4, 4, 4, 4]);
  const fractions = seen.map(({ fraction }) => fraction!);
  expect(fractions).toEqual([...fractions].sort((a, b) => a - b));
  // The whole once, and last.
  expect(fractions.filter((fraction) => fraction >= 1)).toEqual([1]);
  expect(fractions.at(-1)).toBe(1);
});

test("the base mesh comes once, before the model, and before all of the file where it is slow", async () => {
  vi.stubGlobal("document", { baseURI: "http://localhost/" });
  let send = (_: number[]) => {};
  let end = () => {};
  const body = new ReadableStream({
    start(controller) {
      send = (bytes) => controller.enqueue(Uint8Array.from(bytes));
      end = () => controller.close();
    },
  });
  const { client, open } = worker({}, async () => new Response(body));
  await client.open(good());
  const bases: BaseMesh[] = [];
  const opening = client.open("slow.front", { onBase: (base) => bases.push(base) });
  send([77, 1]);
  await new Promise((soon) => setTimeout(soon, 20));
  expect(bases).toHaveLength(0);
  send([2]);
  await vi.waitFor(() => expect(bases).toHaveLength(1));
  expect(bases[0]!.positions).toEqual(Float32Array.of(1, 2, 3));
  expect(open).toHaveBeenCalledTimes(1);
  send([3, 4, 5]);
  end();
  await opening;
  expect(bases).toHaveLength(1);
  vi.unstubAllGlobals();
});

test("what breaks down is told to the one who asked", async () => {
  const { client } = worker();
  await client.open(good());
  await expect(client.memory()).resolves.toBe(65536);
  await expect(client.inspect(7, 1, 0)).rejects.toMatchObject({ kind: "engine", message: "no" });
  await expect(client.spheres(7, 10)).rejects.toMatchObject({ kind: "engine" });
  await expect(client.duplicate(7)).rejects.toMatchObject({ kind: "engine" });
});

test("what the reader throws keeps its kind and its words, and others can be opened", async () => {
  const { client } = worker();
  const failure = client.open(Uint8Array.of(0).buffer, { name: "my scan" });
  await expect(failure).rejects.toMatchObject({ kind: "damaged", message: "my scan: byte 0 is wrong" });
  await expect(failure).rejects.toHaveProperty("remedy", expect.stringContaining("meshfront build"));
  await expect(client.open(good())).resolves.toBeDefined();
});

test("one view at a time, and the latest wins", async () => {
  const { client, views } = worker();
  await client.open(good());
  const frames = await Promise.all([1, 2, 3, 4].map((x) => client.adapt(at(x), LIMITS)));
  expect(views.map((view) => view.eye[0])).toEqual([1, 4]);
  expect(frames.map((frame) => frame?.[0]!.vertices.positions[0])).toEqual([1, undefined, undefined, 4]);
  const last = await client.adapt(at(5), LIMITS);
  expect(last?.[0]!.vertices.positions[0]).toBe(5);
});

test("while a file arrives the models that are there go on", async () => {
  vi.stubGlobal("document", { baseURI: "http://localhost/" });
  let arrive = (_: Response) => {};
  const { client } = worker({}, () => new Promise((resolve) => { arrive = resolve; }));
  await client.open(good());
  const slow = client.open("slow.front");
  await expect(client.adapt(at(1), LIMITS)).resolves.toHaveLength(1);
  arrive(new Response(good()));
  await expect(slow).resolves.toBeDefined();
  vi.unstubAllGlobals();
});

test("an engine that breaks down fails the call, not the line", async () => {
  let broken = true;
  const { client } = worker({
    adapt: (_, views) => {
      if (broken) throw new WebAssembly.RuntimeError("unreachable");
      return views.map(({ views: [view] }) => frameOf(view!));
    },
  });
  await client.open(good());
  await expect(client.adapt(at(1), LIMITS)).rejects.toMatchObject({ kind: "engine", message: "unreachable" });
  broken = false;
  await expect(client.adapt(at(1), LIMITS)).resolves.toBeDefined();
});

test("disposing rejects what is on its way and what waits", async () => {
  const { client, port } = worker();
  await client.open(good());
  const [first, second] = [client.adapt(at(1), LIMITS), client.adapt(at(2), LIMITS)];
  client.dispose();
  await expect(first).rejects.toMatchObject({ kind: "closed" });
  await expect(second).rejects.toMatchObject({ kind: "closed" });
  await expect(client.adapt(at(3), LIMITS)).rejects.toMatchObject({ kind: "closed" });
  expect(port.terminate).toHaveBeenCalledOnce();
});

test("giving up while the file arrives: nobody keeps the model", async () => {
  vi.stubGlobal("document", { baseURI: "http://localhost/" });
  let arrive = (_: Response) => {};
  const { client, close } = worker({}, () => new Promise((resolve) => { arrive = resolve; }));
  const leaving = new AbortController();
  const opening = client.open("slow.front", { signal: leaving.signal });
  leaving.abort();
  await expect(opening).rejects.toMatchObject({ kind: "closed" });
  await new Promise((soon) => setTimeout(soon, 20));
  arrive(new Response(good()));
  await vi.waitFor(() => expect(close).toHaveBeenCalledWith(7));
  vi.unstubAllGlobals();
});

test("a worker that does not start is an engine error", async () => {
  const { client, port } = worker();
  const opening = client.open(good());
  port.onerror?.({ message: "" } as ErrorEvent);
  await expect(opening).rejects.toMatchObject({ kind: "engine" });
});

test("clients of one worker overtake nobody but themselves", async () => {
  const asked: [number, number][] = [];
  const adapt = (group: number, views: ModelView[]) => {
    asked.push([group, views[0]!.views[0]!.eye[0]]);
    return views.map(({ views }) => frameOf(views[0]!));
  };
  const { client } = worker({ adapt });
  await client.open(good());
  const beside = new MeshfrontClient(client);
  expect([beside.isBeside(client), beside.isBeside(worker().client)]).toEqual([true, false]);
  const answers = [
    client.adapt(at(1), LIMITS), beside.adapt(at(2), LIMITS), client.adapt(at(3), LIMITS), beside.adapt(at(4), LIMITS), client.adapt(at(5), LIMITS),
  ];
  const frames = await Promise.all(answers);
  expect(frames.map((frame) => frame !== undefined)).toEqual([true, true, false, true, true]);
  expect(asked).toEqual([[0, 1], [1, 2], [0, 5], [1, 4]]);
});

test("a client that goes leaves its group, and the others their worker", async () => {
  vi.stubGlobal("document", { baseURI: "http://localhost/" });
  let send = () => {};
  const arrives = new Promise<Response>((resolve) => { send = () => resolve(new Response(good())); });
  const { client, leave, open, port } = worker({}, () => arrives);
  await client.open(good());
  const [beside, third] = [new MeshfrontClient(client), new MeshfrontClient(client)];
  const [waiting, other] = [beside.adapt(at(1), LIMITS), client.adapt(at(2), LIMITS)];
  beside.dispose();
  beside.dispose();
  await expect(waiting).rejects.toMatchObject({ kind: "closed" });
  await expect(beside.memory()).rejects.toMatchObject({ kind: "closed" });
  await expect(other).resolves.toHaveLength(1);
  expect(leave.mock.calls).toEqual([[1]]);
  expect(port.terminate).not.toHaveBeenCalled();
  // What was on its way when it left is not opened for nobody.
  const opening = third.open("slow.front");
  third.dispose();
  await expect(opening).rejects.toMatchObject({ kind: "closed" });
  vi.unstubAllGlobals();
  await vi.waitFor(() => expect(leave).toHaveBeenCalledTimes(2));
  send();
  await new Promise((soon) => setTimeout(soon, 20));
  await client.memory();
  expect(open).toHaveBeenCalledTimes(1);
  client.dispose();
  expect(port.terminate).toHaveBeenCalledOnce();
  await expect(client.memory()).rejects.toMatchObject({ kind: "closed" });
});
