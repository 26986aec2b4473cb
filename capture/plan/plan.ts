// What raywalk-capture plan prints as JSON: lines, days, storage and resolution of a capture.
import { type Content } from "report/dom";
import { type Describe, facts, section } from "report/page";
import { type Place, type Plan, plan } from "report/plan";
import { table } from "report/table";
import { counted, type Json, text } from "report/values";

// Shares of the plan's extent.
const CLOSEST_STATIONS = 0.003; // closer ones would be one thick line
const MARK = 0.008; // half the length of a placement's mark
const ARROW = 0.03; // how far arrows lie beyond the last station

export const report: Describe = (d) => ({
  title: "Plan of a capture",
  subtitle: [
    `${counted(d.grid.lines, "line")}, ${counted(d.grid.stations, "station")} ${text(d.spacing_mm)} mm apart`,
    d.validation.lines > 0 &&
      `${counted(d.validation.lines, "line")} for validation, ${counted(d.validation.stations, "station")}`,
  ]
    .filter(Boolean)
    .join("; "),
  warnings: d.warnings,
  facts: facts(
    ["time", duration(d.time.total_s)],
    ["days", d.work.days],
    ["placements of the rail", d.work.placements],
    ["pictures", d.storage.pictures],
    ["storage", storage(d.storage)],
    ["cards", d.work.uses_cards ? d.work.cards : "none"],
    ["battery charges", d.work.battery_charges],
  ),
  sections: [
    section("From above", drawing(d.lines)),
    section(
      "Lines",
      table(d.grid.groups, { caption: "The lines along an axis are equal but for their place." }),
      table(
        d.lines.map(({ placements_from_m, ...line }: Json) => ({
          ...line,
          placements: placements_from_m.length,
        })),
        { caption: "Every line, along its axis", rows: 12 },
      ),
    ),
    section("Time", times(d)),
    section(
      "In words",
      table(Object.entries(d.summary).map(([subject, sentences]) => ({ subject, sentences }))),
    ),
  ],
});

function drawing(lines: Json[]) {
  const extent_m = Math.max(...lines.map((line) => line.to_m - line.from_m));
  const drawn: NonNullable<Plan["lines"]> = [];
  const points: NonNullable<Plan["points"]> = [];
  let left_out = false;
  for (const line of lines) {
    const { id, from_m, to_m, overhang_m, stations, validation } = line;
    const place = (along_m: number, beside_m = 0): Place => {
      const across_m = line.across_m + beside_m;
      return line.axis === "x" ? [along_m, across_m] : [across_m, along_m];
    };
    const add = (from: Place, to: Place, more = {}) => drawn.push({ from, to, ...more });
    const kind = validation ? "truth" : "overhang";
    add(place(from_m), place(to_m + ARROW * extent_m), { kind, name: id, arrow: true });
    if (!validation) add(place(from_m + overhang_m), place(to_m - overhang_m));
    const step_m = (to_m - from_m) / (stations - 1);
    for (const start_m of line.placements_from_m.slice(1)) {
      const [at_m, half_m] = [start_m - step_m / 2, MARK * extent_m];
      add(place(at_m, -half_m), place(at_m, half_m));
    }
    if (step_m < CLOSEST_STATIONS * extent_m) {
      left_out = true;
      continue;
    }
    for (let i = 0; i < stations; ++i) {
      const name = `${id}, station ${i}`;
      points.push({ at: place(from_m + i * step_m), kind: validation ? "truth" : "station", name });
    }
  }
  const notes = [
    "The slider runs along a line towards its arrow.",
    left_out ? "Stations are too close to each other to be drawn." : "Each dot is a station.",
    "Grey: overhang beyond the grid.",
    lines.some((line) => line.placements_from_m.length > 1) &&
      "A mark across a line begins a further placement of the rail.",
    lines.some((line) => line.validation) &&
      "Dashed: lines for validation, which are not part of the light field.",
  ];
  return plan({
    title: "Plan",
    caption: notes.filter(Boolean).join(" "),
    lines: drawn,
    points,
  });
}

function times({ time, video }: Json): Content {
  const parts: [string, number][] = [
    ["moving, with homing once", time.motion_s],
    ["settling", time.settling_s],
    [
      video ? "pictures: recorded in motion" : `pictures, ${text(time.one_station_s)} s a station`,
      time.pictures_s,
    ],
    ["placing the rail", time.placing_s],
    ["all", time.total_s],
  ];
  return table(
    parts.map(([what, of_s]) => ({ what, time: duration(of_s), share: of_s / time.total_s })),
    { columns: ["what", "time", { key: "share", name: "share", unit: "%", factor: 100 }] },
  );
}

const storage = ({ pictures, picture_mb }: Json) =>
  picture_mb === null ? null : size(pictures * picture_mb);

const size = (megabytes: number) =>
  megabytes < 1000 ? `${megabytes.toFixed(0)} MB` : `${(megabytes / 1000).toFixed(1)} GB`;

// "12 min", "3 h 05 min".
function duration(seconds: number): string {
  const minutes = Math.round(seconds / 60);
  if (seconds < 60) return `${Math.round(seconds)} s`;
  if (minutes < 60) return `${minutes} min`;
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
}
