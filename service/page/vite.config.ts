import { createHash } from "node:crypto";
import { copyFileSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
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

/** The reference of the API comes from npm too, so that the service needs no other host. */
function copyApiReference(): Plugin {
  return {
    name: "copy-api-reference",
    closeBundle() {
      const from = join(here, "node_modules/swagger-ui-dist");
      const to = join(out, "docs");
      mkdirSync(to, { recursive: true });
      for (const name of ["swagger-ui-bundle.js", "swagger-ui.css", "LICENSE"]) {
        copyFileSync(join(from, name), join(to, name));
      }
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
  plugins: [copyApiReference(), recordSources()],
  server: { proxy: { "/v1": "http://127.0.0.1:8000" } },
});
