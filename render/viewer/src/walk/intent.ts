// What the user wants to do in a frame. Every device adds to one intent; only the walker acts on it.

export interface Intent {
  /** Speeds in -1..1 of the usual ones: walking, raising the eye, turning. */
  forward: number;
  right: number;
  up: number;
  turn: number;
  tilt: number;
  roll: number;
  /** Towards a narrower picture, -1..1. */
  zoom: number;
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
  return {
    forward: rate(intent.forward / length),
    right: rate(intent.right / length),
    up: rate(intent.up),
    turn: rate(intent.turn),
    tilt: rate(intent.tilt),
    roll: rate(intent.roll),
    zoom: rate(intent.zoom),
    look_yaw_rad: finite(intent.look_yaw_rad),
    look_pitch_rad: finite(intent.look_pitch_rad),
    magnify: intent.magnify > 0 && Number.isFinite(intent.magnify) ? intent.magnify : 1,
    fast: intent.fast,
  };
}

function rate(value: number): number {
  return Math.min(Math.max(finite(value), -1), 1);
}

function finite(value: number): number {
  return Number.isFinite(value) ? value : 0;
}
