import { existsSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { defineConfig } from "@playwright/test";

// Playwright's own download is the last resort: most machines have a browser.
const installed = [
  process.env.MESHFRONT_CHROMIUM,
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
  "/usr/bin/google-chrome-stable",
  "/snap/bin/chromium",
  "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
  "/Applications/Chromium.app/Contents/MacOS/Chromium",
  "C:/Program Files/Google/Chrome/Application/chrome.exe",
].find((path) => path !== undefined && existsSync(path));

export default defineConfig({
  testDir: ".",
  outputDir: "results",
  reporter: "list",
  // Pictures are drawn in software where there is no graphics card: one page at a time, and patience.
  workers: 1,
  timeout: 180_000,
  expect: { timeout: 30_000 },
  globalSetup: fileURLToPath(new URL("setup.ts", import.meta.url)),
  use: {
    viewport: { width: 800, height: 600 },
    deviceScaleFactor: 1,
    launchOptions: {
      ...(installed ? { executablePath: installed } : {}),
      args: [
        "--no-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--no-first-run",
      ],
    },
  },
});
