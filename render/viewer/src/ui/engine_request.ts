// What is asked of the engine for a still view: the contract of `raywalk-render serve`, GET view.
import type { Pose } from "../geometry/frame";
import { DEGREE_RAD } from "../geometry/angles";
import { horizontalFov } from "../walk/field_of_view";
import type { ViewSettings } from "../viewer";
import { decimals } from "./numbers";

const MOST_PIXEL_RATIO = 2;
/** What the engine renders at most (render/serve/view_request.h). */
const MOST_SIDE_PX = 4096;
const MOST_PIXELS = 2 ** 23;
/** The engine moves in the plane of the captured positions only; less than this is no motion. */
const SAME_HEIGHT_M = 0.0005;

export interface StillView {
  pose: Pose;
  settings: ViewSettings;
  fov_y_rad: number;
  /** Of the canvas, in CSS pixels. */
  width_px: number;
  height_px: number;
  pixel_ratio: number;
}

export function engineCanShow(view: StillView): boolean {
  return Math.abs(view.pose.up_m) < SAME_HEIGHT_M && view.width_px > 0 && view.height_px > 0;
}

/** Pixels of the picture that the engine makes for a canvas. */
export function pictureSize(
  view: Pick<StillView, "width_px" | "height_px" | "pixel_ratio">,
): [width_px: number, height_px: number] {
  const wanted = Math.min(Math.max(view.pixel_ratio, 1), MOST_PIXEL_RATIO);
  const ratio = Math.min(
    wanted,
    MOST_SIDE_PX / Math.max(view.width_px, 1),
    MOST_SIDE_PX / Math.max(view.height_px, 1),
    Math.sqrt(MOST_PIXELS / Math.max(view.width_px * view.height_px, 1)),
  );
  const pixels = (css_px: number): number => Math.max(1, Math.floor(css_px * ratio));
  return [pixels(view.width_px), pixels(view.height_px)];
}

export function engineUrl(view: StillView, engine: string, base: URL): URL {
  const { pose, settings } = view;
  const [width_px, height_px] = pictureSize(view);
  const deg = (angle_rad: number): string => decimals(angle_rad / DEGREE_RAD, 4);
  const url = new URL(engine, base);
  url.search = new URLSearchParams({
    x: decimals(pose.x_m, 5),
    z: decimals(pose.z_m, 5),
    yaw: deg(pose.yaw_rad),
    pitch: deg(pose.pitch_rad),
    roll: deg(pose.roll_rad),
    fov: deg(horizontalFov(view.fov_y_rad, width_px / height_px)),
    width: String(width_px),
    height: String(height_px),
    method: settings.method,
    k: decimals(settings.k_deg, 2),
  }).toString();
  return url;
}
