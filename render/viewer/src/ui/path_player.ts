// Plays the recorded path: play, pause, seek. Any movement by the user ends it.
import { DEGREE_RAD, limit } from "../geometry/angles";
import type { Pose } from "../geometry/frame";
import type { Viewer } from "../field/viewer";
import type { Walker } from "../walk/walker";
import { element, iconButton } from "./dom";
import { icon } from "./icons";

type State = "stopped" | "going there" | "playing" | "paused";

export class PathPlayer {
  readonly element = element("div", {
    class: "sheet player",
    testid: "player",
    attributes: { role: "group", "aria-label": "Recorded path" },
  });
  private readonly duration_s: number;
  private readonly seek = element("input", {
    attributes: { type: "range", min: "0", step: "0.1", "aria-label": "Position on the path" },
  });
  private readonly clock = element("span", { class: "clock" });
  private readonly button = iconButton(icon("pause"), "Pause", () => this.toggle());
  private state: State = "stopped";
  private time_s = 0;

  constructor(
    private readonly viewer: Pick<Viewer, "manifest" | "grid">,
    private readonly walker: Walker,
    private readonly again: boolean,
    private readonly changed: () => void,
  ) {
    const { path, path_frames_per_s } = viewer.manifest;
    this.duration_s = Math.max(path.length - 1, 0) / path_frames_per_s;
    this.seek.max = String(this.duration_s);
    this.seek.addEventListener("input", () => this.seekTo(Number(this.seek.value)));
    const stop = iconButton(icon("close"), "End the path", () => this.stop());
    this.element.append(this.button, this.seek, this.clock, stop);
    this.show();
  }

  get playable(): boolean {
    return this.duration_s > 0;
  }

  /** Whether the path moves the walker, or will. */
  get playing(): boolean {
    return this.state === "playing" || this.state === "going there";
  }

  toggle(): void {
    if (this.playing) this.enter("paused");
    else this.play();
  }

  /** Goes on, or begins; the walker glides to the path first. */
  play(): void {
    if (!this.playable) return;
    if (this.time_s >= this.duration_s) this.time_s = 0;
    this.enter("going there");
    this.walker.glideTo(this.at(this.time_s), () => {
      if (this.state === "going there") this.enter("playing");
    });
  }

  stop(): void {
    if (this.state === "stopped") return;
    this.time_s = 0;
    this.enter("stopped");
  }

  advance(seconds: number): void {
    if (this.state !== "playing") return;
    this.time_s += seconds;
    this.walker.place(this.at(this.time_s));
    if (this.time_s < this.duration_s) {
      this.showTime();
      return;
    }
    if (this.again) this.play();
    else this.stop();
  }

  /** Straight between the views of the path, which are close to each other. */
  private at(time_s: number): Pose {
    const { path, path_frames_per_s } = this.viewer.manifest;
    const gone = limit(time_s * path_frames_per_s, 0, path.length - 1);
    const from = path[Math.floor(gone)]!;
    const to = path[Math.ceil(gone)]!;
    const between = (a: number, b: number): number => a + (b - a) * (gone % 1);
    const turned = (key: "yaw_deg" | "pitch_deg" | "roll_deg"): number =>
      between(from[key], to[key]) * DEGREE_RAD;
    const place = { x_m: between(from.x_m, to.x_m), z_m: between(from.z_m, to.z_m) };
    const raised = from.y_m !== undefined && to.y_m !== undefined;
    return {
      ...place,
      up_m: raised ? between(from.y_m!, to.y_m!) - this.viewer.grid.heightAt(place) : 0,
      yaw_rad: turned("yaw_deg"),
      pitch_rad: turned("pitch_deg"),
      roll_rad: turned("roll_deg"),
    };
  }

  private seekTo(time_s: number): void {
    this.time_s = time_s;
    if (this.state !== "playing") this.enter("paused");
    this.walker.place(this.at(time_s));
    this.showTime();
  }

  private enter(state: State): void {
    if (state === "paused" && this.walker.gliding) this.walker.place({});
    this.state = state;
    this.show();
    this.changed();
  }

  private show(): void {
    this.element.hidden = this.state === "stopped";
    const label = this.playing ? "Pause" : "Play";
    this.button.replaceChildren(icon(this.playing ? "pause" : "play"));
    this.button.setAttribute("aria-label", label);
    this.button.title = label;
    this.showTime();
  }

  private showTime(): void {
    this.seek.value = String(this.time_s);
    const text = `${minutes(this.time_s)} / ${minutes(this.duration_s)}`;
    if (this.clock.textContent === text) return;
    this.clock.textContent = text;
    this.seek.setAttribute("aria-valuetext", text);
  }
}

function minutes(seconds: number): string {
  const whole = Math.floor(Math.max(seconds, 0));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
