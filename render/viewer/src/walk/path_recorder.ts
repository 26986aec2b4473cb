// Records where one walks and looks, as a table that `raywalk-render path` and `export-web --path`
// read.
import type { Pose } from "../geometry/frame";
import type { PlanPosition } from "../geometry/grid";
import { DEGREE_RAD } from "../geometry/angles";

/** Often enough for a smooth curve through the poses, and for turns of less than half a circle. */
const EVERY_S = 0.2;
/** Less is no raised eye, which initial views cannot show. */
const RAISED_M = 0.0005;

interface Sample {
  time_s: number;
  pose: Pose;
}

export class PathRecorder {
  private samples: Sample[] = [];
  private latest: Sample | null = null; // null while nothing is recorded

  /** `heightAt` is that of the lines, in the room, from which poses count. */
  constructor(private readonly heightAt: (at: PlanPosition) => number) {}

  get recording(): boolean {
    return this.latest !== null;
  }

  start(pose: Pose): void {
    this.latest = { time_s: 0, pose: { ...pose } };
    this.samples = [this.latest];
  }

  /** Goes on by the time of a frame, in which the walker has come to a pose. */
  advance(seconds: number, pose: Pose): void {
    if (!this.latest) return;
    const time_s = this.latest.time_s + Math.max(seconds, 0);
    this.latest = { time_s, pose: { ...pose } };
    const before = this.samples[this.samples.length - 1]!;
    if (time_s - before.time_s >= EVERY_S) this.samples.push(this.latest);
  }

  /** Ends the recording with the pose of the last frame; the table, or null where nothing went by. */
  stop(): string | null {
    const last = this.samples[this.samples.length - 1];
    if (last && this.latest && this.latest.time_s > last.time_s) this.samples.push(this.latest);
    this.latest = null;
    return this.samples.length > 1 ? this.table() : null;
  }

  /** Places with all their digits: rounded ones may lie beyond the edge of what was captured. */
  private table(): string {
    const raised = this.samples.some(({ pose }) => Math.abs(pose.up_m) > RAISED_M);
    const angle = (angle_rad: number): string => (angle_rad / DEGREE_RAD).toFixed(3);
    const rows = this.samples.map(({ time_s, pose }, i) => [
      `pose${String(i + 1).padStart(5, "0")}`,
      pose.x_m,
      ...(raised ? [this.heightAt(pose) + pose.up_m] : []),
      pose.z_m,
      angle(pose.yaw_rad),
      angle(pose.pitch_rad),
      angle(pose.roll_rad),
      time_s.toFixed(3),
    ]);
    const header = ["name", "x", ...(raised ? ["y"] : []), "z", "yaw", "pitch", "roll", "time"];
    return [header, ...rows].map((row) => `${row.join(",")}\n`).join("");
  }
}
