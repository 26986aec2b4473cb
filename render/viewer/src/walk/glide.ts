// A smooth movement from one pose to another that nobody steers.
import type { Pose } from "../geometry/frame";
import { DEGREE_RAD, limit, turnBetween } from "../geometry/angles";

const SHORTEST_S = 0.35;
const LONGEST_S = 2.5;
const TURN_RAD_PER_S = 120 * DEGREE_RAD;
/** Nobody watches the way, so it may be faster than walking. */
const FACTOR_OF_PACE = 1.5;

export class Glide {
  private readonly duration_s: number;
  private elapsed_s = 0;

  constructor(
    private readonly from: Pose,
    private readonly to: Pose,
    pace_m_per_s: number,
    readonly done: () => void,
  ) {
    const distance_m = Math.hypot(to.x_m - from.x_m, to.z_m - from.z_m);
    const turn_rad = Math.max(
      Math.abs(turnBetween(from.yaw_rad, to.yaw_rad)),
      Math.abs(turnBetween(from.pitch_rad, to.pitch_rad)),
      Math.abs(turnBetween(from.roll_rad, to.roll_rad)),
    );
    const needed_s = Math.max(
      distance_m / (FACTOR_OF_PACE * pace_m_per_s),
      turn_rad / TURN_RAD_PER_S,
    );
    this.duration_s = prefersStill() ? 0 : limit(needed_s, SHORTEST_S, LONGEST_S);
  }

  get finished(): boolean {
    return this.elapsed_s >= this.duration_s;
  }

  advance(seconds: number): Pose {
    this.elapsed_s += seconds;
    const { from, to } = this;
    if (this.finished) return to;
    const part = smooth(this.elapsed_s / this.duration_s);
    const between = (a: number, b: number): number => a + (b - a) * part;
    const turned = (a: number, b: number): number => a + turnBetween(a, b) * part;
    return {
      x_m: between(from.x_m, to.x_m),
      z_m: between(from.z_m, to.z_m),
      up_m: between(from.up_m, to.up_m),
      yaw_rad: turned(from.yaw_rad, to.yaw_rad),
      pitch_rad: turned(from.pitch_rad, to.pitch_rad),
      roll_rad: turned(from.roll_rad, to.roll_rad),
    };
  }
}

/** Begins and ends without a jerk. */
function smooth(part: number): number {
  return part * part * (3 - 2 * part);
}

/** Who asked their system for less motion is taken there at once. */
export function prefersStill(): boolean {
  return globalThis.matchMedia?.("(prefers-reduced-motion: reduce)").matches ?? false;
}
