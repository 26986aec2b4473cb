import assert from "node:assert/strict";
import { test } from "node:test";
import { engineCanShow, engineUrl, pictureSize, type StillView } from "./engine_view";
import { opacityAt, safeLink, usableHotspots } from "./hotspots";
import { Idle } from "./full_screen";
import { PlanLayout } from "./plan_map";
import { directionOf, lookingAt, project, stepTowards } from "./projection";
import { loadedPart, loadingText } from "./status";
import { describePlace, directionName } from "./whereabouts";
import {
  Address,
  formatAddress,
  parseAddress,
  parseOptions,
  type PlaceFromAddress,
} from "./address";
import { decimals, readNumber } from "./numbers";
import type { Pose } from "../geometry/frame";
import { near } from "../testing/near";

const BASE = new URL("https://museum.example/rooms/hall/");
const POSE = { x_m: 1, z_m: 2, up_m: 0.1, yaw_rad: 0, pitch_rad: 0, roll_rad: 0 };
const PICTURE = { fov_y_rad: Math.PI / 2, width_px: 400, height_px: 200 };

test("links of hotspots lead to the web or beside the page only", () => {
  assert.equal(safeLink("https://example.org/a", BASE), "https://example.org/a");
  assert.equal(safeLink("http://example.org", BASE), "http://example.org/");
  assert.equal(safeLink("chairs/1.html", BASE), "https://museum.example/rooms/hall/chairs/1.html");
  const scripts = ["javascript:x", "JaVaScRiPt:x", " java\tscript:x", "\u0001javascript:x"];
  const data = ["data:text/html,<script>", "vbscript:x", "blob:https://museum.example/x"];
  const elsewhere = ["file:///etc/passwd", "ftp://example.org", "http://"];
  for (const link of [undefined, "", "  ", ...scripts, ...data, ...elsewhere]) {
    assert.equal(safeLink(link, BASE), null, link);
  }
  assert.equal(safeLink(5 as unknown as string, BASE), null);
});

test("hotspots without a place or a text are left out", () => {
  const good = { x_m: 0, y_m: 0, z_m: 1, text: "A chair" };
  const bad = [
    { ...good, x_m: NaN },
    { ...good, y_m: "0" as unknown as number },
    { ...good, text: " " },
    { ...good, text: undefined as unknown as string },
  ];
  assert.deepEqual(usableHotspots([good, ...bad]), [good]);
  assert.deepEqual(usableHotspots(undefined), []);
  assert.equal(opacityAt(1), 1);
  near(opacityAt(100), 0.45);
});

function assertSeen(point: [number, number, number], pose: Pose, x_px: number, y_px: number): void {
  const seen = project(point, pose, 1.5, PICTURE)!;
  near(seen.x_px, x_px);
  near(seen.y_px, y_px);
}

test("points of the room are seen where they are", () => {
  assertSeen([1, 1.6, 5], POSE, 200, 100);
  near(project([1, 1.6, 5], POSE, 1.5, PICTURE)!.distance_m, 3);
  assertSeen([2, 2.1, 3], POSE, 300, 50);
  assert.equal(project([1, 1.6, 1], POSE, 1.5, PICTURE), null);
  assert.equal(project([1, 1.6, 2], POSE, 1.5, PICTURE), null);
});

test("turns, tilts and rolls move what is seen the other way", () => {
  const point: [number, number, number] = [1, 1.6, 5];
  assert.ok(project(point, { ...POSE, yaw_rad: 0.2 }, 1.5, PICTURE)!.x_px < 200);
  assert.ok(project(point, { ...POSE, pitch_rad: 0.2 }, 1.5, PICTURE)!.y_px > 100);
  // A head rolled clockwise sees what is above it to the left.
  const above = project([1, 2.6, 5], { ...POSE, roll_rad: 0.5 }, 1.5, PICTURE)!;
  assert.ok(above.x_px < 200);
});

test("a pixel looks where a point in it is seen", () => {
  const pose = { ...POSE, yaw_rad: 0.7, pitch_rad: -0.3, roll_rad: 0.2 };
  const [x, y, z] = directionOf(90, 150, pose, PICTURE);
  near(Math.hypot(x, y, z), 1);
  assertSeen([pose.x_m + 2 * x, 1.6 + 2 * y, pose.z_m + 2 * z], pose, 90, 150);
});

test("one looks at a hotspot, and steps towards what is seen", () => {
  const chair = { x_m: 2, y_m: 1, z_m: 5, text: "A chair" };
  assertSeen([2, 1, 5], { ...POSE, ...lookingAt(chair, POSE, 1.6) }, 200, 100);
  const step = stepTowards(300, 20, POSE, PICTURE, 0.5);
  near(step.x_m! - 1, 0.5 / Math.SQRT2);
  near(step.z_m! - 2, 0.5 / Math.SQRT2);
});

const VIEW: StillView = {
  pose: { ...POSE, up_m: 0, yaw_rad: Math.PI / 2 },
  settings: { method: "two-sided", k_deg: 90, overlap_deg: 5 },
  fov_y_rad: Math.PI / 2,
  width_px: 800,
  height_px: 400,
  pixel_ratio: 3,
};

test("the engine is asked for the same picture, its field of view across", () => {
  const url = engineUrl(VIEW, "view", BASE);
  assert.equal(url.pathname, "/rooms/hall/view");
  const asked = Object.fromEntries(url.searchParams);
  assert.deepEqual(asked, {
    x: "1.00000",
    z: "2.00000",
    yaw: "90.0000",
    pitch: "0.0000",
    roll: "0.0000",
    fov: "126.8699",
    width: "1600",
    height: "800",
    method: "two-sided",
    k: "90.00",
  });
});

test("the engine's picture has the canvas' pixels, within limits", () => {
  assert.deepEqual(pictureSize({ width_px: 300, height_px: 200, pixel_ratio: 1.5 }), [450, 300]);
  assert.deepEqual(pictureSize({ width_px: 3000, height_px: 1500, pixel_ratio: 2 }), [4096, 2048]);
  assert.deepEqual(pictureSize({ width_px: 10, height_px: 5000, pixel_ratio: 1 }), [8, 4096]);
  const [width_px, height_px] = pictureSize({ width_px: 4096, height_px: 2304, pixel_ratio: 1 });
  assert.ok(width_px * height_px <= 2 ** 23 && width_px > 3800, `${width_px} x ${height_px}`);
  assert.ok(engineCanShow(VIEW));
  const raised = { ...VIEW, pose: { ...VIEW.pose, up_m: 0.01 } };
  assert.ok(engineCanShow(raised));
  assert.equal(engineUrl(raised, "view", BASE).searchParams.get("y"), "0.01000");
  assert.ok(!engineCanShow({ ...raised, settings: { ...VIEW.settings, method: "initial" } }));
  assert.ok(!engineCanShow({ ...VIEW, width_px: 0 }));
});

test("the plan has x to the right and z upwards, and clicks mean what is drawn", () => {
  const bounds = { x_min_m: -1, x_max_m: 1, z_min_m: 0, z_max_m: 1 };
  const layout = new PlanLayout([bounds]);
  const at = layout.toPlan({ x_m: 1, z_m: 1 });
  assert.ok(at.x > layout.width / 2 && at.y < layout.height / 2);
  const back = layout.toRoom(layout.toPlan({ x_m: 0.3, z_m: 0.2 }));
  near(back.x_m, 0.3);
  near(back.z_m, 0.2);
});

test("says where one is", () => {
  const pose = { ...POSE, x_m: 0.3, z_m: -0.21, yaw_rad: Math.PI / 4 };
  assert.equal(
    describePlace(pose, { x_m: 0, z_m: 0 }),
    "0.3 m right, 0.2 m back of the middle, looking to the front right of the room.",
  );
  assert.match(describePlace({ ...POSE, x_m: 0, z_m: 0 }, { x_m: 0, z_m: 0.01 }), /^In the middle/);
  assert.equal(directionName(-Math.PI / 2), "the left");
  assert.equal(directionName(-Math.PI), "the back");
});

test("loading is counted by what is there", () => {
  const progress = { coarse: 64, fine: 12, wanted: 64, problems: [] };
  assert.equal(loadingText(progress), "Loading 12 of 64 stations");
  near(loadedPart(progress), 76 / 128);
  assert.equal(loadedPart({ ...progress, wanted: 0 }), 1);
});

test("idleness is told once, and again after more input", () => {
  let told = 0;
  const idle = new Idle(100, () => ++told, 0);
  for (const now_ms of [50, 100, 150]) idle.update(now_ms);
  assert.equal(told, 1);
  idle.touch(160);
  idle.update(200);
  assert.equal(told, 1);
  idle.update(260);
  assert.equal(told, 2);
});

const DEG = Math.PI / 180;

const PLACE = {
  pose: {
    x_m: 0.3004,
    z_m: -1.25,
    up_m: -0.00001,
    yaw_rad: 40.04 * DEG,
    pitch_rad: -10 * DEG,
    roll_rad: 0,
  },
  fov_y_rad: 75 * DEG,
  method: "hlf-vd",
  k_deg: 60,
} as const;

test("an address says where one is, in millimetres and tenths of degrees, and is read", () => {
  assert.equal(
    formatAddress(PLACE),
    "#x=0.300&z=-1.250&up=0.000&yaw=40.0&pitch=-10.0&roll=0.0&fov=75.0&method=hlf-vd&k=60",
  );
  const read = parseAddress(formatAddress(PLACE));
  assert.deepEqual([read.pose.x_m, read.pose.z_m, read.k_deg], [0.3, -1.25, 60]);
  near(read.pose.yaw_rad!, 40 * DEG);
  near(read.fov_y_rad!, 75 * DEG);
  assert.equal(read.method, "hlf-vd");
});

test("what cannot be read is ignored", () => {
  for (const hash of [
    "",
    "#",
    "#x",
    "#x=&z=",
    "#x=NaN&z=Infinity&yaw=-Infinity",
    "#x=1e999&z=0x10&k=1e1",
    "#x=1,5&z=--1&up=2-&pitch=1 2",
    "#%",
    "#%E0%A4%A",
    "#x=%00&method=__proto__&k=three",
    "#method=two-sided'&fov=<script>",
    "#x=" + "9".repeat(5000),
    "#" + "&".repeat(5000),
  ]) {
    assert.deepEqual(parseAddress(hash), { pose: {} }, hash.slice(0, 40));
  }
  parseAddress("#__proto__=1&constructor=2&x=1");
  assert.equal(({} as Record<string, unknown>).x, undefined, "the prototype of objects");
});

test("what is out of range is taken as near as there is", () => {
  const read = parseAddress("#yaw=725&pitch=-400&roll=-181&fov=3&k=9000&x=99999");
  near(read.pose.yaw_rad!, 5 * DEG);
  assert.equal(read.pose.pitch_rad, -90 * DEG);
  near(read.pose.roll_rad!, 179 * DEG);
  assert.equal(read.fov_y_rad, 30 * DEG);
  assert.equal(read.k_deg, 90);
  assert.equal(read.pose.x_m, 99999);
  assert.equal(parseAddress("#fov=170&k=0").fov_y_rad, 110 * DEG);
  assert.equal(parseAddress("#k=0").k_deg, 45);
});

test("an address counts as it was given, whatever a frame has made of it since", () => {
  const target = Object.assign(new EventTarget(), { location: { hash: "#x=1" } });
  const taken: PlaceFromAddress[] = [];
  new Address(target as unknown as Window, (place) => taken.push(place));
  target.dispatchEvent(
    Object.assign(new Event("hashchange"), { newURL: "http://host/index.html#x=2" }),
  );
  assert.deepEqual(taken, [{ pose: { x_m: 2 } }]);
});

test("parameters of the page", () => {
  assert.deepEqual(parseOptions(""), { kiosk: false, play: false, hotspots: true, start: {} });
  assert.deepEqual(parseOptions("?kiosk&play=1&hotspots=0&start=1,-2,90"), {
    kiosk: true,
    play: true,
    hotspots: false,
    start: { x_m: 1, z_m: -2, yaw_rad: 90 * DEG },
  });
  assert.deepEqual(parseOptions("?start=1,-2").start, { x_m: 1, z_m: -2 });
  assert.deepEqual(parseOptions("?start=1&kiosk=0"), parseOptions(""));
  assert.deepEqual(parseOptions("?start=NaN,1e5,&play=no").start, {});
});

test("numbers are read as people and programs write them", () => {
  assert.equal(readNumber(String(-0.5 + 0.032)), -0.5 + 0.032);
  assert.deepEqual(["1", " -2.5 ", "+.5", "3."].map(readNumber), [1, -2.5, 0.5, 3]);
  assert.deepEqual(["", ".", "1e3", "0x1", "١", null].map(readNumber), Array(6).fill(undefined));
  assert.equal(decimals(-0.0001, 3), "0.000");
});
