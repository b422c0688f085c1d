import { defineConfig } from "vite";

export default defineConfig({
  // The page may live under any path of any server.
  base: "./",
  worker: { format: "es" },
  build: { target: "es2022", chunkSizeWarningLimit: 900, assetsInlineLimit: 0 },
});
