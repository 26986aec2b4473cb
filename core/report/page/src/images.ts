// The report's images, in rows; a click opens a row in a window where all its images are zoomed and
// moved together.
import { h } from "./dom";

export interface Image {
  section: string;
  row: string;
  caption: string;
  source: string;
}

const MOST_ZOOM = 32;
const ZOOM_STEP = 1.25;
const PAN_STEP = 0.1; // of the image's width

/** Null where there are none. */
export function imageRows(images: Image[]): HTMLElement | null {
  if (!images.length) return null;
  const rows = new Map<string, Image[]>();
  for (const image of images) rows.set(image.row, [...(rows.get(image.row) ?? []), image]);
  return h(
    "div",
    {
      class: "rows",
      style: `--row: ${Math.max(...[...rows.values()].map((row) => row.length)) > 2 ? 100 : 40}rem`,
    },
    ...[...rows].map(([name, row]) =>
      h(
        "section",
        { class: "image-row", "data-title": name },
        h("h3", {}, name),
        h(
          "div",
          { class: "images", style: `--count: ${row.length}` },
          ...row.map((image) =>
            h(
              "figure",
              {},
              h(
                "button",
                { class: "zoom", title: "Zoom", onclick: () => openZoom(name, row) },
                h("img", { src: image.source, alt: `${name}: ${image.caption}` }),
              ),
              h("figcaption", {}, image.caption),
            ),
          ),
        ),
      ),
    ),
  );
}

function openZoom(name: string, images: Image[]) {
  // What the middle of each pane shows, in widths of the image, and how often it is enlarged.
  let view = { x: 0.5, y: 0.5, zoom: 1 };
  const panes = images.map((image) => {
    const img = h("img", { src: image.source, alt: image.caption, draggable: "false" });
    return {
      img,
      pane: h("figure", {}, h("div", { class: "pane" }, img), h("figcaption", {}, image.caption)),
    };
  });
  const show = (change: Partial<typeof view>) => {
    view = { ...view, ...change };
    view.zoom = Math.min(Math.max(view.zoom, 1), MOST_ZOOM);
    const half = 0.5 / view.zoom;
    view.x = Math.min(Math.max(view.x, half), 1 - half);
    view.y = Math.min(Math.max(view.y, half), 1 - half);
    for (const { img } of panes) {
      img.style.transform = `scale(${view.zoom}) translate(${100 * (0.5 - view.x)}%, ${100 * (0.5 - view.y)}%)`;
      img.style.imageRendering = view.zoom > 3 ? "pixelated" : "auto";
    }
  };
  const keys: Record<string, () => void> = {
    "+": () => show({ zoom: view.zoom * ZOOM_STEP }),
    "-": () => show({ zoom: view.zoom / ZOOM_STEP }),
    "0": () => show({ x: 0.5, y: 0.5, zoom: 1 }),
    ArrowLeft: () => show({ x: view.x - PAN_STEP / view.zoom }),
    ArrowRight: () => show({ x: view.x + PAN_STEP / view.zoom }),
    ArrowUp: () => show({ y: view.y - PAN_STEP / view.zoom }),
    ArrowDown: () => show({ y: view.y + PAN_STEP / view.zoom }),
  };
  const press = (key: string) => keys[key]?.();
  const dialog = h(
    "dialog",
    {
      class: "zoomed",
      "aria-label": name,
      onclose: () => dialog.remove(),
      onkeydown: (event) => {
        const { key } = event as KeyboardEvent;
        if (!keys[key]) return;
        event.preventDefault();
        press(key);
      },
    },
    h(
      "header",
      {},
      h("h2", {}, name),
      h("button", { onclick: () => press("+"), "aria-label": "Enlarge" }, "+"),
      h("button", { onclick: () => press("-"), "aria-label": "Shrink" }, "−"),
      h("button", { onclick: () => press("0") }, "whole"),
      h("button", { onclick: () => dialog.close() }, "close"),
    ),
    h(
      "div",
      { class: "panes", style: `--count: ${images.length}` },
      ...panes.map(({ pane }) => pane),
    ),
  );
  for (const { img } of panes) {
    const pane = img.parentElement as HTMLElement;
    pane.addEventListener("wheel", (event) => {
      event.preventDefault();
      // What is under the pointer stays there.
      const box = pane.getBoundingClientRect();
      const [u, v] = [
        (event.clientX - box.left) / box.width - 0.5,
        (event.clientY - box.top) / box.height - 0.5,
      ];
      const zoom = Math.min(
        Math.max(view.zoom * (event.deltaY < 0 ? ZOOM_STEP : 1 / ZOOM_STEP), 1),
        MOST_ZOOM,
      );
      const moved = 1 / view.zoom - 1 / zoom;
      show({ zoom, x: view.x + u * moved, y: view.y + v * moved });
    });
    pane.addEventListener("pointerdown", (event) => pane.setPointerCapture(event.pointerId));
    pane.addEventListener("pointermove", (event) => {
      if (!pane.hasPointerCapture(event.pointerId)) return;
      const { width, height } = pane.getBoundingClientRect();
      show({
        x: view.x - event.movementX / width / view.zoom,
        y: view.y - event.movementY / height / view.zoom,
      });
    });
  }
  document.body.append(dialog);
  dialog.showModal();
  show({});
}
