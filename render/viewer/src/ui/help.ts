// The help: every key, and what mouse, touch, gamepads and headsets do.
import { COMMAND_KEYS, MOVEMENT_KEYS } from "../walk/keys";
import { element } from "./dom";
import { Dialog } from "./dialog";

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
