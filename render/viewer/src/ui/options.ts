// The page's query parameters:
//
//   ?kiosk            bare view without controls; after a minute without input it begins again
//   ?play             plays the recorded path at once; in a kiosk again and again
//   ?hotspots=0       leaves the hotspots out
//   ?start=x,z,yaw    where the walk begins: metres in the room, degrees (yaw may be left out)
//
// They may be combined: index.html?kiosk&play. What is after # goes first: see address.ts.
import type { Pose } from "../geometry/frame";
import { DEGREE_RAD } from "../geometry/angles";
import { readNumber } from "./numbers";

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
