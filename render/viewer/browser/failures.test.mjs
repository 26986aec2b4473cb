// What goes wrong is told on the page, and what is left works on.
import assert from "node:assert/strict";
import { FAILED_TO_LOAD, pageTest } from "./support/page_test.mjs";
import { contrast, psnr } from "./support/pictures.mjs";
import { place } from "./support/place.mjs";
import { enginePictures } from "./support/rooms.mjs";
import { drawn, goTo, picture, progress } from "./support/viewer.mjs";

pageTest("shows a coarse picture while fine ones are on their way", async (visit) => {
  const host = await visit.host("cells");
  let release;
  const released = new Promise((resolve) => (release = resolve));
  host.before = async (name) => {
    if (/^\/stations\/\d+\.jpg$/.test(name)) await released;
  };
  const started_ms = performance.now();
  const page = await visit.open(host, place({}));
  await page.waitForFunction(() => window.raywalk.viewer.progress().coarse > 20);
  const coarse = await picture(page);
  console.log(`coarse picture after ${Math.round(performance.now() - started_ms)} ms`);
  assert.ok(contrast(coarse) > 10);
  assert.equal((await progress(page)).fine, 0);
  await page.getByTestId("loading").waitFor({ state: "visible" });
  release();
  await drawn(page);
  console.log(`all is drawn after ${Math.round(performance.now() - started_ms)} ms`);
  const { fine, wanted } = await progress(page);
  assert.equal(fine, wanted);
});

pageTest("names damaged and missing files, and shows the rest", async (visit) => {
  const host = await visit.host("cells");
  visit.allowed.push(FAILED_TO_LOAD);
  const picture_file = await host.read("/stations/0003.jpg");
  host.replaced.set("/stations/0003.jpg", picture_file.subarray(0, 2000));
  host.replaced.set("/stations/0005.inverse", Buffer.from("this is no zlib stream"));
  host.replaced.set("/stations/0007.jpg", null);
  const page = await visit.open(host, place({}));
  await drawn(page);
  const messages = page.getByTestId("messages");
  for (const name of ["0003.jpg", "0005.inverse", "0007.jpg"]) {
    await messages.getByText(name).waitFor({ state: "visible" });
  }
  const how = { size_px: page.viewportSize().width, method: "two-sided" };
  const [engine] = await enginePictures("cells", [place({})], how);
  const db = psnr(await picture(page), engine);
  assert.ok(db > 25, `${db} dB`);
});

for (const [what, change, says] of [
  ["of another version", (manifest) => ({ ...manifest, version: 99 }), /format 99/],
  ["without lines", (manifest) => ({ ...manifest, lines: [] }), /incomplete/],
  ["of something else", () => ({ format: "else" }), /not describe a Raywalk room/],
  ["that is missing", () => null, /manifest\.json/],
]) {
  pageTest(`a manifest ${what} is explained`, async (visit) => {
    const host = await visit.host("cells");
    const changed = change(JSON.parse(await host.read("/manifest.json")));
    host.replaced.set("/manifest.json", changed && Buffer.from(JSON.stringify(changed)));
    if (!changed) visit.allowed.push(FAILED_TO_LOAD);
    const page = await visit.page();
    await page.goto(host.address);
    await page.getByTestId("message").getByText(says).waitFor({ state: "visible" });
  });
}

pageTest("a server that stops is told of, and read again when it is back", async (visit) => {
  const host = await visit.host("cells");
  visit.allowed.push(FAILED_TO_LOAD);
  let stopped = false;
  host.before = async (name) => {
    if (!stopped && /^\/stations\/0020\.jpg$/.test(name)) {
      stopped = true;
      await host.stop();
    }
  };
  const page = await visit.open(host, place({}));
  await page.getByTestId("messages").getByText("is the server still there?").first().waitFor();
  assert.ok(contrast(await picture(page)) > 10);
  await page.waitForTimeout(5000); // longer than a damaged file is tried
  await host.start();
  await drawn(page);
  const { fine, wanted, problems } = await progress(page);
  assert.equal(fine, wanted);
  assert.deepEqual(problems, []);
  await goTo(page, place({ x: 0.2 }));
});

pageTest("without WebGL 2 the page says what to do", async (visit) => {
  const host = await visit.host("cells");
  const page = await visit.page({
    init_script: `HTMLCanvasElement.prototype.getContext = () => null;`,
  });
  await page.goto(host.address);
  const message = page.getByTestId("message");
  await message.getByText(/WebGL 2.*another browser/).waitFor({ state: "visible" });
});
