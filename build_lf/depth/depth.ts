// depth.json: distance maps, how far to trust them, and what was found in the frames.
import { axis, chart, type Series, seriesOf } from "report/chart";
import { type Describe, facts, figures, section } from "report/page";
import { table } from "report/table";
import { counted, type Json, text, textAt, textOf } from "report/values";

const MOST_WARNINGS = 50;
const MOST_LINES = 16; // with a curve each; of more lines a curve shows the means

export const report: Describe = (d, images) => ({
  title: `Distances of ${d.room}`,
  subtitle: `${counted(d.maps, "map")} by ${d.method} at ${d.width} x ${d.height}`,
  warnings: shortened(d.warnings),
  facts: facts(
    ["maps", `${d.maps.length} of ${counted(d.stations, "station")}`],
    ["longest baseline", textAt(d, "reach_m")],
    ["layers", d.layers],
    [`confidence below ${text(d.low_confidence_below, 1, 2)}`, textAt(d, "low_confidence_share")],
    ["left out, as it moved", d.leave_out_moving ? textAt(d, "left_out_share") : "not looked for"],
    ["in use by views", d.distances],
    ["time", textOf("seconds_s", d.seconds)],
    ["memory", textAt(d, "peak_memory_mb")],
    ["largest exposure step", `factor ${text(d.largest_exposure_step, 1, 2)}`],
  ),
  sections: [
    d.gains && section("Gains", `By the surfaces that several stations see, ${d.gains.summary}.`),
    section(
      "Distances and confidence",
      "Inverse distance from blue (far) to red (near); confidence from black to white, and red where it is low (the share above is of the solid angle of all maps): there the renderer prefers other maps. Expect it on plain walls, panes and mirrors, at silhouettes, and along a rail that no other line crosses.",
      images("maps"),
    ),
    section(
      "Stations",
      confidence(d.maps),
      table(d.maps, {
        rows: 20,
        columns: [
          "line",
          "station",
          "file",
          "mean_confidence",
          { key: "low_share", name: "low confidence" },
          { key: "parallax_share", name: "moving by 1 px or more over the reach" },
        ],
      }),
    ),
    leftOut(d.left_out),
    d.truth && truth(d.truth),
  ],
});

function shortened(warnings: string[]): string[] {
  const more = warnings.length - MOST_WARNINGS;
  return more > 0
    ? [...warnings.slice(0, MOST_WARNINGS), `and ${more} more, see "warnings" in all values`]
    : warnings;
}

function confidence(maps: Json[]) {
  const lines = new Map<string, Json[]>();
  for (const map of maps) lines.set(map.line, [...(lines.get(map.line) ?? []), map]);
  const many = lines.size > MOST_LINES;
  const means = [...lines].map(([line, of_line]) => ({
    line,
    number: Number(line.slice(1)),
    mean_confidence: of_line.reduce((sum, map) => sum + map.mean_confidence, 0) / of_line.length,
  }));
  const series: Series[] = many
    ? seriesOf(
        means,
        "number",
        "mean_confidence",
        ({ line }) => `lines along ${line[0]}`,
        "both",
        ({ line }) => line,
      )
    : seriesOf(maps, "station", "mean_confidence", ({ line }) => line);
  return chart(series, {
    title: many ? "Confidence of the lines" : "Confidence along the lines",
    x: many ? "number of the line" : "station",
    y: axis("mean_confidence"),
    yRange: [0, 1],
    caption: many ? "Mean over the maps of each line" : "Mean over the sphere of each map",
  });
}

function leftOut(list: Json[]) {
  if (!list.length) return null;
  return section(
    "Left out",
    "People, cars and other things that moved: what these stations show and the stations around them contradict. Views read the place from other stations, and use these pixels only where no other station sees it. raywalk-build-lf depth --keep-moving keeps them.",
    table(
      [...list].sort((a, b) => b.share - a.share),
      {
        rows: 50,
        columns: [
          "line",
          "station",
          "file",
          { key: "share", name: "left out", unit: "%", factor: 100 },
        ],
      },
    ),
  );
}

function truth(t: Json) {
  const of = (list: Json[], name: string) => seriesOf(list, "confidence", "wrong_share", name);
  const columns = [
    "confidence",
    "pixels",
    { key: "wrong_share", name: "off by more than 1 px" },
    "median_error_px",
  ];
  return section(
    "Comparison with the given distances",
    `${counted(t.maps, "map")}: ${t.summary}.`,
    chart([...of(t.elsewhere, "elsewhere"), ...of(t.edges, "beside silhouettes")], {
      title: "Low confidence predicts error",
      x: "confidence",
      y: "share of pixels off by more than 1 px",
      yRange: [0, 1],
      caption: "Calibration of the confidence",
    }),
    figures(
      table(t.elsewhere, { columns, caption: "Elsewhere" }),
      table(t.edges, { columns, caption: "Beside silhouettes (within 3 pixels)" }),
    ),
  );
}
