import assert from "node:assert/strict";
import { test } from "node:test";
import {
  Address,
  formatAddress,
  parseAddress,
  parseOptions,
  type PlaceFromAddress,
} from "./address";
import { decimals, readNumber } from "./numbers";

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

test("an address says where one is, in millimetres and tenths of degrees", () => {
  assert.equal(
    formatAddress(PLACE),
    "#x=0.300&z=-1.250&up=0.000&yaw=40.0&pitch=-10.0&roll=0.0&fov=75.0&method=hlf-vd&k=60",
  );
});

test("what an address says can be read again", () => {
  const read = parseAddress(formatAddress(PLACE));
  assert.equal(read.pose.x_m, 0.3);
  assert.equal(read.pose.z_m, -1.25);
  assert.ok(Math.abs(read.pose.yaw_rad! - 40 * DEG) < 1e-9);
  assert.ok(Math.abs(read.fov_y_rad! - 75 * DEG) < 1e-9);
  assert.equal(read.method, "hlf-vd");
  assert.equal(read.k_deg, 60);
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
});

test("the prototype of objects cannot be reached", () => {
  parseAddress("#__proto__=1&constructor=2&x=1");
  assert.equal(({} as Record<string, unknown>).x, undefined);
});

test("what is out of range is taken as near as there is", () => {
  const read = parseAddress("#yaw=725&pitch=-400&roll=-181&fov=3&k=9000&x=99999");
  assert.ok(Math.abs(read.pose.yaw_rad! - 5 * DEG) < 1e-9);
  assert.equal(read.pose.pitch_rad, -90 * DEG);
  assert.ok(Math.abs(read.pose.roll_rad! - 179 * DEG) < 1e-9);
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
