/** The worker's whole program. */

import { startEngine } from "./engine.js";
import { serve } from "./host.js";
import type { Port, Reply, Request } from "./protocol.js";

serve(self as unknown as Port<Reply, Request>, startEngine);
