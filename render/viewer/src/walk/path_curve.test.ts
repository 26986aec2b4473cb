import assert from "node:assert/strict";
import { test } from "node:test";
import type { PathView } from "../manifest";
import { PathCurve } from "./path_curve";

function view(x_m: number, z_m: number, yaw_deg = 0): PathView {
  return { x_m, z_m, yaw_deg, pitch_deg: 0, roll_deg: 0 };
}

function deg(angle_rad: number): number {
  return (angle_rad * 180) / Math.PI;
}

test("goes through every pose of the path", () => {
  const path = [view(0, 0), view(0.2, 0.1, 30), view(0.4, 0, 90), view(0.5, 0.3, 80)];
  const curve = new PathCurve(path);
  for (const each of path) {
    const nearest = Math.min(
      ...Array.from({ length: 5001 }, (_, i) => {
        const pose = curve.at((curve.duration_s * i) / 5000);
        return Math.hypot(pose.x_m - each.x_m, pose.z_m - each.z_m);
      }),
    );
    assert.ok(nearest < 1e-3, `${nearest}`);
  }
  assert.deepEqual([curve.at(0).x_m, curve.at(1e9).x_m], [0, 0.5]);
});

test("has a constant speed, however far its poses are from each other", () => {
  const curve = new PathCurve([view(0, 0), view(0.01, 0), view(0.5, 0.1), view(1, 0), view(1, 1)]);
  const frame_s = 1 / 60;
  for (let t = 0.1; t < curve.duration_s - 0.1; t += frame_s) {
    const a = curve.at(t);
    const b = curve.at(t + frame_s);
    const speed = Math.hypot(b.x_m - a.x_m, b.z_m - a.z_m) / frame_s;
    assert.ok(speed > 0.38 && speed < 0.405, `${speed} m/s at ${t} s`);
  }
});

test("turns the short way round", () => {
  const curve = new PathCurve([view(0, 0, 170), view(1, 0, -170)]);
  const half = deg(curve.at(curve.duration_s / 2).yaw_rad);
  assert.ok(Math.abs(Math.abs(half) - 180) < 1e-6, `${half}`);
  for (let part = 0; part <= 1; part += 0.05) {
    assert.ok(Math.abs(deg(curve.at(part * curve.duration_s).yaw_rad)) >= 170 - 1e-9);
  }
});

test("takes time for a turn on the spot", () => {
  const curve = new PathCurve([view(0, 0, 0), view(0, 0, 80)]);
  assert.ok(Math.abs(curve.duration_s - 2) < 0.01, `${curve.duration_s}`);
});

test("a path of nothing, of one pose, or of nonsense cannot be played, and does not throw", () => {
  for (const path of [
    [],
    [view(1, 2)],
    [view(1, 1), view(1, 1)],
    [view(NaN, 0), view(0, 0, NaN)],
  ]) {
    const curve = new PathCurve(path);
    assert.equal(curve.playable, false);
    for (const value of Object.values(curve.at(0.5))) assert.ok(Number.isFinite(value));
  }
});
