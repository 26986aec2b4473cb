// What a value of a report's JSON reads like. Keys end with their unit: "position_sigma_mm" is the
// position's sigma in mm, "filled_share" a share that reads better in percent.

// eslint-disable-next-line @typescript-eslint/no-explicit-any
export type Json = any;

export interface Meaning {
  name: string;
  unit: string;
  factor: number; // from the JSON's unit to this one
}

// By the end of a key, longest first.
const UNITS: [suffix: string, unit: string, factor: number][] = [
  ["_per_m", "1/m", 1],
  ["_share", "%", 100],
  ["_bytes", "MB", 1e-6],
  ["_deg", "°", 1],
  ["_rad", "rad", 1],
  ["_db", "dB", 1],
  ["_mb", "MB", 1],
  ["_gb", "GB", 1],
  ["_mm", "mm", 1],
  ["_cm", "cm", 1],
  ["_px", "px", 1],
  ["_ms", "ms", 1],
  ["_m", "m", 1],
  ["_s", "s", 1],
];

const WORDS: Record<string, string> = {
  "ws psnr": "WS-PSNR",
  psnr: "PSNR",
  ssim: "SSIM",
  fsim: "FSIM",
  "e connect": "E_connect",
  "d p": "d_p",
  cpu: "CPU",
  json: "JSON",
};

/** Of a key such as "ws_psnr_db" or a path of such: "pareto.psnr_db". */
export function meaning(key: string): Meaning {
  const found = UNITS.find(([suffix]) => key.endsWith(suffix) && key.length > suffix.length);
  const [suffix, unit, factor] = found ?? ["", "", 1];
  let name = key
    .slice(0, key.length - suffix.length)
    .replace(/[._]+/g, " ")
    .trim();
  for (const [plain, word] of Object.entries(WORDS)) {
    name = name.replace(new RegExp(`\\b${plain}\\b`), word);
  }
  return { name, unit, factor };
}

/** "position sigma / mm": of a column or an axis. */
export function heading({ name, unit }: Pick<Meaning, "name" | "unit">): string {
  return unit ? `${name} / ${unit}` : name;
}

const NOTHING = "–";
const DIGITS = 4;
const MOST_DECIMALS = 6;

/** Decimals that give the largest of these values four digits. */
export function decimalsOf(values: number[]): number {
  if (values.every(Number.isInteger)) return 0;
  const largest = values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  const before = largest > 0 ? Math.floor(Math.log10(largest)) + 1 : 0; // the point
  return Math.min(Math.max(DIGITS - before, 0), MOST_DECIMALS);
}

/** A value as text; numbers with these decimals, or with at most four digits. */
export function text(value: Json, factor = 1, decimals?: number): string {
  if (value === null || value === undefined || value === "") return NOTHING;
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (Array.isArray(value)) return value.map((entry) => text(entry, factor)).join(", ") || NOTHING;
  if (typeof value === "object") {
    return Object.entries(value)
      .map(([key, entry]) => `${meaning(key).name} ${text(entry, meaning(key).factor)}`)
      .join(", ");
  }
  if (typeof value !== "number") return String(value);
  const number = factor * value;
  const fixed = number.toFixed(decimals ?? decimalsOf([number]));
  if (Number(fixed) === 0)
    return number === 0 || decimals !== undefined
      ? fixed.replace("-", "")
      : number.toExponential(2);
  return decimals === undefined ? String(Number(fixed)) : fixed;
}

/** A value with the unit of its key: "0.2057 mm". */
export function textOf(key: string, value: Json): string {
  const { unit, factor } = meaning(key);
  const plain = text(value, factor);
  return plain === NOTHING || !unit ? plain : `${plain} ${unit}`;
}

/** The same of an object's value at a key. */
export const textAt = (object: Json, key: string) => textOf(key, object[key]);

/** "1 line", "3 lines". */
export function counted(count: number | unknown[], noun: string): string {
  const number = Array.isArray(count) ? count.length : count;
  return `${number} ${noun}${number === 1 ? "" : "s"}`;
}

/** Lengths below 1 cm in mm, others in cm. */
export function length(metres: number | null | undefined, otherwise = NOTHING): string {
  if (metres === null || metres === undefined) return otherwise;
  return metres < 0.01 ? `${(1000 * metres).toFixed(1)} mm` : `${(100 * metres).toFixed(1)} cm`;
}

/** An object without nesting: {a: {b_mm: 1}} is {"a.b_mm": 1}. Lists stay as they are. */
export function flattened(value: Json, prefix = ""): Record<string, Json> {
  const flat: Record<string, Json> = {};
  for (const [key, entry] of Object.entries<Json>(value)) {
    if (entry !== null && typeof entry === "object" && !Array.isArray(entry)) {
      Object.assign(flat, flattened(entry, `${prefix}${key}.`));
    } else {
      flat[prefix + key] = entry;
    }
  }
  return flat;
}
