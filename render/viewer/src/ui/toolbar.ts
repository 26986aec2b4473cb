// The toolbar: icons without words, each with its name and its key.
import { COMMAND_KEYS, type Command } from "../walk/keyboard";
import { element, iconButton } from "./dom";
import { icon, type IconName } from "./icons";

interface Tool {
  command: Command | "vr";
  icon: IconName;
  label: string;
  /** Whether it is on or off, rather than something that is done. */
  toggles: boolean;
}

const TOOLS: readonly Tool[] = [
  { command: "plan", icon: "plan", label: "Plan", toggles: true },
  { command: "settings", icon: "settings", label: "How views are made", toggles: true },
  { command: "play", icon: "play", label: "Play the recorded path", toggles: true },
  { command: "record", icon: "record", label: "Record a path", toggles: true },
  { command: "compare", icon: "compare", label: "Compare with ground truth", toggles: true },
  { command: "screenshot", icon: "screenshot", label: "Save a screenshot", toggles: false },
  { command: "vr", icon: "vr", label: "Enter VR", toggles: true },
  { command: "fullscreen", icon: "fullscreen", label: "Full screen", toggles: true },
  { command: "info", icon: "info", label: "About this room", toggles: false },
  { command: "help", icon: "help", label: "Help", toggles: false },
];

export type ToolName = Tool["command"];

export class Toolbar {
  readonly element = element("nav", { class: "toolbar", testid: "toolbar" });
  private readonly buttons = new Map<ToolName, HTMLButtonElement>();

  constructor(run: (tool: ToolName) => void, settings: HTMLElement) {
    this.element.setAttribute("aria-label", "Tools");
    for (const tool of TOOLS) {
      const key = COMMAND_KEYS.find((each) => each.command === tool.command)?.shown[0];
      const act = (): void => run(tool.command);
      const button = iconButton(icon(tool.icon), tool.label, act, `tool-${tool.command}`);
      button.classList.add(`tool-${tool.command}`);
      if (key) {
        button.title = `${tool.label} (${key})`;
        button.setAttribute("aria-keyshortcuts", key);
      }
      if (tool.toggles) button.setAttribute("aria-pressed", "false");
      this.buttons.set(tool.command, button);
      this.element.append(button);
      if (tool.command === "settings") this.element.append(settings);
    }
  }

  offer(tool: ToolName, available: boolean): void {
    this.buttons.get(tool)!.hidden = !available;
  }

  press(tool: ToolName, pressed: boolean): void {
    this.buttons.get(tool)!.setAttribute("aria-pressed", String(pressed));
  }
}
