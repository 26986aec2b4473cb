// The soft edge of what was captured: how far one can walk, and how fast near the end of that.
import type { PlanPosition } from "../geometry/grid";
import type { Cell } from "../manifest";

/** Cells that are this close touch: their borders come from the same line, by different sums. */
const TOUCHING_M = 1e-6;

const EDGE_M = 0.1;
const EDGE_PART_OF_CELL = 0.1;

/** The areas that hold a point. */
function areasAt(areas: readonly Cell[], at: PlanPosition): Cell[] {
  return areas.filter(
    (area) =>
      at.x_m >= area.x_min_m - TOUCHING_M &&
      at.x_m <= area.x_max_m + TOUCHING_M &&
      at.z_m >= area.z_min_m - TOUCHING_M &&
      at.z_m <= area.z_max_m + TOUCHING_M,
  );
}

/** How far one can go from a point along +-x or +-z, through touching areas. */
export function freeDistance(
  areas: readonly Cell[],
  from: PlanPosition,
  axis: "x" | "z",
  sign: number,
): number {
  const start_m = axis === "x" ? from.x_m : from.z_m;
  let reach_m = start_m;
  // Every round enters at least one more area, or is the last.
  for (let round = 0; round <= areas.length; ++round) {
    const at = axis === "x" ? { ...from, x_m: reach_m } : { ...from, z_m: reach_m };
    let next_m = reach_m;
    for (const area of areasAt(areas, at)) {
      if (sign > 0) next_m = Math.max(next_m, axis === "x" ? area.x_max_m : area.z_max_m);
      else next_m = Math.min(next_m, axis === "x" ? area.x_min_m : area.z_min_m);
    }
    if (next_m === reach_m) break;
    reach_m = next_m;
  }
  return Math.abs(reach_m - start_m);
}

/** The shorter side of the area at a point, or of the smallest area where none is. */
export function areaSide(areas: readonly Cell[], at: PlanPosition): number {
  const holding = areasAt(areas, at);
  const sides = (holding.length > 0 ? holding : areas).map((area) =>
    Math.min(area.x_max_m - area.x_min_m, area.z_max_m - area.z_min_m),
  );
  const side_m = Math.min(...sides);
  return Number.isFinite(side_m) && side_m > 0 ? side_m : 1;
}

/** Where braking begins, before the edge. */
export function edgeMargin(side_m: number): number {
  return Math.min(EDGE_M, EDGE_PART_OF_CELL * side_m);
}

/** The share of a speed towards an edge that is left: all of it until the margin, none at the edge. */
export function edgeBrake(free: number, margin: number): number {
  return margin > 0 ? Math.min(1, Math.max(0, free / margin)) : 0;
}
