// Bundles the page: node build.mjs OUTPUT_DIR
import { build } from "esbuild";
import { copyFile, mkdir } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url));
const out = path.resolve(process.argv[2] ?? "dist");

await mkdir(out, { recursive: true });
await build({
  // viewer.js and viewer.css
  entryPoints: [
    { in: path.join(here, "src/main.ts"), out: "viewer" },
    { in: path.join(here, "viewer.css"), out: "viewer" },
  ],
  outdir: out,
  bundle: true,
  format: "esm",
  // What WebXR headsets and the browsers of Debian 12 understand.
  target: ["es2020"],
  minify: true,
  loader: { ".glsl": "text" },
  legalComments: "eof", // licences of the libraries inside
  logLevel: "warning",
});
await copyFile(path.join(here, "index.html"), path.join(out, "index.html"));
