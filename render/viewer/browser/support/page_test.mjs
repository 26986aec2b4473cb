// A test with a browser's page: in a context of its own, and quiet: whatever the page complains of
// makes the test fail, except what the test allows.
import assert from "node:assert/strict";
import test from "node:test";
import { connectToBrowser } from "./browser.mjs";
import { exportFolder } from "./rooms.mjs";
import { StaticHost } from "./static_host.mjs";
import { drawn, openRoom } from "./viewer.mjs";

/** The browser's own note on tests that read pictures back, of no page's making. */
const READING_BACK = /GL Driver Message .*GPU stall due to ReadPixels/;
/** The browser's own message for every file that it does not get. */
export const FAILED_TO_LOAD = /^Failed to load resource/;

const LONGEST_TEST_MS = 120_000;

export function pageTest(name, body) {
  test(name, async () => {
    const visit = new Visit();
    try {
      await inTime(body(visit));
      visit.assertQuiet();
    } finally {
      await visit.end();
    }
  });
}

/** The test runner's own limit would leave a page that hangs open, and so never end. */
async function inTime(body) {
  let timer;
  const limit = new Promise((_, reject) => {
    const error = new Error(`not done after ${LONGEST_TEST_MS / 1000} s`);
    timer = setTimeout(() => reject(error), LONGEST_TEST_MS);
    timer.unref();
  });
  try {
    await Promise.race([body, limit]);
  } finally {
    clearTimeout(timer);
  }
}

class Visit {
  /** Complaints that the test expects. */
  allowed = [READING_BACK];
  #complaints = [];
  #hosts = [];
  #browser = null;

  /** Serves the export of one of the rooms of rooms.mjs. */
  async host(room) {
    const host = new StaticHost(exportFolder(room));
    await host.start();
    this.#hosts.push(host);
    return host;
  }

  /** A new page that has loaded nothing yet. */
  async page({ width = 240, height = 240, init_script = null } = {}) {
    this.#browser ??= await connectToBrowser();
    const context = await this.#browser.newContext({ viewport: { width, height } });
    if (init_script) await context.addInitScript(init_script);
    const page = await context.newPage();
    page.on("console", (message) => {
      if (["error", "warning"].includes(message.type())) this.#complaints.push(message.text());
    });
    page.on("pageerror", (error) => this.#complaints.push(`not caught: ${error.stack}`));
    return page;
  }

  /** A page that has opened what a host serves. */
  async open(host, at, options) {
    const page = await this.page(options);
    await openRoom(page, host.address, at);
    return page;
  }

  /** A page that shows one of the rooms of rooms.mjs, all of it. */
  async show(room, at, options) {
    const page = await this.open(await this.host(room), at, options);
    await drawn(page);
    return page;
  }

  assertQuiet() {
    const unexpected = this.#complaints.filter(
      (text) => !this.allowed.some((pattern) => pattern.test(text)),
    );
    assert.deepEqual(unexpected, [], "the console's errors and warnings");
  }

  async end() {
    await this.#browser?.close();
    for (const host of this.#hosts) await host.stop();
  }
}
