// The viewer in a page, by the handle that the page gives (window.raywalk).
import { addressOf } from "./place.mjs";
import { decodePng } from "./png.mjs";

/** Opens an export; the viewer is there then, its pictures need not be. */
export async function openRoom(page, address, at = null, query = "") {
  await page.goto(`${address}${query}${at ? addressOf(at) : ""}`);
  await page.waitForFunction(() => window.raywalk?.viewer);
}

/** Waits until all that is wanted has been read and drawn. */
export async function drawn(page) {
  await page.evaluate(() => window.raywalk.viewer.drawn());
}

/** Goes there by the page's address, and draws it. */
export async function goTo(page, at) {
  await page.evaluate(async (hash) => {
    const arrived = new Promise((resolve) =>
      addEventListener("hashchange", resolve, { once: true }),
    );
    location.hash = hash;
    await arrived;
    await window.raywalk.viewer.drawn();
  }, addressOf(at));
}

/** What the canvas shows, without the controls over it. */
export async function picture(page) {
  const bytes = await page.evaluate(async () => {
    const file = await window.raywalk.viewer.screenshot();
    const url = await new Promise((resolve) => {
      const reader = new FileReader();
      reader.onload = () => resolve(reader.result);
      reader.readAsDataURL(file);
    });
    return url.slice(url.indexOf(",") + 1);
  });
  return decodePng(Buffer.from(bytes, "base64"));
}

export function pose(page) {
  return page.evaluate(() => window.raywalk.viewer.pose);
}

export function progress(page) {
  return page.evaluate(() => window.raywalk.viewer.progress());
}
