// The keyboard: what each key does, in the order of the help, wherever the focus is, except in what
// uses the same keys itself.
import { RATES, type InputSource, type Intent } from "./intent";

interface Key {
  /** KeyboardEvent.key, letters in lower case, or KeyboardEvent.code. */
  keys: readonly string[];
  /** As written on keyboards. */
  shown: readonly string[];
  does: string;
}

/** Keys that move as long as they are held: what they add to the intent. */
export interface MovementKey extends Key {
  moves: Partial<Intent>;
}

export const MOVEMENT_KEYS: readonly MovementKey[] = [
  { keys: ["KeyW", "ArrowUp"], shown: ["W", "↑"], does: "Walk forward", moves: { forward: 1 } },
  { keys: ["KeyS", "ArrowDown"], shown: ["S", "↓"], does: "Walk backward", moves: { forward: -1 } },
  { keys: ["KeyA"], shown: ["A"], does: "Step to the left", moves: { right: -1 } },
  { keys: ["KeyD"], shown: ["D"], does: "Step to the right", moves: { right: 1 } },
  { keys: ["ArrowLeft"], shown: ["←"], does: "Turn left", moves: { turn: -1 } },
  { keys: ["ArrowRight"], shown: ["→"], does: "Turn right", moves: { turn: 1 } },
  { keys: ["KeyT"], shown: ["T"], does: "Look up", moves: { tilt: 1 } },
  { keys: ["KeyG"], shown: ["G"], does: "Look down", moves: { tilt: -1 } },
  { keys: ["KeyR", "PageUp"], shown: ["R", "Page up"], does: "Raise the eye", moves: { up: 1 } },
  {
    keys: ["KeyF", "PageDown"],
    shown: ["F", "Page down"],
    does: "Lower the eye",
    moves: { up: -1 },
  },
  { keys: ["KeyQ"], shown: ["Q"], does: "Tilt the head to the left", moves: { roll: -1 } },
  { keys: ["KeyE"], shown: ["E"], does: "Tilt the head to the right", moves: { roll: 1 } },
  { keys: ["Equal", "NumpadAdd", "+"], shown: ["+"], does: "Enlarge", moves: { zoom: 1 } },
  { keys: ["Minus", "NumpadSubtract", "-"], shown: ["−"], does: "Reduce", moves: { zoom: -1 } },
  {
    keys: ["ShiftLeft", "ShiftRight"],
    shown: ["Shift"],
    does: "Faster, held with another key",
    moves: { fast: true },
  },
];

/** Keys that do something once. */
export const COMMAND_KEYS = [
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
] as const;

export type Command = (typeof COMMAND_KEYS)[number]["command"];

/** The key of a table: signs are on other places of other keyboards, so they count before places. */
export function keyOf<Each extends Key>(
  table: readonly Each[],
  event: Pick<KeyboardEvent, "code" | "key">,
): Each | null {
  const signs = [event.key, event.key.toLowerCase()];
  const bySign = table.find(({ keys }) => keys.some((key) => signs.includes(key)));
  return bySign ?? table.find(({ keys }) => keys.includes(event.code)) ?? null;
}

export class Keyboard implements InputSource {
  /** Movements of the keys that are held, by KeyboardEvent.code. */
  private readonly held = new Map<string, MovementKey>();
  /** A key that is pressed and released between two frames still moves for one. */
  private readonly tapped = new Set<MovementKey>();

  constructor(
    target: Window,
    private readonly run: (command: Command) => void,
  ) {
    target.addEventListener("keydown", (event) => this.press(event));
    target.addEventListener("keyup", (event) => this.release(event));
    // Keys released elsewhere are not reported here.
    target.addEventListener("blur", () => this.held.clear());
  }

  addTo(intent: Intent): void {
    for (const { moves } of new Set([...this.held.values(), ...this.tapped])) {
      for (const axis of RATES) intent[axis] += moves[axis] ?? 0;
      intent.fast ||= moves.fast ?? false;
    }
    this.tapped.clear();
  }

  private press(event: KeyboardEvent): void {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    if (isTaken(event)) return;
    const command = keyOf(COMMAND_KEYS, event);
    if (command) {
      event.preventDefault();
      if (!event.repeat) this.run(command.command);
      return;
    }
    const movement = keyOf(MOVEMENT_KEYS, event);
    if (!movement) return;
    this.held.set(event.code, movement);
    this.tapped.add(movement);
    if (event.key !== "Shift") event.preventDefault();
  }

  private release(event: KeyboardEvent): void {
    this.held.delete(event.code);
    // macOS reports no release of keys while Command is held.
    if (event.key === "Meta") this.held.clear();
  }
}

const OWN_KEYS = /^(Arrow|Page|Home|End)/;

/** Whether the focused element needs this key: text fields all, sliders and choices their arrows. */
function isTaken(event: KeyboardEvent): boolean {
  const target = event.target;
  if (!(target instanceof Element)) return false;
  if (target.closest("dialog[open], textarea, select, [contenteditable]")) return true;
  if (target instanceof HTMLInputElement) {
    const isChoice = ["range", "radio", "checkbox", "button"].includes(target.type);
    return isChoice ? OWN_KEYS.test(event.key) : true;
  }
  return target.closest(".scrolls") !== null && OWN_KEYS.test(event.key);
}
