import assert from "node:assert/strict";
import { test } from "node:test";
import { turnBetween, wrapAngle } from "../geometry/angles";
import { horizontalFov, pixelAngle } from "./motion";
import { Gamepads, stick } from "./gamepad";
import { isActive, noIntent, readIntent } from "./intent";
import { COMMAND_KEYS, MOVEMENT_KEYS, keyOf } from "./keyboard";
import { positionOnPad } from "../ui/move_pad";
import { magnificationOfWheel, turnOfDrag } from "./pointer";
import { SnapTurn, baseFor, eyeOf, type Head } from "./xr";
import { near } from "../testing/near";

test("angles wrap and turn the short way", () => {
  near(wrapAngle(3 * Math.PI), -Math.PI);
  near(wrapAngle(-0.1), -0.1);
  near(turnBetween(3, -3), 2 * Math.PI - 6);
});

test("the horizontal field of view follows from the vertical one and the aspect", () => {
  near(horizontalFov(Math.PI / 2, 1), Math.PI / 2);
  near(horizontalFov(Math.PI / 2, 2), 2 * Math.atan(2));
  near(horizontalFov(1, 0.5), 2 * Math.atan(Math.tan(0.5) / 2));
  near(pixelAngle(Math.PI / 2, 100), 0.02);
});

test("sticks have a dead zone and a full speed", () => {
  assert.deepEqual(stick(0.1, 0.1), [0, 0]);
  assert.deepEqual(stick(undefined, NaN), [0, 0]);
  const [x, y] = stick(1, 0);
  near(x, 1);
  near(y, 0);
  near(stick(0, -0.575)[1], -0.5);
});

test("a gamepad of the standard mapping walks and looks, others do nothing", () => {
  const pad = { mapping: "standard", connected: true, axes: [0, -1, 1, 0], buttons: [] };
  const intent = readIntent([new Gamepads(() => [null, pad])]);
  near(intent.forward, 1);
  near(intent.turn, 1);
  assert.ok(!isActive(readIntent([new Gamepads(() => [{ ...pad, mapping: "" }])])));
});

test("a diagonal is not faster than a straight way", () => {
  const both = {
    addTo: (intent: { forward: number; right: number }) => {
      intent.forward += 1;
      intent.right += 1;
    },
  };
  const intent = readIntent([both, both]);
  near(Math.hypot(intent.forward, intent.right), 1);
});

test("Shift alone is no movement", () => {
  assert.ok(!isActive({ ...noIntent(), fast: true }));
  assert.ok(isActive({ ...noIntent(), magnify: 1.1 }));
});

test("keys are found by their sign or their place, and none has two meanings", () => {
  assert.equal(keyOf(COMMAND_KEYS, { key: "?", code: "Slash" })?.command, "help");
  assert.equal(keyOf(COMMAND_KEYS, { key: "&", code: "Digit1" })?.command, "initial");
  assert.equal(keyOf(MOVEMENT_KEYS, { key: "z", code: "KeyW" })?.does, "Walk forward");
  assert.equal(keyOf(MOVEMENT_KEYS, { key: "+", code: "BracketRight" })?.does, "Enlarge");
  assert.equal(keyOf(COMMAND_KEYS, { key: "j", code: "KeyJ" }), null);
  assert.equal(keyOf(MOVEMENT_KEYS, { key: "ArrowUp", code: "Numpad8" })?.does, "Walk forward");
  const all = [...COMMAND_KEYS, ...MOVEMENT_KEYS].flatMap(({ keys }): string[] => [...keys]);
  assert.equal(new Set(all).size, all.length);
});

test("a drag takes the scene with it", () => {
  const [yaw, pitch] = turnOfDrag(0.1, 0.05, 0, 0);
  near(yaw, -0.1);
  near(pitch, 0.05);
  // A head on its right shoulder: what is dragged down on the screen goes left in the room.
  const [rolled_yaw, rolled_pitch] = turnOfDrag(0, 0.1, 0, Math.PI / 2);
  near(rolled_yaw, 0.1);
  near(rolled_pitch, 0);
});

test("the wheel enlarges when it is turned away, in every unit, and within limits", () => {
  assert.ok(magnificationOfWheel(-100, 0) > 1);
  near(magnificationOfWheel(3, 1), magnificationOfWheel(48, 0));
  near(magnificationOfWheel(1e9, 2), magnificationOfWheel(300, 0));
});

test("the pad walks where the thumb is", () => {
  const box = { left: 100, top: 200, width: 100, height: 100 };
  assert.deepEqual(positionOnPad(150, 250, box).map(Math.abs), [0, 0]);
  const [right, forward] = positionOnPad(150, 0, box);
  near(right, 0);
  near(forward, 1);
});

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
  near(eye.x_m, 1.1);
  near(eye.z_m, 1.8);
  assert.equal(eye.up_m, 0.05);
});

test("a turn of the base leaves the eye where it is", () => {
  const before = eyeOf({ x_m: 1, z_m: 2, up_m: 0, yaw_rad: 0.4 }, HEAD);
  const after = eyeOf(baseFor(before, 2.5, HEAD), HEAD);
  for (const key of ["x_m", "z_m", "up_m"] as const) near(after[key], before[key]);
});

test("a push of the stick turns once by 30 degrees, until it is let go", () => {
  const snap = new SnapTurn();
  const turns = [0, 0.5, 0.9, 1, 0.5, 0.9, 0.1, -0.9].map((push) =>
    Math.round((snap.turn(push) * 180) / Math.PI),
  );
  assert.deepEqual(turns, [0, 0, 30, 0, 0, 0, 0, -30]);
});
