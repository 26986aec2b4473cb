// Plans of a grid from above: x to the right, z upwards, to scale.
import { type Content, h, svg } from "./dom";

export type Place = [x_m: number, z_m: number];

export interface Plan {
  title: string;
  caption: string;
  lines?: { from: Place; to: Place; kind?: string; name?: string; arrow?: boolean }[];
  points?: { at: Place; kind?: string; name?: string }[];
}

const SIZE = 1000; // of the longer side, in units of the drawing
const BORDER = 70;
const POINT = 5;
const LETTER = 16; // height of a text

/** Null of a plan without extent. `kind` is a class of report.css. */
export function plan({ title, caption, lines = [], points = [] }: Plan): HTMLElement | null {
  const places = [...lines.flatMap(({ from, to }) => [from, to]), ...points.map(({ at }) => at)];
  const range = (axis: 0 | 1) => {
    const values = places.map((place) => place[axis]);
    const least = values.reduce((a, b) => Math.min(a, b), Infinity);
    return [least, values.reduce((a, b) => Math.max(a, b), -Infinity)] as const;
  };
  if (!places.length) return null;
  const [x, z] = [range(0), range(1)];
  const extent_m = Math.max(x[1] - x[0], z[1] - z[0]);
  if (!(extent_m > 0)) return null;
  const scale = SIZE / extent_m;
  const at = ([x_m, z_m]: Place): Place => [(x_m - x[0]) * scale, (z[1] - z_m) * scale];

  // Stations close to each other get smaller dots.
  const dot = Math.min(POINT, Math.max(1.2, (0.35 * SIZE) / Math.sqrt(points.length + 1) / 4));
  const drawn: Content[] = lines.map(({ from, to, kind = "rail", name, arrow }) => {
    const [a, b] = [at(from), at(to)];
    return svg(
      "line",
      {
        class: kind,
        x1: a[0],
        y1: a[1],
        x2: b[0],
        y2: b[1],
        ...(arrow ? { "marker-end": "url(#arrow)" } : {}),
      },
      name ? svg("title", {}, name) : null,
    );
  });
  for (const { at: place, kind = "station", name } of points) {
    const [cx, cy] = at(place);
    drawn.push(
      svg("circle", { class: kind, cx, cy, r: dot }, name ? svg("title", {}, name) : null),
    );
  }
  // Names stand before a line's first end: to the left, or below where the line runs upwards.
  let last: Place = [-Infinity, -Infinity];
  for (const { from, to, name, kind } of lines) {
    if (!name || kind === "moved") continue;
    const [a, b] = [at(from), at(to)];
    const flat = Math.abs(b[0] - a[0]) > Math.abs(b[1] - a[1]);
    if (Math.hypot(a[0] - last[0], a[1] - last[1]) < 1.5 * LETTER) continue;
    last = a;
    drawn.push(
      svg(
        "text",
        flat
          ? { x: a[0] - 10, y: a[1] + LETTER / 3, "text-anchor": "end" }
          : { x: a[0], y: a[1] + LETTER + 8, "text-anchor": "middle" },
        name,
      ),
    );
  }
  const width = (x[1] - x[0]) * scale;
  const height = (z[1] - z[0]) * scale;
  const bar_m = roundLength(extent_m / 4);
  const bar_y = height + BORDER - 14;
  drawn.push(
    svg("line", { class: "scale", x1: 0, y1: bar_y, x2: bar_m * scale, y2: bar_y }),
    svg(
      "text",
      { x: bar_m * scale + 8, y: bar_y + LETTER / 3 },
      `${Number(bar_m.toPrecision(1))} m; x to the right, z upwards`,
    ),
  );
  const box = [-BORDER, -BORDER / 2, width + 1.5 * BORDER, height + 1.5 * BORDER].join(" ");
  return h(
    "figure",
    { "data-title": title },
    h("h3", {}, title),
    svg(
      "svg",
      { viewBox: box, class: "plan", role: "img", "aria-label": title },
      arrowHead(),
      drawn,
    ),
    h("figcaption", {}, caption),
  );
}

function arrowHead() {
  const shape = {
    id: "arrow",
    viewBox: "0 0 10 10",
    refX: 9,
    refY: 5,
    markerWidth: 7,
    markerHeight: 7,
    orient: "auto",
  };
  return svg("defs", {}, svg("marker", shape, svg("path", { d: "M0 0 10 5 0 10z" })));
}

// 1, 2 or 5 times a power of ten.
function roundLength(about_m: number): number {
  const power = 10 ** Math.floor(Math.log10(about_m));
  return power * (about_m >= 5 * power ? 5 : about_m >= 2 * power ? 2 : 1);
}
