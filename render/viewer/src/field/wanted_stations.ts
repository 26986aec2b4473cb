// The order in which stations are wanted around a walker.
import type { Grid, PlanPosition } from "../geometry/grid";
import type { PlacedStation } from "./map_choice";

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
