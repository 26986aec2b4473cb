// Between the room and the flat picture: where a point is seen, where a pixel looks, and the poses
// that the page sends the walker to.
import { Vector3 } from "three";
import {
  quaternionOf,
  threeFromWorld,
  worldFromThree,
  type Pose,
  type Vec3,
} from "../geometry/frame";
import { DEGREE_RAD } from "../geometry/angles";
import type { Hotspot, Manifest } from "../manifest";

export interface Picture {
  fov_y_rad: number;
  width_px: number;
  height_px: number;
}

export interface Seen {
  x_px: number;
  y_px: number;
  /** From the eye to the point. */
  distance_m: number;
}

/** Points closer to the plane of the eye than this are not shown. */
const NEAREST_M = 0.01;

/**
 * Where a point of the room is in the picture; nothing for points behind the eye. height_m is that at
 * which the place was captured, from which the pose's up_m counts.
 */
export function project(
  point_m: Vec3,
  pose: Pose,
  height_m: number,
  picture: Picture,
): Seen | null {
  const seen = threeFromWorld([
    point_m[0] - pose.x_m,
    point_m[1] - height_m - pose.up_m,
    point_m[2] - pose.z_m,
  ]);
  const distance_m = seen.length();
  seen.applyQuaternion(quaternionOf(pose).conjugate());
  const depth_m = -seen.z;
  if (!(depth_m > NEAREST_M)) return null;
  const px_per_tangent = picture.height_px / 2 / Math.tan(picture.fov_y_rad / 2);
  return {
    x_px: picture.width_px / 2 + (seen.x / depth_m) * px_per_tangent,
    y_px: picture.height_px / 2 - (seen.y / depth_m) * px_per_tangent,
    distance_m,
  };
}

/** The direction in the room, of length 1, in which a pixel of the picture looks. */
export function directionOf(x_px: number, y_px: number, pose: Pose, picture: Picture): Vec3 {
  const tangent_per_px = (2 * Math.tan(picture.fov_y_rad / 2)) / Math.max(picture.height_px, 1);
  const direction = new Vector3(
    (x_px - picture.width_px / 2) * tangent_per_px,
    (picture.height_px / 2 - y_px) * tangent_per_px,
    -1,
  );
  return worldFromThree(direction.applyQuaternion(quaternionOf(pose)).normalize());
}

/** Straight up or down, a pixel shows no way to walk. */
const LEAST_HORIZONTAL = 1e-3;

/** Where the walk begins: what the address asks for, else what the export says. */
export function startPose({ start }: Pick<Manifest, "start">, asked: Partial<Pose>): Pose {
  const level = { up_m: 0, pitch_rad: 0, roll_rad: 0 };
  const place = { x_m: start.x_m, z_m: start.z_m, yaw_rad: start.yaw_deg * DEGREE_RAD };
  return { ...level, ...place, ...asked };
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
