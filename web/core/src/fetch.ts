import { MeshfrontError } from "./errors.js";

/** Bytes so far, and of the whole where the server says so. `start` puts the first of them together, until there are many. */
export type Arrival = (loaded: number, total: number | undefined, start: () => Uint8Array | undefined) => void;

/** Base meshes, and the coarsest heights of terrains, lie within so many bytes of most files. */
const START = 1 << 20;

/**
 * Fetches a file, telling how far it is. Never holds more than twice what arrived, whatever the server promises.
 *
 * @throws MeshfrontError `missing` (404, 410), `refused` (other statuses), `network` (no or broken answer)
 */
export async function fetchBytes(url: string, onArrival: Arrival, fetcher: typeof fetch = fetch): Promise<Uint8Array> {
  let response: Response;
  try {
    response = await fetcher(url);
  } catch (cause) {
    throw new MeshfrontError("network", `${url} cannot be reached`, { cause });
  }
  if (response.status === 404 || response.status === 410) {
    throw new MeshfrontError("missing", `${url} does not exist (HTTP ${response.status})`);
  }
  if (!response.ok) throw new MeshfrontError("refused", `${url} was refused (HTTP ${response.status})`);

  // A compressed transfer announces its compressed length, which says nothing about what arrives here.
  const announced = response.headers.has("content-encoding") ? null : response.headers.get("content-length");
  const total = announced === null ? undefined : Number(announced);
  const chunks: Uint8Array[] = [];
  let loaded = 0;
  const start = () => (loaded > 0 && loaded <= START ? joined(chunks, loaded) : undefined);
  onArrival(0, total, start);
  try {
    const reader = response.body?.getReader();
    for (let part = await reader?.read(); part?.value; part = await reader?.read()) {
      chunks.push(part.value);
      loaded += part.value.length;
      onArrival(loaded, total, start);
    }
  } catch (cause) {
    throw new MeshfrontError("network", `${url} broke off after ${loaded} bytes`, { cause });
  }
  try {
    return joined(chunks, loaded);
  } catch (cause) {
    throw new MeshfrontError("memory", `${url} has ${loaded} bytes, more than there is memory for`, { cause });
  }
}

function joined(chunks: Uint8Array[], length: number): Uint8Array {
  const bytes = new Uint8Array(length);
  let at = 0;
  for (const chunk of chunks) {
    bytes.set(chunk, at);
    at += chunk.length;
  }
  return bytes;
}
