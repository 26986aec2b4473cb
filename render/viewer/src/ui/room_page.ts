// The page of an opened room: its parts, and what happens in each frame.
import type { Pose } from "../geometry/frame";
import type { Hotspot, TruthView } from "../manifest";
import type { Viewer } from "../field/viewer";
import { Gamepads } from "../walk/gamepad";
import { isActive, readIntent, type InputSource } from "../walk/intent";
import { Keyboard } from "../walk/keyboard";
import { horizontalFov } from "../walk/motion";
import { PathRecorder } from "../walk/path_recorder";
import { Pointer } from "../walk/pointer";
import { Walker } from "../walk/walker";
import { XrWalk, canEnterVr } from "../walk/xr";
import {
  Address,
  parseAddress,
  type PageOptions,
  type Place,
  type PlaceFromAddress,
} from "./address";
import { Compare } from "./compare";
import { helpDialog, infoDialog } from "./dialogs";
import { download, element } from "./dom";
import { EngineView } from "./engine_view";
import { FullScreen, Idle, fileStem, onInput, saveScreenshot } from "./full_screen";
import { Hotspots, usableHotspots } from "./hotspots";
import { MovePad } from "./move_pad";
import { PathPlayer } from "./path_player";
import { PlanMap } from "./plan_map";
import { lookingAt, startPose, stepTowards, type Picture } from "./projection";
import { Status } from "./status";
import { Toolbar, type ToolName } from "./toolbar";
import { SettingsPanel } from "./view_settings";
import { Whereabouts, middleOf } from "./whereabouts";

/** Where the plan takes little of the picture. */
const WIDE_PX = 700;
/** What need not follow every frame. */
const SLOW_MS = 200;
/** Of walking time, for a double click. */
const STEP_S = 1;

/** A kiosk begins again when its visitor has left. */
const KIOSK_IDLE_MS = 60_000;
/** What keys may do in a kiosk: nothing that would leave something open for the next visitor. */
const KIOSK_TOOLS: readonly ToolName[] = ["close", "help", "level", "play", "where"];

export class RoomPage {
  private readonly walker: Walker;
  private readonly pad = new MovePad();
  private readonly inputs: readonly InputSource[];
  private readonly hotspots: Hotspots;
  private readonly plan: PlanMap;
  private readonly player: PathPlayer;
  private readonly recorder: PathRecorder;
  private readonly compare: Compare;
  private readonly engine: EngineView | null;
  private readonly status: Status;
  private readonly settings: SettingsPanel;
  private readonly toolbar: Toolbar;
  private readonly full_screen: FullScreen;
  private readonly address: Address;
  private readonly whereabouts: Whereabouts;
  private readonly xr: XrWalk;
  private readonly idle: Idle;
  private readonly help = helpDialog();
  private readonly info;
  private readonly start: Pose;
  private readonly first_fov_y_rad: number;
  private slow_ms = -Infinity;

  constructor(
    private readonly root: HTMLElement,
    private readonly canvas: HTMLCanvasElement,
    private readonly viewer: Viewer,
    base: URL,
    private readonly options: PageOptions,
  ) {
    const { manifest, grid } = viewer;
    const labels = options.hotspots ? usableHotspots(manifest.hotspots) : [];
    this.first_fov_y_rad = viewer.fov_y_rad;
    this.start = startPose(manifest, options.start);
    this.walker = new Walker(grid, manifest.vertical_range_m, viewer.fov_y_rad);
    this.inputs = [
      new Keyboard(window, (command) => this.run(command)),
      new Pointer(canvas, this.walker, (x_px, y_px) => this.walkTowards(x_px, y_px)),
      this.pad,
      new Gamepads(),
    ];
    this.recorder = new PathRecorder((at) => grid.heightAt(at));
    this.status = new Status(manifest.title);
    this.hotspots = new Hotspots(labels, base);
    this.plan = new PlanMap(grid, manifest, labels, (at) => this.goTo(at));
    this.player = new PathPlayer(viewer, this.walker, options.kiosk, () => this.showTools());
    this.compare = new Compare(manifest.truth, {
      viewer,
      walkTo: (place, there) => this.goToTruth(place, there),
      position: () => this.walker.pose,
      changed: () => this.showTools(),
      failed: (text) => this.status.tell(text),
    });
    this.engine = manifest.engine
      ? new EngineView(manifest.engine.view, base, (text) => this.status.tell(text))
      : null;
    this.info = infoDialog(manifest, labels, (hotspot) => this.lookAt(hotspot));
    this.settings = new SettingsPanel(viewer, () => canvas.focus());
    this.toolbar = new Toolbar((tool) => this.run(tool), this.settings.element);
    this.full_screen = new FullScreen(root, () => this.showTools());
    this.address = new Address(window, (place) => this.take(place));
    this.whereabouts = new Whereabouts(middleOf(grid), (text) => this.status.say(text));
    this.xr = new XrWalk(viewer, this.walker, (active) => this.vrChanged(active));
    this.idle = new Idle(KIOSK_IDLE_MS, () => this.beginAgain(), performance.now());
    onInput(root, () => this.touched());
    this.watchContext();
    this.layOut();
    this.begin();
    viewer.onFrame = (seconds) => this.frame(seconds);
  }

  private layOut(): void {
    this.root.classList.toggle("kiosk", this.options.kiosk);
    this.plan.element.hidden = this.options.kiosk || this.root.clientWidth < WIDE_PX;
    const top = element("div", { class: "top" }, this.status.element, this.plan.element);
    const bottom = element(
      "div",
      { class: "bottom" },
      this.pad.element,
      this.compare.sheet,
      this.player.element,
      this.toolbar.element,
    );
    this.root.append(
      ...(this.engine ? [this.engine.element] : []),
      this.hotspots.element,
      this.compare.line,
      top,
      bottom,
      this.help.element,
      this.info.element,
      this.status.live,
    );
    this.toolbar.offer("play", this.player.playable);
    this.toolbar.offer("compare", this.compare.available);
    this.toolbar.offer("fullscreen", this.full_screen.available);
    this.toolbar.offer("vr", false);
    void canEnterVr().then((possible) => this.toolbar.offer("vr", possible));
    this.showTools();
  }

  /** Tells that the browser took the graphics away, until they are back. */
  private watchContext(): void {
    const note = element("div", {
      class: "context-note",
      text: "The graphics were reset; one moment…",
      testid: "context-lost",
      attributes: { role: "alert" },
    });
    this.canvas.addEventListener("webglcontextlost", () => this.root.append(note));
    this.canvas.addEventListener("webglcontextrestored", () => note.remove());
  }

  private begin(): void {
    this.walker.place(this.start);
    this.take(parseAddress(location.hash));
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    // A kiosk's owner has asked for the movement; elsewhere the visitor's wish counts.
    if (this.options.play && (this.options.kiosk || !still)) this.player.play();
  }

  /** A kiosk that nobody uses any more is as it was for its first visitor. */
  private beginAgain(): void {
    if (!this.options.kiosk || this.player.playing) return;
    this.help.element.close();
    this.walker.fov_y_rad = this.first_fov_y_rad;
    this.goTo(this.start);
    if (this.options.play) this.player.play();
  }

  private vrChanged(active: boolean): void {
    if (active) {
      this.player.stop();
      this.compare.close();
    }
    this.toolbar.press("vr", active);
  }

  private take(place: PlaceFromAddress): void {
    const { pose, fov_y_rad, ...settings } = place;
    if (Object.keys(pose).length > 0) {
      this.player.stop();
      this.walker.place(pose);
    }
    if (fov_y_rad !== undefined) this.walker.fov_y_rad = fov_y_rad;
    if (Object.keys(settings).length > 0) this.settings.choose(settings);
  }

  private run(tool: ToolName): void {
    if (this.options.kiosk && !KIOSK_TOOLS.includes(tool)) return;
    const commands: Record<ToolName, () => void> = {
      initial: () => this.settings.choose({ method: "initial" }),
      "hlf-vd": () => this.settings.choose({ method: "hlf-vd" }),
      "two-sided": () => this.settings.choose({ method: "two-sided" }),
      settings: () => this.settings.toggle(),
      plan: () => void (this.plan.element.hidden = !this.plan.element.hidden),
      play: () => this.player.toggle(),
      record: () => this.toggleRecording(),
      compare: () => this.compare.toggle(),
      screenshot: () =>
        void saveScreenshot(this.viewer, this.walker.pose).catch(() =>
          this.status.tell("The screenshot could not be made."),
        ),
      fullscreen: () => this.full_screen.toggle(),
      where: () => this.whereabouts.sayNow(this.walker.pose, performance.now()),
      info: () => this.info.toggle(),
      help: () => this.help.toggle(),
      level: () => this.goTo({ up_m: 0, pitch_rad: 0, roll_rad: 0 }),
      close: () => this.closeLast(),
      vr: () => void this.xr.toggle().catch((error) => this.status.tell(`No VR: ${error.message}`)),
    };
    commands[tool]();
    this.showTools();
  }

  private toggleRecording(): void {
    if (!this.recorder.recording) {
      this.recorder.start(this.walker.pose);
      this.status.say("Recording the path; the same again saves it.");
      return;
    }
    const table = this.recorder.stop();
    if (table === null) return;
    const name = `${fileStem(this.viewer.manifest.title)}-path.csv`;
    download(new Blob([table], { type: "text/csv" }), name);
    this.status.say(`The path is saved as ${name}.`);
  }

  private closeLast(): void {
    if (this.settings.open) this.settings.toggle();
    else if (this.compare.active) this.compare.close();
    else this.player.stop();
  }

  private showTools(): void {
    this.toolbar.press("plan", !this.plan.element.hidden);
    this.toolbar.press("settings", this.settings.open);
    this.toolbar.press("play", this.player.playing);
    this.toolbar.press("record", this.recorder.recording);
    this.toolbar.press("compare", this.compare.active);
    this.toolbar.press("fullscreen", this.full_screen.active);
  }

  private goTo(pose: Partial<Pose>, done?: () => void): void {
    this.player.stop();
    this.walker.glideTo(pose, done);
  }

  private goToTruth(place: TruthView, there: () => void): void {
    const up_m = place.y_m - this.viewer.grid.heightAt(place);
    this.goTo({ x_m: place.x_m, z_m: place.z_m, up_m }, there);
  }

  private lookAt(hotspot: Hotspot): void {
    const pose = this.walker.pose;
    this.goTo(lookingAt(hotspot, pose, this.viewer.grid.heightAt(pose) + pose.up_m));
  }

  private walkTowards(x_px: number, y_px: number): void {
    const step_m = STEP_S * this.walker.pace_m_per_s;
    this.goTo(stepTowards(x_px, y_px, this.walker.pose, this.picture(), step_m));
  }

  private picture(): Picture {
    return {
      fov_y_rad: this.walker.fov_y_rad,
      width_px: this.canvas.clientWidth,
      height_px: this.canvas.clientHeight,
    };
  }

  private touched(): void {
    const now_ms = performance.now();
    this.idle.touch(now_ms);
    this.full_screen.touch(now_ms);
  }

  private frame(seconds: number): void {
    const now_ms = performance.now();
    if (this.xr.active) {
      this.xr.frame(seconds);
      this.touched();
    } else {
      this.walk(seconds);
    }
    this.recorder.advance(seconds, this.walker.pose);
    this.address.update(this.place(), now_ms);
    this.engine?.update(this.xr.active || this.compare.active ? null : this.stillView(), now_ms);
    if (now_ms - this.slow_ms < SLOW_MS) return;
    this.slow_ms = now_ms;
    this.slowly(now_ms);
  }

  private walk(seconds: number): void {
    const intent = readIntent(this.inputs);
    if (isActive(intent)) {
      this.player.stop();
      this.touched();
    }
    this.walker.step(seconds, intent);
    this.player.advance(seconds);
    this.compare.update(this.walker.gliding);
    const { pose, fov_y_rad } = this.walker;
    this.viewer.pose = pose;
    this.viewer.fov_y_rad = fov_y_rad;
    const picture = this.picture();
    this.hotspots.update(pose, this.viewer.grid.heightAt(pose), picture);
    const aspect = picture.width_px / Math.max(picture.height_px, 1);
    this.plan.update(pose, horizontalFov(fov_y_rad, aspect));
  }

  private slowly(now_ms: number): void {
    this.status.update(this.viewer.progress());
    if (!this.player.playing) this.whereabouts.update(this.walker.pose, now_ms);
    this.idle.update(now_ms);
    this.full_screen.update(now_ms);
  }

  private place(): Place {
    const { method, k_deg } = this.viewer.settings;
    const { pose, fov_y_rad } = this.walker;
    return { pose, fov_y_rad, method, k_deg };
  }

  private stillView() {
    return {
      pose: this.walker.pose,
      settings: this.viewer.settings,
      pixel_ratio: devicePixelRatio,
      ...this.picture(),
    };
  }
}
