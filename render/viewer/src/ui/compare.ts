// Compares, at a place with ground truth, what a camera saw there, the engine and this viewer: three
// pictures beside each other with two dividers that can be dragged.
import type { Pose } from "../geometry/frame";
import type { TruthView } from "../manifest";
import type { Comparison, Viewer } from "../viewer";
import { element, iconButton } from "./dom";
import { Dividers } from "./dividers";
import { icon } from "./icons";
import { decimals } from "./numbers";

/** Further from the place than this, the pictures would show different things. */
const SAME_PLACE_M = 0.002;

export interface CompareHost {
  viewer: Pick<Viewer, "compare">;
  /** Walks to a place and then calls `there`. */
  walkTo(place: TruthView, there: () => void): void;
  pose(): Pose;
  changed(): void;
  failed(text: string): void;
}

export function nearestTruth(truth: readonly TruthView[], at: Pick<Pose, "x_m" | "z_m">): number {
  const distances = truth.map((each) => Math.hypot(each.x_m - at.x_m, each.z_m - at.z_m));
  return distances.indexOf(Math.min(...distances));
}

type State = "off" | "going there" | "comparing";

export class Compare {
  /** Over the picture. */
  readonly overlay = element("div", { class: "comparison", testid: "comparison" });
  /** Above the toolbar. */
  readonly sheet = element("div", {
    class: "sheet",
    testid: "compare-sheet",
    attributes: { role: "group", "aria-label": "Comparison with ground truth" },
  });
  private readonly dividers = new Dividers(["Ground truth", "Engine", "This viewer"], () =>
    this.show(),
  );
  private readonly places = element("select");
  private state: State = "off";
  private truth = 0;
  /** The viewer takes one comparison after the other; of those asked meanwhile only the last counts. */
  private showing = false;
  private wanted: Comparison | null = null;

  constructor(
    private readonly list: readonly TruthView[],
    private readonly host: CompareHost,
  ) {
    const options = list.map((each, i) =>
      element("option", {
        text: `${i + 1}: ${decimals(each.x_m, 2)}, ${decimals(each.z_m, 2)} m`,
        attributes: { value: String(i) },
      }),
    );
    this.places.append(...options);
    this.places.addEventListener("change", () => this.open(Number(this.places.value)));
    const label = element("label", { text: "Place " }, this.places);
    const close = iconButton(icon("close"), "End the comparison", () => this.close());
    this.sheet.append(label, close);
    this.overlay.append(this.dividers.element);
    this.hide();
  }

  get available(): boolean {
    return this.list.length > 0;
  }

  get active(): boolean {
    return this.state !== "off";
  }

  toggle(): void {
    if (this.active) this.close();
    else this.open(nearestTruth(this.list, this.host.pose()));
  }

  open(truth: number): void {
    const place = this.list[truth];
    if (!place) return;
    this.truth = truth;
    this.places.value = String(truth);
    this.state = "going there";
    this.sheet.hidden = false;
    this.host.walkTo(place, () => {
      if (this.state === "going there" && this.truth === truth) this.begin();
    });
    this.host.changed();
  }

  close(): void {
    if (!this.active) return;
    this.state = "off";
    this.hide();
    this.show();
    this.host.changed();
  }

  /** Once a frame: one who walks away, or off before being there, has ended the comparison. */
  update(gliding: boolean): void {
    if (!this.active || gliding) return;
    const place = this.list[this.truth]!;
    const pose = this.host.pose();
    const away_m = Math.hypot(pose.x_m - place.x_m, pose.z_m - place.z_m);
    if (away_m > SAME_PLACE_M) this.close();
  }

  private begin(): void {
    this.state = "comparing";
    this.overlay.hidden = false;
    this.show();
    this.host.changed();
  }

  private hide(): void {
    this.overlay.hidden = true;
    this.sheet.hidden = true;
  }

  private show(): void {
    const [truth_until, engine_until] = this.dividers.positions;
    const comparing = this.state === "comparing";
    this.wanted = comparing ? { truth: this.truth, truth_until, engine_until } : null;
    if (!this.showing) void this.showWanted();
  }

  private async showWanted(): Promise<void> {
    this.showing = true;
    let shown: Comparison | null;
    do {
      shown = this.wanted;
      try {
        await this.host.viewer.compare(shown);
      } catch (error) {
        this.host.failed(error instanceof Error ? error.message : String(error));
        this.wanted = null;
        if (shown) this.close();
      }
    } while (shown !== this.wanted);
    this.showing = false;
  }
}
