// Charts of lists of the report's JSON, by uPlot. The point nearest to the pointer says its values; with
// the keyboard, arrow keys walk through the points. The values stand below in a table.
import uPlot from "uplot";
import { h } from "./dom";
import { table } from "./table";
import { heading, type Json, meaning, text } from "./values";

export interface Point {
  x: number;
  y: number;
  name?: string; // of what the point shows
}

export interface Series {
  name: string;
  points: Point[];
  style?: "line" | "points" | "both";
}

export interface ChartOptions {
  title: string;
  x: string; // what an axis shows, with its unit
  y: string;
  xLog?: boolean;
  yRange?: [number, number];
  marks?: { x: number; name: string }[]; // vertical lines
  caption?: string;
}

// Okabe and Ito's colours, distinct also to the colour-blind; then the same dashed.
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b8860b", "#56b4e9", "#444444"];
const HEIGHT_SHARE = 0.62;
const MOST_HEIGHT_px = 440;
const PRINTED_WIDTH_px = 620;
const REACH_px = 40; // how far the pointer may be from a point that says its values

/** Series of a list, named by `of`; entries without a value are left out. Points have the entries' names. */
export function seriesOf(
  list: Json[] | null | undefined,
  x: string | ((entry: Json) => Json),
  y: string | ((entry: Json) => Json),
  of: string | ((entry: Json) => string),
  style?: Series["style"],
  name: (entry: Json) => string = (entry) => entry.name,
): Series[] {
  const value = (key: typeof x, entry: Json) => (typeof key === "string" ? entry[key] : key(entry));
  const series = new Map<string, Series>();
  for (const entry of list ?? []) {
    const point = { x: value(x, entry), y: value(y, entry), name: name(entry) };
    if (typeof point.x !== "number" || typeof point.y !== "number") continue;
    const of_entry = typeof of === "string" ? of : of(entry);
    const found = series.get(of_entry) ?? { name: of_entry, points: [], style };
    found.points.push(point);
    series.set(of_entry, found);
  }
  return [...series.values()];
}

/** "inverse distance / 1/m" of a key. */
export const axis = (key: string) => heading(meaning(key));

/** Null without points. */
export function chart(series: Series[], options: ChartOptions): HTMLElement | null {
  const drawn = series.filter(({ points }) => points.length > 0);
  if (!drawn.length) return null;
  const { data, points } = aligned(drawn);
  const holder = h("div", { class: "chart" });
  const tip = h("output", { class: "tip", hidden: true });
  const plot = new uPlot(
    {
      width: PRINTED_WIDTH_px,
      height: MOST_HEIGHT_px,
      scales: {
        x: { time: false, distr: options.xLog ? 3 : 1 },
        y: options.yRange ? { range: options.yRange } : {},
      },
      axes: [
        { label: options.x, ...AXIS },
        { label: options.y, ...AXIS, size: 62 },
      ],
      series: [{}, ...drawn.map(styled)],
      legend: {
        live: false,
        show: drawn.length > 1,
        markers: { fill: (_, index) => COLOURS[(index - 1) % COLOURS.length] as string },
      },
      cursor: { points: { show: false }, drag: { x: false, y: false } },
      hooks: { draw: [(u) => drawMarks(u, options.marks ?? [])] },
    },
    data,
    holder,
  );

  let at = -1;
  const show = (index: number) => {
    at = index;
    const point = points[index];
    tip.hidden = !point;
    if (!point) return;
    const names = [point.series, point.name].filter(Boolean).join(", ");
    tip.textContent = `${names}: ${options.x} ${text(point.x)}, ${options.y} ${text(point.y)}`;
    tip.style.left = `${plot.valToPos(point.x, "x") + plot.over.offsetLeft}px`;
    tip.style.top = `${plot.valToPos(point.y, "y") + plot.over.offsetTop}px`;
    tip.classList.toggle("left", plot.valToPos(point.x, "x") > plot.over.clientWidth / 2);
  };
  plot.over.addEventListener("pointermove", (event) => {
    const away = (point: Point) =>
      Math.hypot(
        plot.valToPos(point.x, "x") - event.offsetX,
        plot.valToPos(point.y, "y") - event.offsetY,
      );
    let nearest = -1;
    let least = REACH_px;
    points.forEach((point, index) => {
      if (!plot.series[point.index]?.show || !(away(point) < least)) return;
      least = away(point);
      nearest = index;
    });
    show(nearest);
  });
  plot.over.addEventListener("pointerleave", () => show(-1));

  const frame = h(
    "div",
    {
      class: "frame",
      tabindex: 0,
      role: "img",
      "aria-label": `${options.title}: ${options.y} over ${options.x}. Arrow keys read the points.`,
      onkeydown: (event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[(event as KeyboardEvent).key];
        if (step === undefined) return;
        event.preventDefault();
        show((at + step + points.length) % points.length);
      },
      onblur: () => show(-1),
    },
    holder,
  );
  fit(plot, frame);
  const values = h("details", { class: "values" }, h("summary", {}, "Values"));
  values.addEventListener(
    "toggle",
    () => {
      const rows = points.map(({ series: of, name, x, y }) => ({
        series: of,
        ...(name ? { name } : {}),
        [options.x]: x,
        [options.y]: y,
      }));
      const columns = [...new Set(rows.flatMap((row) => Object.keys(row)))];
      // As they are: the axes' labels are no keys.
      const named = columns.map((key) => ({ key, name: key, unit: "", factor: 1 }));
      values.append(table(rows, { columns: named }) ?? "");
    },
    { once: true },
  );
  return h(
    "figure",
    { class: "chart-figure", "data-title": options.title },
    h("h3", {}, options.title),
    h("div", { class: "tip-holder" }, frame, tip),
    h("figcaption", {}, options.caption ?? "", values),
  );
}

const AXIS = {
  stroke: "#1f2933",
  labelFont: "14px system-ui, sans-serif",
  font: "12px system-ui, sans-serif",
  grid: { stroke: "#e6eaed", width: 1 },
  ticks: { stroke: "#c3cbd2", width: 1 },
};

function styled({ name, style = "both" }: Series, index: number): uPlot.Series {
  const colour = COLOURS[index % COLOURS.length] as string;
  return {
    label: name,
    stroke: colour,
    width: style === "points" ? 0 : 2,
    dash: index >= COLOURS.length ? [6, 4] : undefined,
    paths: style === "points" ? () => null : undefined,
    spanGaps: true, // the other series' points lie between
    points: { show: style !== "line", size: 6, fill: colour },
  };
}

// uPlot wants one list of x for all series: each point has its place in it, those of equal x share one
// as far as each is of another series.
function aligned(series: Series[]) {
  const points = series
    .flatMap(({ name, points }, i) => points.map((p) => ({ ...p, series: name, index: i + 1 })))
    .sort((a, b) => a.x - b.x);
  const xs: number[] = [];
  const ys: (number | null)[][] = series.map(() => []);
  for (const point of points) {
    const row = ys[point.index - 1] as (number | null)[];
    const last = xs.length - 1;
    if (xs[last] !== point.x || row[last] !== null) {
      xs.push(point.x);
      for (const other of ys) other.push(null);
    }
    row[xs.length - 1] = point.y;
  }
  return { data: [xs, ...ys] as uPlot.AlignedData, points };
}

function drawMarks(plot: uPlot, marks: { x: number; name: string }[]) {
  const { ctx, bbox } = plot;
  const ratio = window.devicePixelRatio || 1;
  ctx.save();
  ctx.font = `${12 * ratio}px system-ui, sans-serif`;
  ctx.fillStyle = ctx.strokeStyle = "#5d6975";
  ctx.setLineDash([4 * ratio, 4 * ratio]);
  marks.forEach(({ x, name }, i) => {
    const at = plot.valToPos(x, "x", true);
    if (at < bbox.left || at > bbox.left + bbox.width) return;
    ctx.beginPath();
    ctx.moveTo(at, bbox.top);
    ctx.lineTo(at, bbox.top + bbox.height);
    ctx.stroke();
    const right = at < bbox.left + bbox.width / 2;
    ctx.textAlign = right ? "left" : "right";
    ctx.fillText(name, at + (right ? 4 : -4) * ratio, bbox.top + (14 + 15 * i) * ratio);
  });
  ctx.restore();
}

// The chart fills its frame's width, on paper too.
function fit(plot: uPlot, frame: HTMLElement) {
  const size = (width: number) => {
    if (width > 0) {
      plot.setSize({ width, height: Math.min(MOST_HEIGHT_px, Math.round(HEIGHT_SHARE * width)) });
    }
  };
  new ResizeObserver(() => size(frame.clientWidth)).observe(frame);
  window.addEventListener("beforeprint", () => size(Math.min(frame.clientWidth, PRINTED_WIDTH_px)));
  window.addEventListener("afterprint", () => size(frame.clientWidth));
}
