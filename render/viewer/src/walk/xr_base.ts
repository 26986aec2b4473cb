// A headset's head inside a session, and the base that takes the session into the room.
//
// A session reports the head relative to where it began. The base is the place and the direction of
// that beginning in the room: eye = base + Ry(base yaw) head. Walking, turning and what keeps the eye
// inside change the base only; the head is the user's own.
import type { Pose } from "../geometry/frame";
import { planFromWalker } from "./motion";

/** Relative to the beginning of the session, in Raywalk's axes. */
export interface Head {
  right_m: number;
  up_m: number;
  forward_m: number;
  yaw_rad: number;
  pitch_rad: number;
  roll_rad: number;
}

export type Base = Pick<Pose, "x_m" | "z_m" | "up_m" | "yaw_rad">;
export type Eye = Pick<Pose, "x_m" | "z_m" | "up_m">;

export function eyeOf(base: Base, head: Head): Eye {
  const [x_m, z_m] = planFromWalker(head.right_m, head.forward_m, base.yaw_rad);
  return { x_m: base.x_m + x_m, z_m: base.z_m + z_m, up_m: base.up_m + head.up_m };
}

/** The base, turned to yaw_rad, that has the eye there: turns go round the eye, not the base. */
export function baseFor(eye: Eye, yaw_rad: number, head: Head): Base {
  const [x_m, z_m] = planFromWalker(head.right_m, head.forward_m, yaw_rad);
  return { x_m: eye.x_m - x_m, z_m: eye.z_m - z_m, up_m: eye.up_m - head.up_m, yaw_rad };
}

const SNAP_RAD = (30 * Math.PI) / 180;
const SNAP_AT = 0.6;
const SNAP_AGAIN_BELOW = 0.3;

/** Turns by a fixed angle for every push of a stick to a side: less sickening than a smooth turn. */
export class SnapTurn {
  private armed = true;

  turn(stick_right: number): number {
    const push = Math.abs(stick_right);
    if (push < SNAP_AGAIN_BELOW) this.armed = true;
    if (!this.armed || push < SNAP_AT) return 0;
    this.armed = false;
    return Math.sign(stick_right) * SNAP_RAD;
  }
}
