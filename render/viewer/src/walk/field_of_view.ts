// The flat picture's field of view: its limits, and what it means in pixels.
import { DEGREE_RAD, limit } from "../geometry/angles";

export const LEAST_FOV_Y_RAD = 30 * DEGREE_RAD;
export const MOST_FOV_Y_RAD = 110 * DEGREE_RAD;

export function limitFov(fov_y_rad: number): number {
  return limit(fov_y_rad, LEAST_FOV_Y_RAD, MOST_FOV_Y_RAD);
}

/** The horizontal angle of a flat picture with this vertical one; aspect is width / height. */
export function horizontalFov(fov_y_rad: number, aspect: number): number {
  return 2 * Math.atan(Math.tan(fov_y_rad / 2) * aspect);
}

/** The angle that one pixel covers in the middle of the picture. */
export function pixelAngle(fov_y_rad: number, height_px: number): number {
  return (2 * Math.tan(fov_y_rad / 2)) / Math.max(height_px, 1);
}
