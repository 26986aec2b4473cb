// The distances seen from a viewpoint, in a panorama around it, as the engine finds them
// (core/view/distance_view.h, edges.h): with the engine's own shaders.
import * as three from "three";
import quartersSource from "../engine/quarters.glsl";
import gatheringSource from "../engine/gathering.glsl";
import geometrySource from "../engine/geometry.glsl";
import lookupSource from "../engine/lookup.glsl";
import type { Manifest } from "../manifest";
import { Pass, triangle, type Uniforms } from "./pass";
import distancesFragment from "./shaders/distances.frag.glsl";
import drawFragment from "./shaders/draw.frag.glsl";
import drawVertex from "./shaders/draw.vert.glsl";
import stationsSource from "./shaders/stations.glsl";
import surfacesSource from "./shaders/surfaces.glsl";

/** Maps that a view's distances are made from, at most. */
export const MAX_MAPS = 8;

type Position = readonly [number, number, number];

/** What all shaders know of maps. */
export const MAPS_SOURCE = geometrySource + stationsSource + lookupSource;
/** And of the quarters of pixels. */
export const QUARTERS_SOURCE = quartersSource + surfacesSource;

export class DistancePass {
  /** What shaders know of maps. */
  readonly uniforms: Uniforms;
  private readonly points = new three.InstancedBufferGeometry();
  private readonly places: { from_centre: three.Vector4; layer: number }[];
  private readonly passes: Pass[];

  constructor(
    private readonly webgl: three.WebGLRenderer,
    { distances }: Pick<Manifest, "distances">,
    maps: three.Texture,
  ) {
    const width = distances.width_px;
    const rows = width / 2;
    const place = () => ({ from_centre: new three.Vector4(), layer: 0, width, rows });
    this.places = Array.from({ length: MAX_MAPS }, place);
    this.uniforms = {
      distance_size: { value: new three.Vector2(width, rows) },
      tolerance: { value: distances.surface_tolerance },
      maps: { value: maps },
      inverse_step_per_m: { value: distances.inverse_step_per_m },
      map_places: { value: this.places },
      gathered: { value: 0 },
    };
    this.points.setDrawRange(0, width * rows);
    const draw = new three.RawShaderMaterial({
      glslVersion: three.GLSL3,
      defines: { MAX_MAPS, DRAW: 1 },
      vertexShader: MAPS_SOURCE + gatheringSource + drawVertex,
      fragmentShader: geometrySource + drawFragment,
      uniforms: this.uniforms,
    });
    const drawn = wholeNumbers(width + 2 * (Math.floor(width / 16) + 1), rows, "R32UI", true);
    this.passes = [new Pass(webgl, new three.Points(this.points, draw), drawn)];
    for (const [name, source, format] of [
      ["REFINE", gatheringSource, "R32UI"],
      ["FILL", gatheringSource, "R32UI"],
      ["EDGES", QUARTERS_SOURCE, "RGBA32UI"],
    ] as const) {
      const uniforms = { ...this.uniforms, before: { value: this.passes.at(-1)!.target.texture } };
      const fragment = MAPS_SOURCE + source + distancesFragment;
      const target = wholeNumbers(width, rows, format);
      // The colours' shader wants it even where it does not read it.
      webgl.initRenderTarget(target);
      const step = triangle(fragment, uniforms, { MAX_MAPS, [name]: 1 });
      this.passes.push(new Pass(webgl, step, target));
    }
  }

  /** Bits of inverse distances. */
  get distances(): three.Texture {
    return this.passes[2]!.target.texture;
  }

  /** Of each pixel at an edge the surfaces of its quarters (surfaces.glsl). */
  get quarters(): three.Texture {
    return this.passes[3]!.target.texture;
  }

  /** Draws the distances of a viewpoint from maps, the nearest first. */
  draw(maps: readonly { layer: number; position_m: Position }[], viewpoint_m: Position): void {
    maps.forEach(({ layer, position_m: [x, y, z] }, i) => {
      const place = this.places[i]!;
      place.layer = layer;
      place.from_centre.set(x - viewpoint_m[0], y - viewpoint_m[1], z - viewpoint_m[2], 0);
    });
    this.uniforms.gathered!.value = maps.length;
    this.points.instanceCount = maps.length;
    this.webgl.setRenderTarget(this.passes[0]!.target);
    this.webgl.clear(true, true, false);
    for (const pass of this.passes) pass.draw();
  }
}

function wholeNumbers(
  width: number,
  height: number,
  internalFormat: "R32UI" | "RGBA32UI",
  depthBuffer = false,
): three.WebGLRenderTarget {
  return new three.WebGLRenderTarget(width, height, {
    internalFormat,
    format: internalFormat === "R32UI" ? three.RedIntegerFormat : three.RGBAIntegerFormat,
    type: three.UnsignedIntType,
    minFilter: three.NearestFilter,
    magFilter: three.NearestFilter,
    depthBuffer,
  });
}
