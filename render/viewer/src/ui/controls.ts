// Everything that the walker listens to, on one element.
import type { Walker } from "../walk/walker";
import { Gamepads } from "../walk/gamepad";
import { readIntent, type InputSource, type Intent } from "../walk/intent";
import { Keyboard } from "../walk/keyboard";
import type { Command } from "../walk/keys";
import { MovePad } from "../walk/move_pad";
import { Pointer } from "../walk/pointer";

export class Controls {
  readonly pad = new MovePad();
  private readonly sources: readonly InputSource[];

  constructor(
    surface: HTMLElement,
    walker: Walker,
    run: (command: Command) => void,
    walkTowards: (x_px: number, y_px: number) => void,
  ) {
    const looking = {
      fov_y_rad: () => walker.fov_y_rad,
      pitch_rad: () => walker.pose.pitch_rad,
      roll_rad: () => walker.pose.roll_rad,
    };
    this.sources = [
      new Keyboard(window, run),
      new Pointer(surface, looking, walkTowards),
      this.pad,
      new Gamepads(),
    ];
  }

  read(): Intent {
    return readIntent(this.sources);
  }
}
