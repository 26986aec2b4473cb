// How long nobody has touched anything: a kiosk then begins again, and full screen hides its tools.

/** Calls back once when nothing has happened for a while, and again after more input. */
export class Idle {
  private last_ms: number;
  private told = false;

  constructor(
    private readonly after_ms: number,
    private readonly idle: () => void,
    now_ms: number,
  ) {
    this.last_ms = now_ms;
  }

  touch(now_ms: number): void {
    this.last_ms = now_ms;
    this.told = false;
  }

  update(now_ms: number): void {
    if (this.told || now_ms - this.last_ms < this.after_ms) return;
    this.told = true;
    this.idle();
  }
}

const INPUT_EVENTS = ["pointerdown", "pointermove", "keydown", "wheel", "focusin"] as const;

/** Calls back on every input by pointers and keys. */
export function onInput(target: HTMLElement, touched: () => void): void {
  for (const type of INPUT_EVENTS) {
    target.addEventListener(type, touched, { capture: true, passive: true });
  }
}
