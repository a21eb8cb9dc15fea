/** Share what is on show: a link to it, and a picture of the stage. */

import { t } from "../strings.js";
import { el, freshId, notify, saveFile } from "./dom.js";
import { format } from "./state.js";

/** @typedef {import("./state.js").Store} Store */

export class Share {
  /**
   * @param {HTMLButtonElement} button that opens the menu, in an element of its own
   * @param {Store} store
   * @param {() => {picture?: () => Promise<Blob> | null}} view returns the view on show; with a stage,
   *   it makes a PNG of it, null as long as there is nothing to see
   */
  constructor(button, store, view) {
    this.button = button;
    this.store = store;
    this.view = view;
    const id = freshId();
    this.link = el("input", { type: "text", readonly: "", "aria-label": t("shareLink"),
      on: { focus: () => this.link.select() } });
    this.save = el("button", { type: "button", on: { click: () => void this.savePicture() } },
      t("sharePicture"));
    this.menu = el("div", { class: "card share-menu", id, hidden: true }, this.link,
      el("div", { class: "actions" }, el("button", { type: "button",
        on: { click: () => void this.copy() } }, t("shareCopy")), this.save));
    button.setAttribute("aria-controls", id);
    button.after(this.menu);
    button.parentElement?.addEventListener("keydown", ({ key }) => {
      if (key !== "Escape" || this.menu.hidden) return;
      this.open(false);
      button.focus();
    });
    document.addEventListener("pointerdown", ({ target }) => {
      const isInside = target instanceof Node && button.parentElement?.contains(target);
      if (!this.menu.hidden && !isInside) this.open(false);
    });
    store.subscribe(() => { this.link.value = this.address; });
  }

  /** The link to what is on show, for a page of its own. */
  get address() {
    return new URL(format(this.store.state), location.href).href;
  }

  /** Return a picture of the stage on show. */
  picture() {
    return this.view().picture?.() ?? null;
  }

  get fileName() {
    return `latolato_${this.store.state.scenario ?? this.store.state.view}.png`;
  }

  /** Hand link and picture to the system, where it can share; else offer both. */
  async share() {
    if (!("share" in navigator) || !this.menu.hidden) {
      this.open(this.menu.hidden);
      return;
    }
    const picture = await this.picture();
    const files = picture ? [new File([picture], this.fileName, { type: picture.type })] : [];
    const data = { title: document.title, url: this.address };
    try {
      await navigator.share(navigator.canShare?.({ files }) ? { ...data, files } : data);
    } catch (error) {
      if (!(error instanceof DOMException)) throw error;
      if (error.name !== "AbortError") this.open(true); // the browser refused; on an abort, the user did
    }
  }

  /** @param {boolean} isOpen */
  open(isOpen) {
    this.menu.hidden = !isOpen;
    this.button.setAttribute("aria-expanded", String(isOpen));
    this.link.value = this.address;
    this.save.hidden = !this.view().picture;
    if (isOpen) this.link.focus();
  }

  /** Copy the link, or leave it selected where the browser refuses the clipboard. */
  async copy() {
    this.link.value = this.address;
    try {
      await navigator.clipboard.writeText(this.link.value);
      notify(t("copied"));
    } catch {
      this.link.focus();
      this.link.select();
      notify(t("shareByHand"));
    }
  }

  async savePicture() {
    const picture = await this.picture();
    if (!picture) return;
    saveFile(picture, this.fileName);
    notify(t("stored", { name: this.fileName }));
  }
}
