// What the page computes from a document.
import assert from "node:assert/strict";
import { test } from "node:test";
import { openDocument, rowsOf } from "./support.mjs";

const scores = (psnr_db) => ({ psnr_db, ws_psnr_db: psnr_db, ssim: 0.5, fsim: 0.5 });
const view = (method, psnr_db) => ({
  name: "<b>centre</b>",
  method,
  x_m: 0,
  z_m: 0,
  line_distance_m: 0.5,
  ...scores(psnr_db),
  limited_corners: 0,
  filled_share: 0.25,
  unseen_share: 0,
  empty_share: 0,
  render_ms: 3,
});
const quarter = (method, psnr_db) => ({ ...view(method, psnr_db), line_distance_m: 0.25 });
const error = (method, k_deg, e_connect) => ({
  connection: "hybrid",
  method,
  k_deg,
  e_connect,
  e_connect_common: e_connect,
  coverage: 1,
});
const mode = (method, psnr_db) => ({
  method,
  connection: "hybrid",
  k_deg: 90,
  k_source: "given",
  overlap_deg: 5,
  ...scores(psnr_db),
  median_render_ms: 3,
});
const validation = () => ({
  volume: "room.lf",
  distances: "given",
  captured_width_px: 512,
  truths: 1,
  widest_truth_px: 1024,
  modes: [mode("initial", 20), mode("hlf-vd", 30)],
  views: [view("initial", 20), view("hlf-vd", 30)],
  quarters: [quarter("initial", 19), quarter("hlf-vd", 31)],
  connection: { viewpoints: 5, overlap_deg: 5, common_share: 0.6, comparable: true },
  connection_error: [
    error("initial", 45, 9),
    error("initial", 90, 7),
    error("hlf-vd", 45, 2),
    error("hlf-vd", 90, 3),
  ],
});

test("a validation finds the best method, gains and the least E_connect", async () => {
  const page = await openDocument("validation", validation());
  const text = await page.locator("main").textContent();
  assert.match(text, /mean PSNR, hlf-vd30 dB/);
  assert.match(text, /gain over initial views10 dB/);
  assert.match(text, /enlarged 2 times/);
  assert.match(text, /<b>centre<\/b>/, "what a user named is no markup");
  const gain = page.locator("#gain-in-psnr-over-initial-views");
  await gain.locator("summary").click();
  const cells = gain.locator("tbody td");
  assert.deepEqual(await cells.allTextContents(), ["hlf-vd", "<b>centre</b>", "25", "12"]);
  const least = await page.locator("#how-well-neighbouring-lines-connect .best").allTextContents();
  assert.deepEqual(least, ["7", "2"]);
});

const setting = (number, change, ratio, psnr_db, on_front) => ({
  number,
  name: "hlf-vd",
  method: "hlf-vd",
  k_deg: 90,
  overlap_deg: 5,
  threads: 2,
  ms: ratio,
  ratio,
  remap_spread: 0.1,
  ...scores(psnr_db),
  on_front,
  ...change,
});

test("a trade finds its front and the effect of each parameter alone", async () => {
  const page = await openDocument("trade", {
    room: "room.lf",
    machine: { threads: 2, cpu: "cpu" },
    width_px: 512,
    remap_ms: 1,
    repetitions: 1,
    busy: true,
    views: ["a", "b"],
    parameters: [{ key: "k_deg" }, { key: "overlap_deg" }],
    presets: [{ name: "fast", number: 2, reason: "near surfaces" }],
    distances: "none",
    settings: [
      setting(1, {}, 4, 30, true),
      setting(2, { name: "k 80", k_deg: 80 }, 5, 28, false),
      setting(3, { name: "k 80, overlap 9", k_deg: 80, overlap_deg: 9 }, 2, 25, true),
      setting(4, { name: "one thread", threads: 1 }, 6, 30, false),
    ],
  });
  const text = await page.locator("main").textContent();
  assert.match(text, /fastest: setting 325 dB in 2 ms/);
  assert.match(text, /most accurate: setting 130 dB in 4 ms/);
  assert.match(text, /Other programs were busy/);
  assert.match(text, /The room has no distances/);
  const front = (await rowsOf(page, "Settings on the front")).map(([name]) => name);
  assert.deepEqual(front, ["3 · k 80, overlap 9", "1 · hlf-vd"]);
  const alone = await rowsOf(page, "Against hlf-vd");
  const effects = alone.map((row) => row.slice(0, 4).join(", "));
  assert.deepEqual(effects, ["2 · k 80, 5, 25, -2", "4 · one thread, 6, 50, 0"]);
  const preset = page.locator("#presets tbody td");
  assert.equal((await preset.allTextContents()).at(-1), "25", "slower than the setting as good");
});
