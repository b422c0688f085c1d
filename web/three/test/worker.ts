/** The real engine behind a message channel, as a worker has it, and small real files. */

import { readFileSync } from "node:fs";
import type { WorkerPort } from "@meshfront/core";
import { startEngine } from "../../core/src/engine.js";
import { serve } from "../../core/src/host.js";
import { limited } from "../../core/test/limited.js";
import type { Port, Reply, Request } from "../../core/src/protocol.js";
import { MeshfrontBudget, type BudgetOptions } from "../src/budget.js";

const wasm = readFileSync(new URL("../../core/wasm/meshfront_wasm_bg.wasm", import.meta.url));

/** A `.front` file of the fixtures. */
export function fixture(name: string): ArrayBuffer {
  return Uint8Array.from(readFileSync(new URL(`../../../testdata/front/${name}.front`, import.meta.url))).buffer;
}

/** A budget whose worker is in this process; its engine gets so many bytes of memory at most. */
export function localBudget(options: BudgetOptions = {}, most?: number): MeshfrontBudget {
  const worker = () => {
    const { port1, port2 } = new MessageChannel();
    serve(port2 as unknown as Port<Reply, Request>, () => startEngine(most === undefined ? wasm : limited(wasm, most)));
    return Object.assign(port1, { terminate: () => { port1.close(); port2.close(); } }) as unknown as WorkerPort;
  };
  return new MeshfrontBudget({ deadlineMs: 1000, ...options, worker });
}
