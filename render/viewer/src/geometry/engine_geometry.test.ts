// The page's geometry against what the engine computes (geometry_cases.cc). Its viewpoints include
// points on lines and in corners, its grids oblique lines, uneven spacing and lines without a cell.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import type { Manifest } from "../manifest";
import { Grid } from "./grid";
import { ViewPlan, type RaySource } from "./view_plan";

interface Column {
  theta_rad: number;
  front: RaySource[];
  behind: RaySource[];
}

interface Viewpoint {
  x_m: number;
  z_m: number;
  k_rad: number;
  overlap_rad: number;
  height_m: number;
  columns: Column[];
}

type Case = Pick<Manifest, "lines" | "cells"> & { viewpoints: Viewpoint[] };

const file = process.env["RAYWALK_GEOMETRY_CASES"];
const cases = file ? (JSON.parse(readFileSync(file, "utf8")) as Case[]) : [];
const RELATIVE = 1e-9;

function near(actual: number, expected: number, what: string): void {
  const error = Math.abs(actual - expected);
  assert.ok(error <= RELATIVE * Math.max(1, Math.abs(expected)), `${what}: ${actual}, ${expected}`);
}

function sameSources(actual: RaySource[], expected: RaySource[], where: string): void {
  assert.equal(actual.length, expected.length, where);
  expected.forEach((source, i) => {
    const { line, station, fraction, d_p_m, weight } = actual[i]!;
    assert.equal(line, source.line, where);
    // An intersection on a station may be told as the end of one gap or the beginning of the next.
    near(station + fraction, source.station + source.fraction, `${where} place on the line`);
    near(d_p_m, source.d_p_m, `${where} distance`);
    near(weight, source.weight, `${where} weight`);
  });
}

const skip = file === undefined && "needs RAYWALK_GEOMETRY_CASES, a file of viewer_geometry_cases";

test("plans of views are those of the engine", { skip }, () => {
  assert.ok(cases.length > 0);
  cases.forEach(({ lines, cells, viewpoints }, index) => {
    const grid = new Grid({ lines, cells });
    for (const at of viewpoints) {
      const plan = new ViewPlan(grid.lines, grid.findCell(at), at, at);
      for (const { theta_rad, front, behind } of at.columns) {
        const where = `grid ${index} at ${at.x_m},${at.z_m} column ${theta_rad}`;
        const column = plan.column(theta_rad);
        sameSources(column.front, front, `${where} front`);
        sameSources(column.behind, behind, `${where} behind`);
      }
    }
  });
});

test("heights of views are those of the engine", { skip }, () => {
  for (const { lines, cells, viewpoints } of cases) {
    const grid = new Grid({ lines, cells });
    for (const at of viewpoints) {
      near(grid.heightAt(at), at.height_m, `height at ${at.x_m},${at.z_m}`);
    }
  }
});
