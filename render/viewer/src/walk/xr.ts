// Walking with a headset: the session, its thumbsticks, and the base of its head.
//
// The left thumbstick walks in the direction looked, the right one turns by 30 degrees. The head
// moves the eye freely inside what was captured; an eye that leaves it is not stopped, which would
// sicken, but the base is pushed softly until the eye is inside again. While the thumbstick walks, a
// vignette narrows the picture.
import { Quaternion } from "three";
import { anglesOf, type Pose } from "../geometry/frame";
import type { Viewer } from "../field/viewer";
import { DEGREE_RAD, wrapAngle } from "../geometry/angles";
import { approach, planFromWalker } from "./motion";
import { stick } from "./gamepad";
import { noIntent, type Intent } from "./intent";
import type { Walker } from "./walker";

const PUSH_TIME_CONSTANT_S = 0.2;
const VIGNETTE_TIME_CONSTANT_S = 0.15;

/** Axes of the xr-standard mapping. */
const THUMBSTICK_X = 2;
const THUMBSTICK_Y = 3;

export async function canEnterVr(): Promise<boolean> {
  try {
    return (await navigator.xr?.isSessionSupported("immersive-vr")) ?? false;
  } catch {
    return false; // refused by the page's permissions
  }
}

export class XrWalk {
  private session: XRSession | null = null;
  private base: Base | null = null;
  private readonly snap = new SnapTurn();

  constructor(
    private readonly viewer: Pick<Viewer, "webgl" | "pose" | "vignette">,
    private readonly walker: Walker,
    private readonly changed: (active: boolean) => void = () => {},
  ) {}

  get active(): boolean {
    return this.session !== null;
  }

  /** Begins or ends a session. Throws what the browser says where none begins. */
  async toggle(): Promise<void> {
    if (this.session) await this.session.end();
    else if (navigator.xr) await this.enter(navigator.xr);
  }

  /** To be called before each frame of a session, within it. */
  frame(seconds: number): void {
    const head = this.head();
    if (!this.session || !head) return;
    this.base ??= baseFor(
      this.walker.pose,
      wrapAngle(this.walker.pose.yaw_rad - head.yaw_rad),
      head,
    );
    const { intent, turn_rad } = this.sticks(this.session);
    this.base = this.walked(this.base, head, intent, seconds);
    this.base = baseFor(eyeOf(this.base, head), wrapAngle(this.base.yaw_rad + turn_rad), head);
    this.viewer.pose = { ...this.base, pitch_rad: 0, roll_rad: 0 };
    this.narrow(intent, seconds);
  }

  private async enter(system: XRSystem): Promise<void> {
    const session = await system.requestSession("immersive-vr");
    const { xr } = this.viewer.webgl;
    session.addEventListener("end", () => this.ended());
    xr.enabled = true;
    xr.setReferenceSpaceType("local");
    this.base = null;
    this.session = session;
    try {
      await xr.setSession(session);
    } catch (error) {
      await session.end();
      throw error;
    }
    // The headset's own "recentre" moves its origin: the walker stays where it is.
    xr.getReferenceSpace()?.addEventListener("reset", () => void (this.base = null));
    this.changed(true);
  }

  private walked(base: Base, head: Head, intent: Intent, seconds: number): Base {
    const eye = eyeOf(base, head);
    this.walker.carry({
      ...eye,
      yaw_rad: base.yaw_rad + head.yaw_rad,
      pitch_rad: head.pitch_rad,
      roll_rad: head.roll_rad,
    });
    const inside = this.walker.pose;
    this.walker.step(seconds, intent);
    const after = this.walker.pose;
    const share = approach(seconds, PUSH_TIME_CONSTANT_S);
    const moved = (key: "x_m" | "z_m" | "up_m"): number =>
      eye[key] + (inside[key] - eye[key]) * share + (after[key] - inside[key]);
    return baseFor(
      { x_m: moved("x_m"), z_m: moved("z_m"), up_m: moved("up_m") },
      base.yaw_rad,
      head,
    );
  }

  private head(): Head | null {
    const { xr } = this.viewer.webgl;
    const space = xr.getReferenceSpace();
    const transform = space && xr.getFrame()?.getViewerPose(space)?.transform;
    if (!transform) return null;
    const { position, orientation } = transform;
    const attitude = new Quaternion(orientation.x, orientation.y, orientation.z, orientation.w);
    return {
      right_m: position.x,
      up_m: position.y,
      forward_m: -position.z,
      ...anglesOf(attitude),
    };
  }

  private sticks(session: XRSession): { intent: Intent; turn_rad: number } {
    const intent = noIntent();
    let turn_rad = 0;
    for (const source of session.inputSources) {
      const axes = source.gamepad?.axes;
      if (!axes) continue;
      const [right, backward] = stick(axes[THUMBSTICK_X], axes[THUMBSTICK_Y]);
      if (source.handedness === "right") {
        turn_rad += this.snap.turn(right);
      } else {
        intent.right += right;
        intent.forward -= backward;
      }
    }
    return { intent, turn_rad };
  }

  private narrow(intent: Intent, seconds: number): void {
    const wanted = Math.min(1, Math.hypot(intent.forward, intent.right));
    this.viewer.vignette +=
      (wanted - this.viewer.vignette) * approach(seconds, VIGNETTE_TIME_CONSTANT_S);
  }

  private ended(): void {
    this.session = null;
    this.base = null;
    this.viewer.vignette = 0;
    this.walker.place({ pitch_rad: 0, roll_rad: 0, up_m: 0 });
    this.changed(false);
  }
}

// A session reports the head relative to where it began. The base is the place and the direction of
// that beginning in the room: eye = base + Ry(base yaw) head. Walking, turning and what keeps the eye
// inside change the base only; the head is the user's own.

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

const SNAP_RAD = 30 * DEGREE_RAD;
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
