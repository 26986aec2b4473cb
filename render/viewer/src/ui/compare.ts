// Compares, at a place with ground truth, this viewer with what a camera saw there or with the engine:
// a slider uncovers one over the other.
import type { PlanPosition } from "../geometry/grid";
import type { TruthView } from "../manifest";
import type { Viewer } from "../field/viewer";
import { element, iconButton } from "./dom";
import { icon } from "./icons";
import { decimals } from "./numbers";

/** Further from the place than this, the pictures would show different things. */
const SAME_PLACE_M = 0.002;

export interface CompareHost {
  viewer: Pick<Viewer, "compare" | "divider">;
  /** Walks to a place and then calls `there`. */
  walkTo(place: TruthView, there: () => void): void;
  position(): PlanPosition;
  changed(): void;
  failed(text: string): void;
}

/** A panorama to compare with. */
interface Choice {
  place: TruthView;
  picture: string;
  label: string;
}

function distance(a: PlanPosition, b: PlanPosition): number {
  return Math.hypot(a.x_m - b.x_m, a.z_m - b.z_m);
}

export class Compare {
  /** Over the picture: where the two meet. */
  readonly line = element("div", { class: "comparison-line", testid: "comparison" });
  /** Above the toolbar. */
  readonly sheet = element("div", {
    class: "sheet",
    testid: "compare-sheet",
    attributes: { role: "group", "aria-label": "Comparison with ground truth" },
  });
  private readonly choices: readonly Choice[];
  private readonly select = element("select", {
    attributes: { "aria-label": "What is compared with this viewer" },
  });
  private readonly slider = element("input", {
    attributes: { type: "range", max: "1", step: "0.01", "aria-label": "How much of it is shown" },
  });
  private chosen: Choice | null = null;

  constructor(
    truth: readonly TruthView[],
    private readonly host: CompareHost,
  ) {
    this.choices = truth.flatMap((place, i) => {
      const label = `${i + 1}: ${decimals(place.x_m, 2)}, ${decimals(place.z_m, 2)} m`;
      return [
        { place, picture: place.picture, label: `${label}, ground truth` },
        { place, picture: place.engine, label: `${label}, engine` },
      ];
    });
    const options = this.choices.map(({ label }) => element("option", { text: label }));
    this.select.append(...options);
    this.select.addEventListener("change", () => this.open(this.select.selectedIndex));
    this.slider.value = "0.5";
    this.slider.addEventListener("input", () => this.divide());
    const close = iconButton(icon("close"), "End the comparison", () => this.close());
    this.sheet.append(this.select, this.slider, element("span", { text: "This viewer" }), close);
    this.sheet.hidden = true;
    this.line.hidden = true;
    this.divide();
  }

  get available(): boolean {
    return this.choices.length > 0;
  }

  get active(): boolean {
    return this.chosen !== null;
  }

  toggle(): void {
    if (this.active) {
      this.close();
      return;
    }
    const away_m = this.choices.map(({ place }) => distance(place, this.host.position()));
    this.open(away_m.indexOf(Math.min(...away_m)));
  }

  close(): void {
    if (!this.active) return;
    this.chosen = null;
    this.sheet.hidden = true;
    this.cover();
    this.host.changed();
  }

  /** Once a frame: one who walks away, or off before being there, has ended the comparison. */
  update(gliding: boolean): void {
    if (!this.chosen || gliding) return;
    if (distance(this.chosen.place, this.host.position()) > SAME_PLACE_M) this.close();
  }

  private open(index: number): void {
    const chosen = this.choices[index];
    if (!chosen) return;
    if (chosen.place !== this.chosen?.place) this.cover();
    this.line.hidden = true; // until the picture is there
    this.chosen = chosen;
    this.select.selectedIndex = index;
    this.sheet.hidden = false;
    this.host.walkTo(chosen.place, () => {
      if (this.chosen === chosen) void this.uncover(chosen);
    });
    this.host.changed();
  }

  private divide(): void {
    this.host.viewer.divider = Number(this.slider.value);
    this.line.style.setProperty("--divider", this.slider.value);
  }

  private async uncover(chosen: Choice): Promise<void> {
    try {
      await this.host.viewer.compare(chosen.picture);
      if (this.chosen === chosen) this.line.hidden = false;
    } catch (error) {
      this.host.failed(error instanceof Error ? error.message : String(error));
      if (this.chosen === chosen) this.close();
    }
  }

  private cover(): void {
    this.line.hidden = true;
    void this.host.viewer.compare(null);
  }
}
