// The plan of a view as a texture: [source][column] = layers of two stations, share of the second,
// share of the line. Sources 0 and 1 are in front, 2 and 3 behind.
import { DataTexture, FloatType, RGBAFormat } from "three";
import { thetaOfColumn } from "../geometry/angles";
import type { PlanPosition } from "../geometry/grid";
import { sharesOf, ViewPlan, type ConnectionRule, type RaySource } from "../geometry/view_plan";
import type { Cell, ViewMethod, Line } from "../manifest";

const MOST_COLUMNS = 2048;
const SOURCES = 4;
const FLOATS = 4;

/** A line with the stations whose pictures are there, and their layers. */
export interface LoadedLine extends Line {
  layers: number[];
}

export class PlanTexture {
  readonly texture: DataTexture;
  private readonly columns: number;
  private readonly texels: Float32Array<ArrayBuffer>;

  /** For a panorama of this width. */
  constructor(width_px: number) {
    this.columns = Math.min(width_px, MOST_COLUMNS);
    this.texels = new Float32Array(this.columns * SOURCES * FLOATS);
    this.texture = new DataTexture(this.texels, this.columns, SOURCES, RGBAFormat, FloatType);
  }

  update(
    lines: LoadedLine[],
    cell: Cell | null,
    viewpoint: PlanPosition,
    rule: ConnectionRule,
    method: ViewMethod,
  ): void {
    const plan = new ViewPlan(lines, cell, viewpoint, rule);
    this.texels.fill(0);
    for (let column = 0; column < this.columns; ++column) {
      const { front, behind } = plan.column(thetaOfColumn(column, this.columns));
      const used = method === "two-sided" ? [...front, ...behind] : front;
      // A vertical cut blends the lines of a connection alone.
      const shares = method === "initial" ? used.map((source) => source.weight) : sharesOf(used);
      front.forEach((source, i) => this.set(i, column, lines, source, shares[i]!));
      if (method !== "two-sided") continue;
      behind.forEach((source, i) =>
        this.set(2 + i, column, lines, source, shares[front.length + i]!),
      );
    }
    this.texture.needsUpdate = true;
  }

  private set(row: number, column: number, lines: LoadedLine[], source: RaySource, share: number) {
    const { layers } = lines[source.line]!;
    const texel = [layers[source.station], layers[source.station + 1], source.fraction, share];
    if (texel[0] === undefined || texel[1] === undefined) return;
    this.texels.set(texel as number[], FLOATS * (row * this.columns + column));
  }
}
