// The colours of a view: one triangle over the picture, whose shader looks every point up in the
// stations.
import * as three from "three";
import { TWO_PI } from "../geometry/angles";
import type { Manifest } from "../manifest";
import type { Eye } from "./distance_pass";
import colourFragment from "./shaders/colour.frag.glsl";
import colourVertex from "./shaders/colour.vert.glsl";
import stationsSource from "./shaders/stations.glsl";
import type { StationTextures } from "./station_textures";

/** Stations that are searched for a point that no line sees, at most. */
export const MAX_FILL = 16;

export interface ColourInputs {
  eye: Eye;
  viewpoint_m: readonly [number, number, number];
  plan: three.Texture;
  /** Null: the vertical cut. */
  distances: three.Texture | null;
  sources: number;
  fillLayers: readonly number[];
}

export class ColourPass {
  readonly mesh: three.Mesh<three.BufferGeometry, three.RawShaderMaterial>;
  private readonly uniforms;

  constructor(
    private readonly manifest: Pick<Manifest, "distances" | "panorama">,
    textures: StationTextures,
  ) {
    const { distances } = manifest;
    this.uniforms = {
      omegaMaps: { value: textures.omegaMaps },
      omegaStep: { value: distances.omega_step_per_m },
      surfaceTolerance: { value: distances.surface_tolerance },
      projection: { value: new three.Vector4() },
      worldFromCamera: { value: new three.Matrix3() },
      distances: { value: null as three.Texture | null },
      plan: { value: null as three.Texture | null },
      stations: { value: textures.table },
      pictures: { value: textures.pictures },
      coarsePictures: { value: textures.coarsePictures },
      viewpoint: { value: new three.Vector3() },
      corrected: { value: false },
      sources: { value: 0 },
      fillLayers: { value: new Int32Array(MAX_FILL) },
      fillCount: { value: 0 },
      vignette: { value: 0 },
      rayAcross: { value: new three.Vector3() },
      rayUpwards: { value: new three.Vector3() },
      capturedPixel: { value: new three.Vector2() },
      divider: { value: 0 },
      comparedPicture: { value: null as three.Texture | null },
    };
    const triangle = new three.BufferGeometry();
    triangle.setDrawRange(0, 3);
    this.mesh = new three.Mesh(
      triangle,
      new three.RawShaderMaterial({
        glslVersion: three.GLSL3,
        defines: { MAX_FILL },
        vertexShader: colourVertex,
        fragmentShader: stationsSource + colourFragment,
        uniforms: this.uniforms,
        depthTest: false,
        depthWrite: false,
      }),
    );
    this.mesh.frustumCulled = false;
  }

  set vignette(strength: number) {
    this.uniforms.vignette.value = strength;
  }

  /** Sets what the next drawing of the mesh shows. */
  set(inputs: ColourInputs): void {
    const { uniforms } = this;
    uniforms.projection.value.copy(inputs.eye.projection);
    uniforms.worldFromCamera.value.copy(inputs.eye.worldFromCamera);
    // From one border of the view to the opposite one, clip coordinates change by 2.
    const { x: focal_x, y: focal_y } = inputs.eye.projection;
    uniforms.rayAcross.value.setFromMatrix3Column(inputs.eye.worldFromCamera, 0);
    uniforms.rayAcross.value.multiplyScalar(2 / focal_x);
    uniforms.rayUpwards.value.setFromMatrix3Column(inputs.eye.worldFromCamera, 1);
    uniforms.rayUpwards.value.multiplyScalar(2 / focal_y);
    const captured_rad = TWO_PI / this.manifest.panorama.width_px;
    uniforms.capturedPixel.value.set(0.5 * captured_rad * focal_x, 0.5 * captured_rad * focal_y);
    uniforms.viewpoint.value.set(...inputs.viewpoint_m);
    uniforms.plan.value = inputs.plan;
    uniforms.distances.value = inputs.distances;
    uniforms.corrected.value = inputs.distances !== null;
    uniforms.sources.value = inputs.sources;
    uniforms.fillCount.value = inputs.fillLayers.length;
    uniforms.fillLayers.value.set(inputs.fillLayers);
    this.mesh.material.uniformsNeedUpdate = true;
  }

  /** Shows a panorama of the viewpoint on the left, up to the divider; null: none. */
  compare(panorama: three.Texture | null, divider: number): void {
    this.uniforms.comparedPicture.value = panorama;
    this.uniforms.divider.value = panorama ? divider : 0;
  }
}
