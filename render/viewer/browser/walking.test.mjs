// Walking and looking as visitors do, with keys, pointer and address.
import assert from "node:assert/strict";
import { text } from "node:stream/consumers";
import { pageTest } from "./support/page_test.mjs";
import { contrast, psnr } from "./support/pictures.mjs";
import { place } from "./support/place.mjs";
import { drawn, goTo, openRoom, picture, pose } from "./support/viewer.mjs";

/** Of the room's two cells beside each other: z in -0.5..0.5, x in -1..1. */
const EDGE_M = 0.5;
const DEGREE_RAD = Math.PI / 180;

pageTest("walks by keys, softly to the edge, and looks around by dragging", async (visit) => {
  const page = await visit.show("cells", place({ x: -0.5, z: 0.3 }));
  await page.getByTestId("view").press("v");
  await page.keyboard.down("w");
  await page.waitForFunction((edge) => window.raywalk.viewer.pose.z_m > edge - 0.02, EDGE_M);
  await page.waitForTimeout(500);
  await page.keyboard.up("w");
  const at = await pose(page);
  assert.ok(at.z_m <= EDGE_M && Math.abs(at.x_m + 0.5) < 0.01, `stopped at ${at.x_m}, ${at.z_m}`);
  await page.waitForFunction(() => /z=0\.(49|50)/.test(location.hash));
  const saved = page.waitForEvent("download");
  await page.keyboard.press("v");
  const rows = (await text(await (await saved).createReadStream())).trim().split("\n");
  assert.equal(rows[0], "name,x,z,yaw,pitch,roll,time");
  const way = [rows[1], rows.at(-1)].map((row) => row.split(",").map(Number));
  assert.ok(Math.abs(way[0][2] - 0.3) < 1e-3 && way[1][2] > EDGE_M - 0.02 && way[1][6] > 0.5);

  const box = await page.getByTestId("view").boundingBox();
  await page.mouse.move(box.x + 150, box.y + 60);
  await page.mouse.down();
  await page.mouse.move(box.x + 50, box.y + 60, { steps: 4 });
  await page.mouse.up();
  // The scene follows the pointer: dragged to the left, one looks to the right.
  await page.waitForFunction(() => window.raywalk.viewer.pose.yaw_rad > 0.1);
});

pageTest("the picture follows the window's size", async (visit) => {
  const page = await visit.show("cells", place({}), { width: 240, height: 180 });
  await page.setViewportSize({ width: 200, height: 240 });
  await page.waitForFunction(() => document.querySelector("canvas").width === 200);
  await drawn(page);
  const shown = await picture(page);
  assert.deepEqual([shown.width, shown.height], [200, 240]);
  assert.ok(contrast(shown) > 10);
});

const HOSTILE = [
  "#x=1e999&z=NaN",
  "#x=99&z=-99&up=1e9&pitch=4000&yaw=Infinity",
  "#%E0%A4%A",
  "#k=-1&fov=0",
  "#method=__proto__&constructor=1&__proto__[x]=1",
  "#x=<img src=x onerror=alert(1)>&method=<script>alert(1)</script>",
];

pageTest("addresses that make no sense do no harm", async (visit) => {
  const there = place({ x: 0.2, z: -0.2, yaw: 30, pitch: 5, k: 60, method: "initial" });
  const page = await visit.show("cells", there);
  const opened = await pose(page);
  const angles = { yaw_rad: 30 * DEGREE_RAD, pitch_rad: 5 * DEGREE_RAD };
  for (const [key, value] of Object.entries({ x_m: 0.2, z_m: -0.2, ...angles })) {
    assert.ok(Math.abs(opened[key] - value) < 1e-3, `${key}: ${opened[key]}`);
  }
  const { method, k_deg } = await page.evaluate(() => window.raywalk.viewer.settings);
  assert.deepEqual([method, k_deg], ["initial", 60]);
  for (const hash of HOSTILE) {
    await page.evaluate((text) => void (location.hash = text), hash);
    await page.waitForTimeout(50);
    const { x_m, z_m, pitch_rad, ...others } = await pose(page);
    assert.ok(Math.abs(x_m) <= 2 * EDGE_M && Math.abs(z_m) <= EDGE_M, `${hash}: ${x_m}, ${z_m}`);
    assert.ok(Math.abs(pitch_rad) <= 90 * DEGREE_RAD + 1e-9, `${hash}: ${pitch_rad}`);
    assert.ok(Object.values(others).every(Number.isFinite), hash);
  }
  await goTo(page, there);
  assert.ok(contrast(await picture(page)) > 10);
});

pageTest("works by keyboard alone, and bare in a kiosk", async (visit) => {
  const host = await visit.host("cells");
  const page = await visit.open(host, null, { width: 1100 });
  await page.getByTestId("view").press("?");
  await page.getByTestId("help").waitFor({ state: "visible" });
  await page.keyboard.press("Escape");
  await page.getByTestId("help").waitFor({ state: "hidden" });
  const reached = new Set();
  for (let i = 0; i < 20; ++i) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement.dataset.testid));
  }
  for (const tool of ["tool-plan", "tool-screenshot", "tool-help"]) assert.ok(reached.has(tool));

  await openRoom(page, host.address, null, "?kiosk");
  await page.getByTestId("toolbar").waitFor({ state: "hidden" });
});

pageTest("plays the recorded path, up and down too, until one walks oneself", async (visit) => {
  const page = await visit.show("cells", null, { width: 640 });
  await page.getByTestId("view").press("p");
  const player = page.getByTestId("player");
  const slider = player.getByRole("slider");
  const duration_s = Number(await slider.getAttribute("max"));
  for (const [share, x_m, up_m] of [
    [0.5, 0, 0.04],
    [1, 0.3, 0],
  ]) {
    await slider.fill((share * duration_s).toFixed(1));
    await page.waitForFunction(
      ([x_m, up_m]) => {
        const at = window.raywalk.viewer.pose;
        return Math.abs(at.x_m - x_m) < 0.05 && Math.abs(at.up_m - up_m) < 0.01;
      },
      [x_m, up_m],
    );
  }
  await player.getByRole("button", { name: "Play", exact: true }).click();
  await page.waitForFunction(() => window.raywalk.viewer.pose.x_m < 0.2);
  await page.getByTestId("view").focus();
  await page.keyboard.down("w");
  await player.waitFor({ state: "hidden" });
  await page.keyboard.up("w");
});

pageTest("compares its view with ground truth and with the engine's", async (visit) => {
  const page = await visit.show("cells", place({}), { width: 640 });
  await page.getByTestId("view").press("b");
  const sheet = page.getByTestId("compare-sheet");
  const line = page.getByTestId("comparison");
  const names = await sheet.getByRole("option").allTextContents();
  for (const [name, least_db] of Object.entries({ "ground truth": 36, engine: 40 })) {
    await sheet.getByRole("combobox").selectOption(names.find((each) => each.endsWith(name)));
    await line.waitFor({ state: "visible" });
    const shown = [];
    for (const share of ["0", "0.5", "1"]) {
      await sheet.getByRole("slider").fill(share);
      await drawn(page);
      shown.push(await picture(page));
    }
    const [own, half, other] = shown;
    const db = psnr(own, other);
    console.log(`this viewer and ${name}: ${db.toFixed(1)} dB`);
    assert.ok(db > least_db && db < 60, `${db} dB`);
    assert.ok(psnr(half, own) > db && psnr(half, other) > db, "each shows a part");
  }
  await page.getByTestId("view").focus();
  await page.keyboard.down("s");
  await sheet.waitFor({ state: "hidden" });
  await page.keyboard.up("s");
});

pageTest("a lost graphics context comes back with the same picture", async (visit) => {
  const page = await visit.show("cells", place({ x: 0.1, yaw: 40 }));
  const before = await picture(page);
  visit.allowed.push(/Context Lost|Context Restored|CONTEXT_LOST_WEBGL/i);
  await page.evaluate(async () => {
    const gl = document.querySelector("canvas").getContext("webgl2");
    const extension = gl.getExtension("WEBGL_lose_context");
    extension.loseContext();
    await new Promise((resolve) => setTimeout(resolve, 300));
    extension.restoreContext();
  });
  await page.waitForFunction(
    () => !document.querySelector("canvas").getContext("webgl2").isContextLost(),
  );
  await drawn(page);
  assert.ok(psnr(await picture(page), before) > 50);
});
