// Opens the room beside the page, or says why that cannot be.
import { ExportError, parseManifest, type Manifest } from "../manifest";
import { DeviceError, type OpenViewer, type Viewer } from "../viewer";
import { parseAddress } from "./address";
import { element } from "./dom";
import { messageElement } from "./message";
import { parseOptions } from "./options";
import { PanoramaFallback } from "./panorama_fallback";
import { RoomPage } from "./room_page";

declare global {
  interface Window {
    /** For tests and pages that embed this one: there once the room is open. */
    raywalk?: { viewer: Viewer };
  }
}

export async function boot(root: HTMLElement, base: URL, openViewer: OpenViewer): Promise<void> {
  const options = parseOptions(location.search);
  if (!hasWebGl2()) {
    await showPanoramas(root, base);
    return;
  }
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
    new RoomPage(root, canvas, viewer, base, options);
    window.raywalk = { viewer };
  } catch (error) {
    if (error instanceof DeviceError) await showPanoramas(root, base);
    else showError(root, error);
  } finally {
    root.removeAttribute("aria-busy");
  }
}

function hasWebGl2(): boolean {
  const context = element("canvas").getContext("webgl2");
  // Browsers allow few contexts; this one has told what it was made for.
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return context !== null;
}

async function showPanoramas(root: HTMLElement, base: URL): Promise<void> {
  try {
    const manifest = await readManifest(base);
    document.title = manifest.title || document.title;
    const start = { ...parseOptions(location.search).start, ...parseAddress(location.hash).pose };
    root.replaceChildren(new PanoramaFallback(manifest, base, start).element);
  } catch (error) {
    showError(root, error);
  }
}

async function readManifest(base: URL): Promise<Manifest> {
  const response = await fetch(new URL("manifest.json", base)).catch(() => null);
  if (!response?.ok) {
    throw new ExportError("manifest.json could not be read; is the whole exported folder there?");
  }
  return parseManifest(await response.text());
}

function showError(root: HTMLElement, error: unknown): void {
  const known = error instanceof ExportError;
  if (!known) console.error(error);
  const text = error instanceof Error ? error.message : String(error);
  root.replaceChildren(
    messageElement({
      title: "This room cannot be shown",
      text: known ? text : `Something unexpected happened: ${text}`,
      action: { label: "Try again", act: () => location.reload() },
    }),
  );
}
