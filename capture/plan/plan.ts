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
      `The rail carries stations from ${text(d.rail.first_mm)} to ${text(d.rail.last_mm)} mm, within the limits of ${text(d.rail.low_limit_mm)} to ${text(d.rail.high_limit_mm)} mm.`,
      `Lines run ${text(d.overhang.planned_mm)} mm beyond the outer corners of the grid; k = ${text(d.overhang.k_deg)}° with a blend of ${text(d.overhang.blend_deg)}° needs ${text(d.overhang.needed_mm)} mm.`,
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
    section("On the spot", onTheSpot(d)),
    section("Spacing", spacing(d)),
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

function times({ time, film }: Json): Content {
  const parts: [string, number][] = [
    ["moving, with homing once", time.motion_s],
    ["settling", time.settling_s],
    [
      film ? "pictures: filmed in motion" : `pictures, ${text(time.one_station_s)} s a station`,
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

// What is not set in the configuration is unknown; nothing is assumed.
function onTheSpot({ work, storage, film }: Json): Content {
  const each = storage.picture_mb === null ? "" : `, ${text(storage.picture_mb)} MB each`;
  const lines = [
    work.hours_per_day === null
      ? "Set run.work_h_per_day to count the days."
      : work.days === null
        ? `The ${text(work.hours_per_day)} h of a day (run.work_h_per_day) do not suffice to home the slider and place the rail.`
        : `${counted(work.days, "day")} of ${text(work.hours_per_day)} h. Every day but the first begins with homing and with placing the rail again.`,
    `${counted(storage.pictures, "picture")}${each}.` +
      (each
        ? ""
        : " Set run.picture_mb, or camera.width_px and height_px, to estimate their size."),
    cards(work, film),
    work.battery_charges === null
      ? "Set camera.battery_pictures or camera.battery_min to count the charges of batteries."
      : `${counted(work.battery_charges, "charge")} of the battery` +
        (work.battery_charges_per_day === null ? "." : `, ${work.battery_charges_per_day} a day.`),
  ];
  return lines;
}

function cards({ uses_cards, card_gb, cards, pictures_per_card }: Json, film: boolean): string {
  if (!uses_cards) return "No cards: the session's disk holds the pictures.";
  if (film) return "Cards are not known: the size of films is not estimated.";
  if (card_gb === null) return "Set camera.card_gb to count the cards.";
  if (cards === null)
    return "Cards are not known: the size of a picture is not, or exceeds camera.card_gb.";
  return `${counted(cards, "card")} of ${text(card_gb)} GB for ${counted(pictures_per_card, "picture")} each; pictures stay on them until deleted.`;
}

function spacing({ spacing }: Json): Content {
  if (!spacing) return "Set camera.width_px and height_px to estimate the resolution.";
  const within = `within ${text(spacing.tolerance_px)} px`;
  return [
    `Without distances, stations so far apart resolve surfaces from ${text(spacing.nearest_resolved_m)} m on ${within} of a panorama ${spacing.panorama_width_px} px wide.`,
    spacing.ghost_px === null
      ? "Set scene.nearest_m to estimate the spacing that the scene needs."
      : `The nearest surface doubles by ${text(spacing.ghost_px)} px; ` +
        (spacing.needed_mm === null
          ? "any spacing would do."
          : `${text(spacing.needed_mm)} mm would keep it ${within}.`),
  ];
}

const size = (megabytes: number) =>
  megabytes < 1000 ? `${megabytes.toFixed(0)} MB` : `${(megabytes / 1000).toFixed(1)} GB`;

// "12 min", "3 h 05 min".
function duration(seconds: number): string {
  const minutes = Math.round(seconds / 60);
  if (seconds < 60) return `${Math.round(seconds)} s`;
  if (minutes < 60) return `${minutes} min`;
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
}
