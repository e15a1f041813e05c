import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { type Plugin, defineConfig } from "vite";

const here = import.meta.dirname;
const out = join(here, "../modallab/api/page/static");

/** Sources of the bundle; tests/service/api/page/test_bundle.py hashes the same files. */
function sources(): string[] {
  const nested = ["src", "public"]
    .flatMap((folder) => readdirSync(join(here, folder), { recursive: true, withFileTypes: true }))
    .filter((entry) => entry.isFile())
    .map((entry) => join(entry.parentPath, entry.name).slice(here.length + 1));
  return [...nested, "index.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts"].sort();
}

function recordSources(): Plugin {
  return {
    name: "record-sources",
    closeBundle() {
      const hash = createHash("sha256");
      for (const path of sources()) {
        hash.update(`${path}\0`).update(readFileSync(join(here, path))).update("\0");
      }
      writeFileSync(join(out, "sources.sha256"), `${hash.digest("hex")}\n`);
    },
  };
}

export default defineConfig({
  root: here,
  base: "./",
  publicDir: "public",
  build: {
    outDir: out,
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0, // a strict policy allows no data: fonts
    modulePreload: { polyfill: false },
  },
  plugins: [recordSources()],
  server: { proxy: { "/v1": "http://127.0.0.1:8000" } },
});
