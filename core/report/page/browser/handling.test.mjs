// What readers do with a report: by keyboard, as by pointer.
import assert from "node:assert/strict";
import { test } from "node:test";
import { contentOf, open, reports } from "./support.mjs";

const openKind = async (kind) =>
  (await open(reports.find((file) => contentOf(file).kind === kind))).page;

test("arrow keys read the points of a chart, and so does the pointer", async () => {
  const page = await openKind("error_model");
  const chart = page.locator(".chart-figure").first();
  const tip = chart.locator(".tip");
  await chart.locator(".frame").focus();
  await page.keyboard.press("ArrowRight");
  assert.match(await tip.textContent(), /^E_t: k \/ ° 45, /);
  await page.keyboard.press("ArrowLeft");
  assert.match(await tip.textContent(), /k \/ ° 90, /);
  await page.keyboard.press("Tab");
  assert.equal(await tip.isVisible(), false);
  const box = await chart.locator(".u-over").boundingBox();
  let said = null;
  for (let y = box.height - 5; y > 0 && !said; y -= 10) {
    await page.mouse.move(box.x + box.width / 2, box.y + y);
    if (await tip.isVisible()) said = await tip.textContent();
  }
  assert.match(said, /^E_[tmb].*: k \/ ° (6\d|7[01]), /);
});

test("the values of a chart stand in a table", async () => {
  const page = await openKind("error_model");
  const values = page.locator(".chart-figure .values").first();
  await values.locator("summary").click();
  assert.deepEqual(await values.locator("thead th").allTextContents(), [
    "series",
    "k / °",
    "error, normalised as in (6)",
  ]);
});

test("a heading sorts its table, and all columns are there on demand", async () => {
  const page = await openKind("trade");
  const table = page.locator("#every-setting .table");
  const times = async () => {
    const cells = await table.locator("tbody tr td:nth-child(2)").allTextContents();
    return cells.map(Number);
  };
  const heading = table.locator("thead th").nth(1);
  await heading.locator("button").click();
  const sorted = await times();
  assert.deepEqual(
    sorted,
    [...sorted].sort((a, b) => a - b),
  );
  assert.equal(await heading.getAttribute("aria-sort"), "ascending");
  await page.keyboard.press("Enter"); // the heading keeps the focus
  assert.deepEqual(await times(), [...sorted].reverse());
  const columns = await table.locator("thead th").count();
  await table.locator(".buttons button", { hasText: "more columns" }).click();
  assert.ok((await table.locator("thead th").count()) > columns);
});

test("images of a row are zoomed into together", async () => {
  const page = await openKind("validation");
  await page.locator(".zoom").first().press("Enter");
  const transforms = () =>
    page.locator("dialog .pane img").evaluateAll((all) => all.map((img) => img.style.transform));
  await page.keyboard.press("+");
  await page.keyboard.press("ArrowRight");
  const [first, second] = await transforms();
  assert.match(first, /scale\(1\.25\) translate\(-8%/);
  assert.equal(first, second);
  await page.keyboard.press("0");
  assert.match((await transforms())[0], /scale\(1\) translate\(0%/);
  await page.keyboard.press("Escape");
  await page.locator("dialog").waitFor({ state: "detached" });
});
