// metrics.json: views beside true ones, and how well lines connect.
import { axis, chart, seriesOf } from "report/chart";
import { type Describe, facts, figures, type Section, section } from "report/page";
import { table } from "report/table";
import { counted, type Json, text } from "report/values";

const SCORES = ["psnr_db", "ws_psnr_db", "ssim", "fsim"];
const SILHOUETTES = [
  "psnr_near_silhouettes_db",
  "psnr_elsewhere_db",
  "near_silhouettes_share",
  "specks_per_megapixel",
];
const most = (keys: string[]) => keys.map((key) => ({ key, best: "most" as const }));

export const report: Describe = (d, images) => {
  const modes: Json[] = d.modes;
  const best = modes.reduce((a, b) => (a.psnr_db >= b.psnr_db ? a : b));
  const initial = modes.find((mode) => mode.method === "initial");
  const scores = best.psnr_near_silhouettes_db === undefined ? SCORES : [...SCORES, ...SILHOUETTES];
  return {
    title: `Validation of ${d.volume}`,
    subtitle: `${counted(d.truths, "true viewpoint")}, ${counted(modes, "method")}`,
    facts: facts(
      [`mean PSNR, ${best.method}`, `${text(best.psnr_db)} dB`],
      initial &&
        initial !== best && [
          "gain over initial views",
          `${text(best.psnr_db - initial.psnr_db)} dB`,
        ],
      ["mean SSIM", best.ssim],
      ["mean FSIM", best.fsim],
      ["median time of a view", `${text(best.median_render_ms)} ms`],
    ),
    sections: [
      section(
        "Methods",
        d.distances === "none" &&
          "The room has no distances, so only initial views could be rendered: the vertical parallax is not corrected. raywalk-build-lf depth estimates them.",
        table(modes, {
          columns: ["method", "connection", "k_deg", ...most(scores), "median_render_ms"],
          caption:
            "Means over all views. Silhouettes are pixels within 2 pixels of neighbours whose true distances have a ratio above 1.15; specks are isolated wrong pixels.",
        }),
      ),
      section("Views beside true ones", images("views")),
      distance(d.quarters, Boolean(initial) && modes.length > 1),
      d.connection && connections(d),
      rendering(d, scores),
    ],
  };
};

function distance(quarters: Json[], gains: boolean): Section | null {
  const initial = new Map<string, Json>();
  const place = (quarter: Json) => `${quarter.name} ${quarter.line_distance_m}`;
  for (const quarter of quarters) {
    if (quarter.method === "initial") initial.set(place(quarter), quarter);
  }
  const points = (title: string, y: string, value: (quarter: Json) => Json) =>
    chart(
      seriesOf(
        quarters,
        (quarter) => 100 * quarter.line_distance_m,
        value,
        (quarter) => quarter.method,
        "points",
      ),
      { title, x: "distance from the line / cm", y },
    );
  const gain = (key: string) => (quarter: Json) => {
    const zero = initial.get(place(quarter));
    return zero && quarter.method !== "initial" ? quarter[key] - zero[key] : null;
  };
  return section(
    "Quality over the distance from the line",
    "As Fig. 13 of the paper. Each point is the quarter of a view that faces a line, over the distance from the viewpoint to that line: the vertical parallax grows with it, and so does the gain of correcting it.",
    figures(
      points("PSNR of every quarter", "PSNR / dB", (quarter) => quarter.psnr_db),
      gains && points("Gain in PSNR over initial views", "gain / dB", gain("psnr_db")),
      gains && points("Gain in SSIM over initial views", "gain in SSIM", gain("ssim")),
      gains && points("Gain in FSIM over initial views", "gain in FSIM", gain("fsim")),
    ),
  );
}

function connections(d: Json): Section | null {
  const { overlap_deg, viewpoints, common_share, comparable } = d.connection;
  const key = comparable ? "e_connect_common" : "e_connect";
  const rows: Json[] = d.connection_error;
  const least = (row: Json) =>
    comparable &&
    row.e_connect_common !== null &&
    rows.every((o) => o.method !== row.method || !(o.e_connect_common < row.e_connect_common));
  const over_k = (title: string, shown: Json[]) =>
    chart(
      seriesOf(shown, "k_deg", key, (row) => row.method),
      {
        title,
        x: axis("k_deg"),
        y: "E_connect / squared 8-bit levels",
        marks: [
          { x: 45, name: "LFU" },
          { x: 90, name: "Ray-space360" },
        ],
      },
    );
  const corrected = rows.filter((row) => row.method !== "initial");
  return section(
    "How well neighbouring lines connect",
    `E_connect, equation (11) of the paper: the mean squared difference of 8-bit RGB between what the two lines of a corner show in an overlap of ${text(overlap_deg)} degrees, over the centres of ${viewpoints} x ${viewpoints} sub-cells of every cell. Smaller is better. A corner is readable where both lines captured part of its overlap; the first E_connect is over other corners at every k and compares none of them. "common" is over the ${text(100 * common_share)} % of the corners that are readable at every k${comparable ? "" : ", too few to compare the angles"}.`,
    figures(
      over_k("E_connect over k", rows),
      corrected.length < rows.length && over_k("E_connect over k, corrected views", corrected),
    ),
    table(rows, {
      columns: [
        "method",
        "connection",
        "k_deg",
        { key: "coverage", name: "corners read", unit: "%", factor: 100 },
        "e_connect",
        { key: "e_connect_common", name: "E_connect, common", good: least },
      ],
      caption:
        "E_connect over the limit angle k, as Table 2 of the paper; the least common one of each method is emphasised",
    }),
  );
}

function rendering(d: Json, scores: string[]): Section | null {
  const views: Json[] = d.views;
  const limited = views.filter((view) => view.limited_corners > 0).length;
  const enlarged = d.widest_truth_px / d.captured_width_px;
  return section(
    "Every view",
    enlarged > 1 &&
      `Views up to ${d.widest_truth_px} pixels wide are enlarged ${text(enlarged)} times from panoramas of ${d.captured_width_px}: they cannot show the detail of a truth of that width.`,
    d.modes.map(
      (mode: Json) =>
        `${mode.method}: connection ${mode.connection} at k = ${text(mode.k_deg)} degrees (${mode.k_source}), blended over ${text(mode.overlap_deg)} degrees.`,
    ),
    d.distances !== "none" && `Distances of the corrected views: ${d.distances}.`,
    `In ${limited} of ${views.length} views at least one corner connects nearer to the physical connection than k requires, because the overhang of its lines runs out. Filled: read from other stations, because the lines in use do not see it; unseen: seen by no station; empty: served by no line.`,
    table(views, {
      columns: [
        "name",
        "method",
        "x_m",
        "z_m",
        { key: "line_distance_m", name: "from line", unit: "cm", factor: 100 },
        ...scores,
        "filled_share",
        "unseen_share",
        "empty_share",
        "render_ms",
      ],
    }),
  );
}
