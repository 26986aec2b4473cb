// About this room: how it was captured, how good its views are, and the way to its hotspots.
import type { Hotspot, Manifest } from "../manifest";
import { Dialog } from "./dialog";
import { element } from "./dom";

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
