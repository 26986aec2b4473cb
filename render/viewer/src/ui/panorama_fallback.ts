// Where there is no WebGL2: the panorama of a station, scrolled sideways, and buttons to the next
// stations.
import type { Manifest, Station } from "../manifest";
import type { PlanPosition } from "../geometry/grid";
import { turnBetween } from "../geometry/angles";
import { element, iconButton } from "./dom";
import { icon, type IconName } from "./icons";

interface Way {
  icon: IconName;
  label: string;
  /** To the right of the direction looked. */
  turn_rad: number;
}

const WAYS: readonly Way[] = [
  { icon: "up", label: "Next station ahead", turn_rad: 0 },
  { icon: "left", label: "Next station to the left", turn_rad: -Math.PI / 2 },
  { icon: "right", label: "Next station to the right", turn_rad: Math.PI / 2 },
  { icon: "down", label: "Next station behind", turn_rad: Math.PI },
];

/** Half the angle in which a station counts as being in a direction, and a little for rounding. */
const SECTOR_RAD = Math.PI / 4 + 1e-6;
const SAME_PLACE_M = 1e-6;

function placeOf(station: Station): PlanPosition {
  return { x_m: station.position_m[0], z_m: station.position_m[2] };
}

export function nearestStation(stations: readonly Station[], at: PlanPosition): Station | null {
  return leastBy(stations, (station) => distance(at, placeOf(station)));
}

/** The nearest other station in a direction; none where the grid ends. */
export function nextStation(
  stations: readonly Station[],
  from: Station,
  direction_rad: number,
): Station | null {
  const here = placeOf(from);
  const ahead = stations.filter((station) => {
    const there = placeOf(station);
    if (distance(here, there) < SAME_PLACE_M) return false;
    const bearing_rad = Math.atan2(there.x_m - here.x_m, there.z_m - here.z_m);
    return Math.abs(turnBetween(direction_rad, bearing_rad)) <= SECTOR_RAD;
  });
  return leastBy(ahead, (station) => distance(here, placeOf(station)));
}

export class PanoramaFallback {
  readonly element = element("div", { class: "fallback", testid: "fallback" });
  private readonly stations: Station[];
  private readonly images = [0, 1, 2].map((copy) =>
    element("img", { attributes: { alt: copy === 0 ? "Panorama" : "", draggable: "false" } }),
  );
  private readonly scroller = element("div", {
    class: "panorama scrolls",
    testid: "panorama",
    attributes: { tabindex: "0", role: "region", "aria-label": "Panorama; scroll to look around" },
  });
  private readonly buttons: { way: Way; button: HTMLButtonElement }[];
  private station: Station | null = null;
  /** Kept from panorama to panorama. */
  private next_yaw_rad: number;

  constructor(
    manifest: Manifest,
    private readonly base: URL,
    start: Partial<PlanPosition>,
  ) {
    this.stations = manifest.lines.flatMap((line) => line.stations);
    this.buttons = WAYS.map((way) => ({
      way,
      button: iconButton(icon(way.icon), way.label, () => this.walk(way)),
    }));
    this.scroller.append(...this.images);
    this.scroller.addEventListener("scroll", () => this.scrolled());
    const note = element("p", {
      class: "fallback-note",
      text: "This browser lacks the WebGL2 that walking needs: these are the panoramas themselves.",
      attributes: { role: "status" },
    });
    const ways = element("div", {
      class: "ways",
      attributes: { role: "group", "aria-label": "Walk" },
    });
    ways.append(...this.buttons.map(({ button }) => button));
    this.element.append(this.scroller, note, ways);
    this.images[0]!.addEventListener("load", () => this.lookTo(this.next_yaw_rad));
    this.next_yaw_rad = ((manifest.start?.yaw_deg ?? 0) * Math.PI) / 180;
    const place = { x_m: manifest.start?.x_m ?? 0, z_m: manifest.start?.z_m ?? 0, ...start };
    this.show(nearestStation(this.stations, place));
  }

  private show(station: Station | null): void {
    if (!station) return;
    this.station = station;
    for (const image of this.images) {
      image.src = new URL(`stations/${encodeURIComponent(station.name)}.jpg`, this.base).href;
    }
    this.offerWays();
  }

  private walk(way: Way): void {
    if (!this.station) return;
    this.next_yaw_rad = this.yaw_rad();
    this.show(nextStation(this.stations, this.station, this.next_yaw_rad + way.turn_rad));
  }

  /** The panorama goes round: its copies on the right are left before their end is seen. */
  private scrolled(): void {
    const width_px = this.images[0]!.clientWidth;
    if (width_px === 0) return;
    if (this.scroller.scrollLeft < 1) this.scroller.scrollLeft += width_px;
    else if (this.scroller.scrollLeft > width_px) this.scroller.scrollLeft -= width_px;
    this.offerWays();
  }

  private offerWays(): void {
    for (const { way, button } of this.buttons) {
      const next =
        this.station && nextStation(this.stations, this.station, this.yaw_rad() + way.turn_rad);
      button.disabled = !next;
    }
  }

  /** The middle of what is seen; the middle of a panorama looks to yaw 0. */
  private yaw_rad(): number {
    const width_px = this.images[0]!.clientWidth;
    if (width_px === 0) return this.next_yaw_rad;
    const middle_px = this.scroller.scrollLeft + this.scroller.clientWidth / 2;
    return (middle_px / width_px) * 2 * Math.PI - Math.PI;
  }

  private lookTo(yaw_rad: number): void {
    const width_px = this.images[0]!.clientWidth;
    const middle_px = ((yaw_rad + Math.PI) / (2 * Math.PI)) * width_px;
    const left_px = middle_px - this.scroller.clientWidth / 2;
    this.scroller.scrollLeft = ((left_px % width_px) + width_px) % width_px;
    this.offerWays();
  }
}

function distance(a: PlanPosition, b: PlanPosition): number {
  return Math.hypot(a.x_m - b.x_m, a.z_m - b.z_m);
}

function leastBy<T>(items: readonly T[], value: (item: T) => number): T | null {
  let best: T | null = null;
  for (const item of items) {
    if (best === null || value(item) < value(best)) best = item;
  }
  return best;
}
