// What a camera shows of the panorama around its viewpoint, and of one that it is compared with.
import * as three from "three";
import geometrySource from "../engine/geometry.glsl";
import type { Eye } from "./colour_pass";
import { triangle } from "./pass";
import screenFragment from "./shaders/screen.frag.glsl";

export class Screen {
  readonly uniforms = {
    panorama: { value: null as three.Texture | null },
    compared_panorama: { value: null as three.Texture | null },
    divider: { value: 0 },
    vignette: { value: 0 },
    projection: { value: new three.Vector4() },
    world_from_camera: { value: new three.Matrix3() },
  };
  readonly mesh = triangle(geometrySource + screenFragment, this.uniforms);

  /** Sets what the next drawing of the mesh shows. */
  set(panorama: three.Texture, eye: Eye): void {
    this.uniforms.panorama.value = panorama;
    this.uniforms.projection.value.copy(eye.projection);
    this.uniforms.world_from_camera.value.copy(eye.worldFromCamera);
    this.mesh.material.uniformsNeedUpdate = true;
  }
}
