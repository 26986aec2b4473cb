// A room of which only a part fits into the page's budget.
import assert from "node:assert/strict";
import { pageTest } from "./support/page_test.mjs";
import { holes, psnr } from "./support/pictures.mjs";
import { place } from "./support/place.mjs";
import { drawn, goTo, picture, progress } from "./support/viewer.mjs";

const MOST_HOLES = 0.01;
/** Along x = 0, from where the right cell begins. */
const BORDER_M = 0.001;
const BEYOND_BORDER_M = [BORDER_M, 0.1, 0.3];

/** RGBA pictures, fine and coarse, and 16 bits of inverse distance. */
function stationBytes({ panorama, distances }) {
  const pixels = (width_px) => width_px ** 2 / 2;
  const colours = pixels(panorama.width_px) + pixels(panorama.coarse_width_px);
  return 4 * colours + 2 * pixels(distances.width_px);
}

/** Adds up what array textures the page asks for. */
const COUNT_LAYERS = () => {
  window.arrayLayers = [];
  const { texStorage3D, texImage3D } = WebGL2RenderingContext.prototype;
  Object.assign(WebGL2RenderingContext.prototype, {
    texStorage3D(target, levels, format, width, height, depth) {
      window.arrayLayers.push(depth);
      return texStorage3D.call(this, target, levels, format, width, height, depth);
    },
    texImage3D(...parameters) {
      window.arrayLayers.push(parameters[5]);
      return texImage3D.apply(this, parameters);
    },
  });
};

/** The room whose budget holds the stations of one cell's lines, and no more. */
async function hostOfOneCell(visit) {
  const host = await visit.host("cells");
  const manifest = JSON.parse(await host.read("/manifest.json"));
  const counts = manifest.lines.map((line) => line.stations.length);
  const sum = (numbers) => numbers.reduce((total, each) => total + each, 0);
  const of_cell = sum(manifest.cells[0].lines.map((line) => counts[line]));
  manifest.budget_mb = ((of_cell + 0.5) * stationBytes(manifest)) / 1e6;
  host.replaced.set("/manifest.json", Buffer.from(JSON.stringify(manifest)));
  return { host, of_cell, stations: sum(counts) };
}

pageTest("crosses from cell to cell without a hole or a jump", async (visit) => {
  const { host, of_cell, stations } = await hostOfOneCell(visit);
  const page = await visit.open(host, place({ x: -0.5 }), { init_script: COUNT_LAYERS });
  await drawn(page);
  const { wanted } = await progress(page);
  assert.ok(wanted === of_cell && wanted < stations, `${wanted} of ${stations}`);

  const db = [];
  for (const yaw of [0, 90, 180, -90]) {
    await goTo(page, place({ x: -BORDER_M, z: 0.1, yaw }));
    const before = await picture(page);
    await goTo(page, place({ x: BORDER_M, z: 0.1, yaw }));
    const after = await picture(page);
    assert.ok(Math.max(holes(before), holes(after)) < MOST_HOLES, "a hole");
    db.push(psnr(before, after));
  }
  console.log(`across the border: ${db.map((value) => value.toFixed(1)).join(" ")} dB`);
  assert.ok(Math.min(...db) > 30, `${db} dB`);
  assert.equal((await progress(page)).wanted, wanted);
  const layers = await page.evaluate(() => window.arrayLayers);
  assert.ok(layers.length >= 3 && Math.max(...layers) <= wanted, `layers ${layers}`);
});

pageTest("shows the next cell from what is there while it is being read", async (visit) => {
  const { host } = await hostOfOneCell(visit);
  const page = await visit.open(host, place({ x: -0.3, yaw: 90 }));
  await drawn(page);
  let read;
  const held = new Promise((resolve) => (read = resolve));
  host.before = () => held;
  const early = [];
  for (const x of BEYOND_BORDER_M) {
    await page.evaluate((at) => (location.hash = `#x=${at}&z=0&yaw=90`), x);
    await page.waitForFunction((at) => window.raywalk.viewer.pose.x_m === at, x);
    early.push(await picture(page));
  }
  assert.ok(Math.max(...early.map(holes)) < MOST_HOLES, "a hole");
  read();
  await drawn(page);
  const { fine, wanted } = await progress(page);
  assert.equal(fine, wanted);
  const db = [];
  for (const [i, x] of BEYOND_BORDER_M.entries()) {
    await goTo(page, place({ x, yaw: 90 }));
    db.push(psnr(early[i], await picture(page)));
  }
  console.log(`before the next cell is there: ${db.map((value) => value.toFixed(1)).join(" ")} dB`);
  assert.ok(Math.min(...db) > 25, `${db} dB`);
});
