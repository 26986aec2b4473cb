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
  /** Shows a panorama of the place, a file of the export, up to the divider; null: none. */
  compare(panorama: string | null): Promise<void>;
  /** Where the viewer's own picture begins, from the left of the view, 0 to 1. */
  divider: number;
}

/** A device that cannot draw rooms: a sentence for users. */
export class DeviceError extends Error {}
