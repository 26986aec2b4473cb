// How views are made: the method, and the angle k of its views.
import { METHODS, type ViewMethod } from "../manifest";
import type { Viewer } from "../field/viewer";
import type { ViewSettings } from "../manifest";
import { LEAST_K_DEG, MOST_K_DEG } from "./address";
import { element } from "./dom";
import { icon } from "./icons";

export class SettingsPanel {
  readonly element = element("div", {
    class: "settings",
    testid: "settings",
    attributes: { role: "group", "aria-label": "How views are made" },
  });
  private readonly radios = new Map<ViewMethod, HTMLInputElement>();
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
    private readonly viewer: Pick<Viewer, "settings">,
    private readonly closed: () => void,
  ) {
    const group = element("div", {
      class: "methods",
      attributes: { role: "radiogroup", "aria-label": "Views" },
    });
    group.append(...METHODS.map((method) => this.choice(method)));
    this.k.addEventListener("input", () => this.choose({ k_deg: Number(this.k.value) }));
    const label = element(
      "label",
      { class: "k" },
      element("span", { text: "k", attributes: { "aria-hidden": "true" } }),
      this.k,
      this.k_shown,
    );
    this.element.append(group, label);
    this.choose({});
  }

  /** Whether it is shown where the toolbar has no room for it, with its slider focused. */
  get open(): boolean {
    return this.element.classList.contains("open");
  }

  toggle(): void {
    if (this.element.classList.toggle("open")) this.k.focus();
    else this.closed();
  }

  choose(change: Partial<ViewSettings>): void {
    this.viewer.settings = { ...this.viewer.settings, ...change };
    const { method, k_deg } = this.viewer.settings;
    this.radios.get(method)!.checked = true;
    this.k.value = String(k_deg);
    this.k_shown.textContent = `${Math.round(k_deg)}°`;
  }

  private choice(method: ViewMethod): HTMLLabelElement {
    const radio = element("input", {
      attributes: { type: "radio", name: "method", value: method },
    });
    radio.addEventListener("change", () => this.choose({ method }));
    this.radios.set(method, radio);
    const label = element("label", { attributes: { title: `Views: ${method}` } }, radio);
    label.append(icon(method), element("span", { text: method }));
    return label;
  }
}
