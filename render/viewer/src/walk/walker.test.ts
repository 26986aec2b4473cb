import assert from "node:assert/strict";
import { test } from "node:test";
import { Grid } from "../geometry/grid";
import type { Cell } from "../manifest";
import { noIntent, readIntent, type Intent } from "./intent";
import { Walker } from "./walker";
import { PathRecorder } from "./path_recorder";
import { near } from "../testing/near";

function cell(x_min_m: number, x_max_m: number, z_min_m: number, z_max_m: number): Cell {
  return { x_min_m, x_max_m, z_min_m, z_max_m, lines: [-1, -1, -1, -1] };
}

/** An L: the cell to the front right is missing. */
const CELLS = [cell(-1, 0, -1, 0), cell(0, 1, -1, 0), cell(-1, 0, 0, 1)];

function walkerAt(x_m: number, z_m: number, cells = CELLS): Walker {
  const walker = new Walker(new Grid({ lines: [], cells }), 0.1, 1.3);
  walker.place({ x_m, z_m });
  return walker;
}

function walk(walker: Walker, seconds: number, intent: Partial<Intent>, frame_s = 1 / 60): void {
  const frames = Math.round(seconds / frame_s);
  for (let i = 0; i < frames; ++i) walker.step(frame_s, { ...noIntent(), ...intent });
}

test("walks forward at the pace of the cell, and comes to rest softly", () => {
  const walker = walkerAt(-0.5, -0.9);
  walk(walker, 1, { forward: 1 });
  near(walker.pose.z_m, -0.9 + (1 - 0.12) / 1.5, 0.01);
  near(walker.pose.x_m, -0.5, 1e-9);
  near(walker.speed_m_per_s, 1 / 1.5, 0.01);
  const before = walker.pose.z_m;
  walk(walker, 0.1, {});
  assert.ok(walker.speed_m_per_s > 0 && walker.speed_m_per_s < 0.4);
  walk(walker, 2, {});
  assert.equal(walker.speed_m_per_s, 0);
  near(walker.pose.z_m - before, 0.12 / 1.5, 0.01);
});

test("walks alike at every frame rate", () => {
  const ends = [1 / 144, 1 / 60, 1 / 20].map((frame_s) => {
    const walker = walkerAt(-0.5, -0.9);
    walk(walker, 1, { forward: 1, turn: 0.2 }, frame_s);
    return walker.pose;
  });
  for (const end of ends) {
    for (const key of ["x_m", "z_m", "yaw_rad"] as const) near(end[key], ends[0]![key], 0.003);
  }
});

test("is stopped softly at the edge and never beyond it", () => {
  const walker = walkerAt(0.5, -0.5);
  let fastest_stop = 0;
  let speed = 0;
  for (let i = 0; i < 300; ++i) {
    const before = walker.pose.z_m;
    walk(walker, 1 / 60, { forward: 1, fast: true });
    assert.ok(walker.pose.z_m <= 0);
    const next = (walker.pose.z_m - before) * 60;
    fastest_stop = Math.max(fastest_stop, speed - next);
    speed = next;
  }
  near(walker.pose.z_m, 0, 0.001);
  // From full speed to none within a frame would be 1.3 m/s.
  assert.ok(fastest_stop < 0.4, `lost ${fastest_stop} m/s within a frame`);
});

test("is not slowed before the last tenth of a cell", () => {
  const walker = walkerAt(0.5, -0.5);
  walk(walker, 0.55, { forward: 1 });
  assert.ok(walker.pose.z_m < -0.1, "still before the margin");
  near(walker.speed_m_per_s, 1 / 1.5, 0.02);
});

test("slides along an edge", () => {
  const walker = walkerAt(0.2, -0.05);
  walker.place({ yaw_rad: Math.PI / 4 });
  walk(walker, 1, { forward: 1 });
  assert.ok(walker.pose.x_m > 0.55, `${walker.pose.x_m}`);
  assert.ok(walker.pose.z_m <= 0 && walker.pose.z_m > -0.05);
});

test("passes between touching cells without being slowed", () => {
  const walker = walkerAt(-0.5, -0.4);
  walk(walker, 1, { forward: 1 });
  near(walker.pose.z_m, -0.4 + (1 - 0.12) / 1.5, 0.01);
  const almost = [cell(-1, 0, -1, 0), cell(-1, 0, 1e-9, 1)];
  const other = walkerAt(-0.5, -0.4, almost);
  walk(other, 1, { forward: 1 });
  near(other.pose.z_m, walker.pose.z_m, 0.001);
});

test("steps sideways relative to the direction looked", () => {
  const walker = walkerAt(-0.5, 0);
  walker.place({ yaw_rad: Math.PI / 2 });
  walk(walker, 0.5, { right: 1 });
  assert.ok(walker.pose.z_m < -0.1);
  near(walker.pose.x_m, -0.5, 1e-6);
});

test("keeps the eye within its vertical range, softly", () => {
  const walker = walkerAt(-0.5, -0.5);
  walk(walker, 10, { up: 1 });
  near(walker.pose.up_m, 0.1, 0.001);
  assert.ok(walker.pose.up_m <= 0.1);
  walk(walker, 20, { up: -1 });
  near(walker.pose.up_m, -0.1, 0.001);
  assert.ok(walker.pose.up_m >= -0.1);
  walker.place({ up_m: 5 });
  assert.equal(walker.pose.up_m, 0.1);
});

test("limits the pitch and wraps the yaw", () => {
  const walker = walkerAt(0, 0);
  walk(walker, 0.1, { look_pitch_rad: 1, look_yaw_rad: 1 });
  assert.equal(walker.pose.pitch_rad, Math.PI / 2);
  near(walker.pose.yaw_rad, 6 - 2 * Math.PI, 1e-9);
});

test("zooms by the size of the picture, within limits", () => {
  const walker = walkerAt(0, 0);
  const before = Math.tan(walker.fov_y_rad / 2);
  walker.step(1 / 60, { ...noIntent(), magnify: 1.5 });
  near(Math.tan(walker.fov_y_rad / 2), before / 1.5, 1e-9);
  walk(walker, 10, { zoom: 1 });
  near(walker.fov_y_rad, Math.PI / 6, 1e-9);
  walk(walker, 10, { zoom: -1 });
  near(walker.fov_y_rad, (110 * Math.PI) / 180, 1e-9);
});

test("never becomes what is no number", () => {
  const walker = walkerAt(-0.5, -0.5);
  walker.place({ x_m: NaN, z_m: Infinity, yaw_rad: NaN, pitch_rad: -Infinity, up_m: NaN });
  const nonsense = {
    forward: NaN,
    right: Infinity,
    turn: -Infinity,
    look_yaw_rad: NaN,
    magnify: 0,
  };
  const broken = { addTo: (intent: Intent) => void Object.assign(intent, nonsense) };
  for (const seconds of [NaN, 0, -1, Infinity, 1e9, 1 / 60]) {
    walker.step(seconds, readIntent([broken]));
  }
  walker.fov_y_rad = NaN;
  for (const value of [...Object.values(walker.pose), walker.fov_y_rad]) {
    assert.ok(Number.isFinite(value), `${value}`);
  }
});

test("glides to a place and says when it is there", () => {
  const walker = walkerAt(-0.5, -0.5);
  let there = 0;
  walker.glideTo({ x_m: 0.5, yaw_rad: 3 }, () => ++there);
  walk(walker, 0.2, {});
  assert.ok(walker.gliding && walker.pose.x_m > -0.5 && walker.pose.x_m < 0.5);
  walk(walker, 3, {});
  assert.equal(there, 1);
  assert.deepEqual([walker.pose.x_m, walker.pose.z_m], [0.5, -0.5]);
  near(walker.pose.yaw_rad, 3, 1e-9);
});

test("a movement by the user ends a glide", () => {
  const walker = walkerAt(-0.5, -0.5);
  let there = 0;
  walker.glideTo({ x_m: 0.5 }, () => ++there);
  walk(walker, 0.2, {});
  walk(walker, 0.1, { turn: 1 });
  walk(walker, 3, {});
  assert.equal(there, 0);
  assert.ok(walker.pose.x_m < 0.2);
});

const POSE = { x_m: 0.1, z_m: -0.25, up_m: 0, yaw_rad: 0, pitch_rad: 0.1, roll_rad: 0 };

type Row = [x: number, z: number, yaw: number, pitch: number, roll: number, time: number];

function rowsOf(table: string, columns = "name,x,z,yaw,pitch,roll,time"): Row[] {
  const [header, ...lines] = table.trim().split("\n");
  assert.equal(header, columns);
  assert.equal(new Set(lines.map((line) => line.split(",")[0])).size, lines.length);
  return lines.map((line) => line.split(",").slice(1).map(Number) as Row);
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
  for (const [x, z, yaw, pitch, roll, time] of rows) {
    near(x, 0.1 + speed * time, 1e-3);
    near((yaw * Math.PI) / 180, time, 1e-3);
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
  const ways = rowsOf(recorder.stop()!).flatMap((row) => [row[0], row[5]]);
  assert.deepEqual(ways, [1 / 3, 0, 1 / 3, 0.01]);
});

test("a raised eye has a height in the room, in a table of its own columns", () => {
  const recorder = new PathRecorder(() => 1.5);
  recorder.start(POSE);
  recorder.advance(0.5, { ...POSE, up_m: 0.25 });
  const rows = rowsOf(recorder.stop()!, "name,x,y,z,yaw,pitch,roll,time");
  const heights = rows.flatMap((row) => row.slice(0, 3));
  assert.deepEqual(heights, [0.1, 1.5, -0.25, 0.1, 1.75, -0.25]);
});
