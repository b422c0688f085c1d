import { expect, test } from "vitest";
import { fetchBytes } from "../src/fetch.js";

const answer = (body: BodyInit | null, init?: ResponseInit) => async () => new Response(body, init);
const silent = () => {};

test("bytes arrive whole, and progress ends with all of them", async () => {
  const parts = [Uint8Array.of(1, 2), Uint8Array.of(3), Uint8Array.of(4, 5, 6)];
  const body = new ReadableStream({
    pull(controller) {
      const part = parts.shift();
      if (part) controller.enqueue(part);
      else controller.close();
    },
  });
  const seen: [number, number | undefined][] = [];
  const bytes = await fetchBytes(
    "x.front",
    (loaded, total) => seen.push([loaded, total]),
    answer(body, { headers: { "content-length": "6" } }),
  );
  expect([...bytes]).toEqual([1, 2, 3, 4, 5, 6]);
  expect(seen).toEqual([[0, 6], [2, 6], [3, 6], [6, 6]]);
});

test("the length of a compressed transfer is not taken for that of the file", async () => {
  const totals = new Set<number | undefined>();
  const headers = { "content-length": "6", "content-encoding": "gzip" };
  await fetchBytes("x.front", (_, total) => totals.add(total), answer("0123456789", { headers }));
  expect([...totals]).toEqual([undefined]);
});

test.each([
  [404, "missing"],
  [410, "missing"],
  [403, "refused"],
  [500, "refused"],
])("status %i is kind %s, and names the file", async (status, kind) => {
  await expect(fetchBytes("a/x.front", silent, answer("no", { status }))).rejects.toMatchObject({
    kind,
    message: expect.stringContaining("a/x.front"),
  });
});

test("no answer, and an answer that breaks off, are kind network", async () => {
  const unreachable = () => Promise.reject(new TypeError("fetch failed"));
  await expect(fetchBytes("x.front", silent, unreachable)).rejects.toMatchObject({ kind: "network" });
  let parts = 0;
  const broken = new ReadableStream({
    pull(controller) {
      if (parts++ === 0) controller.enqueue(new Uint8Array(10));
      else controller.error(new TypeError("connection reset"));
    },
  });
  await expect(fetchBytes("x.front", silent, answer(broken))).rejects.toMatchObject({
    kind: "network",
    message: expect.stringContaining("after 10 bytes"),
  });
});
