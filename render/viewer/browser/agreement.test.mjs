// The page shows what the engine shows.
import assert from "node:assert/strict";
import { pageTest } from "./support/page_test.mjs";
import { psnr } from "./support/pictures.mjs";
import { place } from "./support/place.mjs";
import { enginePictures } from "./support/rooms.mjs";
import { drawn, goTo, picture } from "./support/viewer.mjs";

/** Initial views differ by the compression of the pictures alone. */
const LEAST_DB = { initial: 43, "hlf-vd": 44, "two-sided": 43 };
/** The virtual room's chairs have spindles thinner than a pixel of its panoramas. */
const LEAST_WITH_CHAIRS_DB = 39;

/** All around and up and down; near and on lines, near a corner. */
const PLACES = [
  { x: 0, z: 0, yaw: 0 },
  { x: 0.1, z: 0.2, yaw: 60 },
  { x: -0.3, z: 0.1, yaw: 150, pitch: -10 },
  { x: 0.35, z: -0.35, yaw: -160, pitch: 10 },
  { x: 0.2, z: -0.1, yaw: -90, pitch: -30 },
  { x: -0.2, z: -0.3, yaw: -45, pitch: 20 },
  { x: 0.45, z: 0.4, yaw: 20 },
  { x: 0, z: 0.48, yaw: 100, pitch: -5 },
  { x: -0.5, z: 0.03, yaw: -90 },
  { x: 0.25, z: 0.25, yaw: 135, pitch: -60 },
  { x: -0.1, z: 0.3, yaw: 0, pitch: 80 },
  { x: -0.47, z: -0.47, yaw: -150, pitch: 5 },
].map(place);

async function assertAgreement(page, room, method, places, show, least = LEAST_DB[method]) {
  const size_px = page.viewportSize().width;
  const engine = await enginePictures(room, places, { size_px, method });
  const db = [];
  for (const [i, at] of places.entries()) {
    await show(at);
    db.push(psnr(await picture(page), engine[i]));
  }
  console.log(`${room}, ${method}: ${db.map((value) => value.toFixed(1)).join(" ")} dB`);
  const worst = Math.min(...db);
  assert.ok(worst >= least, `${worst} dB at place ${db.indexOf(worst)}`);
}

const LEAST_OF_ROOM_DB = { white: LEAST_DB["two-sided"], virtual: LEAST_WITH_CHAIRS_DB };
for (const [room, least] of Object.entries(LEAST_OF_ROOM_DB)) {
  pageTest(`shows the ${room} room as the engine does`, async (visit) => {
    const page = await visit.show(room, PLACES[0]);
    await assertAgreement(page, room, "two-sided", PLACES, (at) => goTo(page, at), least);
  });
}

pageTest("shows the other methods, chosen with the page's controls", async (visit) => {
  const places = PLACES.slice(1, 3);
  const page = await visit.show("white", places[0]);
  const choose = {
    initial: () => page.keyboard.press("1"),
    "hlf-vd": async () => {
      const button = page.getByTestId("settings").getByTitle("Views: hlf-vd");
      if (!(await button.isVisible())) await page.keyboard.press("k");
      await button.click();
    },
  };
  for (const [method, press] of Object.entries(choose)) {
    await assertAgreement(page, "white", method, places, async (at) => {
      await goTo(page, { ...at, method: "two-sided" });
      await press();
      await page.waitForFunction((name) => location.hash.includes(`=${name}&`), method);
      await drawn(page);
    });
  }
});
