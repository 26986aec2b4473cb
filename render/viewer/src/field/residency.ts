// Which stations are on the GPU, in which layer of the textures. Knows nothing of either.
//
// Stations are wanted in an order. As many as there are layers are kept; a station that is no longer
// among them gives its layer to one that is.

export class Residency {
  private readonly layerOf = new Map<number, number>();
  private readonly free: number[] = [];
  private wanted: number[] = [];

  constructor(readonly layers: number) {
    for (let layer = layers - 1; layer >= 0; --layer) this.free.push(layer);
  }

  /** The stations that are kept, the most wanted first. */
  get kept(): readonly number[] {
    return this.wanted;
  }

  layer(station: number): number | undefined {
    return this.layerOf.get(station);
  }

  /**
   * Sets what is wanted, the most wanted first; returns the stations that lose their layer. A
   * station gets its layer here, before its files are there.
   */
  want(order: readonly number[]): number[] {
    this.wanted = order.slice(0, this.layers);
    const keeps = new Set(this.wanted);
    const dropped: number[] = [];
    for (const [station, layer] of this.layerOf) {
      if (keeps.has(station)) continue;
      this.layerOf.delete(station);
      this.free.push(layer);
      dropped.push(station);
    }
    for (const station of this.wanted) {
      if (!this.layerOf.has(station)) this.layerOf.set(station, this.free.pop()!);
    }
    return dropped;
  }
}

/** What is read of a station: its coarse picture, its distances, its fine picture. */
export const PARTS = ["coarse", "inverse", "fine"] as const;
export type Part = (typeof PARTS)[number];

/** Maps that a first picture needs at least, of the nearest stations. */
const FIRST_MAPS = 8;

/**
 * The order in which parts are read: coarse pictures of all and the distances of the nearest that
 * have a map, for a first picture; then what is fine, the most wanted first.
 */
export function readingOrder(wanted: readonly number[], hasMap: (station: number) => boolean) {
  const maps = new Set(wanted.filter(hasMap).slice(0, FIRST_MAPS));
  const first = [...maps].map((station) => ({ station, part: "inverse" as Part }));
  const coarse = wanted.map((station) => ({ station, part: "coarse" as Part }));
  const rest = wanted.flatMap((station) => [
    ...(maps.has(station) ? [] : [{ station, part: "inverse" as Part }]),
    { station, part: "fine" as Part },
  ]);
  return [...first, ...coarse, ...rest];
}
