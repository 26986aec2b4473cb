// The distances seen from a viewpoint: the maps of the nearest stations, drawn as surfaces into the
// picture of inverse distances.
import * as three from "three";
import type { Vec3 } from "../geometry/frame";
import type { Manifest } from "../manifest";
import meshFragment from "./shaders/mesh.frag.glsl";
import meshVertex from "./shaders/mesh.vert.glsl";
import distanceMap from "./shaders/distance_map.glsl";
import rimVertex from "./shaders/rim.vert.glsl";
import stationsSource from "./shaders/stations.glsl";

/** Maps that a view's distances are made from, at most. */
export const MAX_MAPS = 4;
/** The nearest distance that surfaces are told apart at, of the nearest of the room. */
const NEAREST_PART = 0.1;
const LARGEST_OMEGA = 65535;

export interface DistanceMapOfView {
  layer: number;
  silhouettes: three.BufferGeometry;
  stationFromView_m: Vec3;
}

/** A camera: how it turns, and what of the projection concerns x and y. */
export interface Eye {
  cameraFromWorld: three.Matrix3;
  worldFromCamera: three.Matrix3;
  /** Focal lengths and shifts in clip coordinates. */
  projection: three.Vector4;
}

export class DistancePass {
  readonly target: three.WebGLRenderTarget;
  private readonly scene = new three.Scene();
  // three.js wants a camera; the shaders have their own.
  private readonly camera = new three.OrthographicCamera();
  private readonly surfaces: three.InstancedBufferGeometry;
  private readonly rims: three.Points<three.BufferGeometry, three.RawShaderMaterial>[] = [];
  private readonly uniforms;

  constructor(
    private readonly webgl: three.WebGLRenderer,
    { distances }: Pick<Manifest, "distances">,
    omegaMaps: three.Texture,
  ) {
    this.target = new three.WebGLRenderTarget(1, 1, {
      // Phones may have half floats only: 11 bits of inverse distance move a pixel by less than one.
      type: webgl.extensions.has("EXT_color_buffer_float") ? three.FloatType : three.HalfFloatType,
      format: three.RedFormat,
      minFilter: three.NearestFilter,
      magFilter: three.NearestFilter,
      depthTexture: new three.DepthTexture(1, 1, three.FloatType),
    });
    const omegaStep = distances.omega_step_per_m;
    this.uniforms = {
      omegaMaps: { value: omegaMaps },
      omegaStep: { value: omegaStep },
      surfaceTolerance: { value: distances.surface_tolerance },
      layers: { value: new Int32Array(MAX_MAPS) },
      stationFromView: { value: new Float32Array(3 * MAX_MAPS) },
      cameraFromWorld: { value: new three.Matrix3() },
      projection: { value: new three.Vector4() },
      nearest_m: { value: NEAREST_PART / (LARGEST_OMEGA * omegaStep) },
      rankPenalty: { value: distances.surface_tolerance / (MAX_MAPS - 1) },
      pixelsPerRadian: { value: new three.Vector2() },
    };
    const width = distances.width_px;
    this.surfaces = surfaceGeometry(width, width / 2);
    this.add(new three.Mesh(this.surfaces, this.material(meshVertex)));
    for (let map = 0; map < MAX_MAPS; ++map) {
      const rim = new three.Points<three.BufferGeometry, three.RawShaderMaterial>(
        new three.BufferGeometry(),
        this.material(rimVertex, { map: { value: map } }),
      );
      this.rims.push(rim);
      this.add(rim);
    }
  }

  /** Draws the distances of a view, `width` x `height` pixels. */
  draw(maps: readonly DistanceMapOfView[], eye: Eye, width: number, height: number): void {
    const { uniforms, webgl } = this;
    maps.forEach(({ layer, stationFromView_m }, i) => {
      uniforms.layers.value[i] = layer;
      uniforms.stationFromView.value.set(stationFromView_m, 3 * i);
    });
    uniforms.cameraFromWorld.value.copy(eye.cameraFromWorld);
    uniforms.projection.value.copy(eye.projection);
    const gl = webgl.getContext() as WebGL2RenderingContext;
    const largestPoint = (gl.getParameter(gl.ALIASED_POINT_SIZE_RANGE) as Float32Array)[1]!;
    uniforms.pixelsPerRadian.value.set(0.5 * height * eye.projection.y, largestPoint);
    this.surfaces.instanceCount = maps.length;
    this.rims.forEach((rim, map) => {
      const seen = maps[map];
      rim.visible = seen !== undefined;
      if (seen) rim.geometry = seen.silhouettes;
    });
    if (this.target.width !== width || this.target.height !== height) {
      this.target.setSize(width, height);
    }
    webgl.setRenderTarget(this.target);
    gl.clearBufferfv(gl.COLOR, 0, [-1, 0, 0, 1]); // unknown
    webgl.clear(false, true, false);
    webgl.render(this.scene, this.camera);
  }

  private add(drawn: three.Mesh | three.Points): void {
    drawn.frustumCulled = false;
    this.scene.add(drawn);
  }

  private material(
    vertex: string,
    more: Record<string, three.IUniform> = {},
  ): three.RawShaderMaterial {
    return new three.RawShaderMaterial({
      glslVersion: three.GLSL3,
      defines: { MAX_MAPS },
      vertexShader: stationsSource + distanceMap + vertex,
      fragmentShader: stationsSource + meshFragment,
      uniforms: { ...this.uniforms, ...more },
    });
  }
}

/** Two triangles between any four neighbouring pixels; the last corner is the upper left one. */
function surfaceGeometry(columns: number, rows: number): three.InstancedBufferGeometry {
  const indices = new Uint32Array(6 * columns * (rows + 1));
  const across = columns + 1;
  let at = 0;
  for (let row = 0; row <= rows; ++row) {
    for (let column = 0; column < columns; ++column) {
      const corner = row * across + column;
      const below = corner + across;
      indices.set([below, below + 1, corner, below + 1, corner + 1, corner], at);
      at += 6;
    }
  }
  const geometry = new three.InstancedBufferGeometry();
  geometry.setIndex(new three.BufferAttribute(indices, 1));
  return geometry;
}
