// The lines and stations that every column of a view is read from: core/view/view_plan.h, which
// explains the geometry, for the stations of an exported room that are loaded. Tests compare the two.
import type { Cell, Line } from "../manifest";
import { HALF_PI, TWO_PI, limit, wrapAngle } from "./angles";
import { alongLine, firstOf, lastOf, type PlanPosition } from "./grid";

/** One line that a column is read from. */
export interface RaySource {
  line: number;
  /** The station before the acquisition point; station + 1 is the one after it. */
  station: number;
  /** Of the way from `station` to `station + 1`, in [0, 1]. */
  fraction: number;
  /** Signed distance in the plan from the viewpoint to the acquisition point. */
  d_p_m: number;
  /** Share in the blend of a connection, in (0, 1]. */
  weight: number;
}

/** At most two lines in front and two behind. */
export interface ColumnPlan {
  front: RaySource[];
  behind: RaySource[];
}

interface LineIntersection {
  d_p_m: number;
  along_m: number;
}

const SIDES = 4;

export class ViewPlan {
  private readonly sides: Line[] | null;
  private readonly sideLines: number[] = [];
  private readonly corners: CornerConnection[] = [];

  /**
   * `lines` with at least two stations each. A viewpoint in a cell is rendered from its four lines;
   * without a cell, columns are rendered from the nearest line that their ray crosses.
   */
  constructor(
    private readonly lines: Line[],
    cell: Cell | null,
    private readonly viewpoint: PlanPosition,
    rule: ConnectionRule,
  ) {
    this.sides = cell && cell.lines.map((line) => lines[line]!);
    if (!cell) return;
    this.sideLines = cell.lines;
    for (let side = 0; side < SIDES; ++side) {
      this.corners.push(connectCorner(this.cornerView(cell, side), rule));
    }
  }

  column(theta: number): ColumnPlan {
    const front = this.sourcesAt(wrapAngle(theta));
    // The line behind is the line in front of the opposite column, at negative distance.
    const behind = this.sourcesAt(wrapAngle(theta + Math.PI));
    for (const source of behind) source.d_p_m = -source.d_p_m;
    return { front, behind };
  }

  private sourcesAt(theta: number): RaySource[] {
    return this.sides ? this.cellSources(theta, this.sides) : this.openSources(theta);
  }

  private cellSources(theta: number, sides: Line[]): RaySource[] {
    const turn = theta < 0 ? theta + TWO_PI : theta;
    const side = Math.min(Math.floor(turn / HALF_PI), SIDES - 1);
    const nextWeight = nextSideWeight(this.corners[side]!, turn - side * HALF_PI);
    const sources: RaySource[] = [];
    for (let which = 0; which < 2; ++which) {
      const weight = which === 0 ? 1 - nextWeight : nextWeight;
      if (weight <= 0) continue;
      const at = (side + which) % SIDES;
      const line = sides[at]!;
      // A ray along a line that the viewpoint is on: the acquisition point is the viewpoint.
      const intersection = crossLine(line, this.viewpoint, theta) ?? {
        d_p_m: 0,
        along_m: alongLine(line, this.viewpoint),
      };
      sources.push(sourceAt(line, this.sideLines[at]!, intersection, weight));
    }
    return sources;
  }

  private openSources(theta: number): RaySource[] {
    let nearest: RaySource | null = null;
    this.lines.forEach((line, index) => {
      const intersection = crossLine(line, this.viewpoint, theta);
      if (!intersection || intersection.d_p_m < 0) return;
      if (intersection.along_m < firstOf(line) || intersection.along_m > lastOf(line)) return;
      if (nearest && intersection.d_p_m >= nearest.d_p_m) return;
      nearest = sourceAt(line, index, intersection, 1);
    });
    return nearest ? [nearest] : [];
  }

  private cornerView(cell: Cell, side: number): CornerView {
    const next = (side + 1) % SIDES;
    const corner = cornerAfter(cell, side);
    const centre = {
      x_m: 0.5 * (cell.x_min_m + cell.x_max_m),
      z_m: 0.5 * (cell.z_min_m + cell.z_max_m),
    };
    return {
      toNextSide_m: Math.max(0, distanceToSide(cell, next, this.viewpoint)),
      toThisSide_m: Math.max(0, distanceToSide(cell, side, this.viewpoint)),
      overhangThis_m: overhang(this.lines[cell.lines[side]!]!, corner, centre),
      overhangNext_m: overhang(this.lines[cell.lines[next]!]!, corner, centre),
    };
  }
}

/** Where a ray from the viewpoint crosses a line; null if it runs parallel to one it is not on. */
export function crossLine(
  line: Line,
  viewpoint: PlanPosition,
  theta: number,
): LineIntersection | null {
  const [along_x, along_z] = line.direction;
  const ray_x = Math.sin(theta);
  const ray_z = Math.cos(theta);
  const to_x = line.origin_m[0] - viewpoint.x_m;
  const to_z = line.origin_m[1] - viewpoint.z_m;
  // viewpoint + d_p ray = origin + along direction; intersection both sides with `direction` leaves d_p.
  const numerator = to_x * along_z - to_z * along_x;
  const along_m = alongLine(line, viewpoint);
  if (numerator === 0) return { d_p_m: 0, along_m };
  const d_p_m = numerator / (ray_x * along_z - ray_z * along_x);
  if (!Number.isFinite(d_p_m)) return null;
  return { d_p_m, along_m: along_m + d_p_m * (ray_x * along_x + ray_z * along_z) };
}

/** Positions outside the captured part are clamped to its end. */
function sourceAt(
  line: Line,
  index: number,
  intersection: LineIntersection,
  weight: number,
): RaySource {
  const stations = line.stations;
  let low = 0;
  let high = stations.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (intersection.along_m < stations[middle]!.along_m) high = middle;
    else low = middle + 1;
  }
  const station = Math.min(Math.max(low - 1, 0), stations.length - 2);
  const from = stations[station]!.along_m;
  const to = stations[station + 1]!.along_m;
  const fraction = Math.min(Math.max((intersection.along_m - from) / (to - from), 0), 1);
  return { line: index, station, fraction, d_p_m: intersection.d_p_m, weight };
}

function distanceToSide(cell: Cell, side: number, at: PlanPosition): number {
  const distances = [
    cell.z_max_m - at.z_m,
    cell.x_max_m - at.x_m,
    at.z_m - cell.z_min_m,
    at.x_m - cell.x_min_m,
  ];
  return distances[side]!;
}

/** The corner where a side meets the next one, clockwise seen from above. */
function cornerAfter(cell: Cell, side: number): PlanPosition {
  const right = side === 0 || side === 1;
  const front = side === 0 || side === 3;
  return {
    x_m: right ? cell.x_max_m : cell.x_min_m,
    z_m: front ? cell.z_max_m : cell.z_min_m,
  };
}

/** Captured length of a line beyond a corner, away from the cell's centre. */
function overhang(line: Line, corner: PlanPosition, centre: PlanPosition): number {
  const at = alongLine(line, corner);
  const towardsEnd = at > alongLine(line, centre);
  return Math.max(0, towardsEnd ? lastOf(line) - at : at - firstOf(line));
}

/**
 * A source's share among those of its column: inversely proportional to the distance of its line, so
 * that a line through the viewpoint is used alone (core/view/column_sources.cc).
 */
export function sharesOf(sources: readonly RaySource[]): number[] {
  const span_m = sources.reduce((sum, source) => sum + Math.abs(source.d_p_m), 0);
  return sources.map((source) => {
    const nearness = span_m > 0 ? 1 / (Math.abs(source.d_p_m) / span_m + 1e-4) : 1;
    return source.weight * nearness;
  });
}

// Hybrid connection: the angle at which the columns of a view change from one line of a cell to the
// next. The same rule as core/view/connection.h, which explains it.

export interface ConnectionRule {
  k_rad: number; // 45 to 90 degrees
  overlap_rad: number; // width of the blend
}

/** A corner as seen from the viewpoint; metres, all >= 0. */
interface CornerView {
  toNextSide_m: number; // a
  toThisSide_m: number; // b
  overhangThis_m: number;
  overhangNext_m: number;
}

/** Angles from the normal of this side towards the next side. */
interface CornerConnection {
  blendBegin: number; // this side alone up to here
  blendEnd: number; // the next side alone from here
}

function connectCorner(corner: CornerView, rule: ConnectionRule): CornerConnection {
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
function nextSideWeight(connection: CornerConnection, angle: number): number {
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
