// Tests of the page in a real browser:
//
//   node browser/run.mjs BIN_DIR REPORTS_DIR
//
// BIN_DIR holds Raywalk's programs, which make small reports of a virtual room; REPORTS_DIR holds more,
// of other tests. The browser is $CHROMIUM, or Debian's; without one, the tests are skipped (status 77).
import { execFileSync, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

const SKIPPED = 77;
const USAGE_ERROR = 2;

const here = path.dirname(fileURLToPath(import.meta.url));
const [bin, reports] = process.argv.slice(2).map((folder) => path.resolve(folder));
if (!reports) {
  console.error("Usage: node browser/run.mjs BIN_DIR REPORTS_DIR");
  process.exit(USAGE_ERROR);
}
const chromium = process.env.CHROMIUM ?? "/usr/bin/chromium";
if (!existsSync(chromium)) {
  console.log(`Skipped: there is no ${chromium} (Debian package chromium).`);
  process.exit(SKIPPED);
}

const folder = mkdtempSync(path.join(os.tmpdir(), "raywalk-report-tests-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.on(signal, () => process.exit(1));
makeReports();
const found = [...htmlBelow(folder), ...(existsSync(reports) ? htmlBelow(reports) : [])];
const tests = readdirSync(here).filter((file) => file.endsWith(".test.mjs"));
const run = spawnSync(process.execPath, ["--test", ...tests], {
  cwd: here,
  env: { ...process.env, CHROMIUM: chromium, RAYWALK_REPORTS: JSON.stringify(found) },
  stdio: "inherit",
});
process.exit(run.status ?? 1);

function makeReports() {
  const at = (name) => path.join(folder, name);
  const raywalk = (program, ...options) =>
    execFileSync(path.join(bin, `raywalk-${program}`), options, {
      stdio: ["ignore", "ignore", "pipe"],
    });
  writeFileSync(at("room.yaml"), "grid: {spacing_mm: 200, overhang_share: 0.2}\n");
  const small = ["--width", "256", "--truth-views", "2"];
  raywalk("simulate", "room", at("room.yaml"), "--out", at("capture"), ...small, "-q");
  const room = at("room.lf");
  raywalk("build-lf", "pack", "--frames", at("capture/poses.csv"), "--out", room, "-q");
  raywalk("build-lf", "depth", room, "--width", "128", "-q");
  mkdirSync(at("reports"));
  const report = (name) => ["--report", at(`reports/${name}`)];
  raywalk("build-lf", "require", room, ...report("require"));
  const truth = ["--truth", at("capture/gt.csv")];
  raywalk("render", "trade", room, ...truth, "--repetitions", "1", ...report("trade"));
  raywalk("render", "error-model", "--viewpoints", "9", ...report("error-model"));
  raywalk("capture", "plan", "capture-osc", ...report("plan.html"));
}

function htmlBelow(root) {
  return readdirSync(root, { withFileTypes: true })
    .flatMap((entry) => {
      const name = path.join(root, entry.name);
      if (entry.isDirectory()) return htmlBelow(name);
      return name.endsWith(".html") ? [name] : [];
    })
    .sort();
}
