// What an exported room holds: manifest.json, written by `raywalk-render export-web`.
// docs/file-formats.md describes every key.

/** Format of manifest.json that this page reads. */
export const FORMAT = "raywalk-web";
export const VERSION = 1;

export const METHODS = ["initial", "hlf-vd", "two-sided"] as const;
export type ViewMethod = (typeof METHODS)[number];

/** How views are made. */
export interface ViewSettings {
  method: ViewMethod;
  k_deg: number;
  overlap_deg: number;
}

export type PlanPoint = [x_m: number, z_m: number];

export interface Station {
  name: string;
  along_m: number;
  position_m: [x: number, y: number, z: number];
  /** Whether its distances are of a map of its own, not what other maps show from there. */
  has_map: boolean;
}

export interface Line {
  id: string;
  origin_m: PlanPoint;
  direction: PlanPoint;
  height_m: number;
  spacing_m: number;
  stations: Station[];
}

export interface Cell {
  x_min_m: number;
  x_max_m: number;
  z_min_m: number;
  z_max_m: number;
  lines: [front: number, right: number, back: number, left: number];
}

export interface Hotspot {
  x_m: number;
  y_m: number;
  z_m: number;
  text: string;
  link?: string;
}

export interface TruthView {
  x_m: number;
  y_m: number;
  z_m: number;
  picture: string;
  engine: string;
}

export interface PathView {
  x_m: number;
  /** Missing: at the height of the lines. */
  y_m?: number;
  z_m: number;
  yaw_deg: number;
  pitch_deg: number;
  roll_deg: number;
}

export interface Quality {
  psnr_db: number;
  worst_psnr_db: number;
  views: number;
  text: string;
}

export interface Manifest {
  format: string;
  version: number;
  program: string;
  title: string;
  budget_mb: number;
  panorama: { width_px: number; coarse_width_px: number };
  distances: { width_px: number; inverse_step_per_m: number; surface_tolerance: number };
  view: ViewSettings & { distance_maps: number };
  lines: Line[];
  cells: Cell[];
  start: { x_m: number; z_m: number; yaw_deg: number };
  vertical_range_m: number;
  quality: Quality | null;
  truth: TruthView[];
  hotspots: Hotspot[];
  /** A walk, so many of its views per second, angles counted on from view to view. */
  path: PathView[];
  path_frames_per_s: number;
  /** Only where `raywalk-render serve` answers: the address of views that the engine renders. */
  engine?: { view: string };
}

/** Why a room cannot be shown, in a sentence for users. */
export class RoomError extends Error {}

/** Checks what the page relies on. Throws RoomError. */
export function parseManifest(text: string): Manifest {
  let manifest: Manifest;
  try {
    manifest = JSON.parse(text) as Manifest;
  } catch {
    throw new RoomError("manifest.json is not valid JSON; export the room again.");
  }
  if (manifest.format !== FORMAT) {
    throw new RoomError("manifest.json does not describe a Raywalk room; export the room again.");
  }
  if (manifest.version !== VERSION) {
    throw new RoomError(
      `This room was exported in format ${manifest.version}; this page reads format ${VERSION}. ` +
        "Export the room again.",
    );
  }
  const complete =
    manifest.panorama?.width_px > 0 &&
    manifest.distances?.width_px > 0 &&
    Number.isFinite(manifest.start?.x_m) &&
    Number.isFinite(manifest.start?.z_m) &&
    METHODS.includes(manifest.view?.method) &&
    Array.isArray(manifest.cells) &&
    Array.isArray(manifest.lines) &&
    manifest.lines.length > 0 &&
    manifest.lines.every((line) => line.stations?.length >= 2);
  if (!complete) {
    throw new RoomError("manifest.json is incomplete; export the room again.");
  }
  return manifest;
}
