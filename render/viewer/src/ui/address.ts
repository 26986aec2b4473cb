// The page's address. What is after # says where one is, so that a link shows the same:
//
//   #x=0.300&z=-0.250&up=0.000&yaw=40.0&pitch=-10.0&roll=0.0&fov=75.0&method=two-sided&k=90
//
// x, z, up in metres (up above the height that was captured), angles in degrees (fov: the vertical
// field of view), k 45 to 90. What is missing stays as it is; what cannot be read is ignored; what
// is out of range is taken as near as there is. Before it may be, combined as in index.html?kiosk&play:
//
//   ?kiosk            bare view without controls; after a minute without input it begins again
//   ?play             plays the recorded path at once; in a kiosk again and again
//   ?hotspots=0       leaves the hotspots out
//   ?start=x,z,yaw    where the walk begins: metres in the room, degrees (yaw may be left out)
import type { Pose } from "../geometry/frame";
import { METHODS, type ViewMethod } from "../manifest";
import { DEGREE_RAD, limit, wrapAngle } from "../geometry/angles";
import { limitFov } from "../walk/motion";
import { decimals, readNumber } from "./numbers";

export const LEAST_K_DEG = 45;
export const MOST_K_DEG = 90;

export interface Place {
  pose: Pose;
  fov_y_rad: number;
  method: ViewMethod;
  k_deg: number;
}

export interface PlaceFromAddress {
  pose: Partial<Pose>;
  fov_y_rad?: number;
  method?: ViewMethod;
  k_deg?: number;
}

const UPDATE_MS = 250;

export function formatAddress(place: Place): string {
  const { pose } = place;
  const deg = (angle_rad: number): string => decimals(angle_rad / DEGREE_RAD, 1);
  const fields: [string, string][] = [
    ["x", decimals(pose.x_m, 3)],
    ["z", decimals(pose.z_m, 3)],
    ["up", decimals(pose.up_m, 3)],
    ["yaw", deg(pose.yaw_rad)],
    ["pitch", deg(pose.pitch_rad)],
    ["roll", deg(pose.roll_rad)],
    ["fov", deg(place.fov_y_rad)],
    ["method", place.method],
    ["k", decimals(place.k_deg, 0)],
  ];
  return "#" + fields.map(([name, value]) => `${name}=${value}`).join("&");
}

export function parseAddress(hash: string): PlaceFromAddress {
  const fields = new URLSearchParams(hash.replace(/^#/, ""));
  const number = (name: string): number | undefined => readNumber(fields.get(name));
  const angle = (name: string, within: (angle_rad: number) => number): number | undefined => {
    const deg = number(name);
    return deg === undefined ? undefined : within(deg * DEGREE_RAD);
  };
  const k_deg = number("k");
  return known({
    pose: known({
      x_m: number("x"),
      z_m: number("z"),
      up_m: number("up"),
      yaw_rad: angle("yaw", wrapAngle),
      pitch_rad: angle("pitch", (pitch_rad) => limit(pitch_rad, -0.5 * Math.PI, 0.5 * Math.PI)),
      roll_rad: angle("roll", wrapAngle),
    }),
    fov_y_rad: angle("fov", limitFov),
    method: METHODS.find((each) => each === fields.get("method")),
    k_deg: k_deg === undefined ? undefined : limit(k_deg, LEAST_K_DEG, MOST_K_DEG),
  });
}

/** Keeps the address up to date, seldom enough for browsers that count such changes. */
export class Address {
  private shown = "";
  private shown_ms = -Infinity;

  constructor(target: Window, moved: (place: PlaceFromAddress) => void) {
    target.addEventListener("hashchange", (event) => {
      // A frame in between may have replaced the address already.
      this.shown = new URL(event.newURL).hash;
      moved(parseAddress(this.shown));
    });
  }

  update(place: Place, now_ms: number): void {
    if (now_ms - this.shown_ms < UPDATE_MS) return;
    const address = formatAddress(place);
    if (address === this.shown) return;
    this.shown = address;
    this.shown_ms = now_ms;
    history.replaceState(history.state, "", address);
  }
}

/** Without the keys that have no value. */
function known<T extends object>(values: { [Key in keyof T]: T[Key] | undefined }): T {
  const entries = Object.entries(values).filter(([, value]) => value !== undefined);
  return Object.fromEntries(entries) as T;
}

export interface PageOptions {
  kiosk: boolean;
  play: boolean;
  hotspots: boolean;
  start: Partial<Pose>;
}

export function parseOptions(query: string): PageOptions {
  const parameters = new URLSearchParams(query);
  return {
    kiosk: isOn(parameters.get("kiosk")),
    play: isOn(parameters.get("play")),
    hotspots: !isOff(parameters.get("hotspots")),
    start: startOf(parameters.get("start")),
  };
}

/** "?kiosk", "?kiosk=1". */
function isOn(value: string | null): boolean {
  return value !== null && !isOff(value);
}

function isOff(value: string | null): boolean {
  return value === "0" || value === "no" || value === "false";
}

function startOf(value: string | null): Partial<Pose> {
  const [x_m, z_m, yaw_deg] = (value ?? "").split(",").map(readNumber);
  if (x_m === undefined || z_m === undefined) return {};
  return { x_m, z_m, ...(yaw_deg === undefined ? {} : { yaw_rad: yaw_deg * DEGREE_RAD }) };
}
