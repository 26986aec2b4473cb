// A view that stays still sharpens to the engine's own picture after a moment.
//
// The picture lies over the canvas and goes at once when anything changes; requests for what is no
// longer shown are given up.
import type { Pose } from "../geometry/frame";
import { DEGREE_RAD } from "../geometry/angles";
import type { ViewSettings } from "../manifest";
import { horizontalFov } from "../walk/motion";
import { element } from "./dom";
import { decimals } from "./numbers";

const STILL_MS = 600;
/** Outside the room, by the engine's rules: the viewer shows such places, the engine does not. */
const OUTSIDE_STATUS = 422;

export class EngineView {
  readonly element = element("img", {
    class: "engine-view",
    testid: "engine-view",
    attributes: { alt: "", draggable: "false" },
  });
  private shown_for = "";
  private since_ms = 0;
  private request: AbortController | null = null;
  private asked = false;
  private complained = false;

  constructor(
    private readonly engine: string,
    private readonly base: URL,
    private readonly failed: (text: string) => void,
  ) {
    this.element.hidden = true;
  }

  /** Once a frame; null while the engine is not to be asked. */
  update(view: StillView | null, now_ms: number): void {
    const possible = view !== null && engineCanShow(view);
    const address = possible ? engineUrl(view, this.engine, this.base).href : "";
    if (address !== this.shown_for) {
      this.shown_for = address;
      this.since_ms = now_ms;
      this.remove();
      return;
    }
    if (address === "" || this.asked || now_ms - this.since_ms < STILL_MS) return;
    this.asked = true;
    void this.ask(address);
  }

  private remove(): void {
    this.request?.abort();
    this.request = null;
    this.asked = false;
    if (this.element.hidden) return;
    this.element.hidden = true;
    this.element.classList.remove("shown");
    URL.revokeObjectURL(this.element.src);
    this.element.removeAttribute("src");
  }

  private async ask(address: string): Promise<void> {
    const request = new AbortController();
    this.request = request;
    try {
      const response = await fetch(address, { signal: request.signal });
      if (response.status === OUTSIDE_STATUS) return;
      if (!response.ok) throw new Error(response.statusText);
      await this.show(await response.blob(), request.signal);
    } catch {
      if (request.signal.aborted || this.complained) return;
      this.complained = true;
      this.failed("The engine did not answer.");
    }
  }

  private async show(picture: Blob, signal: AbortSignal): Promise<void> {
    const url = URL.createObjectURL(picture);
    const decoded = new Image();
    decoded.src = url;
    try {
      await decoded.decode();
    } catch (error) {
      URL.revokeObjectURL(url);
      throw error;
    }
    if (signal.aborted) {
      URL.revokeObjectURL(url);
      return;
    }
    this.element.src = url;
    this.element.hidden = false;
    // The fade begins from what the browser has laid out.
    void this.element.offsetWidth;
    this.element.classList.add("shown");
  }
}

const MOST_PIXEL_RATIO = 2;
/** What the engine renders at most (render/serve/view_request.h). */
const MOST_SIDE_PX = 4096;
const MOST_PIXELS = 2 ** 23;
/** Less is no raised eye, which the engine's initial views cannot have. */
const RAISED_M = 0.0005;

/** A view to ask for: the contract of `raywalk-render serve`, GET view. */
export interface StillView {
  pose: Pose;
  settings: ViewSettings;
  fov_y_rad: number;
  /** Of the canvas, in CSS pixels. */
  width_px: number;
  height_px: number;
  pixel_ratio: number;
}

function isRaised({ pose }: StillView): boolean {
  return Math.abs(pose.up_m) >= RAISED_M;
}

export function engineCanShow(view: StillView): boolean {
  if (isRaised(view) && view.settings.method === "initial") return false;
  return view.width_px > 0 && view.height_px > 0;
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
    ...(isRaised(view) ? { y: decimals(pose.up_m, 5) } : {}),
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
