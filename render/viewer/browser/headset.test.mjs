// WebXR, with an emulated headset (iwer).
import { build } from "esbuild";
import assert from "node:assert/strict";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { pageTest } from "./support/page_test.mjs";
import { contrast, crop, psnr } from "./support/pictures.mjs";
import { place } from "./support/place.mjs";
import { decodePng } from "./support/png.mjs";
import { drawn, openRoom, pose } from "./support/viewer.mjs";

const here = path.dirname(fileURLToPath(import.meta.url));

async function emulator() {
  const bundle = await build({
    stdin: {
      contents: `
        import { XRDevice, metaQuest3 } from "iwer";
        const headset = new XRDevice(metaQuest3);
        headset.installRuntime({ forceInstall: true });
        headset.stereoEnabled = true;
        headset.position.set(0, 1.6, 0);
        window.headset = headset;`,
      resolveDir: here,
    },
    bundle: true,
    format: "iife",
    write: false,
    logLevel: "error",
  });
  return bundle.outputFiles[0].text;
}

async function bothEyes(page) {
  // What is on the canvas in a session, both eyes beside each other, once it has followed the head.
  await page.waitForTimeout(3000);
  const shown = decodePng(await page.screenshot());
  const half = Math.floor(shown.width / 2);
  return {
    left: crop(shown, 0, 0, half, shown.height),
    right: crop(shown, half, 0, half, shown.height),
  };
}

pageTest("enters a headset, with a viewpoint for each eye", async (visit) => {
  const host = await visit.host("cells");
  const page = await visit.page({ width: 320, height: 200, init_script: await emulator() });
  await openRoom(page, host.address, place({ x: 0, z: 0 }));
  await drawn(page);
  await page.getByTestId("view").focus();
  await page.getByTestId("tool-vr").click();
  await page.waitForFunction(() => window.raywalk.viewer.webgl.xr.isPresenting);
  const first = await bothEyes(page);
  assert.ok(contrast(first.left) > 5 && contrast(first.right) > 5);
  assert.ok(psnr(first.left, first.right) < 45, "the eyes see the same");

  await page.evaluate(() => window.headset.position.set(0.1, 1.6, -0.2));
  const moved = await bothEyes(page);
  assert.ok(psnr(first.left, moved.left) < 40, "the picture does not follow the head");

  const before = await pose(page);
  await page.evaluate(() => window.headset.controllers.left.updateAxes("thumbstick", 0, -1));
  await page.waitForFunction((z) => window.raywalk.viewer.pose.z_m > z + 0.05, before.z_m);
  await page.evaluate(() => window.headset.controllers.left.updateAxes("thumbstick", 0, 0));

  await page.evaluate(() => window.raywalk.viewer.webgl.xr.getSession().end());
  await page.waitForFunction(() => !window.raywalk.viewer.webgl.xr.isPresenting);
  await drawn(page);
});
