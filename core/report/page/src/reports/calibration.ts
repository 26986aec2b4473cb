// calibration.json: the steps lens, stitch, mask, poses, grid and rectify, under a summary.
import { axis, chart, type Series, seriesOf } from "../chart";
import { h } from "../dom";
import { type Describe, facts, section } from "../page";
import { type Place, plan } from "../plan";
import { type Column, table } from "../table";
import { counted, type Json, text, textOf } from "../values";

type Images = Parameters<Describe>[1];

export const report: Describe = (d, images) => {
  const { lens, stitch, mask, poses, grid, rectify } = d;
  const solved = grid?.method !== "rotation";
  const how = solved
    ? "poses from COLMAP and the slider"
    : "lines aligned at their crossings without solved poses";
  const largest = grid?.largest_disagreement;
  return {
    title: `Calibration of ${d.source}`,
    subtitle: grid
      ? `${counted(d.stations, "station")} on ${counted(grid.lines, "line")}, ${how}`
      : counted(d.stations, "station"),
    facts: facts(
      ["trustworthy", d.trustworthy],
      grid && ["crossings", grid.crossings.length],
      largest && [
        "largest rotation at a crossing, W = 4096",
        `${change(largest, "rotation_px", 2)} px`,
      ],
      largest && ["largest displacement at a crossing", `${change(largest, "position_mm", 2)} mm`],
      rectify && ["frames", rectify.grid_frames],
    ),
    warnings: d.warnings,
    sections: [
      section("Notes", d.notes),
      rectify ? section("The next step", h("p", {}, h("code", {}, rectify.pack_command))) : null,
      lens ? lensSection(lens, images) : null,
      stitch ? stitchSection(stitch, images) : null,
      mask ? maskSection(mask, images) : null,
      poses ? posesSection(poses) : null,
      grid ? gridSection(grid) : null,
      rectify ? rectifySection(rectify, images) : null,
      section(
        "Fewer keyframes",
        table(d.keyframe_trade, {
          caption:
            "Differences from the densest spacing, over all stations; those without a solved pose " +
            "are predicted from their rail. 0 mm: every station is a keyframe.",
        }),
      ),
      section("Steps", table(d.steps, { caption: "Reused: done by an earlier run." })),
    ],
  };
};

const plusMinus = (value: Json, sigma: Json, decimals: number) =>
  `${text(value, 1, decimals)} ± ${text(sigma, 1, decimals)}`;

const change = ({ before, after }: Json, key: string, decimals: number) =>
  `${text(before[key], 1, decimals)} → ${text(after[key], 1, decimals)}`;

const figures = (...shown: (HTMLElement | null)[]) => h("div", { class: "figures" }, ...shown);

function lensSection(lens: Json, images: Images) {
  // The values of a lens differ in size, so each has its own digits.
  const digits = (key: string): Column => ({
    key,
    value: ({ [key]: value }) =>
      typeof value === "number" ? String(Number(value.toPrecision(5))) : "not fitted",
  });
  const values = (caption: string, of: Json, unit: string | null = null) =>
    table(
      Object.entries<Json>(of)
        .filter(([, value]) => "fitted" in value)
        .map(([key, value]) => ({ value: unit ? `${key} / ${unit}` : axis(key), ...value })),
      { caption, columns: ["value", digits("start"), digits("fitted"), digits("sigma")] },
    );
  const rings = (key: string, name: string): Series[] =>
    seriesOf(lens.residuals_over_angle, "off_axis_deg", key, (ring) => `${ring.lens}: ${name}`);
  const sigmas = (side: string) => {
    const { middle, rim } = lens[side].imaging_sigma_px;
    return `${text(middle)} px half way to the rim and ${text(rim)} px at the rim for the ${side} lens`;
  };
  return section(
    "Lens",
    "Fitted to features tracked along the rail.",
    facts(
      ["root mean square residual", textOf("residual_px", lens.residual_px)],
      [
        "largest standard deviation of an image position",
        textOf("worst_imaging_sigma_px", lens.worst_imaging_sigma_px),
      ],
      ["features followed", lens.points],
      ["seen by both lenses", lens.overlap_points],
      ["stations", lens.pictures],
      ["image points", lens.observations],
      ["image points dropped as outliers", lens.dropped_observations],
      ["features dropped: they move with the camera", lens.dropped_still],
    ),
    "Residuals of the image points: observed minus fitted. Arrows of random directions are noise; " +
      "arrows that agree with their neighbours show an error of the lens model.",
    images("lens"),
    chart([...rings("rms_px", "root mean square"), ...rings("radial_px", "mean outwards")], {
      title: "Residuals over the angle from the axis",
      x: "angle from the axis / °",
      y: "residual / px",
      caption:
        "Rings of five degrees. A mean outwards other than 0 is an error of the radial model.",
    }),
    "A direction at the angle t from a lens's axis is imaged at focal length (t + k1 t³ + k2 t⁵ + " +
      `k3 t⁷ + k4 t⁹) from the centre, in images of ${lens.picture.width_px} x ` +
      `${lens.picture.height_px} pixels. The coefficients are correlated, so their standard ` +
      "deviations look large. The standard deviation of a direction's image position is " +
      `${sigmas("front")}, ${sigmas("back")}.`,
    values("Front lens", lens.front),
    values("Back lens, with its attitude relative to the front lens", lens.back),
    values("Position of the back lens relative to the front lens", lens.baseline_mm, "mm"),
  );
}

function stitchSection(stitch: Json, images: Images) {
  const { seam, balance } = stitch;
  const colours = ["red", "green", "blue"].map((colour, i) => ({
    figure: `light of the back lens over the front's, ${colour}`,
    value: balance.back_gain[i],
  }));
  return section(
    "Stitch",
    `${stitch.frames} frames of ${stitch.width_px} x ${stitch.height_px} pixels, ${stitch.blend} ` +
      `blend over ${stitch.blend_deg} degrees.`,
    facts(
      ["step at the seam before", `${text(seam.step_before_levels, 1, 2)} levels`],
      ["after balancing", `${text(seam.step_after_levels, 1, 2)} levels`],
      ["correlation of the lenses along the seam", seam.correlation],
    ),
    "The step is the median difference of brightness between the lenses in their overlap. The " +
      "correlation is that of their levels there (1 is perfect; near objects lower it by parallax). " +
      "Both are medians over the frames used.",
    images("stitch"),
    `The gain of each colour is measured once for all frames: the median over ${balance.points} ` +
      `points of ${balance.frames} frames that both lenses see. The falloff of light towards the ` +
      "rim is corrected as the lens file gives it.",
    table(colours),
  );
}

function maskSection(mask: Json, images: Images) {
  const { automatic, frame_masks: own } = mask;
  return section(
    "Mask",
    own
      ? "What moves with the camera, and what the frames' own masks hide."
      : "The same in every frame: it hides what moves with the camera.",
    facts(
      [
        `of the sphere is masked${own ? " in all frames" : ""}`,
        textOf("masked_share", mask.masked_share),
      ],
      own && ["frames with a mask of their own", `${own.frames} of ${own.of_frames}`],
      own && ["of their sphere is masked", textOf("masked_share", own.masked_share)],
      mask.cone_deg > 0 && ["cone about the nadir", textOf("cone_deg", mask.cone_deg)],
      automatic && ["reach of the detected dolly", textOf("reach_deg", automatic.reach_deg)],
    ),
    mask.picture && `Image: ${mask.picture}`,
    automatic &&
      `The dolly was detected from ${counted(automatic.stations, "station")} of ` +
        `${counted(automatic.lines, "line")}.`,
    images("mask"),
  );
}

function posesSection(poses: Json) {
  const { alignment, held_out: held } = poses;
  return section(
    "Poses",
    facts(
      ["stations with a pose", `${poses.posed} of ${poses.stations}`],
      held && ["held-out frames with a pose", `${held.posed} of ${held.frames}`],
      ["position, 1 sigma", textOf("position_sigma_mm", poses.position_sigma_mm)],
      ["rotation, 1 sigma", textOf("rotation_sigma_deg", poses.rotation_sigma_deg)],
      ["residual", textOf("residual_px", poses.residual_px)],
      ["time", `${text(poses.total_seconds, 1, 0)} s`],
    ),
    `${poses.keyframes} of ${poses.stations} stations were solved as keyframes; the others are ` +
      "predicted from their rail. --keyframes-mm trades time for accuracy: a skipped station is " +
      "known only to the carriage's repeatability, a solved one to the sigma above. Residuals are " +
      "in pixels of a panorama 4096 wide; sigmas are medians over the stations, each against all " +
      "others.",
    table(poses.lines, {
      caption: "Lines; moved and turned: largest over the stations, relative to the plan",
    }),
    table(poses.crossings, {
      caption: "Scene points seen from both lines near where they cross",
      columns: [CROSSING, "points"],
    }) ?? "No two lines cross.",
    table(poses.unposed, { caption: `${held ? "Frames" : "Stations"} without a pose` }),
    "Images determine neither the scale nor the common rotation. Scale: " +
      `${text(alignment.scale, 1, 6)}, the median ratio of the slider's distance to the solved one ` +
      `over ${counted(alignment.scale_pairs, "pair")} of stations. Rank of the stations' positions: ` +
      `${alignment.rank} (${alignment.rotation_from}); their spread is ` +
      `${text(alignment.spread_m)} m.`,
    movedPlan("Stations as planned and as solved", poses.frames),
    table(poses.seconds, { caption: "Time; reused: done by an earlier run" }),
    `${poses.faces} faces of ${poses.face_px} px of each panorama; ${poses.matched_pairs} pairs of ` +
      `faces matched; ${poses.points} scene points, ${poses.observations} observations.`,
  );
}

const CROSSING: Column = {
  key: "crossing",
  value: (crossing) => `${crossing.along_x} × ${crossing.along_z}`,
  bad: (crossing) => crossing.trustworthy === false,
};

/** Frames with a position and a planned one; `lines` are frames on the planned lines. */
function movedPlan(title: string, frames: Json[], lines: { name: string; frames: Json[] }[] = []) {
  const planned = ({ planned_m: [x, , z] }: Json): Place => [x, z];
  const motion = ({ position_m, planned_m }: Json): Place => [
    position_m[0] - planned_m[0],
    position_m[2] - planned_m[2],
  ];
  const extent = (coordinate: 0 | 1) => {
    const values = frames.map((frame) => planned(frame)[coordinate]);
    return Math.max(...values) - Math.min(...values);
  };
  const largest_m = Math.max(...frames.map((frame) => Math.hypot(...motion(frame))));
  const times = exaggeration((0.1 * Math.max(extent(0), extent(1))) / largest_m);
  const shown = (frame: Json): Place => {
    const [from, by] = [planned(frame), motion(frame)];
    return [from[0] + times * by[0], from[1] + times * by[1]];
  };
  return plan({
    title,
    caption:
      `Grey: as planned; displacements are drawn ${times} times as large, the largest is ` +
      `${text(1000 * largest_m)} mm. Orange: stations with a solved pose; black: predicted.`,
    lines: [
      ...lines.map((line) => ({
        from: planned(line.frames[0]),
        to: planned(line.frames[line.frames.length - 1]),
        kind: "overhang",
        name: line.name,
      })),
      ...frames.map((frame) => ({ from: planned(frame), to: shown(frame), kind: "moved" })),
    ],
    points: [
      ...frames.map((frame) => ({ at: planned(frame), kind: "planned" })),
      ...frames.map((frame) => ({
        at: shown(frame),
        kind: frame.origin === "solved" ? "moved" : "station",
        name: frame.name,
      })),
    ],
  });
}

// The largest of 1, 2, 5, 10, 20, ... up to `room`.
function exaggeration(room: number): number {
  if (!(room > 1 && room < Infinity)) return 1;
  const power = 10 ** Math.floor(Math.log10(room));
  return power * (room >= 5 * power ? 5 : room >= 2 * power ? 2 : 1);
}

function gridSection(grid: Json) {
  const crossings = (caption: string, columns: (string | Column)[]) =>
    table(grid.crossings, { caption, columns: [CROSSING, ...columns] });
  const measured = (when: string, key: string, unit: string, decimals: number): Column => ({
    key: when,
    unit,
    value: ({ [when]: at }) =>
      plusMinus(at[`${key}_${SUFFIX[unit]}`], at[`${key}_sigma_${SUFFIX[unit]}`], decimals),
  });
  const changed = (key: string, name: string): Column => ({
    key: `change.${key}`,
    name,
    value: (crossing) => change(crossing, key, 2),
  });
  const estimate = (key: string, decimals: number): Column => ({
    key,
    value: ({ [key]: { value, sigma } }) => plusMinus(value, sigma, decimals),
  });
  const LINE: Column = { key: "id", name: "line", bad: (line) => !line.connected };
  const frames = new Map(grid.frames.map((frame: Json) => [frame.name, frame]));
  const lines = grid.deviations.map(({ line, stations }: Json) => ({
    name: line,
    frames: stations.map((station: Json) => frames.get(station.name)),
  }));
  return section(
    "Grid",
    grid.crossings.length > 0 &&
      "Displacement and rotation of the two lines' panoramas relative to each other, before and " +
        "after, measured by matches held out of the estimate, ± one standard deviation by the " +
        "matches' scatter. A remaining difference is significant only where it exceeds them. " +
        "Sigma: standard deviation by the estimate itself. Pixels are those of a panorama 4096 " +
        "wide. Epipolar: the median distance of a match from its epipolar line.",
    crossings("Displacement at the crossings", [
      { key: "matches", name: "matches used" },
      { key: "held_out_matches", name: "held out" },
      measured("before", "position", "mm", 2),
      measured("after", "position", "mm", 2),
      "sigma_mm",
      { key: "trustworthy", bad: (crossing) => !crossing.trustworthy },
    ]),
    crossings("Rotation at the crossings", [
      measured("before", "rotation", "°", 3),
      measured("after", "rotation", "°", 3),
      "sigma_deg",
      changed("rotation_px", "rotation"),
      "sigma_px",
      changed("median_px", "epipolar"),
    ]),
    crossings(
      "Corrections by the estimate, and what two estimates from half of the stations each differ by",
      [
        "correction_mm",
        "correction_deg",
        "correction_px",
        { key: "split_half_mm", name: "halves differ" },
        { key: "split_half_expected_mm", name: "expected" },
        { key: "split_half_deg", name: "halves differ" },
        { key: "split_half_expected_deg", name: "expected" },
      ],
    ),
    movedPlan("Lines as planned and as estimated", grid.frames, lines),
    "Every line relative to the plan, ± one standard deviation: its middle along and across the " +
      "rail and in height, the direction of the rail, the attitude of the camera, and the " +
      "stations' scatter about the rail (jitter, standard deviation per component). The common " +
      "motion of all lines is unobservable; it is chosen so that the positions fit the plan best. " +
      "Emphasised: lines that no matches connect to others.",
    table(grid.lines, {
      caption: "Positions",
      columns: [
        LINE,
        "solved_stations",
        "stations",
        estimate("along_mm", 2),
        estimate("across_mm", 2),
        estimate("height_mm", 2),
        "jitter_along_mm",
        { key: "jitter_mm", name: "jitter across" },
        { key: "position_model", name: "model" },
      ],
    }),
    table(grid.lines, {
      caption: "Directions and attitudes",
      columns: [
        LINE,
        ...["heading_deg", "tilt_deg", "yaw_deg", "pitch_deg", "roll_deg"].map((key) =>
          estimate(key, 3),
        ),
        "jitter_deg",
        { key: "rotation_model", name: "model" },
      ],
    }),
    grid.method === "poses" && models(grid),
    "The deviation of each station from the fitted rail. Random scatter is the rail's jitter from " +
      "stop to stop; a smooth wave would be a bend that the model does not describe.",
    ...grid.deviations.map(deviations),
  );
}

const SUFFIX: Record<string, string> = { mm: "mm", "°": "deg" };

function models(grid: Json) {
  const of = (caption: string, key: string, unit: string) =>
    table(
      grid.lines.flatMap((line: Json) =>
        line[key].map((model: Json) => ({ line: line.id, model: model.name, ...model })),
      ),
      {
        caption,
        columns: [
          "line",
          "model",
          "parameters",
          { key: "residual", unit },
          { key: "left_out", unit },
          { key: "bic", name: "BIC" },
          "kept",
        ],
      },
    );
  const error = `${text(grid.solved_line_error_mm)} mm, ` + `${text(grid.solved_line_error_deg)}°`;
  return [
    h(
      "p",
      {},
      "The candidate model with the lowest Bayesian information criterion (BIC) is selected: a bow " +
        "or a twist has to lower the residuals by more than its parameters would by fitting noise. " +
        "Left out: the residual of stations left out of the fit (five-fold cross-validation). " +
        "Whatever the model, the pose of a station with a solved pose is weighted between that " +
        "pose and the rail by their variances.",
    ),
    facts(
      ["scale of the solved poses", text(grid.scale, 1, 5)],
      ["common error of solved lines", error],
    ),
    of("Models of the rails: positions", "position_models", "mm"),
    of("Models of the rails: attitudes", "rotation_models", "°"),
  ];
}

function deviations({ line, stations }: Json) {
  const of = (what: string, unit: string, keys: string[]) =>
    chart(
      keys.flatMap((key) =>
        seriesOf(
          stations,
          "rail_m",
          key,
          () => axis(key).split(" / ")[0] as string,
          "both",
          (station) => station.name,
        ),
      ),
      { title: `Line ${line}: ${what}`, x: "rail position / m", y: `deviation / ${unit}` },
    );
  return figures(
    of("position", "mm", ["along_mm", "across_mm", "up_mm"]),
    of("attitude", "°", ["about_x_deg", "about_y_deg", "about_z_deg"]),
  );
}

function rectifySection(rectify: Json, images: Images) {
  const { frame_masks: own, left_out } = rectify;
  return section(
    "Rectify",
    facts(
      ["frames", rectify.grid_frames],
      ["validation frames", rectify.validation_frames],
      ["left out", left_out.length],
      own && ["frames with a mask of their own", own.frames],
      own && ["of their sphere is masked", textOf("masked_share", own.masked_share)],
    ),
    "Frames of fisheye pictures are made in world axes; captured panoramas are listed with their " +
      "attitudes. What the calibration gains: pack " +
      `${rectify.before_list} too, the frames at their planned positions, and let ` +
      "raywalk-render validate measure both rooms.",
    left_out.length > 0 && `Left out, without a pose: ${left_out.join(", ")}.`,
    rectify.crossings.length > 0 &&
      "Overlays: the two panoramas nearest to each crossing, one in red, the other in cyan, in the " +
        "direction with the most texture: where they agree the image is grey. They were not taken " +
        "at exactly the same position, so near objects keep a little parallax.",
    images("rectify"),
  );
}
