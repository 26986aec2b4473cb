// calibration.json: the steps lens, stitch, mask, poses and rectify, under a summary.
import { axis, chart, type Series, seriesOf } from "report/chart";
import { h } from "report/dom";
import { type Describe, facts, figures, section } from "report/page";
import { type Place, plan } from "report/plan";
import { type Column, table } from "report/table";
import { counted, type Json, meaning, text, textAt } from "report/values";

type Images = Parameters<Describe>[1];

export const report: Describe = (d, images) => {
  const { lens, stitch, mask, poses, rectify } = d;
  const largest = (key: string) =>
    Math.max(...poses.intersections.map((intersection: Json) => intersection[key] ?? 0));
  const crossed = poses?.intersections.length > 0;
  return {
    title: `Calibration of ${d.source}`,
    subtitle: poses
      ? `${counted(d.stations, "station")} on ${counted(poses.lines, "line")}`
      : counted(d.stations, "station"),
    facts: facts(
      ["trustworthy", d.trustworthy],
      poses && ["intersections", poses.intersections.length],
      crossed && [
        "largest rotation left at an intersection, W = 4096",
        `${text(largest("rotation_px"), 1, 2)} px`,
      ],
      crossed && [
        "largest displacement left at an intersection",
        `${text(largest("position_mm"), 1, 2)} mm`,
      ],
      poses?.contradictions.length > 0 && ["contradictions", poses.contradictions.length],
      rectify && ["frames", rectify.grid_frames],
    ),
    warnings: d.warnings,
    sections: [
      section("Notes", d.notes),
      rectify && section("The next step", h("p", {}, h("code", {}, rectify.next_command))),
      lens && lensSection(lens, images),
      stitch && stitchSection(stitch, images),
      mask && maskSection(mask, images),
      poses && posesSection(poses),
      poses && crossed && intersectionSection(poses.intersections),
      poses && railSection(poses),
      rectify && rectifySection(rectify, images),
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
      ["root mean square residual", textAt(lens, "residual_px")],
      ["largest standard deviation of an image position", textAt(lens, "worst_imaging_sigma_px")],
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
      [`of the sphere is masked${own ? " in all frames" : ""}`, textAt(mask, "masked_share")],
      own && ["frames with a mask of their own", `${own.frames} of ${own.of_frames}`],
      own && ["of their sphere is masked", textAt(own, "masked_share")],
      mask.cone_deg > 0 && ["cone about the nadir", textAt(mask, "cone_deg")],
      automatic && ["reach of the detected dolly", textAt(automatic, "reach_deg")],
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
      ["position, 1 sigma", textAt(poses, "position_sigma_mm")],
      ["rotation, 1 sigma", textAt(poses, "rotation_sigma_deg")],
      ["residual", textAt(poses, "residual_px")],
      ["time", `${text(poses.total_seconds, 1, 0)} s`],
    ),
    `${poses.keyframes} of ${poses.stations} stations were solved as keyframes; the others are ` +
      "predicted from their rail. --keyframes-mm trades time for accuracy: a skipped station is " +
      "known only to the carriage's repeatability, a solved one to the sigma above. Residuals are " +
      "in pixels of a panorama 4096 wide; sigmas are medians over the stations, each against all " +
      "others.",
    table(poses.contradictions, {
      caption: "What the listed positions, or the slider's feedback, have wrong by the pictures",
      columns: ["kind", "text"],
    }),
    table(poses.lines, {
      caption: "Lines; moved and turned: largest over the stations, relative to the plan",
      columns: [
        LINE,
        "posed",
        "keyframes",
        "stations",
        "observations",
        "residual_px",
        "moved_mm",
        "turned_deg",
      ],
    }),
    table(poses.unposed, { caption: `${held ? "Frames" : "Stations"} without a pose` }),
    "Images determine neither the scale nor the common rotation. Scale: " +
      `${text(alignment.scale, 1, 6)}, the median ratio of the slider's distance to the solved one ` +
      `over ${counted(alignment.scale_pairs, "pair")} of stations. Rank of the stations' positions: ` +
      `${alignment.rank} (${alignment.rotation_from}); their spread is ` +
      `${text(alignment.spread_m)} m.`,
    table(poses.seconds, { caption: "Time; reused: done by an earlier run" }),
    `${poses.faces} faces of ${poses.face_px} px of each panorama; ${poses.matched_pairs} pairs of ` +
      `faces matched; ${poses.points} scene points, ${poses.observations} observations.`,
  );
}

const LINE: Column = { key: "id", name: "line", bad: (line) => line.posed === 0 };

const INTERSECTION: Column = {
  key: "intersection",
  value: (intersection) => `${intersection.along_x} × ${intersection.along_z}`,
  bad: (intersection) => intersection.faults?.length > 0,
};

/** Frames with a position and a planned one; `lines` are frames on the planned lines. */
function movedPlan(title: string, frames: Json[], lines: { name: string; frames: Json[] }[]) {
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

function intersectionSection(intersections: Json[]) {
  const left = (key: string, unit: string): Column => ({
    key: `left.${key}`,
    name: key === "position" ? "displacement left" : "rotation left",
    unit,
    value: (intersection) =>
      plusMinus(intersection[`${key}_${unit}`], intersection[`${key}_sigma_${unit}`], 2),
  });
  return section(
    "Intersections",
    "Displacement and rotation of the two lines' panoramas relative to each other: as corrected " +
      "from the plan, and what is left by scene points that were held out of the adjustment, ± one " +
      "standard deviation. What is left is significant only where it exceeds them. Pixels are " +
      "those of a panorama 4096 wide.",
    table(intersections, {
      columns: [
        INTERSECTION,
        "correction_mm",
        "correction_deg",
        "held_out_points",
        left("position", "mm"),
        left("rotation", "px"),
      ],
    }),
  );
}

function railSection(poses: Json) {
  const frames = new Map(poses.frames.map((frame: Json) => [frame.name, frame]));
  const lines = poses.lines.map(({ id, deviations: stations }: Json) => ({
    name: id,
    frames: stations.map((station: Json) => frames.get(station.name)),
  }));
  return section(
    "Rails",
    movedPlan("Stations and lines as planned and as solved", poses.frames, lines),
    "Every rail relative to the plan: its middle along and across the rail and in height, its " +
      "direction, the attitude of the camera, its bow across and up, and the stations' scatter " +
      "about it (standard deviation per component). The common motion of all lines is " +
      "unobservable; it is chosen so that the positions fit the plan best.",
    table(poses.lines, {
      columns: [
        LINE,
        ..."along_mm across_mm height_mm heading_deg tilt_deg yaw_deg pitch_deg roll_deg".split(
          " ",
        ),
        "bow_mm",
        ..."scatter_along_mm scatter_mm scatter_deg".split(" "),
      ],
    }),
    "The deviation of each station from its rail. Random scatter is the rail's jitter from stop to " +
      "stop; a smooth wave would be a bend that the model does not describe.",
    ...poses.lines.map(deviations),
  );
}

function deviations({ id: line, deviations: stations }: Json) {
  const of = (what: string, unit: string, keys: string[]) =>
    chart(
      keys.flatMap((key) => seriesOf(stations, "rail_m", key, () => meaning(key).name)),
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
      own && ["of their sphere is masked", textAt(own, "masked_share")],
    ),
    "Frames of fisheye pictures are made in world axes; captured panoramas are listed with their " +
      "attitudes. What the calibration gains: pack " +
      `${rectify.before_list} too, the frames at their planned positions, and let ` +
      "raywalk-render validate measure both rooms.",
    left_out.length > 0 && `Left out, without a pose: ${left_out.join(", ")}.`,
    rectify.intersections.length > 0 &&
      "Overlays: the two panoramas nearest to each intersection, one in red, the other in cyan, in the " +
        "direction with the most texture: where they agree the image is grey. They were not taken " +
        "at exactly the same position, so near objects keep a little parallax.",
    images("rectify"),
  );
}
