// Which stations a view is made from, as core/view/map_choice.h has it, and which are wanted around a
// walker.
import type { Grid, PlanPosition } from "../geometry/grid";
import type { Cell } from "../manifest";

export interface PlacedStation {
  station: number;
  line: number;
  position_m: readonly [number, number, number];
  has_map: boolean;
}

function distance(a: readonly number[], b: readonly number[]): number {
  return Math.hypot(a[0]! - b[0]!, a[1]! - b[1]!, a[2]! - b[2]!);
}

/** Sorted by distance from a viewpoint. */
export function byDistance(
  stations: readonly PlacedStation[],
  viewpoint_m: readonly [number, number, number],
): PlacedStation[] {
  return stations
    .map((station) => ({ station, d: distance(station.position_m, viewpoint_m) }))
    .sort((a, b) => a.d - b.d)
    .map(({ station }) => station);
}

/** Of stations, sorted by distance. In a cell, maps are spread over its lines; without one, the nearest on both sides tell most. */
export function nearestMaps(
  sorted: readonly PlacedStation[],
  cell: Cell | null,
  most: number,
  mostPerLine: number,
): PlacedStation[] {
  const gap_m = cell
    ? 0.125 * Math.min(cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m)
    : 0;
  const perLine = cell ? mostPerLine : Infinity;
  const chosen: PlacedStation[] = [];
  for (const map of sorted) {
    if (chosen.length === most) break;
    const ofLine = chosen.filter((other) => other.line === map.line).length;
    const near = chosen.some((other) => distance(other.position_m, map.position_m) < gap_m);
    if (ofLine < perLine && !near) chosen.push(map);
  }
  return chosen;
}

/** Stations of the walker's cell come first, then those of other cells, each the nearest first. */
export function wantedStations(
  stations: readonly PlacedStation[],
  grid: Grid,
  walker: PlanPosition,
): number[] {
  const cell = grid.findCell(walker);
  const span = cell ? Math.max(cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m) : 0;
  return stations
    .map(({ station, line, position_m }) => {
      const distance = Math.hypot(position_m[0] - walker.x_m, position_m[2] - walker.z_m);
      const ofCell = cell !== null && cell.lines.includes(line);
      // A line may run through many cells: only what is near its walker's cell is read there.
      const first = ofCell && distance <= 1.5 * span;
      return { station, rank: first ? distance : distance + 2 * span };
    })
    .sort((a, b) => a.rank - b.rank)
    .map(({ station }) => station);
}
