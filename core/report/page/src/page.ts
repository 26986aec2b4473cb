// The parts that reports are made of.
import { append, type Content, h } from "./dom";
import { type Image, imageRows } from "./images";
import { type Json, text, textOf } from "./values";

export interface Section {
  title: string;
  content: Content;
}

export interface Report {
  title: string;
  subtitle?: string;
  facts?: Content; // at the top
  warnings?: string[];
  sections: (Section | null | undefined | false)[];
}

/** What draws a kind of report. `images` of a section: as rows to zoom into. */
export type Describe = (document: Json, images: (section: string) => HTMLElement | null) => Report;

/** Null where there is no content; texts are paragraphs. */
export function section(title: string, ...content: Content[]): Section | null {
  const shown = content.flat().filter((part) => part);
  if (!shown.length) return null;
  return {
    title,
    content: shown.map((part) => (typeof part === "string" ? h("p", {}, part) : part)),
  };
}

export type Fact = [name: string, value: Json] | null | false | undefined;

/** Figures at a glance; numbers have four digits. */
export function facts(...list: Fact[]): HTMLElement {
  const shown = list.filter((fact): fact is [string, Json] => Boolean(fact));
  return h(
    "dl",
    { class: "facts" },
    ...shown.map(([name, value]) =>
      h("div", {}, h("dt", {}, name), h("dd", {}, typeof value === "string" ? value : text(value))),
    ),
  );
}

/** Charts, plans or tables side by side where there is room. */
export const figures = (...shown: Content[]) => h("div", { class: "figures" }, ...shown);

const slug = (title: string) => title.toLowerCase().replace(/[^a-z0-9]+/g, "-");

/** Draws the report whose JSON stands in the page. */
export function draw(describe: Describe) {
  const content = document.getElementById("report")?.textContent ?? "";
  const { document: values, images, sources } = JSON.parse(content);
  const report = describe(values, imagesOf(images, sources));
  const sections = report.sections.filter((part): part is Section => Boolean(part));
  const all = { title: "All values", content: allValues(values) };
  const warnings = report.warnings ?? [];
  document.title = report.title;
  document.body.append(
    h(
      "main",
      {},
      h(
        "header",
        {},
        h("h1", {}, report.title),
        h("p", { class: "subtitle" }, report.subtitle ?? ""),
      ),
      warnings.length
        ? h(
            "section",
            { class: "warnings", role: "alert" },
            h("h2", {}, "Warnings"),
            ...warnings.map((warning) => h("p", {}, warning)),
          )
        : null,
      report.facts,
      h(
        "nav",
        { "aria-label": "Sections" },
        ...[...sections, all].map(({ title }) => h("a", { href: `#${slug(title)}` }, title)),
      ),
      ...[...sections, all].map(({ title, content }) =>
        h("section", { id: slug(title) }, linked(h("h2", {}, title), slug(title)), content),
      ),
    ),
  );
  // A link to every figure and row of images.
  const used = new Set<string>();
  for (const figure of document.querySelectorAll<HTMLElement>("[data-title]")) {
    let id = slug(figure.dataset.title ?? "");
    while (used.has(id) || document.getElementById(id)) id += "-";
    used.add(id);
    figure.id = id;
    const heading = figure.querySelector("h3");
    if (heading) linked(heading, id);
  }
  if (location.hash) document.getElementById(location.hash.slice(1))?.scrollIntoView();
}

function linked(heading: HTMLElement, id: string) {
  append(heading, h("a", { class: "link", href: `#${id}`, "aria-label": "Link to this" }, "#"));
  return heading;
}

// `images` name the place of their source in `sources`.
const imagesOf =
  (images: (Omit<Image, "source"> & { source: number })[], sources: string[]) => (name: string) =>
    imageRows(
      images
        .filter((image) => image.section === name)
        .map((image) => ({ ...image, source: sources[image.source] ?? "" })),
    );

// The document as a tree, whose branches are made when they are opened.
function allValues(value: Json): HTMLElement {
  return h(
    "dl",
    { class: "tree" },
    ...Object.entries<Json>(value).map(([key, entry]) => {
      const branch = entry !== null && typeof entry === "object" && Object.keys(entry).length > 0;
      if (!branch) {
        return h("div", { "data-key": key }, h("dt", {}, key), h("dd", {}, textOf(key, entry)));
      }
      const count = Array.isArray(entry) ? ` (${entry.length})` : "";
      const details = h("details", { "data-key": key }, h("summary", {}, key + count));
      details.addEventListener("toggle", () => details.append(allValues(entry)), { once: true });
      return details;
    }),
  );
}
