// Labels at points of the room. They are elements over the picture, so that links, keyboards and
// screen readers work as everywhere; their text is never read as markup.
import type { Pose } from "../geometry/frame";
import type { Hotspot } from "../manifest";
import { element } from "./dom";
import { project, type Picture } from "./projection";

const CLEAR_UNTIL_M = 2;
const FAINT_FROM_M = 8;
const FAINT = 0.45;

/** The address of a hotspot's link if the page may open it: http, https, or beside the page. */
export function safeLink(link: string | undefined, base: URL): string | null {
  if (typeof link !== "string" || link.trim() === "") return null;
  let url: URL;
  try {
    url = new URL(link, base);
  } catch {
    return null;
  }
  const isBeside = url.protocol === base.protocol && url.host === base.host;
  const isOnTheWeb = url.protocol === "http:" || url.protocol === "https:";
  return isOnTheWeb || (isBeside && url.protocol === "file:") ? url.href : null;
}

/** Faint in the distance, but never so much that it cannot be read. */
export function opacityAt(distance_m: number): number {
  const part = (distance_m - CLEAR_UNTIL_M) / (FAINT_FROM_M - CLEAR_UNTIL_M);
  return 1 - (1 - FAINT) * Math.min(Math.max(part, 0), 1);
}

export function usableHotspots(hotspots: readonly Hotspot[] | undefined): Hotspot[] {
  return (hotspots ?? []).filter(
    (each) =>
      [each.x_m, each.y_m, each.z_m].every(Number.isFinite) &&
      typeof each.text === "string" &&
      each.text.trim() !== "",
  );
}

export class Hotspots {
  readonly element = element("div", { class: "hotspots", testid: "hotspots" });
  private readonly labels: { at: Hotspot; label: HTMLElement }[];

  constructor(hotspots: readonly Hotspot[], base: URL) {
    this.labels = hotspots.map((at) => ({ at, label: labelOf(at, base) }));
    this.element.append(...this.labels.map(({ label }) => label));
  }

  update(pose: Pose, height_m: number, picture: Picture): void {
    for (const { at, label } of this.labels) {
      const seen = project([at.x_m, at.y_m, at.z_m], pose, height_m, picture);
      const visible = seen !== null && isInside(seen.x_px, seen.y_px, picture);
      label.hidden = !visible;
      if (!visible) continue;
      const { x_px, y_px } = seen;
      label.style.transform = `translate(${x_px.toFixed(1)}px, ${y_px.toFixed(1)}px) translateY(-50%)`;
      label.style.opacity = opacityAt(seen.distance_m).toFixed(2);
    }
  }
}

function isInside(x_px: number, y_px: number, picture: Picture): boolean {
  return x_px >= 0 && y_px >= 0 && x_px <= picture.width_px && y_px <= picture.height_px;
}

function labelOf(hotspot: Hotspot, base: URL): HTMLElement {
  const link = safeLink(hotspot.link, base);
  const text = element("span", { class: "hotspot-text", text: hotspot.text });
  const dot = element("span", { class: "hotspot-dot", attributes: { "aria-hidden": "true" } });
  if (!link) return element("div", { class: "hotspot" }, dot, text);
  return element(
    "a",
    { class: "hotspot", attributes: { href: link, target: "_blank", rel: "noopener" } },
    dot,
    text,
  );
}
