// A dialog with a title and a button that closes it; Escape and a click beside it do too.
import { element, iconButton } from "./dom";
import { icon } from "./icons";

export class Dialog {
  readonly element: HTMLDialogElement;
  readonly content = element("div", { class: "dialog-content" });

  constructor(title: string, testid: string) {
    const close = iconButton(icon("close"), "Close", () => this.element.close());
    const head = element("header", {}, element("h2", { text: title }), close);
    this.element = element(
      "dialog",
      { testid, attributes: { "aria-label": title } },
      head,
      this.content,
    );
    this.element.addEventListener("click", (event) => {
      if (event.target === this.element) this.element.close();
    });
  }

  toggle(): void {
    if (this.element.open) this.element.close();
    else this.element.showModal();
  }
}
