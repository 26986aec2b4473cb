// Runs the unit tests of the page in the current folder: node ../test.mjs. Each src/**/*.test.ts is
// bundled into a temporary folder, since Node 18 reads no TypeScript, and given to Node's own test runner.
import { build } from "esbuild";
import { spawnSync } from "node:child_process";
import { mkdtemp, readdir, rm } from "node:fs/promises";
import os from "node:os";
import path from "node:path";

const here = process.cwd();

async function testsBelow(folder) {
  const entries = await readdir(folder, { withFileTypes: true });
  const found = await Promise.all(
    entries.map((entry) => {
      const name = path.join(folder, entry.name);
      if (entry.isDirectory()) return testsBelow(name);
      return entry.name.endsWith(".test.ts") ? [name] : [];
    }),
  );
  return found.flat().sort();
}

const entryPoints = await testsBelow(path.join(here, "src"));
if (entryPoints.length === 0) {
  console.error("test.mjs: no tests below src");
  process.exit(1);
}
const out = await mkdtemp(path.join(os.tmpdir(), "raywalk-page-tests-"));
let status = 1;
try {
  await build({
    entryPoints,
    outdir: out,
    outbase: path.join(here, "src"),
    outExtension: { ".js": ".mjs" },
    bundle: true,
    platform: "node",
    format: "esm",
    target: ["node18"],
    external: ["node:*"],
    loader: { ".glsl": "text" },
    sourcemap: "inline",
    logLevel: "warning",
  });
  const bundled = entryPoints.map((file) =>
    path.join(out, path.relative(path.join(here, "src"), file)).replace(/\.ts$/, ".mjs"),
  );
  const run = spawnSync(process.execPath, ["--enable-source-maps", "--test", ...bundled], {
    stdio: "inherit",
  });
  status = run.status ?? 1;
} finally {
  await rm(out, { recursive: true, force: true });
}
process.exit(status);
