// Poses that the page sends the walker to.
import type { Pose } from "../geometry/frame";
import type { Grid, PlanPosition } from "../geometry/grid";
import { viewHeight } from "../geometry/view_height";
import type { Hotspot, Manifest } from "../manifest";
import { DEGREE_RAD } from "../geometry/angles";
import { directionOf, type Picture } from "./projection";

/** Straight up or down, a pixel shows no way to walk. */
const LEAST_HORIZONTAL = 1e-3;

/** Where the walk begins: what the address asks for, else what the export says. */
export function startPose({ start }: Pick<Manifest, "start">, asked: Partial<Pose>): Pose {
  const level = { up_m: 0, pitch_rad: 0, roll_rad: 0 };
  const place = { x_m: start.x_m, z_m: start.z_m, yaw_rad: start.yaw_deg * DEGREE_RAD };
  return { ...level, ...place, ...asked };
}

/** The height, in the room, at which a place was captured. */
export function capturedHeight(grid: Grid, at: PlanPosition): number {
  return viewHeight(grid.lines, grid.findCell(at), at);
}

/** The turn towards a point of the room; height_m is that of the eye. */
export function lookingAt(point: Hotspot, pose: Pose, height_m: number): Partial<Pose> {
  const x_m = point.x_m - pose.x_m;
  const z_m = point.z_m - pose.z_m;
  return {
    yaw_rad: Math.atan2(x_m, z_m),
    pitch_rad: Math.atan2(point.y_m - height_m, Math.hypot(x_m, z_m)),
    roll_rad: 0,
  };
}

/** A step towards what a pixel shows. */
export function stepTowards(
  x_px: number,
  y_px: number,
  pose: Pose,
  picture: Picture,
  step_m: number,
): Partial<Pose> {
  const [x, , z] = directionOf(x_px, y_px, pose, picture);
  const factor_m = step_m / Math.max(Math.hypot(x, z), LEAST_HORIZONTAL);
  return { x_m: pose.x_m + x * factor_m, z_m: pose.z_m + z * factor_m };
}
