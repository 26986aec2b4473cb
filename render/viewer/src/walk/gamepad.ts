// A gamepad of the standard mapping: the left stick walks, the right one looks, the triggers zoom,
// the shoulder buttons raise and lower the eye.
import type { InputSource, Intent } from "./intent";

const DEAD_ZONE = 0.15;

/** Buttons of the standard mapping. */
const LEFT_SHOULDER = 4;
const RIGHT_SHOULDER = 5;
const LEFT_TRIGGER = 6;
const RIGHT_TRIGGER = 7;
const LEFT_STICK = 10;

export interface PadState {
  mapping: string;
  connected: boolean;
  axes: readonly number[];
  buttons: readonly { value: number; pressed: boolean }[];
}

export class Gamepads implements InputSource {
  constructor(private readonly read: () => readonly (PadState | null)[] = connectedPads) {}

  addTo(intent: Intent): void {
    for (const pad of this.read()) {
      if (pad?.connected && pad.mapping === "standard") addPad(pad, intent);
    }
  }
}

/** A stick's position without the dead zone in its middle: 0..1 outside it, with its direction. */
export function stick(x: number | undefined, y: number | undefined): [x: number, y: number] {
  const length = Math.hypot(x ?? 0, y ?? 0);
  if (!(length > DEAD_ZONE)) return [0, 0];
  const factor = Math.min(1, (length - DEAD_ZONE) / (1 - DEAD_ZONE)) / length;
  return [(x ?? 0) * factor, (y ?? 0) * factor];
}

function addPad(pad: PadState, intent: Intent): void {
  const [right, backward] = stick(pad.axes[0], pad.axes[1]);
  const [turn, down] = stick(pad.axes[2], pad.axes[3]);
  const pressed = (button: number): number => trigger(pad.buttons[button]?.value ?? 0);
  intent.right += right;
  intent.forward -= backward;
  intent.turn += turn;
  intent.tilt -= down;
  intent.up += pressed(RIGHT_SHOULDER) - pressed(LEFT_SHOULDER);
  intent.zoom += pressed(RIGHT_TRIGGER) - pressed(LEFT_TRIGGER);
  if (pad.buttons[LEFT_STICK]?.pressed) intent.fast = true;
}

function trigger(value: number): number {
  return value > DEAD_ZONE ? value : 0;
}

/** Browsers refuse the list to pages that may not use gamepads. */
function connectedPads(): readonly (Gamepad | null)[] {
  try {
    return navigator.getGamepads?.() ?? [];
  } catch {
    return [];
  }
}
