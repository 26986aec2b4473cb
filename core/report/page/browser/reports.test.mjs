// What holds of every report.
import assert from "node:assert/strict";
import { test } from "node:test";
import { contentOf, open, reports } from "./support.mjs";

const A4_WIDTH_px = 718; // without margins, at 96 pixels per inch

test("reports of every kind are there", () => {
  const kinds = new Set(reports.map((file) => contentOf(file).kind));
  const expected = "calibration depth error_model plan require trade validation";
  assert.equal([...kinds].sort().join(" "), expected);
});

for (const file of reports) {
  const name = file.split("/").slice(-2).join("/");

  test(`${name} opens without complaint, asks no host, and fits every width`, async () => {
    for (const width of [1280, 390]) {
      const { page, faults } = await open(file, width);
      assert.deepEqual(faults, []);
      assert.ok((await page.title()) !== "Raywalk report");
      await fits(page);
    }
  });

  test(`${name} shows every key of its JSON`, async () => {
    const { page } = await open(file);
    const shown = await page.evaluate(async () => {
      // Branches are made when they are opened.
      for (;;) {
        const closed = [...document.querySelectorAll(".tree details:not([open])")];
        if (!closed.length) break;
        for (const branch of closed) branch.open = true;
        await new Promise((resolve) => setTimeout(resolve, 50));
      }
      return document.querySelectorAll(".tree [data-key]").length;
    });
    const count = (value) =>
      value !== null && typeof value === "object"
        ? Object.values(value).reduce((sum, entry) => sum + 1 + count(entry), 0)
        : 0;
    assert.equal(shown, count(contentOf(file).document));
  });

  test(`${name} prints`, async () => {
    const { page, faults } = await open(file, A4_WIDTH_px);
    await page.emulateMedia({ media: "print" });
    await page.evaluate(() => window.dispatchEvent(new Event("beforeprint")));
    await fits(page);
    assert.ok((await page.pdf({ format: "A4" })).length > 10000);
    assert.deepEqual(faults, []);
  });

  test(`${name} has a link to every section, figure and row of images`, async () => {
    const { page } = await open(file);
    const dead = await page.evaluate(() => {
      const targets = [...document.querySelectorAll("main > section[id], [data-title]")];
      const ids = targets.map((target) => target.id);
      const unlinked = targets.filter(
        ({ id }) => !document.querySelector(`a[href="#${CSS.escape(id)}"]`),
      );
      return { unlinked: unlinked.length, twice: ids.length - new Set(ids).size };
    });
    assert.deepEqual(dead, { unlinked: 0, twice: 0 });
  });
}

async function fits(page) {
  const over = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  assert.ok(over <= 0, `${over} pixels wider than the window`);
}
