// The dialogs: the help, with every key and what mouse, touch, gamepads and headsets do; and about this
// room: how it was captured, how good its views are, and the way to its hotspots.
import type { Hotspot, Manifest } from "../manifest";
import { COMMAND_KEYS, MOVEMENT_KEYS } from "../walk/keyboard";
import { element, iconButton } from "./dom";
import { icon } from "./icons";

/** With a title and a button that closes it; Escape and a click beside it do too. */
export class Dialog {
  readonly element: HTMLDialogElement;
  readonly content = element("div", { class: "dialog-content" });

  constructor(title: string, testid: string) {
    const close = iconButton(icon("close"), "Close", () => this.element.close());
    const head = element("header", {}, element("h2", { text: title }), close);
    this.element = element(
      "dialog",
      { testid, attributes: { "aria-label": title } },
      head,
      this.content,
    );
    this.element.addEventListener("click", (event) => {
      if (event.target === this.element) this.element.close();
    });
  }

  toggle(): void {
    if (this.element.open) this.element.close();
    else this.element.showModal();
  }
}

interface Row {
  shown: readonly string[];
  does: string;
}

const OTHERS: readonly Row[] = [
  { shown: ["Mouse"], does: "Drag to look, wheel to zoom, double click to walk a step that way" },
  { shown: ["Touch"], does: "Drag to look, two fingers to zoom, the pad to walk" },
  {
    shown: ["Gamepad"],
    does: "Left stick walks, right stick looks, triggers zoom, shoulders raise and lower the eye",
  },
  {
    shown: ["Headset"],
    does: "Left thumbstick walks where you look, right thumbstick turns by 30°",
  },
  { shown: ["Plan"], does: "Click to walk there; arrow keys and Enter do the same" },
];

export function helpDialog(): Dialog {
  const dialog = new Dialog("Help", "help");
  dialog.content.append(
    element("h3", { text: "Keys" }),
    table([...MOVEMENT_KEYS, ...COMMAND_KEYS]),
    element("h3", { text: "Other ways to walk" }),
    table(OTHERS),
  );
  return dialog;
}

function table(rows: readonly Row[]): HTMLElement {
  const lines = rows.map((row) => {
    const keys = element("th", { attributes: { scope: "row" } });
    keys.append(...row.shown.map((key) => element("kbd", { text: key })));
    return element("tr", {}, keys, element("td", { text: row.does }));
  });
  return element("table", { class: "keys" }, element("tbody", {}, ...lines));
}

export function infoDialog(
  manifest: Manifest,
  hotspots: readonly Hotspot[],
  lookAt: (hotspot: Hotspot) => void,
): Dialog {
  const dialog = new Dialog(manifest.title || "This room", "info");
  const stations = manifest.lines.reduce((sum, line) => sum + line.stations.length, 0);
  const facts: [string, string][] = [
    ["Lines", `${manifest.lines.length}`],
    ["Stations", `${stations}`],
    ["Cells", `${manifest.cells.length}`],
    ["Panoramas", `${manifest.panorama.width_px} px wide`],
    ["Vertical range of the eye", `±${manifest.vertical_range_m} m`],
    ["Graphics memory", `at most ${manifest.budget_mb} MB`],
    ["Exported by", manifest.program],
  ];
  if (manifest.quality) {
    dialog.content.append(element("p", { text: manifest.quality.text, testid: "quality" }));
  }
  const list = element("dl");
  for (const [name, value] of facts) {
    list.append(element("dt", { text: name }), element("dd", { text: value }));
  }
  dialog.content.append(list);
  if (hotspots.length > 0) dialog.content.append(...hotspotList(hotspots, dialog, lookAt));
  return dialog;
}

/** Labels behind one cannot be reached with a keyboard: from here one turns to them. */
function hotspotList(
  hotspots: readonly Hotspot[],
  dialog: Dialog,
  lookAt: (hotspot: Hotspot) => void,
): HTMLElement[] {
  const buttons = hotspots.map((hotspot) => {
    const button = element("button", {
      class: "plain-button",
      text: hotspot.text,
      attributes: { type: "button" },
    });
    button.addEventListener("click", () => {
      dialog.element.close();
      lookAt(hotspot);
    });
    return element("li", {}, button);
  });
  return [element("h3", { text: "Look at" }), element("ul", { class: "hotspot-list" }, ...buttons)];
}
