/** Client and host, joined by a real message channel; the engine between them is a script that can be held. */

import { afterEach, expect, test, vi } from "vitest";
import { MeshfrontClient, type WorkerPort } from "../src/client.js";
import { serve, type Engine } from "../src/host.js";
import type { Port, Reply, Request } from "../src/protocol.js";
import type { FrameUpdate, ModelInfo, View } from "../src/view.js";

const VIEW: View = {
  eye: [0, 0, 5], target: [0, 0, 0], up: [0, 1, 0], fovY: 1, width: 100, height: 100, near: 0.1,
  tolerancePx: 1, maxTriangles: Infinity, deadlineMs: 5, frustum: true, orientation: true,
};
const at = (x: number): View => ({ ...VIEW, eye: [x, 0, 5] });

const INFO = { updates: 3, bytes: 4 } as ModelInfo;

function frameOf(view: View): FrameUpdate {
  return {
    vertexSlots: 1,
    triangleSlots: 1,
    vertices: {
      ranges: Uint32Array.of(0, 1),
      positions: Float32Array.from(view.eye),
      normals: new Int16Array(4),
      colors: new Uint8Array(0),
      levels: new Uint8Array(1),
    },
    triangles: { ranges: Uint32Array.of(0, 1), corners: new Uint32Array(3) },
    stats: {
      triangles: 1, refined: 1, coarsened: 0, evaluations: 1, engineMs: 0, gatherMs: 0, settled: true, budgetBound: false,
      errorPx: 0, uploadBytes: 33,
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
  const adapt = (view: View) => {
    views.push(view);
    return frameOf(view);
  };
  const load = vi.fn(async (bytes: Uint8Array, name: string) => {
    if (bytes[0] !== 77) throw Object.assign(new Error(`${name}: byte 0 is wrong`), { name: "damaged" });
    return { info: INFO, adapt, flyBy: () => { throw new Error("no"); }, ...engine } as Engine;
  });
  serve(channel.port2 as unknown as Port<Reply, Request>, load, fetcher);
  const port = channel.port1 as unknown as WorkerPort;
  port.terminate = vi.fn(() => channel.port1.close());
  return { startWorker: () => port, views, load, port };
}
const good = () => Uint8Array.of(77, 1, 2, 3).buffer;

test("opens bytes, which are handed over and not copied", async () => {
  const { startWorker, load } = worker();
  const bytes = good();
  const client = await MeshfrontClient.open(bytes, { startWorker });
  expect(client.info).toEqual(INFO);
  expect(load).toHaveBeenCalledOnce();
  expect(bytes.byteLength).toBe(0);
});

test("opens an address, and tells how far it is", async () => {
  vi.stubGlobal("document", { baseURI: "http://localhost/page/" });
  const asked: string[] = [];
  const fetcher = (async (url: string) => {
    asked.push(url);
    return new Response(good(), { headers: { "content-length": "4" } });
  }) as typeof fetch;
  const { startWorker } = worker({}, fetcher);
  const seen: number[] = [];
  await MeshfrontClient.open("a.front", { startWorker, onProgress: (loaded) => seen.push(loaded) });
  vi.unstubAllGlobals();
  expect(asked).toEqual(["http://localhost/page/a.front"]);
  expect(seen).toEqual([0, 4]);
});

test("what the reader throws keeps its kind and its words, and the worker ends", async () => {
  const { startWorker, port } = worker();
  const failure = MeshfrontClient.open(Uint8Array.of(0).buffer, { startWorker, name: "my scan" });
  await expect(failure).rejects.toMatchObject({ kind: "damaged", message: "my scan: byte 0 is wrong" });
  await expect(failure).rejects.toHaveProperty("remedy", expect.stringContaining("meshfront build"));
  expect(port.terminate).toHaveBeenCalledOnce();
});

test("one view at a time, and the latest wins", async () => {
  const { startWorker, views } = worker();
  const client = await MeshfrontClient.open(good(), { startWorker });
  const frames = await Promise.all([1, 2, 3, 4].map((x) => client.adapt(at(x))));
  expect(views.map((view) => view.eye[0])).toEqual([1, 4]);
  expect(frames.map((frame) => frame?.vertices.positions[0])).toEqual([1, undefined, undefined, 4]);
  const last = await client.adapt(at(5));
  expect(last?.vertices.positions[0]).toBe(5);
});

test("an engine that breaks down fails the call, not the line", async () => {
  let broken = true;
  const { startWorker } = worker({
    adapt: (view) => {
      if (broken) throw new WebAssembly.RuntimeError("unreachable");
      return frameOf(view);
    },
  });
  const client = await MeshfrontClient.open(good(), { startWorker });
  await expect(client.adapt(VIEW)).rejects.toMatchObject({ kind: "engine", message: "unreachable" });
  broken = false;
  await expect(client.adapt(VIEW)).resolves.toBeDefined();
});

test("disposing rejects what is on its way and what waits", async () => {
  const { startWorker, port } = worker();
  const client = await MeshfrontClient.open(good(), { startWorker });
  const [first, second] = [client.adapt(at(1)), client.adapt(at(2))];
  client.dispose();
  await expect(first).rejects.toMatchObject({ kind: "closed" });
  await expect(second).rejects.toMatchObject({ kind: "closed" });
  await expect(client.adapt(at(3))).rejects.toMatchObject({ kind: "closed" });
  expect(port.terminate).toHaveBeenCalledOnce();
});

test("giving up while the file arrives", async () => {
  vi.stubGlobal("document", { baseURI: "http://localhost/" });
  const { startWorker, port } = worker({}, () => new Promise(() => {}));
  const leaving = new AbortController();
  const opening = MeshfrontClient.open("slow.front", { startWorker, signal: leaving.signal });
  leaving.abort();
  await expect(opening).rejects.toMatchObject({ kind: "closed" });
  vi.unstubAllGlobals();
  expect(port.terminate).toHaveBeenCalledOnce();
});

test("a worker that does not start is an engine error", async () => {
  const { startWorker, port } = worker();
  const opening = MeshfrontClient.open(good(), { startWorker: () => {
    const started = startWorker();
    queueMicrotask(() => port.onerror?.({ message: "" } as ErrorEvent));
    return started;
  } });
  await expect(opening).rejects.toMatchObject({ kind: "engine" });
});
