// Elements of the page, made in one expression.

export interface Parts {
  class?: string;
  /** Always as text: nothing from a room is read as markup. */
  text?: string;
  testid?: string;
  attributes?: Record<string, string>;
}

export function element<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  parts: Parts = {},
  ...children: Node[]
): HTMLElementTagNameMap[Tag] {
  const made = document.createElement(tag);
  if (parts.class) made.className = parts.class;
  if (parts.text !== undefined) made.textContent = parts.text;
  if (parts.testid) made.dataset.testid = parts.testid;
  for (const [name, value] of Object.entries(parts.attributes ?? {}))
    made.setAttribute(name, value);
  made.append(...children);
  return made;
}

export function svg<Tag extends keyof SVGElementTagNameMap>(
  tag: Tag,
  attributes: Record<string, string | number> = {},
  ...children: Node[]
): SVGElementTagNameMap[Tag] {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.append(...children);
  return made;
}

/** A button that shows an icon and says what it does. */
export function iconButton(
  icon: SVGElement,
  label: string,
  act: () => void,
  testid?: string,
): HTMLButtonElement {
  const button = element("button", {
    class: "icon-button",
    attributes: { type: "button", "aria-label": label, title: label },
    ...(testid ? { testid } : {}),
  });
  button.append(icon);
  button.addEventListener("click", act);
  return button;
}

/** Offers a file to be saved. */
export function download(content: Blob, name: string): void {
  const url = URL.createObjectURL(content);
  element("a", { attributes: { href: url, download: name } }).click();
  // The browser has begun to read it by then.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
