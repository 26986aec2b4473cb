// Tables of a list of the report's JSON: sorted by a click on a heading, with all keys on demand.
import { h } from "./dom";
import { counted, decimalsOf, flattened, heading, type Json, meaning, text } from "./values";

export interface Column {
  key: string; // of a flattened row
  name?: string; // instead of the key's
  unit?: string;
  factor?: number;
  value?: (row: Json) => Json; // instead of the row's at the key
  best?: "most" | "least"; // of the column, emphasised
  good?: (row: Json) => boolean; // emphasised the same way
  bad?: (row: Json) => boolean; // emphasised as a warning
}

export interface TableOptions {
  caption?: string;
  columns?: (string | Column)[]; // those shown first; none: all
  rows?: number; // how many are shown before "all rows"
}

const MOST_ROWS = 60;

const isPlain = (value: Json) =>
  value === null || typeof value !== "object" || value.every((v: Json) => typeof v !== "object");

/** Null of a list without entries. */
export function table(list: Json[] | null | undefined, options: TableOptions = {}) {
  if (!list?.length) return null;
  const rows = list.map((row) => ({ row, flat: flattened(row) }));
  const known = [...new Set(rows.flatMap(({ flat }) => Object.keys(flat)))].filter((key) =>
    rows.every(({ flat }) => flat[key] === undefined || isPlain(flat[key])),
  );
  const chosen: Column[] = (options.columns ?? known).map((column) =>
    typeof column === "string" ? { key: column } : column,
  );
  const others = known.filter((key) => chosen.every((column) => column.key !== key));
  let all = false;
  let shown = options.rows ?? MOST_ROWS;
  let sorted: { key: string; down: boolean } | null = null;

  const valueOf = (column: Column, { row, flat }: (typeof rows)[number]) =>
    column.value ? column.value(row) : flat[column.key];
  const holder = h("div", { class: "scroll", tabindex: 0, role: "group" });
  if (options.caption) holder.setAttribute("aria-label", options.caption);
  const buttons = h("p", { class: "buttons" });

  function draw() {
    const columns = all ? [...chosen, ...others.map((key): Column => ({ key }))] : chosen;
    const ordered = [...rows];
    const by = sorted && columns.find((column) => column.key === sorted?.key);
    if (by && sorted) {
      const sign = sorted.down ? -1 : 1;
      ordered.sort((a, b) => sign * compare(valueOf(by, a), valueOf(by, b)));
    }
    const head = h("tr");
    const cells = columns.map((column) => {
      const usual = meaning(column.key);
      const { name, unit } = { name: column.name ?? usual.name, unit: column.unit ?? usual.unit };
      const factor = column.factor ?? usual.factor;
      const numbers = rows
        .map((row) => valueOf(column, row))
        .filter((value): value is number => typeof value === "number");
      const decimals = decimalsOf(numbers.map((value) => factor * value));
      const best =
        column.best && rows.length > 1 && numbers.length
          ? Math[column.best === "most" ? "max" : "min"](...numbers)
          : null;
      const direction =
        sorted?.key === column.key ? (sorted.down ? "descending" : "ascending") : "none";
      const sort = () => {
        sorted = { key: column.key, down: direction === "ascending" };
        draw();
      };
      head.append(
        h(
          "th",
          { scope: "col", "aria-sort": direction, class: numbers.length ? "" : "text" },
          h("button", { onclick: sort }, heading({ name, unit })),
        ),
      );
      return (row: (typeof rows)[number]) => {
        const value = valueOf(column, row);
        const number = typeof value === "number";
        const good = column.good?.(row.row) || (best !== null && value === best);
        const kind = column.bad?.(row.row) ? "bad" : good ? "best" : "";
        return h(
          "td",
          {
            class: `${kind} ${numbers.length ? "" : "text"}`.trim(),
            title: number ? `${value}` : "",
          },
          text(value, factor, decimals),
        );
      };
    });
    const body = ordered
      .slice(0, shown)
      .map((row) => h("tr", {}, ...cells.map((cell) => cell(row))));
    holder.replaceChildren(h("table", {}, h("thead", {}, head), h("tbody", {}, ...body)));
    buttons.replaceChildren();
    if (rows.length > shown) {
      buttons.append(button(`all ${counted(rows, "row")}`, () => (shown = rows.length)));
    }
    if (others.length) {
      buttons.append(
        button(all ? "fewer columns" : `${counted(others, "more column")}`, () => (all = !all)),
      );
    }
  }

  function button(name: string, change: () => void) {
    return h("button", { onclick: () => (change(), draw()) }, name);
  }

  draw();
  return h(
    "div",
    { class: "table" },
    options.caption ? h("p", { class: "caption" }, options.caption) : null,
    holder,
    buttons,
  );
}

// Nothing last; texts as people count: x2 before x10.
function compare(a: Json, b: Json): number {
  const missing = (value: Json) => value === null || value === undefined;
  if (missing(a) || missing(b)) return Number(missing(a)) - Number(missing(b));
  if (typeof a === "number" && typeof b === "number") return a - b;
  return String(a).localeCompare(String(b), "en", { numeric: true });
}
