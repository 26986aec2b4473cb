// The keyboard, wherever the focus is, except in what uses the same keys itself.
import type { InputSource, Intent } from "./intent";
import { commandKey, movementKey, type Command, type MovementKey } from "./keys";

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
    for (const key of new Set([...this.held.values(), ...this.tapped])) key.addTo(intent);
    this.tapped.clear();
  }

  private press(event: KeyboardEvent): void {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    if (isTaken(event)) return;
    // Commands first: they go by the letter, movements by the place on the keyboard.
    const command = commandKey(event);
    if (command) {
      event.preventDefault();
      if (!event.repeat) this.run(command.command);
      return;
    }
    const movement = movementKey(event);
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
  return target.closest("[role=slider], .scrolls") !== null && OWN_KEYS.test(event.key);
}
