// One view of an eye: its plan, its distances, its colours. A headset has two, a screen one.
import type { Texture, WebGLRenderer } from "three";
import { DEGREE_RAD } from "../geometry/angles";
import type { Vec3 } from "../geometry/frame";
import type { Grid } from "../geometry/grid";
import type { Cell, Manifest } from "../manifest";
import type { ViewSettings } from "../manifest";
import { ColourPass, MAX_FILL, type Eye } from "./colour_pass";
import { DistancePass, MAX_MAPS } from "./distance_pass";
import { byDistance, nearestMaps, type PlacedStation } from "./station_choice";
import { PlanTexture, type LoadedLine } from "./plan_texture";
import type { StationStore } from "./station_store";
import type { StationTextures } from "./station_textures";

const MAPS_PER_LINE = 2;
const ANY_PER_LINE = Infinity;
const SOURCES = { initial: 2, "hlf-vd": 2, "two-sided": 4 };

export class EyeView {
  private readonly plan: PlanTexture;
  private readonly distances: DistancePass;
  private readonly colours: ColourPass;
  private gatheredFrom = ""; // what the distances are of

  constructor(
    webgl: WebGLRenderer,
    private readonly manifest: Manifest,
    private readonly grid: Grid,
    private readonly store: StationStore,
    textures: StationTextures,
  ) {
    this.plan = new PlanTexture(manifest.panorama.width_px);
    this.distances = new DistancePass(webgl, manifest, textures.inverseMaps);
    const { distances, plan } = this;
    this.colours = new ColourPass(webgl, manifest, textures, distances, plan.texture);
  }

  /** Draws the panorama around a viewpoint where the eye sees it. */
  draw(viewpoint_m: Vec3, eye: Eye, settings: ViewSettings): Texture {
    const [x_m, , z_m] = viewpoint_m;
    const cell = this.grid.findCell({ x_m, z_m });
    const rule = {
      k_rad: settings.k_deg * DEGREE_RAD,
      overlap_rad: settings.overlap_deg * DEGREE_RAD,
    };
    const lines = loadedLines(this.grid, this.store);
    this.plan.update(lines, cell, { x_m, z_m }, rule, settings.method);
    const near = this.stationsAround(cell, viewpoint_m);
    const most = Math.min(MAX_MAPS, this.manifest.view.distance_maps);
    // What other maps show from a station is their views mixed: thin things are wider there.
    const own = near.filter(({ has_map }) => has_map);
    const maps = nearestMaps(own, cell, most, MAPS_PER_LINE);
    const corrected = settings.method !== "initial" && maps.length > 0;
    if (corrected) this.gather(maps, viewpoint_m);
    return this.colours.draw({
      eye,
      viewpoint_m,
      corrected,
      sources: SOURCES[settings.method],
      fillLayers: nearestMaps(corrected ? near : [], cell, MAX_FILL, ANY_PER_LINE)
        .map(({ station }) => this.store.layerWith(station, "picture"))
        .filter((layer) => layer !== undefined),
    });
  }

  /** Draws the distances, unless they are those already. */
  private gather(maps: readonly PlacedStation[], viewpoint_m: Vec3): void {
    const gatheredFrom = JSON.stringify([viewpoint_m, maps.map(({ station }) => station)]);
    if (gatheredFrom === this.gatheredFrom) return;
    this.gatheredFrom = gatheredFrom;
    const layerOf = (station: number) => this.store.layerWith(station, "inverse")!;
    const placed = maps.map(({ station, position_m }) => ({ layer: layerOf(station), position_m }));
    this.distances.draw(placed, viewpoint_m);
  }

  /** Stations of the lines around the viewpoint whose distances are there, the nearest first. */
  private stationsAround(cell: Cell | null, viewpoint_m: Vec3): PlacedStation[] {
    const there = this.store.placed.filter(
      ({ station, line }) =>
        (!cell || cell.lines.includes(line)) &&
        this.store.layerWith(station, "inverse") !== undefined,
    );
    return byDistance(there, viewpoint_m);
  }
}

/** The lines with those of their stations that have a picture, if at least two do. */
function loadedLines(grid: Grid, store: StationStore): LoadedLine[] {
  let station = 0;
  return grid.lines.map((line) => {
    const all = line.stations.map((there) => ({
      there,
      layer: store.layerWith(station++, "picture"),
    }));
    const loaded = all.filter(({ layer }) => layer !== undefined);
    const used = loaded.length >= 2 ? loaded : all;
    return {
      ...line,
      stations: used.map(({ there }) => there),
      layers: used.map(({ layer }) => layer as number),
    };
  });
}
