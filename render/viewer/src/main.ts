// The page's beginning: opens the room in the folder of the page, or says why that cannot be.
import { openViewer, type Viewer } from "./field/viewer";
import { RoomError } from "./manifest";
import { parseOptions } from "./ui/address";
import { element } from "./ui/dom";
import { RoomPage } from "./ui/room_page";

declare global {
  interface Window {
    /** For tests and pages that embed this one: there once the room is open. */
    raywalk?: { viewer: Viewer };
  }
}

async function open(root: HTMLElement, base: URL): Promise<void> {
  const canvas = element("canvas", {
    class: "view",
    testid: "view",
    attributes: {
      tabindex: "0",
      role: "application",
      "aria-label": "View of the room. Walk with the arrow keys; H opens the help.",
    },
  });
  root.replaceChildren(canvas);
  root.setAttribute("aria-busy", "true");
  try {
    const viewer = await openViewer(canvas, base);
    document.title = viewer.manifest.title || document.title;
    new RoomPage(root, canvas, viewer, base, parseOptions(location.search));
    window.raywalk = { viewer };
  } catch (error) {
    showError(root, error);
  } finally {
    root.removeAttribute("aria-busy");
  }
}

/** A message over the whole page: what is wrong, in a sentence. */
function showError(root: HTMLElement, error: unknown): void {
  const known = error instanceof RoomError;
  if (!known) console.error(error);
  const text = error instanceof Error ? error.message : String(error);
  const again = element("button", {
    class: "plain-button",
    text: "Try again",
    attributes: { type: "button" },
  });
  again.addEventListener("click", () => location.reload());
  root.replaceChildren(
    element(
      "div",
      { class: "message", testid: "message", attributes: { role: "alert" } },
      element("h1", { text: "This room cannot be shown" }),
      element("p", { text: known ? text : `Something unexpected happened: ${text}` }),
      again,
    ),
  );
}

void open(document.getElementById("room-page")!, new URL("./", location.href));
