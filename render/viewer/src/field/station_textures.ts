// The textures that hold stations: an array layer each for the fine picture, the coarse picture and
// the distances, and a table of what is there.
import * as three from "three";
import { RoomError, type Manifest } from "../manifest";

const BYTES_PER_PIXEL = 4;
const BYTES_PER_INVERSE = 2;
const FLOATS_PER_TEXEL = 4;

type Sizes = Pick<Manifest, "panorama" | "distances" | "budget_mb">;

function pixelsOf(width_px: number): number {
  return (width_px * width_px) / 2;
}

export function bytesPerStation({ panorama, distances }: Sizes): number {
  return (
    BYTES_PER_PIXEL * (pixelsOf(panorama.width_px) + pixelsOf(panorama.coarse_width_px)) +
    BYTES_PER_INVERSE * pixelsOf(distances.width_px)
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
  readonly inverseMaps: three.DataArrayTexture;
  /** [fact][layer]: position and picture (0 none, 1 coarse, 2 fine); whether distances are there. */
  readonly table: three.DataTexture;
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
    this.inverseMaps = emptyArray(sizes.distances.width_px, this.layers);
    this.inverseMaps.format = three.RedIntegerFormat;
    this.inverseMaps.type = three.UnsignedShortType;
    this.inverseMaps.internalFormat = "R16UI";
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

  setInverse(layer: number, values: Uint16Array<ArrayBuffer>): void {
    const width = this.sizes.distances.width_px;
    const source = new three.DataTexture(
      values,
      width,
      width / 2,
      three.RedIntegerFormat,
      three.UnsignedShortType,
    );
    source.internalFormat = "R16UI";
    this.upload(source, this.inverseMaps, layer);
    source.dispose();
    this.setFact(layer, 1, 0, 1);
  }

  /** Gives a layer to a station of which nothing is there yet. */
  assign(layer: number, position_m: readonly [number, number, number]): void {
    position_m.forEach((value, axis) => this.setFact(layer, 0, axis, value));
    this.setFact(layer, 0, 3, 0);
    this.setFact(layer, 1, 0, 0);
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
