// What the user wants to do in a frame. Every device adds to one intent; only the walker acts on it.
import { limit } from "../geometry/angles";

/** Speeds in -1..1 of the usual ones: walking, raising the eye, turning, towards a narrower picture. */
export const RATES = ["forward", "right", "up", "turn", "tilt", "roll", "zoom"] as const;

export interface Intent extends Record<(typeof RATES)[number], number> {
  /** Turns of this frame that are done at once, as a drag asks for them. */
  look_yaw_rad: number;
  look_pitch_rad: number;
  /** Factor of this frame by which the picture becomes larger. */
  magnify: number;
  fast: boolean;
}

/** A device, or a part of the page, that moves the walker. */
export interface InputSource {
  /** Adds what was asked since the last call. */
  addTo(intent: Intent): void;
}

export function noIntent(): Intent {
  return {
    forward: 0,
    right: 0,
    up: 0,
    turn: 0,
    tilt: 0,
    roll: 0,
    zoom: 0,
    look_yaw_rad: 0,
    look_pitch_rad: 0,
    magnify: 1,
    fast: false,
  };
}

export function readIntent(sources: readonly InputSource[]): Intent {
  const intent = noIntent();
  for (const source of sources) source.addTo(intent);
  return checked(intent);
}

/** Whether anything is to move; `fast` alone moves nothing. */
export function isActive(intent: Intent): boolean {
  const { fast: _, magnify, ...movements } = intent;
  return magnify !== 1 || Object.values(movements).some((value) => value !== 0);
}

/** Devices report what they like: speeds are kept in -1..1, and what is no number counts as none. */
function checked(intent: Intent): Intent {
  const length = Math.max(1, Math.hypot(intent.forward, intent.right));
  intent.forward /= length;
  intent.right /= length;
  for (const axis of RATES) intent[axis] = limit(finite(intent[axis]), -1, 1);
  intent.look_yaw_rad = finite(intent.look_yaw_rad);
  intent.look_pitch_rad = finite(intent.look_pitch_rad);
  if (!(intent.magnify > 0 && Number.isFinite(intent.magnify))) intent.magnify = 1;
  return intent;
}

function finite(value: number): number {
  return Number.isFinite(value) ? value : 0;
}
