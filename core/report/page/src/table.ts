// Tables of a list of the report's JSON: sorted by a click on a heading, with all keys on demand.
import { h } from "./dom";
import { counted, decimalsOf, flattened, heading, type Json, meaning, text } from "./values";

export interface Column {
  key: string; // of a flattened row
  name?: string; // instead of the key's
  unit?: string;
  factor?: number;
  value?: (row: Json) => Json; // instead of the row's at the key
  best?: "most"; // of the column is emphasised
  good?: (row: Json) => boolean; // emphasised the same way
  bad?: (row: Json) => boolean; // emphasised as a warning
}

export interface TableOptions {
  caption?: string;
  columns?: (string | Column)[]; // those shown first; none: all
  rows?: number; // how many are shown before "all rows"
}

const MOST_ROWS = 60;

interface Row {
  row: Json; // as in the list
  flat: Record<string, Json>;
}

/** Null of a list without entries. */
export function table(list: Json[] | null | undefined, options: TableOptions = {}) {
  if (!list?.length) return null;
  const rows: Row[] = list.map((row) => ({ row, flat: flattened(row) }));
  const known = [...new Set(rows.flatMap(({ flat }) => Object.keys(flat)))].filter((key) =>
    rows.every(({ flat }) => isPlain(flat[key])),
  );
  const chosen: Column[] = (options.columns ?? known).map((column) =>
    typeof column === "string" ? { key: column } : column,
  );
  const others = known.filter((key) => chosen.every((column) => column.key !== key));
  const columns = [...chosen, ...others.map((key): Column => ({ key }))].map((column) =>
    prepared(column, rows),
  );
  let shown_columns = chosen.length;
  let shown_rows = options.rows ?? MOST_ROWS;
  let sorted: { key: string; down: boolean } | null = null;

  const holder = h("div", { class: "scroll", tabindex: 0, role: "group" });
  if (options.caption) holder.setAttribute("aria-label", options.caption);
  const buttons = h("p", { class: "buttons" });

  function draw() {
    const shown = columns.slice(0, shown_columns);
    const by = shown.find(({ key }) => key === sorted?.key);
    const ordered = by ? inOrder(rows, by.value, sorted?.down ?? false) : rows;
    const heads = shown.map(({ key, label, numeric }) => {
      const direction = sorted?.key !== key ? "none" : sorted.down ? "descending" : "ascending";
      const sort = () => {
        sorted = { key, down: direction === "ascending" };
        draw();
        holder.querySelector<HTMLElement>('th:not([aria-sort="none"]) button')?.focus();
      };
      const attributes = { scope: "col", "aria-sort": direction, class: numeric ? "" : "text" };
      return h("th", attributes, h("button", { onclick: sort }, label));
    });
    const body = ordered
      .slice(0, shown_rows)
      .map((row) => h("tr", {}, ...shown.map(({ cell }) => cell(row))));
    holder.replaceChildren(
      h("table", {}, h("thead", {}, h("tr", {}, ...heads)), h("tbody", {}, ...body)),
    );
    buttons.replaceChildren();
    if (rows.length > shown_rows) {
      addButton(`all ${counted(rows, "row")}`, () => (shown_rows = rows.length));
    }
    if (others.length && shown_columns === chosen.length) {
      addButton(counted(others, "more column"), () => (shown_columns = columns.length));
    } else if (others.length) {
      addButton("fewer columns", () => (shown_columns = chosen.length));
    }
  }

  function addButton(name: string, change: () => void) {
    buttons.append(h("button", { onclick: () => (change(), draw()) }, name));
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

const isPlain = (value: Json) =>
  !Array.isArray(value) || value.every((entry) => typeof entry !== "object");

// What all cells of a column share.
function prepared(column: Column, rows: Row[]) {
  const { key, best, good, bad } = column;
  const usual = meaning(key);
  const factor = column.factor ?? usual.factor;
  const value = ({ row, flat }: Row) => (column.value ? column.value(row) : flat[key]);
  const numbers = rows.map(value).filter((entry): entry is number => typeof entry === "number");
  const decimals = decimalsOf(numbers.map((number) => factor * number));
  const numeric = numbers.length > 0;
  const most = best && rows.length > 1 ? Math.max(...numbers) : NaN;
  const cell = (row: Row) => {
    const of_row = value(row);
    const is_best = good?.(row.row) || of_row === most;
    const kind = bad?.(row.row) ? "bad" : is_best ? "best" : "";
    const title = typeof of_row === "number" ? String(of_row) : "";
    const attributes = { class: `${kind} ${numeric ? "" : "text"}`.trim(), title };
    return h("td", attributes, text(of_row, factor, decimals));
  };
  const label = heading({ name: column.name ?? usual.name, unit: column.unit ?? usual.unit });
  return { key, label, numeric, value, cell };
}

// Texts as people count: x2 before x10. Nothing comes last in both directions.
function inOrder(rows: Row[], value: (row: Row) => Json, down: boolean): Row[] {
  const missing = (entry: Json) => entry === null || entry === undefined;
  const compare = (a: Json, b: Json) =>
    typeof a === "number" && typeof b === "number"
      ? a - b
      : String(a).localeCompare(String(b), "en", { numeric: true });
  return [...rows].sort((one, other) => {
    const [a, b] = [value(one), value(other)];
    if (missing(a) || missing(b)) return Number(missing(a)) - Number(missing(b));
    return (down ? -1 : 1) * compare(a, b);
  });
}
