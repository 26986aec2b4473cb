// The pad for walking with a thumb: drag from its middle, or press its four buttons, which keys and
// screen readers reach too.
import type { InputSource, Intent } from "../walk/intent";
import { element } from "./dom";

/** A step by a screen reader's or a switch's click, which has no duration. */
const CLICK_S = 0.4;

interface Direction {
  name: "forward" | "left" | "right" | "backward";
  label: string;
  right: number;
  forward: number;
}

const DIRECTIONS: readonly Direction[] = [
  { name: "forward", label: "Walk forward", right: 0, forward: 1 },
  { name: "left", label: "Step to the left", right: -1, forward: 0 },
  { name: "right", label: "Step to the right", right: 1, forward: 0 },
  { name: "backward", label: "Walk backward", right: 0, forward: -1 },
];

export class MovePad implements InputSource {
  readonly element = element("div", {
    class: "move-pad",
    testid: "move-pad",
    attributes: { role: "group", "aria-label": "Walk" },
  });
  private readonly knob = element("div", { class: "move-pad-knob" });
  private thumb: { id: number; right: number; forward: number } | null = null;
  private pressed: Direction | null = null;
  private stepping: { direction: Direction; until_ms: number } | null = null;

  constructor() {
    this.element.append(...DIRECTIONS.map((direction) => this.button(direction)), this.knob);
    this.element.addEventListener("pointerdown", (event) => this.touch(event));
    this.element.addEventListener("pointermove", (event) => this.drag(event));
    for (const type of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
      this.element.addEventListener(type, (event) => this.lift(event));
    }
    this.element.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  addTo(intent: Intent): void {
    if (this.stepping && performance.now() > this.stepping.until_ms) this.stepping = null;
    for (const asked of [this.thumb, this.pressed, this.stepping?.direction]) {
      intent.right += asked?.right ?? 0;
      intent.forward += asked?.forward ?? 0;
    }
  }

  private button(direction: Direction): HTMLButtonElement {
    const button = element("button", {
      class: `move-pad-${direction.name}`,
      attributes: { type: "button", "aria-label": direction.label },
    });
    button.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault(); // a click as well would be a step of its own
      this.pressed = direction;
    });
    const release = (): void => void (this.pressed = null);
    button.addEventListener("keyup", release);
    button.addEventListener("blur", release);
    button.addEventListener("click", (event) => {
      // Pointers have walked while they were down.
      if (event.detail > 0) return;
      this.stepping = { direction, until_ms: performance.now() + CLICK_S * 1000 };
    });
    return button;
  }

  private touch(event: PointerEvent): void {
    if (this.thumb) return;
    this.element.setPointerCapture(event.pointerId);
    this.thumb = { id: event.pointerId, right: 0, forward: 0 };
    this.drag(event);
  }

  private drag(event: PointerEvent): void {
    if (this.thumb?.id !== event.pointerId) return;
    const box = this.element.getBoundingClientRect();
    const [right, forward] = positionOnPad(event.clientX, event.clientY, box);
    this.thumb.right = right;
    this.thumb.forward = forward;
    this.moveKnob(right, forward);
  }

  private lift(event: PointerEvent): void {
    if (this.thumb?.id !== event.pointerId) return;
    this.thumb = null;
    this.moveKnob(0, 0);
  }

  private moveKnob(right: number, forward: number): void {
    this.knob.style.setProperty("--thumb-right", String(right));
    this.knob.style.setProperty("--thumb-forward", String(forward));
  }
}

/** Of full speed, for a thumb on a pad: none in the middle, all from 0.8 of its radius on. */
export function positionOnPad(
  x_px: number,
  y_px: number,
  box: { left: number; top: number; width: number; height: number },
): [right: number, forward: number] {
  const radius_px = Math.max(Math.min(box.width, box.height) * 0.4, 1);
  const right = (x_px - box.left - box.width / 2) / radius_px;
  const forward = -(y_px - box.top - box.height / 2) / radius_px;
  const length = Math.max(1, Math.hypot(right, forward));
  return [right / length, forward / length];
}
