// The viewer without its user interface: a room, a canvas, a pose.
import type { WebGLRenderer } from "three";
import type { Pose } from "./geometry/frame";
import type { Grid } from "./geometry/grid";
import type { ViewMethod, Manifest } from "./manifest";

export interface ViewSettings {
  method: ViewMethod;
  k_deg: number;
  overlap_deg: number;
}

export interface LoadProgress {
  /** Stations of the walker's surroundings that are there, at least coarse, and in all. */
  coarse: number;
  fine: number;
  wanted: number;
  /** Files that could not be had: sentences for users. */
  problems: string[];
}

/** Pictures at a place with ground truth, shown beside each other. */
export interface Comparison {
  /** Index into Manifest.truth. */
  truth: number;
  /** Dividers from the left, 0 to 1: truth | engine | viewer. */
  truth_until: number;
  engine_until: number;
}

export interface Viewer {
  readonly manifest: Manifest;
  readonly grid: Grid;
  readonly webgl: WebGLRenderer;
  settings: ViewSettings;
  /** Vertical field of view of the flat picture, radians. */
  fov_y_rad: number;
  pose: Pose;
  progress(): LoadProgress;
  /** Called before each frame, with the seconds since the last one. */
  onFrame: (seconds: number) => void;
  /** Resolves when a frame of the current pose with all that is loaded has been drawn. */
  drawn(): Promise<void>;
  /** PNG of the picture. */
  screenshot(): Promise<Blob>;
  compare(comparison: Comparison | null): Promise<void>;
}

/** A device that cannot draw rooms. */
export class DeviceError extends Error {}

/** Opens the exported room at `base` (the folder of manifest.json) in a canvas. Throws ExportError, DeviceError. */
export type OpenViewer = (canvas: HTMLCanvasElement, base: URL) => Promise<Viewer>;
