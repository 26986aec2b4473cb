// What walking and its controls share.

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
