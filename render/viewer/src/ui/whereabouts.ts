// Where one is, in words, for those who do not see it.
import type { Pose } from "../geometry/frame";
import type { Grid, PlanPosition } from "../geometry/grid";
import { decimals } from "./numbers";

/** By eighths of a turn to the right. The front of a room is where its directions are counted from. */
const DIRECTIONS = [
  "the front",
  "the front right",
  "the right",
  "the back right",
  "the back",
  "the back left",
  "the left",
  "the front left",
] as const;

export function directionName(yaw_rad: number): string {
  const eighth = Math.round(yaw_rad / (Math.PI / 4));
  return DIRECTIONS[((eighth % 8) + 8) % 8]!;
}

export function describePlace(pose: Pose, middle: PlanPosition): string {
  const parts = [
    distance(pose.x_m - middle.x_m, "right", "left"),
    distance(pose.z_m - middle.z_m, "forward", "back"),
  ].filter((part) => part !== null);
  const place = parts.length > 0 ? `${parts.join(", ")} of the middle` : "In the middle";
  return `${place}, looking to ${directionName(pose.yaw_rad)} of the room.`;
}

export function middleOf(grid: Pick<Grid, "bounds">): PlanPosition {
  const { x_min_m, x_max_m, z_min_m, z_max_m } = grid.bounds();
  return { x_m: (x_min_m + x_max_m) / 2, z_m: (z_min_m + z_max_m) / 2 };
}

function distance(offset_m: number, ahead: string, behind: string): string | null {
  const text = decimals(Math.abs(offset_m), 1);
  if (Number(text) === 0) return null;
  return `${text} m ${offset_m > 0 ? ahead : behind}`;
}

const STILL_MS = 1500;
const LEAST_BETWEEN_MS = 5000;

/** Says where one is when one has come to rest, but not at every stop. */
export class Whereabouts {
  private text = "";
  private since_ms = 0;
  private said = "";
  private said_ms = 0;

  constructor(
    private readonly middle: PlanPosition,
    private readonly say: (text: string) => void,
  ) {}

  update(pose: Pose, now_ms: number): void {
    const text = describePlace(pose, this.middle);
    if (text !== this.text) {
      this.text = text;
      this.since_ms = now_ms;
    }
    // The first place is the start: nothing has changed yet.
    if (this.said === "") this.said = text;
    const rested = now_ms - this.since_ms > STILL_MS;
    if (text === this.said || !rested || now_ms - this.said_ms < LEAST_BETWEEN_MS) return;
    this.sayNow(pose, now_ms);
  }

  sayNow(pose: Pose, now_ms: number): void {
    const text = describePlace(pose, this.middle);
    this.say(text);
    this.said = text;
    this.said_ms = now_ms;
  }
}
