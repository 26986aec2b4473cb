// The keys: what each does, in the order of the help.
import type { Intent } from "./intent";

export type Command =
  | "initial"
  | "hlf-vd"
  | "two-sided"
  | "settings"
  | "plan"
  | "play"
  | "record"
  | "compare"
  | "screenshot"
  | "fullscreen"
  | "where"
  | "info"
  | "help"
  | "level"
  | "close";

interface Documented {
  /** As written on keyboards. */
  shown: readonly string[];
  does: string;
}

/** Keys that move as long as they are held, by their place on the keyboard (KeyboardEvent.code). */
export interface MovementKey extends Documented {
  codes: readonly string[];
  addTo(intent: Intent): void;
}

/** Keys that do something once, by KeyboardEvent.key in lower case or by KeyboardEvent.code. */
export interface CommandKey extends Documented {
  keys: readonly string[];
  command: Command;
}

export const MOVEMENT_KEYS: readonly MovementKey[] = [
  {
    codes: ["KeyW", "ArrowUp"],
    shown: ["W", "↑"],
    does: "Walk forward",
    addTo: (intent) => void (intent.forward += 1),
  },
  {
    codes: ["KeyS", "ArrowDown"],
    shown: ["S", "↓"],
    does: "Walk backward",
    addTo: (intent) => void (intent.forward -= 1),
  },
  {
    codes: ["KeyA"],
    shown: ["A"],
    does: "Step to the left",
    addTo: (intent) => void (intent.right -= 1),
  },
  {
    codes: ["KeyD"],
    shown: ["D"],
    does: "Step to the right",
    addTo: (intent) => void (intent.right += 1),
  },
  {
    codes: ["ArrowLeft"],
    shown: ["←"],
    does: "Turn left",
    addTo: (intent) => void (intent.turn -= 1),
  },
  {
    codes: ["ArrowRight"],
    shown: ["→"],
    does: "Turn right",
    addTo: (intent) => void (intent.turn += 1),
  },
  {
    codes: ["KeyT"],
    shown: ["T"],
    does: "Look up",
    addTo: (intent) => void (intent.tilt += 1),
  },
  {
    codes: ["KeyG"],
    shown: ["G"],
    does: "Look down",
    addTo: (intent) => void (intent.tilt -= 1),
  },
  {
    codes: ["KeyR", "PageUp"],
    shown: ["R", "Page up"],
    does: "Raise the eye",
    addTo: (intent) => void (intent.up += 1),
  },
  {
    codes: ["KeyF", "PageDown"],
    shown: ["F", "Page down"],
    does: "Lower the eye",
    addTo: (intent) => void (intent.up -= 1),
  },
  {
    codes: ["KeyQ"],
    shown: ["Q"],
    does: "Tilt the head to the left",
    addTo: (intent) => void (intent.roll -= 1),
  },
  {
    codes: ["KeyE"],
    shown: ["E"],
    does: "Tilt the head to the right",
    addTo: (intent) => void (intent.roll += 1),
  },
  {
    codes: ["Equal", "NumpadAdd", "+"],
    shown: ["+"],
    does: "Enlarge",
    addTo: (intent) => void (intent.zoom += 1),
  },
  {
    codes: ["Minus", "NumpadSubtract", "-"],
    shown: ["−"],
    does: "Reduce",
    addTo: (intent) => void (intent.zoom -= 1),
  },
  {
    codes: ["ShiftLeft", "ShiftRight"],
    shown: ["Shift"],
    does: "Faster, held with another key",
    addTo: (intent) => void (intent.fast = true),
  },
];

export const COMMAND_KEYS: readonly CommandKey[] = [
  {
    keys: ["0", "Digit0", "Numpad0"],
    shown: ["0"],
    does: "Level the view again",
    command: "level",
  },
  { keys: ["1", "Digit1"], shown: ["1"], does: "Views: initial", command: "initial" },
  { keys: ["2", "Digit2"], shown: ["2"], does: "Views: hlf-vd", command: "hlf-vd" },
  { keys: ["3", "Digit3"], shown: ["3"], does: "Views: two-sided", command: "two-sided" },
  { keys: ["k"], shown: ["K"], does: "Choose how views are made, and k", command: "settings" },
  { keys: ["m"], shown: ["M"], does: "Show or hide the plan", command: "plan" },
  { keys: ["p"], shown: ["P"], does: "Play or pause the recorded path", command: "play" },
  { keys: ["v"], shown: ["V"], does: "Record a path, and save it", command: "record" },
  { keys: ["b"], shown: ["B"], does: "Compare with ground truth", command: "compare" },
  { keys: ["c"], shown: ["C"], does: "Save a screenshot", command: "screenshot" },
  { keys: ["x"], shown: ["X"], does: "Full screen", command: "fullscreen" },
  { keys: ["l"], shown: ["L"], does: "Say where one is", command: "where" },
  { keys: ["i"], shown: ["I"], does: "About this room", command: "info" },
  { keys: ["?", "h"], shown: ["?", "H"], does: "Show this help", command: "help" },
  { keys: ["escape"], shown: ["Esc"], does: "Close what is open", command: "close" },
];

export function movementKey(event: Pick<KeyboardEvent, "code" | "key">): MovementKey | null {
  // "+" and "-" are on other places of other keyboards: their sign counts before their place.
  const bySign = MOVEMENT_KEYS.find((each) => each.codes.includes(event.key));
  return bySign ?? MOVEMENT_KEYS.find((each) => each.codes.includes(event.code)) ?? null;
}

export function commandKey(event: Pick<KeyboardEvent, "code" | "key">): CommandKey | null {
  const key = event.key.toLowerCase();
  const bySign = COMMAND_KEYS.find((each) => each.keys.includes(key));
  return bySign ?? COMMAND_KEYS.find((each) => each.keys.includes(event.code)) ?? null;
}
