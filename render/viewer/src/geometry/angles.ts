// Angles, radians unless a name says otherwise. As core/geometry/sphere.h has them.

export const HALF_PI = 0.5 * Math.PI;
export const TWO_PI = 2 * Math.PI;

export function radiansFromDegrees(degrees: number): number {
  return (degrees * Math.PI) / 180;
}

/** In [-pi, pi). */
export function wrapAngle(angle: number): number {
  const turns = Math.floor((angle + Math.PI) / TWO_PI);
  return angle - turns * TWO_PI;
}

/** Longitude of the middle of column `u` of a panorama `width` wide. */
export function thetaOfColumn(u: number, width: number): number {
  return ((u + 0.5) / width) * TWO_PI - Math.PI;
}
