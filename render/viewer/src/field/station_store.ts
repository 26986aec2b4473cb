// Reads the stations that are wanted and hands them to the textures.
import { RoomError, type Manifest } from "../manifest";
import { PARTS, readingOrder, Residency, type Part } from "./residency";
import { readInverse, readPicture, UnreachableError } from "./station_files";
import type { StationTextures } from "./station_textures";
import type { PlacedStation } from "./station_choice";

const MOST_AT_ONCE = 6; // as many connections as browsers open to a host
const MOST_ATTEMPTS = 3;
const RETRY_MS = 2000;

interface PartState {
  is: "missing" | "being read" | "there" | "failed";
  attempts: number;
}

interface StationState {
  parts: Record<Part, PartState>;
  abort: AbortController;
}

function nothingYet(): StationState {
  const part = (): PartState => ({ is: "missing", attempts: 0 });
  return { parts: { coarse: part(), inverse: part(), fine: part() }, abort: new AbortController() };
}

function problemKey(station: number, part: Part): string {
  return `${station} ${part}`;
}

export class StationStore {
  /** Stations of the whole room, in the order of the lines. */
  readonly placed: PlacedStation[] = [];
  private readonly names: string[] = [];
  private readonly residency: Residency;
  private readonly states = new Map<number, StationState>();
  private order: ReturnType<typeof readingOrder> = [];
  private running = 0;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private readonly problemOf = new Map<string, string>();

  /** `changed` is called whenever something more can be shown. */
  constructor(
    private readonly manifest: Manifest,
    private readonly base: URL,
    private readonly textures: StationTextures,
    private readonly changed: () => void,
  ) {
    this.residency = new Residency(textures.layers);
    manifest.lines.forEach((line, index) => {
      for (const { name, position_m, has_map } of line.stations) {
        this.placed.push({ station: this.placed.length, line: index, position_m, has_map });
        this.names.push(name);
      }
    });
  }

  /** Stations in the order in which they are wanted. */
  want(order: readonly number[]): void {
    for (const station of this.residency.want(order)) {
      this.states.get(station)?.abort.abort();
      this.states.delete(station);
      for (const part of PARTS) this.problemOf.delete(problemKey(station, part));
      this.changed();
    }
    for (const station of this.residency.kept) {
      if (this.states.has(station)) continue;
      this.states.set(station, nothingYet());
      this.textures.assign(this.residency.layer(station)!, this.placed[station]!.position_m);
    }
    this.order = readingOrder(this.residency.kept, (station) => this.placed[station]!.has_map);
    this.readMore();
  }

  /** Reads everything again, after the textures were lost. */
  readAgain(): void {
    const order = [...this.residency.kept];
    this.want([]);
    this.want(order);
  }

  /** The layer of a station whose part is there. */
  layerWith(station: number, part: "picture" | "inverse"): number | undefined {
    const parts = this.states.get(station)?.parts;
    const of: Part[] = part === "inverse" ? ["inverse"] : ["coarse", "fine"];
    const there = of.some((name) => parts?.[name].is === "there");
    return there ? this.residency.layer(station) : undefined;
  }

  count(part: Part): number {
    return [...this.states.values()].filter((state) => state.parts[part].is === "there").length;
  }

  get wanted(): number {
    return this.residency.kept.length;
  }

  /** Whether all that is wanted is there, or has failed for good. */
  get settled(): boolean {
    return this.running === 0 && this.retry === undefined && this.next() === undefined;
  }

  get problems(): string[] {
    return [...new Set(this.problemOf.values())];
  }

  private next(): { station: number; part: Part } | undefined {
    return this.order.find(({ station, part }) => {
      const { parts } = this.states.get(station)!;
      // A coarse picture is of no use beside the fine one.
      const useless = part === "coarse" && parts.fine.is === "there";
      return !useless && parts[part].is === "missing";
    });
  }

  private readMore(): void {
    while (this.running < MOST_AT_ONCE) {
      const job = this.next();
      if (!job) return;
      const state = this.states.get(job.station)!;
      ++this.running;
      void this.read(job.station, job.part, state).finally(() => {
        --this.running;
        this.readMore();
        this.changed();
      });
    }
  }

  private async read(station: number, part: Part, state: StationState): Promise<void> {
    const key = problemKey(station, part);
    const progress = state.parts[part];
    progress.is = "being read";
    ++progress.attempts;
    try {
      await this.readPart(station, part, state);
      progress.is = "there";
      this.problemOf.delete(key);
    } catch (error) {
      progress.is = "failed";
      if (state.abort.signal.aborted) return;
      this.problemOf.set(key, error instanceof RoomError ? error.message : String(error));
      // A server that is away may come back at any time.
      if (error instanceof UnreachableError) progress.attempts = 0;
      if (progress.attempts < MOST_ATTEMPTS) this.tryAgainLater();
    }
  }

  private async readPart(station: number, part: Part, state: StationState): Promise<void> {
    const { panorama, distances } = this.manifest;
    const signal = state.abort.signal;
    const file = (suffix: string) => new URL(`stations/${this.names[station]}${suffix}`, this.base);
    if (part === "inverse") {
      const values = await readInverse(file(".inverse"), distances.width_px, signal);
      if (!signal.aborted) this.textures.setInverse(this.residency.layer(station)!, values);
      return;
    }
    const fine = part === "fine";
    const width_px = fine ? panorama.width_px : panorama.coarse_width_px;
    const picture = await readPicture(file(fine ? ".jpg" : "-coarse.jpg"), width_px, signal);
    const useless = signal.aborted || (!fine && state.parts.fine.is === "there");
    if (!useless) this.textures.setPicture(this.residency.layer(station)!, picture, fine);
    picture.close();
  }

  // All failed parts once more, after a while.
  private tryAgainLater(): void {
    this.retry ??= setTimeout(() => {
      this.retry = undefined;
      for (const state of this.states.values()) {
        for (const part of PARTS) {
          const progress = state.parts[part];
          if (progress.is === "failed" && progress.attempts < MOST_ATTEMPTS)
            progress.is = "missing";
        }
      }
      this.readMore();
      this.changed();
    }, RETRY_MS);
  }
}
