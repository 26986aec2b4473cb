// trade.json: speed against accuracy over the settings of a room.
import { chart, seriesOf } from "report/chart";
import { type Describe, facts, type Section, section } from "report/page";
import { table } from "report/table";
import { counted, type Json, text } from "report/values";

const SCORES = ["psnr_db", "ws_psnr_db", "ssim", "fsim"];
const REMAPS = "time of a view / remaps";
const TIME = [
  { key: "ms", name: "time", unit: "ms" },
  { key: "ratio", name: "time", unit: "remaps" },
];

const nameOf = (setting: Json) => `${setting.number} · ${setting.name}`;
const SETTING = { key: "name", name: "setting", value: nameOf };

export const report: Describe = (d) => {
  const settings: Json[] = d.settings;
  const front = settings.filter((setting) => setting.on_front).sort((a, b) => a.ratio - b.ratio);
  const [fastest, best] = [front[0], front[front.length - 1]];
  const speed = (setting: Json) => `${text(setting.psnr_db)} dB in ${text(setting.ms)} ms`;
  return {
    title: `Speed and accuracy of ${d.room}`,
    subtitle: `${counted(settings, "setting")}, ${counted(d.views, "true viewpoint")}, ${d.width_px} pixels wide, ${counted(d.machine.threads, "thread")} of ${d.machine.cpu}${d.machine.gpu ? `, and ${d.machine.gpu}` : ""}`,
    facts: facts(
      [`fastest: setting ${fastest.number}`, speed(fastest)],
      [`most accurate: setting ${best.number}`, speed(best)],
      ["on the front", `${front.length} of ${settings.length}`],
      ["one cv::remap of that size", `${text(d.remap_ms)} ms`],
    ),
    warnings: [
      d.busy &&
        "Other programs were busy meanwhile, so that times are less certain. Run raywalk-render trade again while nothing else runs.",
      d.distances === "none" &&
        "The room has no distances, so only initial views were measured; raywalk-build-lf depth estimates them.",
    ].filter(Boolean),
    sections: [
      section(
        "The front",
        "Each point is a setting of all parameters. On the front: no other setting is both faster and more accurate. Up and to the left is better. Time is in units of one cv::remap of a panorama of the truths' size, run alternately with the views.",
        chart(
          [
            ...seriesOf(front, "ratio", "psnr_db", "the front", "line", nameOf),
            ...seriesOf(
              settings,
              "ratio",
              "psnr_db",
              (setting) => (setting.device === "gpu" ? `${setting.method}, gpu` : setting.method),
              "points",
              nameOf,
            ),
          ],
          { title: "PSNR over the time of a view", x: REMAPS, y: "PSNR / dB", xLog: true },
        ),
        table(front, {
          columns: [SETTING, ...TIME, ...SCORES],
          caption: "Settings on the front, the fastest first",
        }),
      ),
      presets(d.presets, settings),
      singleParameters(d, settings),
      section(
        "Every setting",
        table(settings, {
          columns: [SETTING, ...TIME, ...SCORES, "remap_spread"],
          caption: "Parameters are named as in the settings file configs/view.yaml",
        }),
      ),
      section("What the parameters are, and their cost per output pixel", table(d.parameters)),
      measured(d),
    ],
  };
};

function presets(list: Json[], settings: Json[]): Section | null {
  const rows = list.map((preset) => {
    const setting = settings[preset.number - 1];
    const as_good = settings.filter((other) => other.psnr_db >= setting.psnr_db);
    const least = Math.min(...as_good.map((other) => other.ratio));
    return { ...setting, preset: preset.name, slower_share: setting.ratio / least - 1 };
  });
  return section(
    "Presets",
    table(rows, {
      columns: [
        "preset",
        SETTING,
        ...TIME,
        ...SCORES,
        { key: "slower_share", name: "slower than the front" },
      ],
    }),
    rows.length > 0 &&
      "Settings derived from the room's own distances, spacing and width: --preset.",
    list.map((preset) => `${preset.name}: ${preset.reason}.`),
  );
}

// The settings that differ from the central one of their method in one parameter.
function singleParameters(d: Json, settings: Json[]): Section | null {
  const keys: string[] = [
    ...d.parameters.map((parameter: Json) => parameter.key),
    "threads",
    "device",
  ];
  const tables = settings
    .filter((setting) => setting.name === setting.method)
    .map((centre) => {
      const changed = settings.filter(
        (setting) =>
          setting.method === centre.method &&
          keys.filter((key) => setting[key] !== centre[key]).length === 1,
      );
      const less = (key: string) => ({
        key,
        value: (setting: Json) => setting[key] - centre[key],
      });
      return table(changed, {
        columns: [
          SETTING,
          { key: "ms", name: "time", unit: "ms" },
          {
            key: "ratio",
            name: "change of time",
            unit: "%",
            factor: 100,
            value: (setting: Json) => setting.ratio / centre.ratio - 1,
          },
          ...SCORES.map(less),
        ],
        caption: `Against ${centre.name}`,
      });
    });
  return section(
    "One parameter at a time",
    tables.some(Boolean) &&
      "The effect of each parameter alone: time and scores relative to the central setting of its method, which is the default.",
    tables,
  );
}

function measured(d: Json): Section | null {
  return section(
    "How it was measured",
    `Times are medians over ${counted(d.views, "view")}, each rendered ${counted(d.repetitions, "time")} after a warm-up. Scores are means over the views; an image smaller than its truth is enlarged before it is scored, and its time does not include that. Views: ${d.views.join(", ")}.`,
    "Times are of views whose panoramas are decoded where the room is compressed. The machine counts as busy where a quarter of the remaps beside a setting took a quarter longer than the fastest (remap spread above 0.25), in half of the settings.",
    `${d.room}: stored ${d.stored_width_px} pixels wide, distances: ${d.distances}.`,
  );
}
