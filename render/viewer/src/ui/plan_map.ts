// The plan of the grid: lines, stations, places with ground truth, hotspots, and the walker with what
// is seen. A click walks there; with the keyboard a cross is moved and Enter walks to it.
import { limit } from "../geometry/angles";
import type { Pose } from "../geometry/frame";
import type { Bounds, Grid, PlanPosition } from "../geometry/grid";
import type { Hotspot, Manifest } from "../manifest";
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
    this.layout = new PlanLayout([grid.bounds(), ...grid.walkable]);
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
    const { x_min_m, x_max_m, z_min_m, z_max_m } = this.layout.bounds;
    this.showCross({
      x_m: limit(from.x_m + move[0] * step_m, x_min_m, x_max_m),
      z_m: limit(from.z_m + move[1] * step_m, z_min_m, z_max_m),
    });
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

/** Of the longer side, and around, in units of the drawing. */
const LONGER = 160;
const MARGIN = 12;

/** How the plan lies in its drawing: x to the right, z upwards. */
export class PlanLayout {
  readonly bounds: Bounds;
  readonly width: number;
  readonly height: number;
  readonly per_m: number;
  readonly longer_m: number;

  constructor(areas: readonly Bounds[]) {
    const bounds = {
      x_min_m: Math.min(...areas.map((each) => each.x_min_m)),
      x_max_m: Math.max(...areas.map((each) => each.x_max_m)),
      z_min_m: Math.min(...areas.map((each) => each.z_min_m)),
      z_max_m: Math.max(...areas.map((each) => each.z_max_m)),
    };
    const width_m = bounds.x_max_m - bounds.x_min_m;
    const height_m = bounds.z_max_m - bounds.z_min_m;
    this.bounds = bounds;
    this.longer_m = Math.max(width_m, height_m) || 1;
    this.per_m = LONGER / this.longer_m;
    this.width = width_m * this.per_m + 2 * MARGIN;
    this.height = height_m * this.per_m + 2 * MARGIN;
  }

  toPlan({ x_m, z_m }: PlanPosition): { x: number; y: number } {
    return {
      x: MARGIN + (x_m - this.bounds.x_min_m) * this.per_m,
      y: MARGIN + (this.bounds.z_max_m - z_m) * this.per_m,
    };
  }

  toRoom({ x, y }: { x: number; y: number }): PlanPosition {
    return {
      x_m: this.bounds.x_min_m + (x - MARGIN) / this.per_m,
      z_m: this.bounds.z_max_m - (y - MARGIN) / this.per_m,
    };
  }
}
