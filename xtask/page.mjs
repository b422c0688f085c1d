// The page in a headless Chromium:
//
//   node xtask/page.mjs --meshfront BINARY --chromium PROGRAM (--screenshot OUT.png | --fly-by) FILE.front
//
// serves FILE with the binary, waits until the picture is all that the view asks for, and then writes a screenshot, or
// flies once around the model in the worker and prints its report as JSON.

import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

const web = join(dirname(fileURLToPath(import.meta.url)), "../web/package.json");
const { chromium } = createRequire(web)("@playwright/test");

const text = { type: "string" };
const { values: options, positionals: [front] } = parseArgs({
  allowPositionals: true,
  options: { meshfront: text, chromium: text, screenshot: text, credit: text, "fly-by": { type: "boolean" } },
});

// Drawing is in software where there is no GPU: a large model takes seconds to settle on a busy machine.
const PATIENCE_MS = 120_000;

const credit = options.credit ? ["--credit", options.credit] : [];
const server = spawn(options.meshfront, ["view", front, "--no-open", "--port", "0", ...credit], {
  stdio: ["ignore", "pipe", "inherit"],
});
const ended = new Promise((_, reject) => {
  server.once("error", reject);
  server.once("exit", (code) => reject(new Error(`meshfront view ended with ${code}`)));
});
let browser;
try {
  const address = await Promise.race([
    new Promise((resolve) => createInterface({ input: server.stdout }).once("line", resolve)),
    ended,
  ]);
  browser = await chromium.launch({
    executablePath: options.chromium,
    args: [
      "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking",
      "--disable-component-update", "--disable-sync", "--no-first-run",
    ],
  });
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  await page.goto(address.trim(), { timeout: PATIENCE_MS });
  const stats = await settled(page).catch(async (error) => {
    const shown = await page.locator("[role=alert]").allInnerTexts().catch(() => []);
    throw new Error([`the page did not settle: ${error.message}`, ...complaints, ...shown].join("\n"));
  });
  if (options["fly-by"]) {
    console.log(JSON.stringify(await page.evaluate(() => window.meshfront.flyBy())));
  } else {
    await page.screenshot({ path: options.screenshot });
    console.log(JSON.stringify(stats));
  }
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
} finally {
  await browser?.close();
  ended.catch(() => {});
  server.kill("SIGINT");
}

async function settled(page) {
  await page.waitForFunction(() => window.meshfront?.info(), undefined, { timeout: PATIENCE_MS });
  const late = new Promise((_, reject) => setTimeout(() => reject(new Error("it took too long")), PATIENCE_MS).unref());
  return Promise.race([page.evaluate(() => window.meshfront.settled()), late]);
}
