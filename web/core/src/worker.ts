/** The worker's whole program. */

import { startEngine } from "./engine.js";
import { serve } from "./host.js";
import type { Port, Reply, Request } from "./protocol.js";

// At once: WebAssembly is compiled while the page finds out what to open. Who asks is told what fails.
const engine = startEngine();
engine.catch(() => {});
serve(self as unknown as Port<Reply, Request>, () => engine);
