// The colours of a view: a panorama around the viewpoint, of which only what the camera shows is
// drawn.
import * as three from "three";
import type { Manifest } from "../manifest";
import { MAPS_SOURCE, MAX_MAPS, QUARTERS_SOURCE, type DistancePass } from "./distance_pass";
import { Pass, triangle } from "./pass";
import colourFragment from "./shaders/colour.frag.glsl";
import type { StationTextures } from "./station_textures";

/** Stations that are searched for a point that no line sees, at most. */
export const MAX_FILL = 16;

/** A camera: how it turns, and what of the projection concerns x and y. */
export interface Eye {
  worldFromCamera: three.Matrix3;
  /** Focal lengths and shifts in clip coordinates. */
  projection: three.Vector4;
}

export interface ColourInputs {
  eye: Eye;
  viewpoint_m: readonly [number, number, number];
  /** By distances; else the vertical cut. */
  corrected: boolean;
  sources: number;
  fillLayers: readonly number[];
}

export class ColourPass {
  private readonly uniforms;
  private readonly pass: Pass;

  constructor(
    webgl: three.WebGLRenderer,
    { panorama }: Pick<Manifest, "panorama">,
    textures: StationTextures,
    distances: DistancePass,
    plan: three.Texture,
  ) {
    const width = panorama.width_px;
    const target = new three.WebGLRenderTarget(width, width / 2, {
      minFilter: three.LinearFilter,
      magFilter: three.LinearFilter,
      wrapS: three.RepeatWrapping,
      depthBuffer: false,
    });
    this.uniforms = {
      distances: { value: distances.distances },
      quarters: { value: distances.quarters },
      plan: { value: plan },
      stations: { value: textures.table },
      pictures: { value: textures.pictures },
      coarse_pictures: { value: textures.coarsePictures },
      output_size: { value: new three.Vector2(width, width / 2) },
      viewpoint: { value: new three.Vector3() },
      corrected: { value: false },
      sources: { value: 0 },
      fill_layers: { value: new Int32Array(MAX_FILL) },
      fill_count: { value: 0 },
      world_from_camera: { value: new three.Matrix3() },
      projection: { value: new three.Vector4() },
    };
    const fragment = MAPS_SOURCE + QUARTERS_SOURCE + colourFragment;
    const all = { ...distances.uniforms, ...this.uniforms };
    this.pass = new Pass(webgl, triangle(fragment, all, { MAX_FILL, MAX_MAPS }), target);
  }

  /** Draws what the camera shows; returns the panorama. */
  draw(inputs: ColourInputs): three.Texture {
    const { uniforms } = this;
    uniforms.viewpoint.value.set(...inputs.viewpoint_m);
    uniforms.corrected.value = inputs.corrected;
    uniforms.sources.value = inputs.sources;
    uniforms.fill_count.value = inputs.fillLayers.length;
    uniforms.fill_layers.value.set(inputs.fillLayers);
    uniforms.world_from_camera.value.copy(inputs.eye.worldFromCamera);
    uniforms.projection.value.copy(inputs.eye.projection);
    this.pass.draw();
    return this.pass.target.texture;
  }
}
