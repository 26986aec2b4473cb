// What walking and its controls share.
import { DEGREE_RAD, limit } from "../geometry/angles";

/** The share of a change that is done after `seconds`, where it decays with `time_constant_s`. */
export function approach(seconds: number, time_constant_s: number): number {
  return 1 - Math.exp(-seconds / time_constant_s);
}

/** Directions of the plan: where one comes to by a step to the right and a step forward. */
export function planFromWalker(
  right: number,
  forward: number,
  yaw_rad: number,
): [x: number, z: number] {
  const sin = Math.sin(yaw_rad);
  const cos = Math.cos(yaw_rad);
  return [right * cos + forward * sin, forward * cos - right * sin];
}

/** Within what a flat picture may show, vertically. */
export function limitFov(fov_y_rad: number): number {
  return limit(fov_y_rad, 30 * DEGREE_RAD, 110 * DEGREE_RAD);
}

/** The horizontal angle of a flat picture with this vertical one; aspect is width / height. */
export function horizontalFov(fov_y_rad: number, aspect: number): number {
  return 2 * Math.atan(Math.tan(fov_y_rad / 2) * aspect);
}

/** The angle that one pixel covers in the middle of the picture. */
export function pixelAngle(fov_y_rad: number, height_px: number): number {
  return (2 * Math.tan(fov_y_rad / 2)) / Math.max(height_px, 1);
}
