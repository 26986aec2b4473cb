// A browser and pages for the tests.
import { readFileSync } from "node:fs";
import { after, afterEach, before } from "node:test";
import { chromium } from "playwright-core";

/** The files of the reports that the programs made. */
export const reports = JSON.parse(process.env.RAYWALK_REPORTS ?? "[]");

let browser;
before(async () => {
  const executablePath = process.env.CHROMIUM;
  browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
});
afterEach(() => Promise.all(browser.contexts().map((context) => context.close())));
after(() => browser.close());

/** The JSON inside a report. */
export function contentOf(file) {
  const [, json] = /id="report">(.*?)<\/script>/s.exec(readFileSync(file, "utf8"));
  return JSON.parse(json);
}

/** An opened report, and what the browser complained of or asked other hosts for. */
export async function open(file, width = 1280) {
  const page = await browser.newPage({ viewport: { width, height: 800 } });
  const faults = [];
  page.on("console", (message) => faults.push(message.text()));
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("request", (request) => {
    if (!/^(file|data):/.test(request.url())) faults.push(request.url());
  });
  await page.goto(`file://${file}`);
  await page.locator("main").waitFor();
  return { page, faults };
}

/** A page of a document that no program made. */
export async function openDocument(kind, document) {
  const json = JSON.stringify({ kind, document, images: [], sources: [] });
  const page = await browser.newPage();
  const ofKind = reports.find((file) => contentOf(file).kind === kind);
  await page.setContent(
    readFileSync(ofKind, "utf8").replace(
      /(id="report">).*?(<\/script>)/s,
      (_, a, b) => a + json + b,
    ),
  );
  await page.locator("main").waitFor();
  return page;
}

/** The cells' texts of the table with this caption. */
export const rowsOf = (page, caption) =>
  page
    .locator(".table", { has: page.locator(".caption", { hasText: caption }) })
    .locator("tbody tr")
    .evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
