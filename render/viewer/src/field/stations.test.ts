// What decides which stations are read, kept and drawn from.
import assert from "node:assert/strict";
import test from "node:test";
import { Grid } from "../geometry/grid";
import type { Cell, Line } from "../manifest";
import { byDistance, nearestMaps, wantedStations, type PlacedStation } from "./station_choice";
import { readingOrder, Residency } from "./residency";
import { decodeInverse } from "./station_files";
import { bytesPerStation, layersWithin } from "./station_textures";

function placed(line: number, points: [number, number][], from = 0): PlacedStation[] {
  return points.map(([x, z], i) => ({
    station: from + i,
    line,
    position_m: [x, 0, z],
    has_map: true,
  }));
}

test("a station keeps its layer while it is wanted, and no two share one", () => {
  const residency = new Residency(3);
  let random = 1;
  const next = () => (random = (random * 16807) % 2147483647);
  let before = new Map<number, number>();
  for (let round = 0; round < 200; ++round) {
    const order = [...new Set(Array.from({ length: 6 }, () => next() % 8))];
    const dropped = residency.want(order);
    const now = new Map(order.slice(0, 3).map((station) => [station, residency.layer(station)!]));
    assert.deepEqual([...residency.kept], order.slice(0, 3));
    assert.equal(new Set(now.values()).size, now.size);
    for (const layer of now.values()) assert.ok(layer >= 0 && layer < 3);
    for (const [station, layer] of before) {
      if (now.has(station)) assert.equal(now.get(station), layer);
      else assert.ok(dropped.includes(station) && residency.layer(station) === undefined);
    }
    before = now;
  }
});

test("coarse pictures of all come before fine ones, and each part comes once", () => {
  const order = readingOrder(
    Array.from({ length: 20 }, (_, i) => i),
    (station) => station % 4 === 2,
  );
  assert.equal(order.length, 60);
  assert.equal(new Set(order.map(({ station, part }) => `${station} ${part}`)).size, 60);
  const firstFine = order.findIndex(({ part }) => part === "fine");
  const lastCoarse = order.map(({ part }) => part).lastIndexOf("coarse");
  assert.ok(lastCoarse < firstFine);
  const maps = order.slice(0, 5).map(({ station, part }) => `${station} ${part}`);
  assert.deepEqual(maps, ["2 inverse", "6 inverse", "10 inverse", "14 inverse", "18 inverse"]);
});

test("distances are sums of differences down the columns, modulo 65536", () => {
  // Two columns, one row below the other: 1, 65535 and then 0 (one less), 2 (three more).
  const low = [1, 255, 255, 3];
  const high = [0, 255, 255, 0];
  const values = decodeInverse(Uint8Array.from([...low, ...high]), 2);
  assert.deepEqual([...values], [1, 65535, 0, 2]);
});

test("maps are spread over the lines of a cell", () => {
  const cell: Cell = { x_min_m: 0, x_max_m: 1, z_min_m: 0, z_max_m: 1, lines: [0, 1, 2, 3] };
  const along = [0.5, 0.55, 0.7, 0.9].map((x): [number, number] => [x, 1]);
  const left = placed(3, [[0, 0.5]], 4);
  const sorted = byDistance([...left, ...placed(0, along)], [0.5, 0, 0.9]);
  const chosen = nearestMaps(sorted, cell, 4, 2).map(({ station }) => station);
  // 1 is too near to 0, 3 would be the third of its line.
  assert.deepEqual(chosen, [0, 2, 4]);
  assert.equal(nearestMaps(sorted, null, 4, 2).length, 4);
});

test("the budget holds the layers, and a device's limit does", () => {
  const sizes = {
    budget_mb: 256,
    panorama: { width_px: 1024, coarse_width_px: 256 },
    distances: { width_px: 512, inverse_step_per_m: 1, surface_tolerance: 0.1 },
  };
  assert.equal(bytesPerStation(sizes), 4 * (524288 + 32768) + 2 * 131072);
  const layers = layersWithin(sizes, 1000, 2048);
  assert.ok(layers * bytesPerStation(sizes) <= 256e6);
  assert.ok((layers + 1) * bytesPerStation(sizes) > 256e6);
  assert.equal(layersWithin(sizes, 10, 2048), 10);
  assert.equal(layersWithin(sizes, 1000, 64), 64);
});

test("stations of the walker's cell are wanted before those of others", () => {
  const line = (id: string): Line => ({
    id,
    origin_m: [0, 0],
    direction: [1, 0],
    height_m: 0,
    spacing_m: 0.5,
    stations: [],
  });
  const cell = (x: number, lines: Cell["lines"]): Cell => {
    return { x_min_m: x, x_max_m: x + 1, z_min_m: 0, z_max_m: 1, lines };
  };
  const grid = new Grid({
    lines: ["x0", "x1", "z0", "z1", "z2"].map(line),
    cells: [cell(0, [1, 3, 0, 2]), cell(1, [1, 4, 0, 3])],
  });
  const stations = [
    ...placed(2, [[0, 0.5]]),
    ...placed(3, [[1, 0.5]], 1),
    ...placed(4, [[2, 0.5]], 2),
  ];
  assert.deepEqual(wantedStations(stations, grid, { x_m: 0.9, z_m: 0.5 }), [1, 0, 2]);
  assert.deepEqual(wantedStations(stations, grid, { x_m: 1.2, z_m: 0.5 }), [1, 2, 0]);
});
