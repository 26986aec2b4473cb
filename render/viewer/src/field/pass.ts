// A step of drawing: a shader for every pixel of a target. three.js wants a scene and a camera for it;
// the shaders have their own.
import * as three from "three";
import triangleVertex from "./shaders/triangle.vert.glsl";

export type Uniforms = Record<string, three.IUniform>;
type Drawn<Kind extends three.Object3D> = Kind & { material: three.RawShaderMaterial };

const camera = new three.OrthographicCamera();

/** Draws geometry into a target, with uniforms as they are then. */
export class Pass {
  private readonly scene = new three.Scene();

  constructor(
    private readonly webgl: three.WebGLRenderer,
    private readonly drawn: Drawn<three.Mesh | three.Points>,
    readonly target: three.WebGLRenderTarget,
  ) {
    drawn.frustumCulled = false;
    this.scene.add(drawn);
  }

  draw(): void {
    this.drawn.material.uniformsNeedUpdate = true;
    this.webgl.setRenderTarget(this.target);
    this.webgl.render(this.scene, camera);
  }
}

/** A triangle that covers the target. */
export function triangle(
  fragment: string,
  uniforms: Uniforms,
  defines: Record<string, unknown> = {},
): Drawn<three.Mesh> {
  const corners = new three.BufferGeometry();
  // three.js draws nothing without a position, unless it is told how much.
  corners.setDrawRange(0, 3);
  const mesh = new three.Mesh(
    corners,
    new three.RawShaderMaterial({
      glslVersion: three.GLSL3,
      defines,
      vertexShader: triangleVertex,
      fragmentShader: fragment,
      uniforms,
      depthTest: false,
      depthWrite: false,
    }),
  );
  mesh.frustumCulled = false;
  return mesh;
}
