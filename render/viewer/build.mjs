// Bundles the page: node build.mjs OUTPUT_DIR
import { build } from "esbuild";
import { copyFile, mkdir } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url));
const out = path.resolve(process.argv[2] ?? "dist");

await mkdir(out, { recursive: true });
await build({
  entryPoints: [path.join(here, "src/main.ts")],
  outfile: path.join(out, "viewer.js"),
  bundle: true,
  format: "esm",
  // What WebXR headsets and the browsers of Debian 12 understand.
  target: ["es2020"],
  minify: true,
  loader: { ".glsl": "text" },
  legalComments: "eof", // licences of the libraries inside
  logLevel: "warning",
});
for (const file of ["index.html", "viewer.css"]) {
  await copyFile(path.join(here, file), path.join(out, file));
}
