// The grid of an exported room: its lines and cells, and where a walker may be.
import type { Cell, Line, Manifest } from "../manifest";

export interface PlanPosition {
  x_m: number;
  z_m: number;
}

/** A rectangle of the plan. */
export type Bounds = Omit<Cell, "lines">;

/** Where lines close no cell, the walker may be this far from their stations, in spacings. */
const REACH_IN_SPACINGS = 4;

export class Grid {
  readonly lines: Line[];
  readonly cells: Cell[];
  /** What a walker may reach: the cells, or what surrounds the lines of a room without cells. */
  readonly walkable: Cell[];

  constructor(manifest: Pick<Manifest, "lines" | "cells">) {
    this.lines = manifest.lines;
    this.cells = manifest.cells;
    this.walkable = this.cells.length > 0 ? this.cells : this.lines.map(around);
  }

  /** The cell that holds a point, borders included; the first if several do. */
  findCell(at: PlanPosition): Cell | null {
    return this.cells.find((cell) => holds(cell, at)) ?? null;
  }

  /** The point itself where a walker may be there, else the nearest such point. */
  clamp(at: PlanPosition): PlanPosition {
    let best = at;
    let least = Infinity;
    for (const area of this.walkable) {
      const inside = {
        x_m: Math.min(Math.max(at.x_m, area.x_min_m), area.x_max_m),
        z_m: Math.min(Math.max(at.z_m, area.z_min_m), area.z_max_m),
      };
      const distance = Math.hypot(inside.x_m - at.x_m, inside.z_m - at.z_m);
      if (distance < least) {
        least = distance;
        best = inside;
      }
    }
    return best;
  }

  /**
   * The height of a view, that of the lines around it, as core/view/view_height.h has it: in a cell,
   * interpolated between opposite sides, or the mean of lines that close none. Metres.
   */
  heightAt(at: PlanPosition): number {
    const heightOf = (line: Line) => heightAlong(line, alongLine(line, at));
    const cell = this.findCell(at);
    if (!cell) return this.lines.reduce((sum, line) => sum + heightOf(line), 0) / this.lines.length;
    const [front, right, back, left] = cell.lines.map((line) => heightOf(this.lines[line]!));
    const rightPart = (at.x_m - cell.x_min_m) / (cell.x_max_m - cell.x_min_m);
    const frontPart = (at.z_m - cell.z_min_m) / (cell.z_max_m - cell.z_min_m);
    const mix = (a: number, b: number, part: number) => a + (b - a) * part;
    return 0.5 * (mix(left!, right!, rightPart) + mix(back!, front!, frontPart));
  }

  /** The rectangle of the plan that holds all stations. */
  bounds(): Bounds {
    const stations = this.lines.flatMap((line) => line.stations);
    const x = stations.map((station) => station.position_m[0]);
    const z = stations.map((station) => station.position_m[2]);
    return {
      x_min_m: Math.min(...x),
      x_max_m: Math.max(...x),
      z_min_m: Math.min(...z),
      z_max_m: Math.max(...z),
    };
  }
}

/** The orthogonal projection of a point onto a line, as along_m. */
export function alongLine(line: Line, at: PlanPosition): number {
  return (
    (at.x_m - line.origin_m[0]) * line.direction[0] +
    (at.z_m - line.origin_m[1]) * line.direction[1]
  );
}

export function firstOf(line: Line): number {
  return line.stations[0]!.along_m;
}

export function lastOf(line: Line): number {
  return line.stations[line.stations.length - 1]!.along_m;
}

function holds(cell: Cell, at: PlanPosition): boolean {
  return (
    at.x_m >= cell.x_min_m &&
    at.x_m <= cell.x_max_m &&
    at.z_m >= cell.z_min_m &&
    at.z_m <= cell.z_max_m
  );
}

function around(line: Line): Cell {
  const reach_m = REACH_IN_SPACINGS * line.spacing_m;
  const x = line.stations.map((station) => station.position_m[0]);
  const z = line.stations.map((station) => station.position_m[2]);
  return {
    x_min_m: Math.min(...x) - reach_m,
    x_max_m: Math.max(...x) + reach_m,
    z_min_m: Math.min(...z) - reach_m,
    z_max_m: Math.max(...z) + reach_m,
    lines: [-1, -1, -1, -1],
  };
}

/** Stations further away than this count nothing for the height of a view. */
const HEIGHT_REACH_IN_SPACINGS = 4;

/** Local linear regression of the stations' heights with tricube weights. */
function heightAlong(line: Line, along_m: number): number {
  const at_m = Math.min(Math.max(along_m, firstOf(line)), lastOf(line));
  const nearest_m = Math.min(...line.stations.map((s) => Math.abs(s.along_m - at_m)));
  const reach_m = Math.max(HEIGHT_REACH_IN_SPACINGS * line.spacing_m, 2 * nearest_m);
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
