import { defineConfig } from "vitest/config";

/** The page is served by `glasshelm bridge` from the package's own static folder. */
export default defineConfig({
  base: "./",
  build: {
    outDir: "../src/glasshelm/bridge/static",
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 1200,
  },
  server: { proxy: { "/ws": { target: "ws://127.0.0.1:8470", ws: true } } },
  test: { css: true },
});
