// Between the room and the flat picture: where a point is seen, and where a pixel looks.
import { Vector3 } from "three";
import {
  quaternionOf,
  threeFromWorld,
  worldFromThree,
  type Pose,
  type Vec3,
} from "../geometry/frame";

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
