// A kiosk: the bare view, which begins again when its visitor has left.
import { Idle } from "./idle";
import type { ToolName } from "./toolbar";

const IDLE_MS = 60_000;

/** What keys may still do: nothing that would leave something open for the next visitor. */
const ALLOWED: ReadonlySet<ToolName> = new Set<ToolName>([
  "close",
  "help",
  "level",
  "play",
  "where",
]);

export class Kiosk {
  private readonly idle: Idle;

  constructor(
    readonly on: boolean,
    beginAgain: () => void,
  ) {
    this.idle = new Idle(IDLE_MS, on ? beginAgain : () => {}, performance.now());
  }

  allows(tool: ToolName): boolean {
    return !this.on || ALLOWED.has(tool);
  }

  touch(now_ms: number): void {
    this.idle.touch(now_ms);
  }

  update(now_ms: number): void {
    this.idle.update(now_ms);
  }
}
