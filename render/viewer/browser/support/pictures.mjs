// Numbers that say what pictures (of png.mjs) show.
import assert from "node:assert/strict";

/** Of all channels together. */
export function psnr(a, b) {
  assert.deepEqual([a.width, a.height], [b.width, b.height], "pictures of different sizes");
  let sum = 0;
  for (let i = 0; i < a.rgb.length; ++i) sum += (a.rgb[i] - b.rgb[i]) ** 2;
  return 10 * Math.log10((255 ** 2 * a.rgb.length) / sum);
}

export function crop(picture, left, top, width, height) {
  const rgb = new Uint8Array(3 * width * height);
  for (let row = 0; row < height; ++row) {
    const from = 3 * ((top + row) * picture.width + left);
    rgb.set(picture.rgb.subarray(from, from + 3 * width), 3 * row * width);
  }
  return { width, height, rgb };
}

/** Standard deviation of all values: 0 where everything has one colour. */
export function contrast({ rgb }) {
  const mean = rgb.reduce((sum, value) => sum + value, 0) / rgb.length;
  return Math.sqrt(rgb.reduce((sum, value) => sum + (value - mean) ** 2, 0) / rgb.length);
}

const HOLES = [
  [0, 0, 0],
  [64, 64, 64],
];

/** The share of pixels in the colours of nothing: black, and what the shader shows where no station
    knows anything. */
export function holes({ rgb }) {
  const isHole = (i) =>
    HOLES.some((colour) => colour.every((value, c) => Math.abs(rgb[i + c] - value) <= 1));
  let count = 0;
  for (let i = 0; i < rgb.length; i += 3) count += isHole(i) ? 1 : 0;
  return (3 * count) / rgb.length;
}
