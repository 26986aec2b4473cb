import assert from "node:assert/strict";
import { test } from "node:test";
import { PathRecorder } from "./path_recorder";

const POSE = { x_m: 0.1, z_m: -0.25, up_m: 0, yaw_rad: 0, pitch_rad: 0.1, roll_rad: 0 };

function rowsOf(table: string): number[][] {
  const [header, ...lines] = table.trim().split("\n");
  assert.equal(header, "name,x,z,yaw,pitch,roll,time");
  assert.equal(new Set(lines.map((line) => line.split(",")[0])).size, lines.length);
  return lines.map((line) => line.split(",").slice(1).map(Number));
}

test("records where one was, when", () => {
  const recorder = new PathRecorder(() => 1.5);
  recorder.advance(1, POSE);
  assert.equal(recorder.stop(), null);
  recorder.start(POSE);
  const speed = 0.5;
  for (let frame = 1; frame <= 61; ++frame) {
    const time_s = frame / 60;
    recorder.advance(1 / 60, { ...POSE, x_m: 0.1 + speed * time_s, yaw_rad: time_s });
  }
  const rows = rowsOf(recorder.stop()!);
  assert.equal(recorder.recording, false);
  assert.ok(rows.length === 6 || rows.length === 7, `${rows.length} rows`);
  for (const [x, z, yaw, pitch, roll, time] of rows as [
    number,
    number,
    number,
    number,
    number,
    number,
  ][]) {
    assert.ok(Math.abs(x - 0.1 - speed * time) < 1e-3, `${x} at ${time} s`);
    assert.ok(Math.abs((yaw * Math.PI) / 180 - time) < 1e-3);
    assert.deepEqual([z, pitch, roll], [-0.25, 5.73, 0]);
  }
  assert.equal(rows[rows.length - 1]![5], 1.017);
});

test("begins anew, and keeps the edge of what was captured", () => {
  const recorder = new PathRecorder(() => 1.5);
  recorder.start(POSE);
  recorder.advance(1, POSE);
  recorder.start({ ...POSE, x_m: 1 / 3 });
  recorder.advance(0.01, { ...POSE, x_m: 1 / 3 });
  const rows = rowsOf(recorder.stop()!);
  assert.deepEqual(
    rows.map((row) => [row[0], row[5]]),
    [
      [1 / 3, 0],
      [1 / 3, 0.01],
    ],
  );
});

test("a raised eye has a height in the room, in a table of its own columns", () => {
  const recorder = new PathRecorder(() => 1.5);
  recorder.start(POSE);
  recorder.advance(0.5, { ...POSE, up_m: 0.25 });
  const lines = recorder.stop()!.trim().split("\n");
  assert.equal(lines[0], "name,x,y,z,yaw,pitch,roll,time");
  assert.deepEqual(
    lines.slice(1).map((line) => line.split(",").slice(1, 4).map(Number)),
    [
      [0.1, 1.5, -0.25],
      [0.1, 1.75, -0.25],
    ],
  );
});
