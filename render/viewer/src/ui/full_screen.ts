// Full screen, where the tools hide when nothing is touched; and pictures to take home.
import type { Pose } from "../geometry/frame";
import type { Viewer } from "../field/viewer";
import { DEGREE_RAD } from "../geometry/angles";
import { download } from "./dom";
import { decimals } from "./numbers";

const HIDE_AFTER_MS = 4000;

export class FullScreen {
  private readonly idle = new Idle(HIDE_AFTER_MS, () => this.hideTools(), performance.now());

  constructor(
    private readonly root: HTMLElement,
    changed: () => void,
  ) {
    document.addEventListener("fullscreenchange", () => {
      this.touch(performance.now());
      changed();
    });
  }

  /** Phones may have none. */
  get available(): boolean {
    return document.fullscreenEnabled === true;
  }

  get active(): boolean {
    return document.fullscreenElement !== null;
  }

  toggle(): void {
    const done = this.active ? document.exitFullscreen() : this.root.requestFullscreen();
    // Refused without a user's gesture, or by a frame around the page: nothing to do about it.
    done.catch(() => {});
  }

  touch(now_ms: number): void {
    this.idle.touch(now_ms);
    this.root.classList.remove("quiet");
  }

  update(now_ms: number): void {
    this.idle.update(now_ms);
  }

  private hideTools(): void {
    if (this.active) this.root.classList.add("quiet");
  }
}

export async function saveScreenshot(
  viewer: Pick<Viewer, "manifest" | "screenshot">,
  pose: Pose,
): Promise<void> {
  download(await viewer.screenshot(), screenshotName(viewer.manifest.title, pose));
}

/** A room's name as every file system takes it. */
export function fileStem(title: string): string {
  return title.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-+|-+$/g, "") || "room";
}

/** A name that says what is seen. */
export function screenshotName(title: string, pose: Pose): string {
  const room = fileStem(title);
  const place = `x${decimals(pose.x_m, 2)}-z${decimals(pose.z_m, 2)}`;
  return `${room}-${place}-yaw${decimals(pose.yaw_rad / DEGREE_RAD, 0)}.png`;
}

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
