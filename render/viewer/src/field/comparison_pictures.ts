// The pictures of places with ground truth: what a camera saw there, what the engine renders.
import { LinearFilter, RepeatWrapping, Texture } from "three";
import { ExportError, type Manifest } from "../manifest";

export interface PicturePair {
  truth: Texture;
  engine: Texture;
}

export class ComparisonPictures {
  private readonly pairs = new Map<number, Promise<PicturePair>>();

  constructor(
    private readonly manifest: Pick<Manifest, "truth">,
    private readonly base: URL,
  ) {}

  /** Throws ExportError if the pictures cannot be had. */
  of(index: number): Promise<PicturePair> {
    let pair = this.pairs.get(index);
    if (!pair) {
      pair = this.read(index);
      pair.catch(() => this.pairs.delete(index)); // may be asked for again
      this.pairs.set(index, pair);
    }
    return pair;
  }

  private async read(index: number): Promise<PicturePair> {
    const view = this.manifest.truth[index];
    if (!view) throw new ExportError("There is no ground truth of this place.");
    const [truth, engine] = await Promise.all([
      this.texture(view.picture),
      this.texture(view.engine),
    ]);
    return { truth: truth!, engine: engine! };
  }

  private async texture(file: string): Promise<Texture> {
    const response = await fetch(new URL(file, this.base)).catch(() => undefined);
    const bitmap =
      response?.ok &&
      (await response
        .blob()
        .then((bytes) => createImageBitmap(bytes, { colorSpaceConversion: "none" }))
        .catch(() => undefined));
    if (!bitmap) throw new ExportError(`${file} could not be had or is damaged.`);
    const texture = new Texture(bitmap);
    texture.flipY = false;
    texture.generateMipmaps = false;
    texture.minFilter = LinearFilter;
    texture.wrapS = RepeatWrapping;
    texture.needsUpdate = true;
    return texture;
  }
}
