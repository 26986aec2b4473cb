// Numbers in addresses and on the page.

const PLAIN_NUMBER = /^[+-]?(\d{1,9}(\.\d{0,20})?|\.\d{1,20})$/;

/**
 * A number as people and programs write it; nothing for what else JavaScript takes for one ("",
 * "0x1", "1e99").
 */
export function readNumber(text: string | null | undefined): number | undefined {
  const trimmed = (text ?? "").trim();
  return PLAIN_NUMBER.test(trimmed) ? Number(trimmed) : undefined;
}

/** With so many decimals, and no minus before what is then zero. */
export function decimals(value: number, count: number): string {
  const text = value.toFixed(count);
  return Number(text) === 0 ? (0).toFixed(count) : text;
}
