// Reads PNG as the engine and the browser write it: 8 bits, RGB or RGBA, not interlaced. In Node, so
// that pictures are compared by nothing that has drawn them.
import assert from "node:assert/strict";
import { inflateSync } from "node:zlib";

const SIGNATURE_BYTES = 8;
const CHANNELS_OF_TYPE = { 2: 3, 6: 4 };

/** {width, height, rgb: [row][column][channel]}; transparency is left out. */
export function decodePng(file) {
  let header;
  const data = [];
  for (const { type, body } of chunks(file)) {
    if (type === "IHDR") header = body;
    if (type === "IDAT") data.push(body);
  }
  const width = header.readUInt32BE(0);
  const height = header.readUInt32BE(4);
  const channels = CHANNELS_OF_TYPE[header[9]];
  assert.ok(header[8] === 8 && channels && header[12] === 0, "a kind of PNG that is not expected");
  const bytes = unfilter(inflateSync(Buffer.concat(data)), width * channels, height, channels);
  return { width, height, rgb: withoutAlpha(bytes, width * height, channels) };
}

function* chunks(file) {
  for (let at = SIGNATURE_BYTES; at < file.length; ) {
    const length = file.readUInt32BE(at);
    const type = file.toString("latin1", at + 4, at + 8);
    yield { type, body: file.subarray(at + 8, at + 8 + length) };
    at += length + 12;
  }
}

function unfilter(filtered, stride, height, channels) {
  const bytes = new Uint8Array(stride * height);
  for (let row = 0; row < height; ++row) {
    const filter = filtered[row * (stride + 1)];
    const from = row * (stride + 1) + 1;
    const to = row * stride;
    for (let i = 0; i < stride; ++i) {
      const left = i >= channels ? bytes[to + i - channels] : 0;
      const above = row > 0 ? bytes[to + i - stride] : 0;
      const corner = i >= channels && row > 0 ? bytes[to + i - stride - channels] : 0;
      bytes[to + i] = filtered[from + i] + predicted(filter, left, above, corner);
    }
  }
  return bytes;
}

function predicted(filter, left, above, corner) {
  if (filter === 0) return 0;
  if (filter === 1) return left;
  if (filter === 2) return above;
  if (filter === 3) return (left + above) >> 1;
  const to_left = Math.abs(above - corner);
  const to_above = Math.abs(left - corner);
  const to_corner = Math.abs(left + above - 2 * corner);
  if (to_left <= to_above && to_left <= to_corner) return left;
  return to_above <= to_corner ? above : corner;
}

function withoutAlpha(bytes, pixels, channels) {
  if (channels === 3) return bytes;
  const rgb = new Uint8Array(3 * pixels);
  for (let i = 0; i < pixels; ++i) rgb.set(bytes.subarray(4 * i, 4 * i + 3), 3 * i);
  return rgb;
}
