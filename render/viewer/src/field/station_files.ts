// Reads a station's files. Whatever goes wrong is a sentence for users (RoomError).
import { RoomError } from "../manifest";

/** The server did not answer: it may later. */
export class UnreachableError extends RoomError {}

function nameOf(url: URL): string {
  return url.pathname.split("/").slice(-2).join("/");
}

async function fetched(url: URL, signal?: AbortSignal): Promise<Response> {
  const name = nameOf(url);
  let response: Response;
  try {
    response = await fetch(url, signal ? { signal } : {});
  } catch (error) {
    if (signal?.aborted) throw error;
    throw new UnreachableError(`${name} could not be had; is the server still there?`);
  }
  if (!response.ok) {
    throw new RoomError(`${name} could not be had (status ${response.status}).`);
  }
  return response;
}

function damaged(url: URL): RoomError {
  return new RoomError(`${nameOf(url)} is damaged; export the room again.`);
}

/** A panorama as stored, without conversion of colours; of this width, if one is given. */
export async function readPicture(
  url: URL,
  width_px?: number,
  signal?: AbortSignal,
): Promise<ImageBitmap> {
  const response = await fetched(url, signal);
  const bytes = await response.blob().catch((error: unknown) => {
    if (signal?.aborted) throw error;
    throw damaged(url);
  });
  const picture = await createImageBitmap(bytes, {
    colorSpaceConversion: "none",
    premultiplyAlpha: "none",
  }).catch(() => {
    throw damaged(url);
  });
  const { width, height } = picture;
  if (width !== (width_px ?? width) || height !== width / 2) {
    picture.close();
    throw damaged(url);
  }
  return picture;
}

/** Inverse distances in steps, [row][column] (render/web/inverse_file.h describes the file). */
export async function readInverse(
  url: URL,
  width_px: number,
  signal: AbortSignal,
): Promise<Uint16Array<ArrayBuffer>> {
  const response = await fetched(url, signal);
  let bytes: Uint8Array;
  try {
    const plain = response.body!.pipeThrough(new DecompressionStream("deflate"));
    bytes = new Uint8Array(await new Response(plain).arrayBuffer());
  } catch (error) {
    if (signal.aborted) throw error;
    throw damaged(url);
  }
  const pixels = (width_px * width_px) / 2;
  if (bytes.length !== 2 * pixels) throw damaged(url);
  return decodeInverse(bytes, width_px);
}

/** Low bytes, then high bytes, of the differences to the row above. */
export function decodeInverse(bytes: Uint8Array, width_px: number): Uint16Array<ArrayBuffer> {
  const pixels = bytes.length / 2;
  const values = new Uint16Array(pixels);
  for (let i = 0; i < pixels; ++i) {
    const above = i < width_px ? 0 : values[i - width_px]!;
    values[i] = above + bytes[i]! + 256 * bytes[pixels + i]!;
  }
  return values;
}
