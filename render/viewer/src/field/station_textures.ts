// The textures that hold stations: an array layer each for the fine picture, the coarse picture and
// the distances, and a table of what is there.
import * as three from "three";
import { RoomError, type Manifest } from "../manifest";

const BYTES_PER_PIXEL = 4;
const BYTES_PER_OMEGA = 2;
const FLOATS_PER_TEXEL = 4;

type Sizes = Pick<Manifest, "panorama" | "distances" | "budget_mb">;

function pixelsOf(width_px: number): number {
  return (width_px * width_px) / 2;
}

export function bytesPerStation({ panorama, distances }: Sizes): number {
  return (
    BYTES_PER_PIXEL * (pixelsOf(panorama.width_px) + pixelsOf(panorama.coarse_width_px)) +
    BYTES_PER_OMEGA * pixelsOf(distances.width_px)
  );
}

/** As many layers as the budget and the device hold, at most one per station. */
export function layersWithin(sizes: Sizes, stations: number, most: number): number {
  const affordable = Math.floor((sizes.budget_mb * 1e6) / bytesPerStation(sizes));
  return Math.max(2, Math.min(affordable, most, stations));
}

export class StationTextures {
  readonly layers: number;
  readonly pictures: three.DataArrayTexture;
  readonly coarsePictures: three.DataArrayTexture;
  readonly omegaMaps: three.DataArrayTexture;
  /** [fact][layer]: position and picture (0 none, 1 coarse, 2 fine); whether distances are there. */
  readonly table: three.DataTexture;
  /** Of each layer with distances, their pixels next to silhouettes (attribute "pixel"). */
  readonly silhouettes: three.BufferGeometry[] = [];
  private readonly facts: Float32Array<ArrayBuffer>;

  constructor(
    private readonly webgl: three.WebGLRenderer,
    private readonly sizes: Sizes,
    stations: number,
  ) {
    const gl = webgl.getContext() as WebGL2RenderingContext;
    const mostPixels = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
    if (sizes.panorama.width_px > mostPixels) {
      throw new RoomError(
        `This device shows panoramas up to ${mostPixels} pixels wide; the room was exported with ` +
          `${sizes.panorama.width_px}. Export it with --width ${mostPixels}.`,
      );
    }
    const mostLayers = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS) as number;
    this.layers = layersWithin(sizes, stations, mostLayers);
    this.pictures = pictureArray(sizes.panorama.width_px, this.layers);
    this.coarsePictures = pictureArray(sizes.panorama.coarse_width_px, this.layers);
    this.omegaMaps = emptyArray(sizes.distances.width_px, this.layers);
    this.omegaMaps.format = three.RedIntegerFormat;
    this.omegaMaps.type = three.UnsignedShortType;
    this.omegaMaps.internalFormat = "R16UI";
    this.facts = new Float32Array(2 * FLOATS_PER_TEXEL * this.layers);
    this.table = new three.DataTexture(
      this.facts,
      this.layers,
      2,
      three.RGBAFormat,
      three.FloatType,
    );
    this.table.needsUpdate = true;
  }

  setPicture(layer: number, picture: ImageBitmap, fine: boolean): void {
    const source = new three.Texture(picture);
    this.upload(source, fine ? this.pictures : this.coarsePictures, layer);
    source.dispose();
    this.setFact(layer, 0, 3, fine ? 2 : 1);
  }

  setOmega(layer: number, values: Uint16Array<ArrayBuffer>): void {
    const { width_px: width, surface_tolerance } = this.sizes.distances;
    const rim = silhouettePixels(values, width, surface_tolerance);
    this.silhouettes[layer]?.dispose();
    this.silhouettes[layer] = new three.BufferGeometry().setAttribute(
      "pixel",
      new three.BufferAttribute(rim, 1),
    );
    // three.js draws nothing without a position, unless it is told how much.
    this.silhouettes[layer].setDrawRange(0, rim.length);
    const source = new three.DataTexture(
      values,
      width,
      width / 2,
      three.RedIntegerFormat,
      three.UnsignedShortType,
    );
    source.internalFormat = "R16UI";
    this.upload(source, this.omegaMaps, layer);
    source.dispose();
    this.setFact(layer, 1, 0, 1);
  }

  /** Gives a layer to a station of which nothing is there yet. */
  assign(layer: number, position_m: readonly [number, number, number]): void {
    position_m.forEach((value, axis) => this.setFact(layer, 0, axis, value));
    this.setFact(layer, 0, 3, 0);
    this.setFact(layer, 1, 0, 0);
  }

  /** After the graphics context was lost: what belonged to it cannot be disposed of any more. */
  forget(): void {
    this.silhouettes.length = 0;
  }

  private upload(source: three.Texture, into: three.DataArrayTexture, layer: number): void {
    this.webgl.copyTextureToTexture(source, into, null, new three.Vector3(0, 0, layer));
  }

  private setFact(layer: number, fact: number, channel: number, value: number): void {
    this.facts[FLOATS_PER_TEXEL * (fact * this.layers + layer) + channel] = value;
    this.table.needsUpdate = true;
  }
}

function emptyArray(width_px: number, layers: number): three.DataArrayTexture {
  const texture = new three.DataArrayTexture(null, width_px, width_px / 2, layers);
  // Memory is reserved without contents; layers are filled one by one.
  texture.source.dataReady = false;
  texture.minFilter = three.NearestFilter;
  texture.magFilter = three.NearestFilter;
  texture.generateMipmaps = false;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

function pictureArray(width_px: number, layers: number): three.DataArrayTexture {
  const texture = emptyArray(width_px, layers);
  texture.format = three.RGBAFormat;
  texture.type = three.UnsignedByteType;
  texture.minFilter = three.LinearFilter;
  texture.magFilter = three.LinearFilter;
  texture.wrapS = three.RepeatWrapping;
  texture.wrapT = three.ClampToEdgeWrapping;
  return texture;
}

/**
 * The pixels of a distance map next to a silhouette, a few of a hundred: pixels, counted through the rows, one of whose eight neighbours is on another surface: inverse
 * distances (in steps, [row][column]) differ by more than `tolerance` of the larger one.
 */
export function silhouettePixels(
  omega: Uint16Array,
  width_px: number,
  tolerance: number,
): Float32Array<ArrayBuffer> {
  const height = omega.length / width_px;
  const found: number[] = [];
  const differ = (a: number, b: number) => Math.abs(a - b) > tolerance * Math.max(a, b);
  for (let row = 0; row < height; ++row) {
    const above = Math.max(row - 1, 0) * width_px;
    const here = row * width_px;
    const below = Math.min(row + 1, height - 1) * width_px;
    for (let column = 0; column < width_px; ++column) {
      const left = (column + width_px - 1) % width_px;
      const right = (column + 1) % width_px;
      const own = omega[here + column]!;
      const isRim =
        differ(own, omega[here + left]!) ||
        differ(own, omega[here + right]!) ||
        differ(own, omega[above + column]!) ||
        differ(own, omega[below + column]!) ||
        differ(own, omega[above + left]!) ||
        differ(own, omega[above + right]!) ||
        differ(own, omega[below + left]!) ||
        differ(own, omega[below + right]!);
      if (isRim) found.push(here + column);
    }
  }
  return Float32Array.from(found);
}
