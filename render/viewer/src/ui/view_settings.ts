// How views are made: the generation, and the angle k of its views.
import { GENERATIONS, type Generation } from "../manifest";
import type { ViewSettings } from "../viewer";
import { LEAST_K_DEG, MOST_K_DEG } from "./address";
import { element } from "./dom";
import { icon } from "./icons";

export class SettingsPanel {
  readonly element = element("div", {
    class: "settings",
    testid: "settings",
    attributes: { role: "group", "aria-label": "How views are made" },
  });
  private readonly radios = new Map<Generation, HTMLInputElement>();
  private readonly k = element("input", {
    attributes: {
      type: "range",
      min: String(LEAST_K_DEG),
      max: String(MOST_K_DEG),
      step: "1",
      "aria-label": "k in degrees",
      title: "k in degrees",
    },
  });
  private readonly k_shown = element("output", { class: "k-value" });

  constructor(
    settings: ViewSettings,
    private readonly choose: (change: Partial<ViewSettings>) => void,
  ) {
    const group = element("div", {
      class: "generations",
      attributes: { role: "radiogroup", "aria-label": "Views" },
    });
    group.append(...GENERATIONS.map((generation) => this.choice(generation)));
    this.k.addEventListener("input", () => this.choose({ k_deg: Number(this.k.value) }));
    const label = element(
      "label",
      { class: "k" },
      element("span", { text: "k", attributes: { "aria-hidden": "true" } }),
      this.k,
      this.k_shown,
    );
    this.element.append(group, label);
    this.show(settings);
  }

  show(settings: ViewSettings): void {
    this.radios.get(settings.generation)!.checked = true;
    this.k.value = String(settings.k_deg);
    this.k_shown.textContent = `${Math.round(settings.k_deg)}°`;
  }

  focus(): void {
    this.k.focus();
  }

  private choice(generation: Generation): HTMLLabelElement {
    const radio = element("input", {
      attributes: { type: "radio", name: "generation", value: generation },
    });
    radio.addEventListener("change", () => this.choose({ generation }));
    this.radios.set(generation, radio);
    const label = element("label", { attributes: { title: `Views: ${generation}` } }, radio);
    label.append(icon(generation), element("span", { text: generation }));
    return label;
  }
}
