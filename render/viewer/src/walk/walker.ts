// The walker: where the eye is, how fast it moves, and the one place where it is moved.
//
// Speeds follow what is asked with a short delay, independent of the frame rate, and end softly at the
// edge of what was captured: the part of a speed that points outwards shrinks with the distance
// that is left, so that one slides along edges and passes freely between touching cells.
import type { Pose } from "../geometry/frame";
import type { Grid, PlanPosition } from "../geometry/grid";
import { DEGREE_RAD, limit, wrapAngle } from "../geometry/angles";
import { approach, limitFov, planFromWalker } from "./motion";
import { areaSide, edgeBrake, edgeMargin, freeDistance } from "./edges";
import { Glide } from "./glide";
import { isActive, type Intent } from "./intent";

const PACE_M_PER_S = 0.7;
/** However small the cells, one needs this long for a side. */
const LEAST_SECONDS_PER_CELL = 1.5;
const FAST_FACTOR = 2;
const TURN_RAD_PER_S = 80 * DEGREE_RAD;
const ROLL_RAD_PER_S = 40 * DEGREE_RAD;
/** The eye needs this long for the whole of the vertical range. */
const SECONDS_PER_RANGE = 2;
/** Factor of the magnification after a second of zooming. */
const ZOOM_PER_S = 2.2;

const SPEED_TIME_CONSTANT_S = 0.12;
const LONGEST_STEP_S = 1 / 120;
/** A page that was hidden does not catch up. */
const LONGEST_FRAME_S = 0.25;
/** Below these speeds, in m/s and rad/s, one stands: the page may then sharpen the picture. */
const STANDING = 2e-3;

/** The field of view at which turning by keys has its usual speed. */
const USUAL_FOV_Y_RAD = 75 * DEGREE_RAD;

const MOST_PITCH_RAD = 90 * DEGREE_RAD;
const MOST_VERTICAL_RANGE_M = 10;

interface Speeds {
  x: number;
  z: number;
  up: number;
  turn: number;
  tilt: number;
  roll: number;
}

export class Walker {
  private current: Pose = { x_m: 0, z_m: 0, up_m: 0, yaw_rad: 0, pitch_rad: 0, roll_rad: 0 };
  private speeds: Speeds = standing();
  private fov_rad: number;
  private glide: Glide | null = null;
  private readonly range_m: number;

  constructor(
    private readonly grid: Grid,
    vertical_range_m: number,
    fov_y_rad: number,
  ) {
    const range_m = Number.isFinite(vertical_range_m) ? vertical_range_m : 0;
    this.range_m = limit(range_m, 0, MOST_VERTICAL_RANGE_M);
    this.fov_rad = limitFov(fov_y_rad);
    this.place({});
  }

  get pose(): Pose {
    return { ...this.current };
  }

  get fov_y_rad(): number {
    return this.fov_rad;
  }

  set fov_y_rad(fov_rad: number) {
    if (Number.isFinite(fov_rad)) this.fov_rad = limitFov(fov_rad);
  }

  get gliding(): boolean {
    return this.glide !== null;
  }

  /** The usual pace here: as a person walks, slower where cells are small. */
  get pace_m_per_s(): number {
    return Math.min(PACE_M_PER_S, this.side_m() / LEAST_SECONDS_PER_CELL);
  }

  get speed_m_per_s(): number {
    return Math.hypot(this.speeds.x, this.speeds.z);
  }

  /** Puts the eye there at once, or as close to it as was captured; what is not given stays. */
  place(pose: Partial<Pose>): void {
    this.speeds = standing();
    this.carry(pose);
  }

  /** Puts the eye where something else has carried it, as a head does; walking goes on. */
  carry(pose: Partial<Pose>): void {
    this.glide = null;
    this.current = this.reachable(pose);
  }

  /** Moves the eye there smoothly; any movement by the user ends that. */
  glideTo(pose: Partial<Pose>, done: () => void = () => {}): void {
    this.speeds = standing();
    this.glide = new Glide(this.current, this.reachable(pose), this.pace_m_per_s, done);
  }

  step(frame_s: number, intent: Intent): void {
    if (!(frame_s > 0)) return;
    const seconds = Math.min(frame_s, LONGEST_FRAME_S);
    if (isActive(intent)) this.glide = null;
    this.look(intent, seconds);
    if (this.glide) {
      this.followGlide(this.glide, seconds);
      return;
    }
    const steps = Math.ceil(seconds / LONGEST_STEP_S);
    for (let i = 0; i < steps; ++i) this.shortStep(seconds / steps, intent);
  }

  private look(intent: Intent, seconds: number): void {
    this.turnBy(intent.look_yaw_rad, intent.look_pitch_rad, 0);
    const zoom = intent.magnify * ZOOM_PER_S ** (intent.zoom * seconds);
    if (zoom === 1) return;
    // The picture's size, not the angle, is what grows evenly.
    this.fov_y_rad = 2 * Math.atan(Math.tan(this.fov_rad / 2) / zoom);
  }

  private followGlide(glide: Glide, seconds: number): void {
    const pose = glide.advance(seconds);
    this.current = this.reachable(pose);
    if (!glide.finished) return;
    this.glide = null;
    glide.done();
  }

  private shortStep(seconds: number, intent: Intent): void {
    this.accelerate(seconds, intent);
    this.move(seconds);
    const { turn, tilt, roll } = this.speeds;
    this.turnBy(turn * seconds, tilt * seconds, roll * seconds);
  }

  private accelerate(seconds: number, intent: Intent): void {
    const hurry = intent.fast ? FAST_FACTOR : 1;
    const pace = this.pace_m_per_s * hurry;
    const [x, z] = planFromWalker(intent.right, intent.forward, this.current.yaw_rad);
    // Where the picture is enlarged, a turn moves it as fast as elsewhere.
    const turning = TURN_RAD_PER_S * Math.min(1, this.fov_rad / USUAL_FOV_Y_RAD) * hurry;
    const wanted: Speeds = {
      x: x * pace,
      z: z * pace,
      up: (intent.up * 2 * this.range_m * hurry) / SECONDS_PER_RANGE,
      turn: intent.turn * turning,
      tilt: intent.tilt * turning,
      roll: intent.roll * ROLL_RAD_PER_S,
    };
    const share = approach(seconds, SPEED_TIME_CONSTANT_S);
    for (const key of Object.keys(wanted) as (keyof Speeds)[]) {
      const speed = this.speeds[key] + (wanted[key] - this.speeds[key]) * share;
      this.speeds[key] = wanted[key] === 0 && Math.abs(speed) < STANDING ? 0 : speed;
    }
  }

  private move(seconds: number): void {
    const { x, z, up } = this.speeds;
    const margin_m = edgeMargin(this.side_m());
    const walked: PlanPosition = {
      x_m: this.current.x_m + x * seconds * this.brake("x", x, margin_m),
      z_m: this.current.z_m + z * seconds * this.brake("z", z, margin_m),
    };
    const inside = this.grid.clamp(walked);
    this.current.x_m = inside.x_m;
    this.current.z_m = inside.z_m;
    const free_m = this.range_m - Math.sign(up) * this.current.up_m;
    const up_m = this.current.up_m + up * seconds * edgeBrake(free_m, this.range_m / 4);
    this.current.up_m = limit(up_m, -this.range_m, this.range_m);
  }

  private brake(axis: "x" | "z", speed: number, margin_m: number): number {
    if (speed === 0) return 0;
    const free_m = freeDistance(this.grid.walkable, this.current, axis, Math.sign(speed));
    return edgeBrake(free_m, margin_m);
  }

  private turnBy(yaw_rad: number, pitch_rad: number, roll_rad: number): void {
    const pose = this.current;
    pose.yaw_rad = wrapAngle(pose.yaw_rad + yaw_rad);
    pose.pitch_rad = limit(pose.pitch_rad + pitch_rad, -MOST_PITCH_RAD, MOST_PITCH_RAD);
    pose.roll_rad = wrapAngle(pose.roll_rad + roll_rad);
  }

  private side_m(): number {
    return areaSide(this.grid.walkable, this.current);
  }

  private reachable(pose: Partial<Pose>): Pose {
    const known = (value: number | undefined, otherwise: number): number =>
      value !== undefined && Number.isFinite(value) ? value : otherwise;
    const now = this.current;
    const inside = this.grid.clamp({
      x_m: known(pose.x_m, now.x_m),
      z_m: known(pose.z_m, now.z_m),
    });
    return {
      x_m: inside.x_m,
      z_m: inside.z_m,
      up_m: limit(known(pose.up_m, now.up_m), -this.range_m, this.range_m),
      yaw_rad: wrapAngle(known(pose.yaw_rad, now.yaw_rad)),
      pitch_rad: limit(known(pose.pitch_rad, now.pitch_rad), -MOST_PITCH_RAD, MOST_PITCH_RAD),
      roll_rad: wrapAngle(known(pose.roll_rad, now.roll_rad)),
    };
  }
}

function standing(): Speeds {
  return { x: 0, z: 0, up: 0, turn: 0, tilt: 0, roll: 0 };
}
