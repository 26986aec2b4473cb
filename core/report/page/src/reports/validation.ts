// metrics.json: views beside true ones, and how well lines connect.
import { axis, chart, seriesOf } from "../chart";
import { h } from "../dom";
import { type Describe, facts, section } from "../page";
import { table } from "../table";
import { counted, text } from "../values";

export const validation: Describe = (d, images) => {
  const viewed = d.views.length > 0;
  return {
    title: `Validation of ${d.volume}`,
    subtitle: viewed
      ? `${counted(d.truths, "true viewpoint")}, ${counted(d.modes, "method")}`
      : "connections of two rooms, without true views",
    facts: viewed && facts(["best", d.best.generation], ["PSNR", `${text(d.best.psnr_db)} dB`]),
    sections: [
      section("Views", images("views")),
      section(
        "Gain over distance",
        h(
          "div",
          { class: "figures" },
          chart(
            seriesOf(
              d.quarter_gains,
              "line_distance_m",
              "psnr_db",
              (q) => q.generation,
              "points",
              (q) => q.name,
            ),
            {
              title: "Gain in PSNR",
              x: axis("line_distance_m"),
              y: "PSNR / dB",
            },
          ),
        ),
      ),
      section("Every view", table(d.views)),
    ],
  };
};
