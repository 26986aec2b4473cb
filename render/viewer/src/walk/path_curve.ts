// A recorded path as a smooth movement of constant speed.
//
// Centripetal Catmull-Rom curves through its poses, which make no loops where poses are unevenly
// spaced; directions are counted on from pose to pose by the shortest turn before they are
// interpolated. Time goes by with the way, or with the turn where that takes
// longer, so that one who turns on the spot is not rushed.
import type { Pose } from "../geometry/frame";
import type { PathView } from "../manifest";
import { DEGREE_RAD, turnBetween, wrapAngle } from "../geometry/angles";

const SPEED_M_PER_S = 0.4;
const TURN_RAD_PER_S = 40 * DEGREE_RAD;
const STEPS_PER_PIECE = 24;
/** Poses closer than this, in time, are one. */
const SAME_POSE_S = 1e-4;

/** What the curve interpolates, in the order of `KEYS`. */
type Knot = readonly number[];
const KEYS = ["x_m", "z_m", "yaw_rad", "pitch_rad", "roll_rad"] as const;

export type PathPose = Pick<Pose, (typeof KEYS)[number]>;

export class PathCurve {
  private readonly knots: Knot[];
  /** Time at which each step of the curve is reached. */
  private readonly times_s: number[] = [0];

  constructor(path: readonly PathView[]) {
    this.knots = knotsOf(path);
    const steps = Math.max(0, this.knots.length - 1) * STEPS_PER_PIECE;
    for (let step = 1; step <= steps; ++step) {
      const needed_s = durationOf(this.atStep(step - 1), this.atStep(step));
      this.times_s.push(this.times_s[step - 1]! + needed_s);
    }
  }

  get playable(): boolean {
    return this.duration_s > 0;
  }

  get duration_s(): number {
    return this.times_s[this.times_s.length - 1]!;
  }

  at(time_s: number): PathPose {
    const step = this.stepAt(time_s);
    const from = this.atStep(Math.floor(step));
    const to = this.atStep(Math.ceil(step));
    // Straight between steps: there the speed is even, which along the curve it would not be.
    const part = step - Math.floor(step);
    return poseOf(from.map((value, i) => value + (to[i]! - value) * part));
  }

  /** The step, with its fraction, that is reached at a time. */
  private stepAt(time_s: number): number {
    const last = this.times_s.length - 1;
    if (!(time_s > 0)) return 0;
    if (time_s >= this.duration_s) return last;
    let low = 0;
    let high = last;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times_s[middle]! <= time_s) low = middle;
      else high = middle;
    }
    const from_s = this.times_s[low]!;
    return low + (time_s - from_s) / (this.times_s[high]! - from_s);
  }

  private atStep(step: number): Knot {
    const last = this.knots.length - 1;
    if (last < 1) return this.knots[0] ?? KEYS.map(() => 0);
    const piece = Math.min(Math.floor(step / STEPS_PER_PIECE), last - 1);
    const part = step / STEPS_PER_PIECE - piece;
    const knot = (i: number): Knot => this.knots[Math.min(Math.max(i, 0), last)]!;
    const [before, from, to, after] = [
      knot(piece - 1),
      knot(piece),
      knot(piece + 1),
      knot(piece + 2),
    ];
    const spans = [span(before, from), span(from, to), span(to, after)] as const;
    return from.map((value, i) => catmullRom(before[i]!, value, to[i]!, after[i]!, spans, part));
  }
}

function knotsOf(path: readonly PathView[]): Knot[] {
  const knots: Knot[] = [];
  for (const view of path) {
    const angles = [view.yaw_deg, view.pitch_deg, view.roll_deg].map((deg) => deg * DEGREE_RAD);
    const place = [view.x_m, view.z_m];
    if (![...place, ...angles].every(Number.isFinite)) continue;
    const before = knots[knots.length - 1]?.slice(place.length);
    const counted = angles.map((angle, i) =>
      before ? before[i]! + turnBetween(before[i]!, angle) : angle,
    );
    const knot = [...place, ...counted];
    const last = knots[knots.length - 1];
    if (!last || durationOf(last, knot) > SAME_POSE_S) knots.push(knot);
  }
  return knots;
}

/** The curve's parameter between two poses; any will do for the pose that an end has beyond it. */
function span(from: Knot, to: Knot): number {
  return Math.sqrt(durationOf(from, to)) || 1;
}

function catmullRom(
  before: number,
  from: number,
  to: number,
  after: number,
  [span_before, span_here, span_after]: readonly [number, number, number],
  part: number,
): number {
  const slope = (a: number, b: number, c: number, ab: number, bc: number): number =>
    ((b - a) / ab - (c - a) / (ab + bc) + (c - b) / bc) * span_here;
  const slope_from = slope(before, from, to, span_before, span_here);
  const slope_to = slope(from, to, after, span_here, span_after);
  const square = 3 * (to - from) - 2 * slope_from - slope_to;
  const cubic = 2 * (from - to) + slope_from + slope_to;
  return from + part * (slope_from + part * (square + part * cubic));
}

function durationOf(from: Knot, to: Knot): number {
  const [x_m, z_m, ...turns_rad] = to.map((value, i) => value - from[i]!);
  return Math.max(
    Math.hypot(x_m!, z_m!) / SPEED_M_PER_S,
    Math.hypot(...turns_rad) / TURN_RAD_PER_S,
  );
}

function poseOf(knot: Knot): PathPose {
  const [x_m, z_m, yaw_rad, pitch_rad, roll_rad] = knot as [number, number, number, number, number];
  return {
    x_m,
    z_m,
    yaw_rad: wrapAngle(yaw_rad),
    pitch_rad,
    roll_rad: wrapAngle(roll_rad),
  };
}
