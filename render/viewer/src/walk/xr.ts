// Walking with a headset: the session, its thumbsticks, and the base of its head.
//
// The left thumbstick walks in the direction looked, the right one turns by 30 degrees. The head
// moves the eye freely inside what was captured; an eye that leaves it is not stopped, which would
// sicken, but the base is pushed softly until the eye is inside again. While the thumbstick walks, a
// vignette narrows the picture.
import { Quaternion } from "three";
import { anglesOf } from "../geometry/frame";
import type { Viewer } from "../viewer";
import { wrapAngle } from "../geometry/angles";
import { approach } from "./motion";
import { stick } from "./gamepad";
import { noIntent, type Intent } from "./intent";
import type { Walker } from "./walker";
import { SnapTurn, baseFor, eyeOf, type Base, type Head } from "./xr_base";

/** A renderer that can narrow its picture: 0 not at all, 1 as far as it does. */
export interface ComfortVignette {
  vignette: number;
}

export type XrViewer = Pick<Viewer, "webgl" | "pose"> & Partial<ComfortVignette>;

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
    private readonly viewer: XrViewer,
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
    if (this.viewer.vignette === undefined) return;
    const wanted = Math.min(1, Math.hypot(intent.forward, intent.right));
    this.viewer.vignette +=
      (wanted - this.viewer.vignette) * approach(seconds, VIGNETTE_TIME_CONSTANT_S);
  }

  private ended(): void {
    this.session = null;
    this.base = null;
    if (this.viewer.vignette !== undefined) this.viewer.vignette = 0;
    this.walker.place({ pitch_rad: 0, roll_rad: 0, up_m: 0 });
    this.changed(false);
  }
}
