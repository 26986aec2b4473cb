// For tests: whether numbers agree.
import assert from "node:assert/strict";

export function near(actual: number, expected: number, tolerance = 1e-9): void {
  const off = Math.abs(actual - expected);
  assert.ok(off <= tolerance, `${actual} is not within ${tolerance} of ${expected}`);
}
