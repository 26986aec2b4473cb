// Hybrid connection: the angle at which the columns of a view change from one line of a cell to the
// next. The same rule as core/view/connection.h, which explains it; tests compare the two.
import { HALF_PI, limit } from "./angles";

export interface ConnectionRule {
  k_rad: number; // 45 to 90 degrees
  overlap_rad: number; // width of the blend
}

/** A corner as seen from the viewpoint; metres, all >= 0. */
export interface CornerView {
  toNextSide_m: number; // a
  toThisSide_m: number; // b
  overhangThis_m: number;
  overhangNext_m: number;
}

/** Angles from the normal of this side towards the next side. */
export interface CornerConnection {
  blendBegin: number; // this side alone up to here
  blendEnd: number; // the next side alone from here
}

export function connectCorner(corner: CornerView, rule: ConnectionRule): CornerConnection {
  const wanted = limit(
    Math.atan2(corner.toNextSide_m, corner.toThisSide_m),
    HALF_PI - rule.k_rad,
    rule.k_rad,
  );
  const shared = sharedAngles(corner);
  const cut = limit(wanted, shared.begin, shared.end);
  const half = 0.5 * rule.overlap_rad;
  return {
    blendBegin: Math.max(cut - half, shared.begin),
    blendEnd: Math.min(cut + half, shared.end),
  };
}

/** Weight of the next side's line at an angle: 0 before the blend, 1 after it, linear within. */
export function nextSideWeight(connection: CornerConnection, angle: number): number {
  if (angle <= connection.blendBegin) return 0;
  if (angle >= connection.blendEnd) return 1;
  return (angle - connection.blendBegin) / (connection.blendEnd - connection.blendBegin);
}

/** Smallest and largest angle at which both lines can be read. */
function sharedAngles(corner: CornerView): { begin: number; end: number } {
  const a = corner.toNextSide_m;
  const b = corner.toThisSide_m;
  // A viewpoint on the corner itself reads both lines there at every angle.
  if (a === 0 && b === 0) return { begin: 0, end: HALF_PI };
  return {
    begin: Math.atan2(a, b + corner.overhangNext_m),
    end: Math.atan2(a + corner.overhangThis_m, b),
  };
}
