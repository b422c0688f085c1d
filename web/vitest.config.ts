import { defineConfig } from "vitest/config";

export default defineConfig({ test: { include: ["{core,three,viewer}/test/**/*.test.ts"] } });
