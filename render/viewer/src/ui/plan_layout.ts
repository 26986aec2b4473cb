// How the plan lies in its drawing: x to the right, z upwards.
import type { PlanPosition } from "../geometry/grid";
import type { Cell } from "../manifest";

type Bounds = Omit<Cell, "lines">;

/** Of the longer side, and around, in units of the drawing. */
const LONGER = 160;
const MARGIN = 12;

export interface PlanLayout {
  width: number;
  height: number;
  per_m: number;
  longer_m: number;
  toPlan(at: PlanPosition): { x: number; y: number };
  toRoom(at: { x: number; y: number }): PlanPosition;
  inside(at: PlanPosition): PlanPosition;
}

export function planLayout(areas: readonly Cell[], stations: Bounds): PlanLayout {
  const all: Bounds[] = [stations, ...areas];
  const x_min_m = Math.min(...all.map((each) => each.x_min_m));
  const x_max_m = Math.max(...all.map((each) => each.x_max_m));
  const z_min_m = Math.min(...all.map((each) => each.z_min_m));
  const z_max_m = Math.max(...all.map((each) => each.z_max_m));
  const longer_m = Math.max(x_max_m - x_min_m, z_max_m - z_min_m) || 1;
  const per_m = LONGER / longer_m;
  return {
    width: (x_max_m - x_min_m) * per_m + 2 * MARGIN,
    height: (z_max_m - z_min_m) * per_m + 2 * MARGIN,
    per_m,
    longer_m,
    toPlan: ({ x_m, z_m }) => ({
      x: MARGIN + (x_m - x_min_m) * per_m,
      y: MARGIN + (z_max_m - z_m) * per_m,
    }),
    toRoom: ({ x, y }) => ({
      x_m: x_min_m + (x - MARGIN) / per_m,
      z_m: z_max_m - (y - MARGIN) / per_m,
    }),
    inside: ({ x_m, z_m }) => ({
      x_m: Math.min(Math.max(x_m, x_min_m), x_max_m),
      z_m: Math.min(Math.max(z_m, z_min_m), z_max_m),
    }),
  };
}
