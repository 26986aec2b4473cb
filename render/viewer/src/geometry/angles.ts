// Angles, radians unless a name says otherwise, as core/geometry/sphere.h has them.

export const HALF_PI = 0.5 * Math.PI;
export const TWO_PI = 2 * Math.PI;
export const DEGREE_RAD = Math.PI / 180;

/** In [-pi, pi). */
export function wrapAngle(angle: number): number {
  const turns = Math.floor((angle + Math.PI) / TWO_PI);
  return angle - turns * TWO_PI;
}

/** The shortest turn from one direction to another, in [-pi, pi). */
export function turnBetween(from_rad: number, to_rad: number): number {
  return wrapAngle(to_rad - from_rad);
}

export function limit(value: number, least: number, most: number): number {
  return Math.min(Math.max(value, least), most);
}

/** Longitude of the middle of column `u` of a panorama `width` wide. */
export function thetaOfColumn(u: number, width: number): number {
  return ((u + 0.5) / width) * TWO_PI - Math.PI;
}
