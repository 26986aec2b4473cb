// What run.mjs tells the tests: {bin, folder, browser}, the programs, the rooms, and where the
// browser listens.
export const SETUP_VARIABLE = "RAYWALK_BROWSER_TESTS";

export function setup() {
  const text = process.env[SETUP_VARIABLE];
  if (!text) throw new Error("these tests are run by browser/run.mjs");
  return JSON.parse(text);
}
