// Two dividers between three pictures that lie over each other.
import { element } from "./dom";

const STEP = 0.02;
const LARGE_STEP = 0.1;

export type Positions = [first: number, second: number];

/** Moves one divider; the other gives way, and neither leaves the picture. */
export function moveDivider(positions: Positions, which: 0 | 1, to: number): Positions {
  const at = Number.isFinite(to) ? Math.min(Math.max(to, 0), 1) : positions[which];
  return which === 0 ? [at, Math.max(at, positions[1])] : [Math.min(positions[0], at), at];
}

export class Dividers {
  readonly element = element("div", { class: "dividers" });
  positions: Positions = [1 / 3, 2 / 3];
  private readonly handles: readonly [HTMLElement, HTMLElement];

  constructor(
    labels: readonly [string, string, string],
    private readonly moved: () => void,
  ) {
    this.handles = [
      this.handle(0, `Divider between ${labels[0]} and ${labels[1]}`),
      this.handle(1, `Divider between ${labels[1]} and ${labels[2]}`),
    ];
    labels.forEach((text, i) => {
      this.element.append(element("span", { class: `picture-label picture-label-${i}`, text }));
    });
    this.element.append(...this.handles);
    this.show();
  }

  private handle(which: 0 | 1, label: string): HTMLElement {
    const handle = element("div", {
      class: "divider",
      attributes: {
        role: "slider",
        tabindex: "0",
        "aria-label": label,
        "aria-orientation": "horizontal",
        "aria-valuemin": "0",
        "aria-valuemax": "100",
      },
    });
    handle.addEventListener("pointerdown", (event) => handle.setPointerCapture(event.pointerId));
    handle.addEventListener("pointermove", (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const box = this.element.getBoundingClientRect();
      this.move(which, (event.clientX - box.left) / Math.max(box.width, 1));
    });
    handle.addEventListener("keydown", (event) => {
      const to = positionByKey(event.key, this.positions[which]);
      if (to === null) return;
      event.preventDefault();
      this.move(which, to);
    });
    return handle;
  }

  private move(which: 0 | 1, to: number): void {
    this.positions = moveDivider(this.positions, which, to);
    this.show();
    this.moved();
  }

  private show(): void {
    this.positions.forEach((position, i) => {
      const percent = Math.round(position * 100);
      this.handles[i]!.setAttribute("aria-valuenow", String(percent));
      this.handles[i]!.setAttribute("aria-valuetext", `${percent} % from the left`);
      this.element.style.setProperty(`--divider-${i}`, String(position));
    });
  }
}

export function positionByKey(key: string, now: number): number | null {
  switch (key) {
    case "ArrowLeft":
    case "ArrowDown":
      return now - STEP;
    case "ArrowRight":
    case "ArrowUp":
      return now + STEP;
    case "PageDown":
      return now - LARGE_STEP;
    case "PageUp":
      return now + LARGE_STEP;
    case "Home":
      return 0;
    case "End":
      return 1;
    default:
      return null;
  }
}
