// The height of a view: that of the lines around it, as core/view/view_height.h has it.
import type { Cell, Line } from "../manifest";
import { alongLine, firstOf, lastOf, type PlanPosition } from "./grid";

const REACH_IN_SPACINGS = 4;

/** Local linear regression of the stations' heights with tricube weights. */
function heightAlong(line: Line, along_m: number): number {
  const at_m = Math.min(Math.max(along_m, firstOf(line)), lastOf(line));
  const nearest_m = Math.min(...line.stations.map((s) => Math.abs(s.along_m - at_m)));
  const reach_m = Math.max(REACH_IN_SPACINGS * line.spacing_m, 2 * nearest_m);
  let sum = 0;
  let sumX = 0;
  let sumY = 0;
  let sumXX = 0;
  let sumXY = 0;
  for (const station of line.stations) {
    const x = (station.along_m - at_m) / reach_m;
    if (Math.abs(x) >= 1) continue;
    const y = station.position_m[1] - line.height_m;
    const weight = (1 - Math.abs(x) ** 3) ** 3;
    sum += weight;
    sumX += weight * x;
    sumY += weight * y;
    sumXX += weight * x * x;
    sumXY += weight * x * y;
  }
  const determinant = sum * sumXX - sumX * sumX;
  const oneStation = 1e-12 * sum * sum; // then there is no slope
  const above = determinant > oneStation ? (sumXX * sumY - sumX * sumXY) / determinant : sumY / sum;
  return line.height_m + above;
}

/** Height of a view at a point of a cell, or (null) beside lines that close none. Metres. */
export function viewHeight(lines: Line[], cell: Cell | null, at: PlanPosition): number {
  const heightOf = (line: Line) => heightAlong(line, alongLine(line, at));
  if (!cell) return lines.reduce((sum, line) => sum + heightOf(line), 0) / lines.length;
  const [front, right, back, left] = cell.lines.map((line) => heightOf(lines[line]!));
  const rightPart = (at.x_m - cell.x_min_m) / (cell.x_max_m - cell.x_min_m);
  const frontPart = (at.z_m - cell.z_min_m) / (cell.z_max_m - cell.z_min_m);
  const mix = (a: number, b: number, part: number) => a + (b - a) * part;
  return 0.5 * (mix(left!, right!, rightPart) + mix(back!, front!, frontPart));
}
