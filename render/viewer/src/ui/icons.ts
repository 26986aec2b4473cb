// Icons without words, drawn with lines in a square of 24.
import { svg } from "./dom";

const SHAPES = {
  plan: ["M4 4h16v16H4z", "M4 11h9", "M13 4v7", "M13 20v-4"],
  settings: ["M4 7h8", "M16 7h4", "M4 17h4", "M12 17h8", "M14 5v4", "M10 15v4"],
  play: ["M8 5l11 7-11 7z"],
  record: ["M12 3.5a8.5 8.5 0 1 0 .01 0", "M12 8.5a3.5 3.5 0 1 0 .01 0"],
  pause: ["M8 5v14", "M16 5v14"],
  compare: ["M12 3v18", "M9 8l-4 4 4 4", "M15 8l4 4-4 4"],
  screenshot: ["M4 8h4l2-3h4l2 3h4v11H4z", "M12 10a3.4 3.4 0 1 0 .01 0"],
  fullscreen: ["M4 9V4h5", "M15 4h5v5", "M20 15v5h-5", "M9 20H4v-5"],
  vr: ["M3 7h18v10h-6l-2-3h-2l-2 3H3z", "M8 11v.01", "M16 11v.01"],
  info: ["M12 3.5a8.5 8.5 0 1 0 .01 0", "M12 11v5", "M12 8v.01"],
  help: [
    "M12 3.5a8.5 8.5 0 1 0 .01 0",
    "M9.7 9.6a2.4 2.4 0 1 1 3.4 2.3c-.8.4-1.1.9-1.1 1.7",
    "M12 16.5v.01",
  ],
  close: ["M6 6l12 12", "M18 6L6 18"],
  // One viewpoint; rays through a depth; rays from two sides.
  initial: ["M12 18v.01", "M12 18L5 6", "M12 18l7-12"],
  "hlf-vd": ["M12 19v.01", "M12 19L6 5", "M12 19l6-14", "M7.5 9h9"],
  "two-sided": ["M4 18L15 6", "M20 18L9 6", "M4 18v.01", "M20 18v.01", "M8 12h8"],
} as const satisfies Record<string, readonly string[]>;

export type IconName = keyof typeof SHAPES;

export function icon(name: IconName): SVGSVGElement {
  const paths = SHAPES[name].map((d) => svg("path", { d }));
  return svg(
    "svg",
    { viewBox: "0 0 24 24", class: "icon", "aria-hidden": "true", focusable: "false" },
    ...paths,
  );
}
