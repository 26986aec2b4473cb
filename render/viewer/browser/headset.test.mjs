// Walking with a headset, which iwer emulates: it shows both eyes beside each other.
import assert from "node:assert/strict";
import { build } from "esbuild";
import { pageTest } from "./support/page_test.mjs";
import { contrast, crop, psnr } from "./support/pictures.mjs";
import { place } from "./support/place.mjs";
import { decodePng } from "./support/png.mjs";
import { drawn, goTo, picture, pose } from "./support/viewer.mjs";

const EYE_PX = 120;
const EYES_APART_M = 0.064;
const FOV_DEG = 90;
const START = place({ x: -0.5, z: -0.1, fov: FOV_DEG });

const HEADSET = `
import { XRDevice, metaQuest3 } from "iwer";
window.headset = new XRDevice(metaQuest3, {
  stereoEnabled: true,
  ipd: ${EYES_APART_M},
  fovy: ${(FOV_DEG * Math.PI) / 180},
});
window.headset.installRuntime({ forceInstall: true });
`;

async function emulatedHeadset() {
  const resolveDir = new URL("..", import.meta.url).pathname;
  const bundle = await build({
    stdin: { contents: HEADSET, resolveDir },
    bundle: true,
    write: false,
    format: "iife",
  });
  return { content: bundle.outputFiles[0].text };
}

/** Pictures of both eyes, of a frame that was begun after this call. */
async function eyes(page) {
  await page.evaluate(async () => {
    const { render } = window.raywalk.viewer.webgl.info;
    const last = render.frame + 3;
    while (render.frame < last) await new Promise((resolve) => setTimeout(resolve, 10));
  });
  const both = decodePng(await page.screenshot());
  return [0, 1].map((eye) => crop(both, eye * EYE_PX, 0, EYE_PX, EYE_PX));
}

pageTest("shows a headset a picture for each eye, and walks with it", async (visit) => {
  const init_script = await emulatedHeadset();
  const page = await visit.show("cells", START, { width: EYE_PX, height: EYE_PX, init_script });
  // What each eye should see, and what both see from a step ahead.
  const expected = [];
  for (const side of [-0.5, 0.5]) {
    await goTo(page, { ...START, x: START.x + side * EYES_APART_M });
    expected.push(await picture(page));
  }
  await goTo(page, { ...START, x: START.x - EYES_APART_M / 2, z: START.z + 0.2 });
  const ahead = await picture(page);
  await goTo(page, START);

  await page.setViewportSize({ width: 2 * EYE_PX, height: EYE_PX });
  await page.getByTestId("tool-vr").press("Enter");
  await page.waitForFunction(() => window.raywalk.viewer.webgl.xr.isPresenting);
  const [left, right] = await eyes(page);
  const agreements = [psnr(left, expected[0]), psnr(right, expected[1])];
  console.log(`eyes: ${agreements.map((db) => db.toFixed(1)).join(" ")} dB`);
  assert.ok(Math.min(...agreements) > 40, `${agreements} dB`);
  assert.ok(psnr(left, right) < 35, "both eyes see the same");
  assert.ok(contrast(left) > 10 && contrast(right) > 10);

  await page.evaluate(() => (window.headset.position.z -= 0.2));
  const [leftAhead] = await eyes(page);
  const db = psnr(leftAhead, ahead);
  assert.ok(db > 40, `a step ahead: ${db} dB`);

  const before = await pose(page);
  await page.evaluate(() => window.headset.controllers.left.updateAxes("thumbstick", 0, -1));
  await page.waitForFunction((z_m) => window.raywalk.viewer.pose.z_m > z_m + 0.1, before.z_m);
  await page.evaluate(() => window.headset.controllers.left.updateAxes("thumbstick", 0, 0));
  await page.evaluate(() => window.headset.controllers.right.updateAxes("thumbstick", 1, 0));
  await page.waitForFunction(
    () => Math.abs(window.raywalk.viewer.pose.yaw_rad - Math.PI / 6) < 0.01,
  );
  await page.evaluate(() => window.headset.controllers.right.updateAxes("thumbstick", 0, 0));

  await page.getByTestId("tool-vr").evaluate((button) => button.click());
  await page.waitForFunction(() => !window.raywalk.viewer.webgl.xr.isPresenting);
  await drawn(page);
  const after = await picture(page);
  assert.deepEqual([after.width, after.height], [2 * EYE_PX, EYE_PX]);
  assert.ok(contrast(after) > 10);
});
