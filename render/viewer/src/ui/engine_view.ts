// A view that stays still sharpens to the engine's own picture after a moment.
//
// The picture lies over the canvas and goes at once when anything changes; requests for what is no
// longer shown are given up.
import { engineCanShow, engineUrl, type StillView } from "./engine_request";
import { element } from "./dom";

const STILL_MS = 600;
/** Outside the room, by the engine's rules: the viewer shows such places, the engine does not. */
const OUTSIDE_STATUS = 422;

export class EngineView {
  readonly element = element("img", {
    class: "engine-view",
    testid: "engine-view",
    attributes: { alt: "", draggable: "false" },
  });
  private shown_for = "";
  private since_ms = 0;
  private request: AbortController | null = null;
  private asked = false;
  private complained = false;

  constructor(
    private readonly engine: string,
    private readonly base: URL,
    private readonly failed: (text: string) => void,
  ) {
    this.element.hidden = true;
  }

  /** Once a frame; null while the engine is not to be asked. */
  update(view: StillView | null, now_ms: number): void {
    const possible = view !== null && engineCanShow(view);
    const address = possible ? engineUrl(view, this.engine, this.base).href : "";
    if (address !== this.shown_for) {
      this.shown_for = address;
      this.since_ms = now_ms;
      this.remove();
      return;
    }
    if (address === "" || this.asked || now_ms - this.since_ms < STILL_MS) return;
    this.asked = true;
    void this.ask(address);
  }

  private remove(): void {
    this.request?.abort();
    this.request = null;
    this.asked = false;
    if (this.element.hidden) return;
    this.element.hidden = true;
    this.element.classList.remove("shown");
    URL.revokeObjectURL(this.element.src);
    this.element.removeAttribute("src");
  }

  private async ask(address: string): Promise<void> {
    const request = new AbortController();
    this.request = request;
    try {
      const response = await fetch(address, { signal: request.signal });
      if (response.status === OUTSIDE_STATUS) return;
      if (!response.ok) throw new Error(response.statusText);
      await this.show(await response.blob(), request.signal);
    } catch {
      if (request.signal.aborted || this.complained) return;
      this.complained = true;
      this.failed("The engine did not answer.");
    }
  }

  private async show(picture: Blob, signal: AbortSignal): Promise<void> {
    const url = URL.createObjectURL(picture);
    const decoded = new Image();
    decoded.src = url;
    try {
      await decoded.decode();
    } catch (error) {
      URL.revokeObjectURL(url);
      throw error;
    }
    if (signal.aborted) {
      URL.revokeObjectURL(url);
      return;
    }
    this.element.src = url;
    this.element.hidden = false;
    // The fade begins from what the browser has laid out.
    void this.element.offsetWidth;
    this.element.classList.add("shown");
  }
}
