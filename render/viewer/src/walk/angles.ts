// Angles and simple numbers that walking and its controls share.

export const DEGREE_RAD = Math.PI / 180;

/** The same direction in [-pi, pi). */
export function wrapAngle(angle_rad: number): number {
  const turns = Math.floor((angle_rad + Math.PI) / (2 * Math.PI));
  return angle_rad - turns * 2 * Math.PI;
}

/** The shortest turn from one direction to another, in [-pi, pi). */
export function turnBetween(from_rad: number, to_rad: number): number {
  return wrapAngle(to_rad - from_rad);
}

export function limit(value: number, least: number, most: number): number {
  return Math.min(Math.max(value, least), most);
}

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
