// The plan of the grid: lines, stations, places with ground truth, hotspots, and the walker with what
// is seen. A click walks there; with the keyboard a cross is moved and Enter walks to it.
import type { Pose } from "../geometry/frame";
import type { Grid, PlanPosition } from "../geometry/grid";
import type { Cell, Hotspot, Manifest } from "../manifest";
import { svg, element } from "./dom";

const VIEW_CONE = 22;
/** Of the drawing's longer side, for a press of an arrow key. */
const CROSS_STEP = 1 / 40;

export class PlanMap {
  readonly element = element("div", { class: "plan", testid: "plan" });
  private readonly layout: PlanLayout;
  private readonly drawing: SVGSVGElement;
  private readonly cone = svg("path", { class: "plan-cone" });
  private readonly walker = svg("circle", { class: "plan-walker", r: 4 });
  private readonly cross = svg("path", { class: "plan-cross", d: "M-6 0h12M0 -6v12" });
  private target: PlanPosition | null = null;

  constructor(
    grid: Grid,
    manifest: Pick<Manifest, "truth">,
    hotspots: readonly Hotspot[],
    private readonly walkTo: (at: PlanPosition) => void,
  ) {
    this.layout = planLayout(grid.walkable, grid.bounds());
    const { width, height } = this.layout;
    this.drawing = svg("svg", {
      viewBox: `0 0 ${width} ${height}`,
      tabindex: 0,
      role: "application",
      "aria-label":
        "Plan of the room. Click to walk there, or move the cross with the arrow keys and press Enter.",
      class: "scrolls",
    });
    this.drawing.append(
      ...this.cells(grid),
      ...this.lines(grid),
      ...(manifest.truth ?? []).map((each) => this.mark(each, "plan-truth", "Ground truth")),
      ...hotspots.map((each) => this.mark(each, "plan-hotspot", each.text)),
      this.cone,
      this.walker,
      this.cross,
    );
    this.showCross(null);
    this.drawing.addEventListener("click", (event) => this.click(event));
    this.drawing.addEventListener("keydown", (event) => this.key(event));
    this.drawing.addEventListener("blur", () => this.showCross(null));
    this.element.append(this.drawing);
  }

  update(pose: Pose, fov_x_rad: number): void {
    if (this.element.hidden) return;
    const at = this.layout.toPlan(pose);
    const half_rad = Math.min(fov_x_rad, Math.PI * 0.95) / 2;
    const corner = (side: number): string => {
      const angle_rad = pose.yaw_rad + side * half_rad;
      const x = at.x + VIEW_CONE * Math.sin(angle_rad);
      const y = at.y - VIEW_CONE * Math.cos(angle_rad);
      return `${x.toFixed(2)} ${y.toFixed(2)}`;
    };
    const arc = `A${VIEW_CONE} ${VIEW_CONE} 0 0 1 ${corner(1)}`;
    this.cone.setAttribute("d", `M${at.x.toFixed(2)} ${at.y.toFixed(2)}L${corner(-1)}${arc}z`);
    this.walker.setAttribute("cx", at.x.toFixed(2));
    this.walker.setAttribute("cy", at.y.toFixed(2));
  }

  private cells(grid: Grid): SVGElement[] {
    return grid.walkable.map((cell) => {
      const corner = this.layout.toPlan({ x_m: cell.x_min_m, z_m: cell.z_max_m });
      const width = (cell.x_max_m - cell.x_min_m) * this.layout.per_m;
      const height = (cell.z_max_m - cell.z_min_m) * this.layout.per_m;
      return svg("rect", { class: "plan-cell", ...corner, width, height });
    });
  }

  private lines(grid: Grid): SVGElement[] {
    const drawn: SVGElement[] = [];
    for (const { stations } of grid.lines) {
      const at = stations.map(({ position_m: [x_m, , z_m] }) => this.layout.toPlan({ x_m, z_m }));
      const path = at.map(({ x, y }) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L");
      drawn.push(svg("path", { class: "plan-line", d: `M${path}` }));
      for (const { x, y } of at) {
        drawn.push(svg("circle", { class: "plan-station", cx: x, cy: y, r: 1.4 }));
      }
    }
    return drawn;
  }

  private mark(at: PlanPosition, name: string, label: string): SVGElement {
    const { x, y } = this.layout.toPlan(at);
    const title = svg("title");
    title.textContent = label;
    return svg("path", { class: name, d: `M${x} ${y - 4}l4 4l-4 4l-4 -4z` }, title);
  }

  private click(event: MouseEvent): void {
    const matrix = this.drawing.getScreenCTM();
    if (!matrix) return;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    this.walkTo(this.layout.toRoom(at));
  }

  private key(event: KeyboardEvent): void {
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      if (this.target) this.walkTo(this.target);
      return;
    }
    const moves: Record<string, [x: number, z: number]> = {
      ArrowUp: [0, 1],
      ArrowDown: [0, -1],
      ArrowLeft: [-1, 0],
      ArrowRight: [1, 0],
    };
    const move = moves[event.key];
    if (!move) return;
    event.preventDefault();
    const step_m = this.layout.longer_m * CROSS_STEP;
    const from = this.target ?? this.walkerPlace();
    this.showCross(
      this.layout.inside({ x_m: from.x_m + move[0] * step_m, z_m: from.z_m + move[1] * step_m }),
    );
  }

  private walkerPlace(): PlanPosition {
    const { cx, cy } = this.walker;
    return this.layout.toRoom({ x: cx.baseVal.value, y: cy.baseVal.value });
  }

  private showCross(at: PlanPosition | null): void {
    this.target = at;
    this.cross.style.display = at ? "" : "none";
    if (!at) return;
    const { x, y } = this.layout.toPlan(at);
    this.cross.setAttribute("transform", `translate(${x} ${y})`);
  }
}

type Bounds = Omit<Cell, "lines">;

/** Of the longer side, and around, in units of the drawing. */
const LONGER = 160;
const MARGIN = 12;

/** How the plan lies in its drawing: x to the right, z upwards. */
interface PlanLayout {
  width: number;
  height: number;
  per_m: number;
  longer_m: number;
  toPlan(at: PlanPosition): { x: number; y: number };
  toRoom(at: { x: number; y: number }): PlanPosition;
  inside(at: PlanPosition): PlanPosition;
}

export function planLayout(areas: readonly Cell[], stations: Bounds): PlanLayout {
  const all: Bounds[] = [stations, ...areas];
  const x_min_m = Math.min(...all.map((each) => each.x_min_m));
  const x_max_m = Math.max(...all.map((each) => each.x_max_m));
  const z_min_m = Math.min(...all.map((each) => each.z_min_m));
  const z_max_m = Math.max(...all.map((each) => each.z_max_m));
  const longer_m = Math.max(x_max_m - x_min_m, z_max_m - z_min_m) || 1;
  const per_m = LONGER / longer_m;
  return {
    width: (x_max_m - x_min_m) * per_m + 2 * MARGIN,
    height: (z_max_m - z_min_m) * per_m + 2 * MARGIN,
    per_m,
    longer_m,
    toPlan: ({ x_m, z_m }) => ({
      x: MARGIN + (x_m - x_min_m) * per_m,
      y: MARGIN + (z_max_m - z_m) * per_m,
    }),
    toRoom: ({ x, y }) => ({
      x_m: x_min_m + (x - MARGIN) / per_m,
      z_m: z_max_m - (y - MARGIN) / per_m,
    }),
    inside: ({ x_m, z_m }) => ({
      x_m: Math.min(Math.max(x_m, x_min_m), x_max_m),
      z_m: Math.min(Math.max(z_m, z_min_m), z_max_m),
    }),
  };
}
