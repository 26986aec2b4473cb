// The viewer without its user interface: opens an exported room in a canvas and draws it.
import * as three from "three";
import {
  worldFromCamera,
  worldFromThree,
  quaternionOf,
  type Pose,
  type Vec3,
} from "../geometry/frame";
import { DEGREE_RAD } from "../geometry/angles";
import { Grid, type PlanPosition } from "../geometry/grid";
import { RoomError, parseManifest, type Manifest, type ViewSettings } from "../manifest";
import type { Eye } from "./colour_pass";
import { EyeView } from "./eye_view";
import { Screen } from "./screen";
import { readPicture } from "./station_files";
import { StationStore } from "./station_store";
import { StationTextures } from "./station_textures";
import { wantedStations } from "./station_choice";

export interface LoadProgress {
  /** Stations of the walker's surroundings that are there, at least coarse, and in all. */
  coarse: number;
  fine: number;
  wanted: number;
  /** Files that could not be had: sentences for users. */
  problems: string[];
}

const MOST_PIXEL_RATIO = 2;
const FIRST_FOV_Y_RAD = 1.2;
/** While files arrive, this part of the time is spent on drawing what has come. */
const LOADING_SHARE = 0.25;

const NO_WEBGL =
  "which this browser does not offer. Update it, switch its graphics acceleration on, or open the " +
  "page in another browser or on another device.";

/**
 * Opens the exported room at `base`, the folder of manifest.json. Throws RoomError where it is none that
 * this page reads, or the device cannot draw it.
 */
export async function openViewer(canvas: HTMLCanvasElement, base: URL): Promise<Viewer> {
  const response = await fetch(new URL("manifest.json", base)).catch(() => undefined);
  if (!response?.ok) {
    throw new RoomError("manifest.json could not be had; is this the folder of an exported room?");
  }
  return new Viewer(canvas, base, parseManifest(await response.text()));
}

export class Viewer {
  readonly grid: Grid;
  readonly webgl: three.WebGLRenderer;
  /** Vertical field of view of the flat picture, radians. */
  fov_y_rad = FIRST_FOV_Y_RAD;
  settings: ViewSettings;
  pose: Pose;
  /** Darkens the border, 0 to 1: for comfort while walking in a headset. */
  vignette = 0;
  /** Up to where the compared panorama is shown, from the left of the view, 0 to 1. */
  divider = 0;
  /** Called before each frame, with the seconds since the last one. */
  onFrame: (seconds: number) => void = () => {};

  private readonly textures: StationTextures;
  private readonly store: StationStore;
  private readonly screen = new Screen();
  private compared: three.Texture | null = null;
  private comparisons = 0; // asked for
  private readonly scene = new three.Scene();
  private readonly camera = new three.PerspectiveCamera();
  private readonly eyes: EyeView[] = [];
  private eyesDrawn = 0;
  private wantedAt: PlanPosition = { x_m: Infinity, z_m: Infinity };
  private readonly step_m: number;
  private lastFrame_ms = 0;
  private lastDrawn = ""; // what the picture on the screen shows
  private changes = 0;
  private arrivals = 0; // of files, since the picture was drawn
  private drawing_ms = 0; // of the last picture, until the next frame
  private drawnAt_ms = -Infinity;
  private waiting: (() => void)[] = [];

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly base: URL,
    readonly manifest: Manifest,
  ) {
    this.grid = new Grid(manifest);
    const context = canvas.getContext("webgl2", { antialias: false, alpha: false, stencil: false });
    if (!context) throw new RoomError(`Walking needs WebGL 2, ${NO_WEBGL}`);
    this.webgl = new three.WebGLRenderer({ canvas, context });
    // Pictures are blended as they are stored, as the engine does.
    this.webgl.outputColorSpace = three.LinearSRGBColorSpace;
    this.webgl.autoClear = false;
    this.webgl.xr.enabled = true;
    const stations = manifest.lines.reduce((sum, line) => sum + line.stations.length, 0);
    this.textures = new StationTextures(this.webgl, manifest, stations);
    this.store = new StationStore(manifest, base, this.textures, () => ++this.arrivals);
    this.step_m = 0.25 * Math.min(...manifest.lines.map((line) => line.spacing_m));
    this.settings = { ...manifest.view };
    const { x_m, z_m, yaw_deg } = manifest.start;
    const yaw_rad = yaw_deg * DEGREE_RAD;
    this.pose = { x_m, z_m, up_m: 0, yaw_rad, pitch_rad: 0, roll_rad: 0 };
    this.scene.add(this.screen.mesh);
    this.screen.mesh.onBeforeRender = (_webgl, _scene, camera) => this.prepareEye(camera);
    canvas.addEventListener("webglcontextrestored", () => this.readAgain());
    this.webgl.setAnimationLoop((time_ms) => this.frame(time_ms));
  }

  progress(): LoadProgress {
    const { store } = this;
    return {
      coarse: Math.max(store.count("coarse"), store.count("fine")),
      fine: store.count("fine"),
      wanted: store.wanted,
      problems: store.problems,
    };
  }

  /** Resolves when a frame of the current pose with all that is loaded has been drawn. */
  drawn(): Promise<void> {
    return new Promise((resolve) => this.waiting.push(resolve));
  }

  /** PNG of the picture. */
  screenshot(): Promise<Blob> {
    // The canvas is kept only until the browser has shown it.
    this.draw();
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => {
        if (blob) resolve(blob);
        else reject(new Error("the browser made no picture"));
      });
    });
  }

  /** Shows a panorama of the place, a file of the export, up to the divider; null: none. */
  async compare(panorama: string | null): Promise<void> {
    const asked = ++this.comparisons;
    const picture = panorama === null ? null : await readPicture(new URL(panorama, this.base));
    if (asked !== this.comparisons) return;
    this.compared?.dispose();
    this.compared = picture && panoramaTexture(picture);
    ++this.changes;
  }

  private readAgain(): void {
    this.eyes.length = 0;
    this.store.readAgain();
    ++this.changes;
  }

  private frame(time_ms: number): void {
    if (this.webgl.getContext().isContextLost()) return;
    const seconds = Math.min(0.1, Math.max(0, (time_ms - this.lastFrame_ms) / 1000));
    // The frame after a drawing waits for it.
    if (this.lastFrame_ms === this.drawnAt_ms) this.drawing_ms = time_ms - this.drawnAt_ms;
    this.lastFrame_ms = time_ms;
    this.onFrame(seconds);
    this.wantStations();
    this.fitCanvas();
    if (this.arrivals > 0 && this.mayShowArrivals(time_ms)) {
      this.arrivals = 0;
      ++this.changes;
    }
    const shown = JSON.stringify([
      this.pose,
      this.settings,
      this.fov_y_rad,
      this.vignette,
      this.divider,
      this.changes,
      this.canvas.width,
      this.canvas.height,
    ]);
    // Nothing is drawn while nothing changes, which saves batteries.
    if (shown !== this.lastDrawn || this.webgl.xr.isPresenting) {
      this.lastDrawn = shown;
      this.drawnAt_ms = time_ms;
      this.draw();
    }
    if (this.store.settled && this.arrivals === 0) {
      for (const resolve of this.waiting.splice(0)) resolve();
    }
  }

  // Only after a step that may change the order: rooms can have thousands of stations.
  private wantStations(): void {
    const { x_m, z_m } = this.pose;
    const moved_m = Math.hypot(x_m - this.wantedAt.x_m, z_m - this.wantedAt.z_m);
    if (moved_m < this.step_m) return;
    this.wantedAt = { x_m, z_m };
    this.store.want(wantedStations(this.store.placed, this.grid, this.pose));
  }

  private mayShowArrivals(time_ms: number): boolean {
    return this.store.settled || time_ms - this.drawnAt_ms > this.drawing_ms / LOADING_SHARE;
  }

  private fitCanvas(): void {
    if (this.webgl.xr.isPresenting) return;
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = Math.min(window.devicePixelRatio, MOST_PIXEL_RATIO);
    const size = this.webgl.getSize(new three.Vector2());
    if (size.x === clientWidth && size.y === clientHeight && this.webgl.getPixelRatio() === ratio) {
      return;
    }
    this.webgl.setPixelRatio(ratio);
    this.webgl.setSize(clientWidth, clientHeight, false);
  }

  private draw(): void {
    this.eyesDrawn = 0;
    const { uniforms } = this.screen;
    uniforms.vignette.value = this.vignette;
    uniforms.compared_panorama.value = this.compared;
    uniforms.divider.value = this.compared ? this.divider : 0;
    const { camera } = this;
    if (!this.webgl.xr.isPresenting) {
      camera.quaternion.copy(quaternionOf(this.pose));
      camera.fov = (this.fov_y_rad * 180) / Math.PI;
      camera.aspect = this.canvas.width / this.canvas.height;
      camera.updateProjectionMatrix();
    }
    this.webgl.setRenderTarget(null);
    this.webgl.render(this.scene, camera);
  }

  // Called by three.js for the screen's camera, or for each eye of a headset.
  private prepareEye(camera: three.Camera): void {
    const { webgl } = this;
    // An emulated headset with one eye has a second one of no width.
    const viewport = (camera as three.PerspectiveCamera).viewport as three.Vector4 | undefined;
    if (viewport && viewport.z * viewport.w === 0) return;
    const presenting = webgl.xr.isPresenting;
    // A headset's poses are relative to where the walker stands and faces.
    const base = new three.Matrix4();
    if (presenting) base.makeRotationFromQuaternion(quaternionOf(standing(this.pose)));
    const cameraWorld = base.multiply(camera.matrixWorld);
    const head = worldFromThree(new three.Vector3().setFromMatrixPosition(cameraWorld));
    const viewpoint_m = this.viewpoint(presenting ? head : [0, 0, 0]);

    const which = this.eyesDrawn++;
    this.eyes[which] ??= new EyeView(webgl, this.manifest, this.grid, this.store, this.textures);
    const target = webgl.getRenderTarget();
    webgl.xr.enabled = false;
    const eye = eyeOf(cameraWorld, camera.projectionMatrix);
    const panorama = this.eyes[which].draw(viewpoint_m, eye, this.settings);
    webgl.xr.enabled = true;
    webgl.setRenderTarget(target);
    if (viewport) webgl.state.viewport(viewport);
    this.screen.set(panorama, eye);
  }

  private viewpoint(head: Vec3): Vec3 {
    const at = this.grid.clamp({ x_m: this.pose.x_m + head[0], z_m: this.pose.z_m + head[2] });
    return [at.x_m, this.grid.heightAt(at) + this.pose.up_m + head[1], at.z_m];
  }
}

function panoramaTexture(picture: ImageBitmap): three.Texture {
  const texture = new three.Texture(picture);
  texture.flipY = false;
  texture.generateMipmaps = false;
  texture.minFilter = three.LinearFilter;
  texture.wrapS = three.RepeatWrapping;
  texture.needsUpdate = true;
  return texture;
}

function standing(pose: Pose): Pose {
  return { ...pose, pitch_rad: 0, roll_rad: 0 };
}

function eyeOf(cameraWorld: three.Matrix4, projection: three.Matrix4): Eye {
  const turn = new three.Matrix3().setFromMatrix4(worldFromCamera(cameraWorld));
  const p = projection.elements;
  return {
    worldFromCamera: turn,
    projection: new three.Vector4(p[0], p[5], p[8], p[9]),
  };
}
