// Tests of the page in a real browser:
//
//   node browser/run.mjs BIN_DIR WHITE_ROOM_DIR [NAME...]
//
// BIN_DIR holds Raywalk's programs, which make the rooms; WHITE_ROOM_DIR is tests/data/white-room.
// With names, such as "agreement", only those files run. The browser is $CHROMIUM, or Debian's;
// without one, the tests are skipped (status 77).
import { spawn } from "node:child_process";
import { existsSync, rmSync } from "node:fs";
import { mkdtemp, readdir } from "node:fs/promises";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { SETUP_VARIABLE } from "./support/setup.mjs";

const SKIPPED = 77;
const INTERRUPTED = 130;
const USAGE_ERROR = 2;

const here = path.dirname(fileURLToPath(import.meta.url));
const [bin_argument, white_room, ...names] = process.argv.slice(2);
if (!white_room) {
  console.error("Usage: node browser/run.mjs BIN_DIR WHITE_ROOM_DIR [NAME...]");
  process.exit(USAGE_ERROR);
}
const bin = path.resolve(bin_argument); // the tests run in another folder
const executable = process.env.CHROMIUM ?? "/usr/bin/chromium";
if (!existsSync(executable)) {
  console.log(`Skipped: there is no ${executable} (Debian package chromium).`);
  process.exit(SKIPPED);
}

const { launchBrowser } = await import("./support/browser.mjs");
const { makeRooms } = await import("./support/rooms.mjs");

const folder = await mkdtemp(path.join(os.tmpdir(), "raywalk-browser-tests-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) {
  process.on(signal, () => process.exit(INTERRUPTED));
}

const started_ms = performance.now();
await makeRooms(bin, white_room, folder);
console.log(`Made the rooms in ${((performance.now() - started_ms) / 1000).toFixed(1)} s`);
const browser = await launchBrowser(executable);
const status = await runTests({ bin, folder, browser: browser.wsEndpoint() });
await browser.close();
process.exit(status);

/** Node's test runner in a process of its own, with what the tests need to know. */
async function runTests(setup) {
  const tests = (await readdir(here))
    .filter((file) => file.endsWith(".test.mjs"))
    .filter((file) => names.length === 0 || names.includes(file.replace(".test.mjs", "")))
    .sort();
  if (tests.length === 0) throw new Error(`no tests named ${names.join(", ")}`);
  const runner = spawn(process.execPath, ["--test", ...tests], {
    cwd: here,
    env: { ...process.env, [SETUP_VARIABLE]: JSON.stringify(setup) },
    stdio: "inherit",
  });
  process.on("exit", () => runner.kill());
  return new Promise((resolve) => runner.on("exit", (code) => resolve(code ?? 1)));
}
