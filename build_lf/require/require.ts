// require.json: what the scene of a room requires of layers, stations and storage.
import { axis, chart, type Series, seriesOf } from "report/chart";
import { type Describe, facts, figures, section } from "report/page";
import { type Place, plan } from "report/plan";
import { table } from "report/table";
import { counted, type Json, length, text, textAt, textOf } from "report/values";

const CURVE_POINTS = 60;

const metres = (value: number | null) =>
  value === null || !isFinite(value) ? "sky" : `${value.toFixed(2)} m`;
const radians = (degrees: number) => (degrees * Math.PI) / 180;

export const report: Describe = (d) => {
  const { spacing, storage, tolerance_px } = d;
  const width = storage.panorama_width_px;
  return {
    title: `What ${d.room} requires`,
    subtitle: `${counted(d.lines, "line")}, ${spacing.stations} stations of ${width} x ${width / 2} px, for a tolerance of ${tolerance_px} px`,
    facts: facts(
      ["surfaces", `${metres(d.distance.near_m)} to ${metres(d.distance.far_m)}`],
      ["distances", d.distances],
      ["layers in the middle of a cell", storage.inverse_steps],
      ["spacing, without depth", length(spacing.needed_without_depth_m, "any")],
      ["spacing, with distances", length(spacing.needed_with_distances_m)],
      ["captured", length(spacing.captured_median_m)],
      ["stations needed", `${spacing.stations_needed_with_distances} of ${spacing.stations}`],
      ["width worth storing", widthOf(storage.worth_width_px, "any")],
    ),
    sections: [
      scene(d),
      section(
        "Depth layers",
        `A view a distance d_p from the line moves each ray's latitude by up to d_p times the inverse distance of its source. With layers equally spaced in inverse distance, from ${text(d.layers.inverse_min_per_m)} to ${text(d.layers.inverse_max_per_m)} per metre, an error of half a layer remains. These counts keep it within ${tolerance_px} px at ${width} px, except for rays that graze a surface at more than 80 degrees.`,
        chart(seriesOf(d.layers.by_d_p, "d_p_m", "layers", "layers"), {
          title: "Depth layers over the distance from the line",
          x: axis("d_p_m"),
          y: "layers",
          marks: [{ x: storage.reach_m, name: "middle of a cell" }],
        }),
      ),
      stations(d),
      section(
        "Storage",
        `Width: with the error of the distances, at half a cell (${metres(storage.reach_m)}) and half a step, the residual parallax equals ${tolerance_px} px of a panorama of ${widthOf(storage.worth_width_px, "any width")}; a wider one stores detail that views displace by more. Distances: maps ${storage.needed_distance_width_px} px wide keep ${textOf("kept_share", storage.share_within_tolerance)} of the directions within the tolerance at this reach, which needs ${counted(storage.inverse_steps, "step")} of inverse distance, ${counted(storage.inverse_bits, "bit")}.`,
        table(bytes(storage)),
      ),
      d.thinned &&
        section(
          "The thinned room",
          facts(
            ["room", d.thinned.room],
            ["stations", d.thinned.stations],
            ["distance maps", d.thinned.distance_maps],
            ["bytes", textOf("all_bytes", d.thinned.bytes)],
            ["dropped ones re-created", d.thinned.views],
            ["mean PSNR", textAt(d.thinned, "psnr_db")],
            ["worst PSNR", textOf("psnr_db", d.thinned.worst_psnr_db)],
          ),
        ),
    ],
  };
};

const widthOf = (pixels: number | null, otherwise: string) =>
  pixels === null ? otherwise : `${pixels.toFixed(0)} px`;

function scene(d: Json) {
  const { near_m, median_m, far_m, sky_share, known_share, inverse_error_per_m } = d.distance;
  const error_m = inverse_error_per_m === null ? null : inverse_error_per_m * median_m * median_m;
  return section(
    "Distances of the scene",
    `Distances from the stations, weighted by solid angle and confidence: 1 % are nearer than ${metres(near_m)}, half nearer than ${metres(median_m)}, 99 % nearer than ${metres(far_m)}. Sky covers ${textOf("sky_share", sky_share)} of the directions; ${textOf("known_share", known_share)} of them are known.`,
    inverse_error_per_m !== null &&
      `Where two maps see the same surface, 95 % of the pixels agree on its inverse distance within ${text(inverse_error_per_m)} per metre${median_m === null ? "" : `: ${length(error_m)} at ${metres(median_m)}`}.`,
    floorPlan(d),
  );
}

function floorPlan(d: Json) {
  const farthest_m = 4 * (d.distance.median_m ?? Infinity); // a view through a door ends there
  const walls = d.surroundings.flatMap(({ x_m, z_m, distances_m }: Json) => {
    const at = (i: number): Place => {
      const theta = radians(((i + 0.5) / distances_m.length) * 360 - 180);
      return [x_m + distances_m[i] * Math.sin(theta), z_m + distances_m[i] * Math.cos(theta)];
    };
    return distances_m.flatMap((distance_m: number | null, i: number) => {
      const before_m = distances_m.at(i - 1);
      if (!distance_m || !before_m || Math.max(distance_m, before_m) > farthest_m) return [];
      const [from, to] = [at((i || distances_m.length) - 1), at(i)];
      const joined = Math.hypot(to[0] - from[0], to[1] - from[1]) < 0.15 * distance_m;
      return joined ? [{ from, to, kind: "overhang" }] : [];
    });
  });
  return plan({
    title: "From above",
    caption:
      "Surfaces at the height of the camera, stations that are needed with distances (black) and those that could be dropped (grey).",
    lines: walls,
    points: d.stations.map(({ line, station, x_m, z_m, kept }: Json) => ({
      at: [x_m, z_m],
      kind: kept ? "station" : "dropped",
      name: `${line}, station ${station}${kept ? "" : ", could be dropped"}`,
    })),
  });
}

function stations(d: Json) {
  const { spacing, tolerance_px } = d;
  const captured_cm = 100 * spacing.captured_median_m;
  const row = (known: string, needed_m: number | null) => ({
    known,
    spacing_needed_cm: needed_m === null ? null : 100 * needed_m,
  });
  const held = (key: string, name: string) =>
    seriesOf(spacing.held_out, (gap) => 100 * gap.step_m, key, name);
  const enough = !(spacing.captured_max_m > (spacing.needed_without_depth_m ?? Infinity));
  const tolerance_deg = (360 * tolerance_px) / d.storage.panorama_width_px;
  return section(
    "Spacing of the stations",
    `Plenoptic sampling along a rail: a source at inverse distance w appears in two stations, a step s apart, in directions s w apart. A blend without correction shows it twice; corrected by an assumed distance, the copies are apart by the error of that distance. One layer is Chai's optimal single depth; his critical sampling is a tolerance of 1 px about it. Here it is ${tolerance_px} px, ${text(tolerance_deg)} degrees.`,
    figures(
      chart(ghosts(d), {
        title: "Ghosts over the spacing",
        x: "spacing of the stations / cm",
        y: "ghost / px",
        yRange: [0, 8 * tolerance_px],
        marks: [{ x: captured_cm, name: "captured" }],
        caption: "Distance between the two copies of the nearest source.",
      }),
      chart(
        [
          ...held("psnr_with_distances_db", "with distances"),
          ...held("psnr_without_depth_db", "without depth"),
          ...held("psnr_of_tolerance_db", `${tolerance_px} px off`),
        ],
        {
          title: "Stations re-created from those kept",
          x: "step between the stations kept / cm",
          y: "PSNR / dB",
          marks: [{ x: 100 * spacing.needed_with_distances_m, name: "needed" }],
          caption:
            "Measured: PSNR of stations left out and re-created; the captured station displaced by the tolerance for comparison.",
        },
      ),
    ),
    table(
      [
        row("nothing (blended in place)", spacing.needed_without_depth_m),
        ...spacing.needed_with_layers.map(({ layers, needed_m }: Json) =>
          row(counted(layers, "layer"), needed_m),
        ),
        row("distances, from their error alone", spacing.needed_by_error_m),
        row("distances, by re-created stations", spacing.measured_up_to_m),
      ],
      {
        caption:
          "Spacing needed, by knowledge of the distances; emphasised where the capture is wider",
        columns: [
          "known",
          {
            key: "spacing_needed_cm",
            value: ({ spacing_needed_cm }) => spacing_needed_cm ?? "any",
            bad: ({ spacing_needed_cm }) => (spacing_needed_cm ?? Infinity) < captured_cm,
          },
        ],
      },
    ),
    table(spacing.held_out, {
      caption: "The middle station of each gap, rendered from the stations kept",
      columns: [
        { key: "stride", name: "every" },
        { key: "step_m", unit: "cm", factor: 100 },
        "views",
        {
          key: "psnr_with_distances_db",
          bad: (gap) => gap.psnr_with_distances_db < gap.psnr_of_tolerance_db,
        },
        "psnr_without_depth_db",
        "psnr_of_tolerance_db",
        { key: "hidden_share", name: "occluded" },
      ],
    }),
    `With distances ${spacing.stations_needed_with_distances} of ${spacing.stations} stations suffice, including those at corners and ends. Without depth they may be at most ${length(spacing.needed_without_depth_m, "any distance")} apart, and the capture is ${enough ? "dense enough" : "not dense enough"}. The rule for distances ignores occlusion, reflections and resampling, which the re-created stations measure: the smaller of the two spacings is used.`,
  );
}

// core/geometry/spacing.h: the ghost of the worst source, where inverse distances are off by `error`.
function ghosts({ distance, layers, spacing, storage, tolerance_px }: Json): Series[] {
  const { inverse_min_per_m: least, inverse_max_per_m: most } = layers;
  const widest_m = 2 * spacing.captured_median_m;
  const pixel_rad = radians(360 / storage.panorama_width_px);
  const curve = (name: string, error: number, product: number): Series => ({
    name,
    style: "line",
    points: Array.from({ length: CURVE_POINTS + 1 }, (_, i) => {
      const half_m = (widest_m * i) / CURVE_POINTS / 2;
      const ghost_rad = 2 * Math.atan2(half_m * error, 1 + half_m * half_m * product);
      return { x: 200 * half_m, y: ghost_rad / pixel_rad };
    }).filter(({ y }) => y <= 8 * tolerance_px),
  });
  const corrected = (name: string, error: number) => curve(name, error, least * (least + error));
  const edge = (x: number) => ({ x, y: tolerance_px });
  return [
    curve("no depth", most, 0),
    ...[1, 4, 16].map((n) => corrected(counted(n, "layer"), (most - least) / (2 * n))),
    ...(distance.inverse_error_per_m === null
      ? []
      : [corrected("distances", distance.inverse_error_per_m)]),
    {
      name: `tolerance ${tolerance_px} px`,
      style: "line",
      points: [edge(0), edge(100 * widest_m)],
    },
  ];
}

function bytes(s: Json) {
  const row = (what: string, stored_bytes: number, original: number) => ({
    what,
    stored_bytes,
    of_the_original_share: stored_bytes / original,
  });
  return [
    row("rays as captured", s.ray_bytes, s.ray_bytes),
    row("rays of the stations needed", s.ray_bytes_thinned, s.ray_bytes),
    row("... at the width worth storing", s.ray_bytes_worth, s.ray_bytes),
    row(`distances, ${s.distance_width_px} px wide`, s.distance_bytes, s.distance_bytes),
    row(
      `distances, ${s.needed_distance_width_px} px wide, ${s.inverse_bits} bits`,
      s.distance_bytes_needed,
      s.distance_bytes,
    ),
  ];
}
