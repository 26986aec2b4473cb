// The status line: the room's name, what is loading, what went wrong, and what screen readers say.
import type { LoadProgress } from "../field/viewer";
import { element, iconButton } from "./dom";
import { icon } from "./icons";

const MOST_PROBLEMS = 4;

/** The share that is there: a coarse picture is half of what is waited for. */
export function loadedPart(progress: LoadProgress): number {
  if (!(progress.wanted > 0)) return 1;
  return Math.min(1, (progress.coarse + progress.fine) / (2 * progress.wanted));
}

export function loadingText(progress: LoadProgress): string {
  return `Loading ${progress.fine} of ${progress.wanted} stations`;
}

export class Status {
  readonly element = element("div", { class: "status", testid: "status" });
  readonly live = element("div", {
    class: "screen-reader-only",
    testid: "live",
    attributes: { "aria-live": "polite", role: "status" },
  });
  private readonly loading = element("span", { class: "loading", testid: "loading" });
  private readonly bar = element("div", {
    class: "progress",
    attributes: {
      role: "progressbar",
      "aria-label": "Loading",
      "aria-valuemin": "0",
      "aria-valuemax": "100",
    },
  });
  private readonly messages = element("ul", { class: "messages", testid: "messages" });
  private readonly told = new Set<string>();
  private complete = false;

  constructor(title: string) {
    const name = element("h1", { class: "title", text: title });
    this.element.append(
      element("div", { class: "status-line" }, name, this.loading),
      this.bar,
      this.messages,
    );
  }

  update(progress: LoadProgress): void {
    for (const problem of progress.problems) this.tell(problem);
    const part = loadedPart(progress);
    const percent = String(Math.round(part * 100));
    if (part < 1) this.complete = false;
    this.bar.hidden = part >= 1;
    const text = part < 1 ? loadingText(progress) : "";
    if (this.loading.textContent !== text) this.loading.textContent = text;
    if (this.bar.getAttribute("aria-valuenow") !== percent) {
      this.bar.setAttribute("aria-valuenow", percent);
      this.bar.setAttribute("aria-valuetext", text);
      this.bar.style.setProperty("--part", String(part));
    }
    if (part < 1 || this.complete) return;
    this.complete = true;
    this.say("All around here is loaded.");
  }

  /** A message that stays until it is closed. The same is told once. */
  tell(text: string): void {
    if (this.told.has(text)) return;
    this.told.add(text);
    const line = element("li", { attributes: { role: "status" } });
    const close = iconButton(icon("close"), "Close this message", () => line.remove());
    line.append(element("span", { text }), close);
    this.messages.append(line);
    while (this.messages.children.length > MOST_PROBLEMS) this.messages.firstElementChild?.remove();
  }

  /** For screen readers, which read the same text again only if it differs: by a space. */
  say(text: string): void {
    this.live.textContent = this.live.textContent === text ? `${text}\u00a0` : text;
  }
}
