// A message over the whole page: what is wrong, in a sentence.
import { element } from "./dom";

export interface MessageParts {
  title: string;
  text: string;
  /** A button below, for what can be done. */
  action?: { label: string; act(): void };
}

export function messageElement({ title, text, action }: MessageParts): HTMLElement {
  const box = element(
    "div",
    { class: "message", testid: "message", attributes: { role: "alert" } },
    element("h1", { text: title }),
    element("p", { text }),
  );
  if (action) {
    const button = element("button", {
      class: "plain-button",
      text: action.label,
      attributes: { type: "button" },
    });
    button.addEventListener("click", () => action.act());
    box.append(button);
  }
  return box;
}

/** Tells that the browser took the graphics away, until they are back. */
export function watchContext(canvas: HTMLCanvasElement, over: HTMLElement): void {
  const note = element("div", {
    class: "context-note",
    text: "The graphics were reset; one moment…",
    testid: "context-lost",
    attributes: { role: "alert" },
  });
  canvas.addEventListener("webglcontextlost", () => over.append(note));
  canvas.addEventListener("webglcontextrestored", () => note.remove());
}
