// The page from `raywalk-render serve`: still views come from the engine, and nothing else is served.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import http from "node:http";
import path from "node:path";
import { createInterface } from "node:readline";
import { FAILED_TO_LOAD, pageTest } from "./support/page_test.mjs";
import { psnr } from "./support/pictures.mjs";
import { place } from "./support/place.mjs";
import { decodePng } from "./support/png.mjs";
import { enginePictures, exportFolder, roomFolder } from "./support/rooms.mjs";
import { setup } from "./support/setup.mjs";
import { drawn, openRoom } from "./support/viewer.mjs";

async function served(room, body) {
  const program = path.join(setup().bin, "raywalk-render");
  const flags = ["serve", roomFolder(room), "--export", exportFolder(room), "--port", "0"];
  const server = spawn(program, flags, { stdio: ["ignore", "pipe", "inherit"] });
  const ended = new Promise((resolve) => server.on("exit", resolve));
  try {
    for await (const line of createInterface({ input: server.stdout })) {
      if (line.startsWith("http://")) {
        await body(line.trim());
        break;
      }
    }
  } finally {
    server.kill("SIGINT");
  }
  assert.equal(await ended, 0);
}

pageTest("still views sharpen to the engine's picture", (visit) =>
  served("white", async (address) => {
    visit.allowed.push(FAILED_TO_LOAD); // a view that is not wanted any more
    const page = await visit.page();
    const asked = page.waitForRequest(/\/view\?/);
    const at = place({ x: 0.1, yaw: 30 });
    await openRoom(page, address, at, "?kiosk");
    await drawn(page);
    const query = new URL((await asked).url()).searchParams;
    assert.equal(Number(query.get("x")), 0.1);
    assert.equal(Number(query.get("yaw")), 30);
    await page.waitForFunction(() => {
      const view = document.querySelector('[data-testid="engine-view"]');
      return view?.classList.contains("shown") && getComputedStyle(view).opacity === "1";
    });
    // All that is seen of a kiosk is this picture.
    const how = { size_px: page.viewportSize().width, method: at.method };
    const [engine] = await enginePictures("white", [at], how);
    const db = psnr(decodePng(await page.screenshot()), engine);
    console.log(`the engine's picture in the page: ${db.toFixed(1)} dB`);
    assert.ok(db > 42, `${db} dB`);
    await page.getByTestId("view").focus();
    await page.keyboard.down("ArrowRight");
    await page.waitForFunction(() => {
      const view = document.querySelector('[data-testid="engine-view"]');
      return !view.classList.contains("shown");
    });
    await page.keyboard.up("ArrowRight");
  }),
);

/** Asks as it is: fetch would make a path safe before it is sent. */
function statusOf(address, name) {
  const { hostname, port } = new URL(address);
  return new Promise((resolve, reject) => {
    const request = http.get({ hostname, port, path: name }, (reply) => {
      reply.resume();
      resolve(reply.statusCode);
    });
    request.on("error", reject);
  });
}

pageTest("nothing but the export is served", () =>
  served("white", async (address) => {
    for (const [asked, status] of [
      ["/manifest.json", 200],
      ["/stations/0000.jpg", 200],
      ["/../white.lf/manifest.json", 400],
      ["/stations/../../white.lf/manifest.json", 400],
      ["/%2e%2e/white.lf/manifest.json", 400],
      ["/stations/..%2f..%2fwhite.lf/manifest.json", 400],
      ["/stations/..%5c..%5cwhite.lf/manifest.json", 400],
      ["//etc/passwd", 400],
      ["/etc/passwd", 404],
      ["/stations/", 404],
      ["/view?x=9&z=9", 422],
      ["/view?x=nan&z=0", 400],
    ]) {
      const refused = status === 400 ? [400, 404] : [status];
      const replied = await statusOf(address, asked);
      assert.ok(refused.includes(replied), `${asked}: ${replied}`);
    }
  }),
);
