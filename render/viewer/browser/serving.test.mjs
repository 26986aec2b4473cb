// The page from `raywalk-render serve`: still views come from the engine, and nothing else is served.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import path from "node:path";
import { createInterface } from "node:readline";
import { FAILED_TO_LOAD, pageTest } from "./support/page_test.mjs";
import { place } from "./support/place.mjs";
import { exportFolder, roomFolder } from "./support/rooms.mjs";
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
    await openRoom(page, address, place({ x: 0.1, yaw: 30 }));
    await drawn(page);
    const query = new URL((await asked).url()).searchParams;
    assert.equal(Number(query.get("x")), 0.1);
    assert.equal(Number(query.get("yaw")), 30);
    await page.waitForFunction(() => {
      const view = document.querySelector('[data-testid="engine-view"]');
      return view?.classList.contains("shown");
    });
    await page.getByTestId("view").focus();
    await page.keyboard.down("ArrowRight");
    await page.waitForFunction(() => {
      const view = document.querySelector('[data-testid="engine-view"]');
      return !view.classList.contains("shown");
    });
    await page.keyboard.up("ArrowRight");
  }),
);

pageTest("nothing but the export is served", () =>
  served("white", async (address) => {
    for (const [asked, status] of [
      ["manifest.json", 200],
      ["stations/0000.jpg", 200],
      ["%2e%2e/white.lf/manifest.json", 400],
      ["stations/..%2f..%2fwhite.lf/manifest.json", 400],
      ["stations/", 404],
      ["view?x=9&z=9", 422],
      ["view?x=nan&z=0", 400],
    ]) {
      const reply = await fetch(address + asked);
      const refused = status === 400 ? [400, 404] : [status];
      assert.ok(refused.includes(reply.status), `${asked}: ${reply.status}`);
      await reply.arrayBuffer();
    }
  }),
);
