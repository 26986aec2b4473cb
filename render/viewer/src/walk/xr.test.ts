import assert from "node:assert/strict";
import { test } from "node:test";
import { SnapTurn, baseFor, eyeOf, type Head } from "./xr";

const HEAD: Head = {
  right_m: 0.2,
  up_m: 0.05,
  forward_m: 0.1,
  yaw_rad: 0.3,
  pitch_rad: 0,
  roll_rad: 0,
};

test("the eye is where the base takes the head", () => {
  const eye = eyeOf({ x_m: 1, z_m: 2, up_m: 0, yaw_rad: Math.PI / 2 }, HEAD);
  assert.ok(Math.abs(eye.x_m - 1.1) < 1e-9);
  assert.ok(Math.abs(eye.z_m - 1.8) < 1e-9);
  assert.equal(eye.up_m, 0.05);
});

test("a turn of the base leaves the eye where it is", () => {
  const before = eyeOf({ x_m: 1, z_m: 2, up_m: 0, yaw_rad: 0.4 }, HEAD);
  const after = eyeOf(baseFor(before, 2.5, HEAD), HEAD);
  for (const key of ["x_m", "z_m", "up_m"] as const) {
    assert.ok(Math.abs(after[key] - before[key]) < 1e-9);
  }
});

test("a push of the stick turns once by 30 degrees, until it is let go", () => {
  const snap = new SnapTurn();
  const turns = [0, 0.5, 0.9, 1, 0.5, 0.9, 0.1, -0.9].map((push) =>
    Math.round((snap.turn(push) * 180) / Math.PI),
  );
  assert.deepEqual(turns, [0, 0, 30, 0, 0, 0, 0, -30]);
});
