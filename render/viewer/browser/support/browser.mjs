// The browser that all tests share.
import { chromium } from "playwright-core";
import { setup } from "./setup.mjs";

const ARGUMENTS = [
  "--no-sandbox",
  // WebGL2 without a graphics card.
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--no-first-run",
];

export function launchBrowser(executable) {
  return chromium.launchServer({ executablePath: executable, args: ARGUMENTS });
}

/** Closing the connection closes what was opened through it. */
export function connectToBrowser() {
  return chromium.connect(setup().browser);
}
