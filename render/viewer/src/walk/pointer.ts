// Looking with a mouse, a pen or fingers: the scene is grabbed and dragged, as in other viewers of
// panoramas. The wheel and two fingers zoom; a double click walks a step that way.
import { limit } from "../geometry/angles";
import { pixelAngle } from "./motion";
import type { InputSource, Intent } from "./intent";
import type { Walker } from "./walker";

const WHEEL_PER_PX = 0.0015;
const PX_PER_LINE = 16;
const PX_PER_PAGE = 400;
const MOST_WHEEL_PX = 300;
/** Near the zenith a small drag would be a large turn: there it is limited. */
const LEAST_COSINE = 0.3;

export class Pointer implements InputSource {
  private readonly fingers = new Map<number, { x: number; y: number }>();
  private yaw_rad = 0;
  private pitch_rad = 0;
  private magnify = 1;

  constructor(
    private readonly surface: HTMLElement,
    private readonly walker: Pick<Walker, "fov_y_rad" | "pose">,
    walkTowards: (x_px: number, y_px: number) => void,
  ) {
    surface.addEventListener("pointerdown", (event) => this.grab(event));
    surface.addEventListener("pointermove", (event) => this.drag(event));
    for (const type of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
      surface.addEventListener(type, (event) => this.letGo(event));
    }
    surface.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    surface.addEventListener("dblclick", (event) => walkTowards(event.offsetX, event.offsetY));
  }

  addTo(intent: Intent): void {
    intent.look_yaw_rad += this.yaw_rad;
    intent.look_pitch_rad += this.pitch_rad;
    intent.magnify *= this.magnify;
    this.yaw_rad = 0;
    this.pitch_rad = 0;
    this.magnify = 1;
  }

  private grab(event: PointerEvent): void {
    if (event.pointerType === "mouse" && event.button !== 0) return;
    this.surface.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.surface.classList.add("grabbed");
  }

  private drag(event: PointerEvent): void {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    if (this.fingers.size === 1) {
      this.turn(now.x - before.x, now.y - before.y);
    } else {
      const other = [...this.fingers].find(([id]) => id !== event.pointerId)?.[1];
      if (other) this.magnify *= spread(other, before, now);
    }
    this.fingers.set(event.pointerId, now);
  }

  private turn(dx_px: number, dy_px: number): void {
    const angle = pixelAngle(this.walker.fov_y_rad, this.surface.clientHeight);
    const { pitch_rad, roll_rad } = this.walker.pose;
    const turn = turnOfDrag(dx_px * angle, dy_px * angle, pitch_rad, roll_rad);
    this.yaw_rad += turn[0];
    this.pitch_rad += turn[1];
  }

  private letGo(event: PointerEvent): void {
    this.fingers.delete(event.pointerId);
    if (this.fingers.size === 0) this.surface.classList.remove("grabbed");
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.magnify *= magnificationOfWheel(event.deltaY, event.deltaMode);
  }
}

/** The turn that keeps the scene below the pointer, for a drag to the right and down. */
export function turnOfDrag(
  right_rad: number,
  down_rad: number,
  pitch_rad: number,
  roll_rad: number,
): [yaw_rad: number, pitch_rad: number] {
  // A head rolled clockwise sees the scene rolled the other way.
  const sin = Math.sin(roll_rad);
  const cos = Math.cos(roll_rad);
  const level_right_rad = right_rad * cos - down_rad * sin;
  const level_down_rad = right_rad * sin + down_rad * cos;
  return [-level_right_rad / Math.max(Math.cos(pitch_rad), LEAST_COSINE), level_down_rad];
}

export function magnificationOfWheel(delta: number, mode: number): number {
  const px_per_unit = mode === 1 ? PX_PER_LINE : mode === 2 ? PX_PER_PAGE : 1;
  return Math.exp(-WHEEL_PER_PX * limit(delta * px_per_unit, -MOST_WHEEL_PX, MOST_WHEEL_PX));
}

interface Point {
  x: number;
  y: number;
}

function spread(other: Point, before: Point, now: Point): number {
  const from_px = Math.hypot(before.x - other.x, before.y - other.y);
  const to_px = Math.hypot(now.x - other.x, now.y - other.y);
  return from_px > 1 && to_px > 1 ? to_px / from_px : 1;
}
