/** The menu from which the map on show is stored: its numbers and its picture. */

import { ask, Offline, Refusal } from "../shared/api.js";
import { el, tell } from "../shared/dom.js";
import { saveFile } from "../shared/jobs.js";
import { t } from "../strings.js";

const KINDS = ["csv", "nc", "zarr", "png", "svg"];

export class MapFiles {
  /** @param {() => Promise<Record<string, any> | null>} body what is on show, null for nothing */
  constructor(body) {
    this.body = body;
    this.error = el("p", { class: "error", role: "alert", hidden: true });
    this.buttons = KINDS.map((kind) => el("button", { type: "button",
      on: { click: () => void this.store(kind) } }, t(`file_${kind}`)));
    this.root = el("details", { class: "card downloads", on: {
      keydown: (/** @type {KeyboardEvent} */ event) => {
        if (event.key === "Escape") this.root.open = false;
      } } },
      el("summary", {}, t("download")),
      el("ul", {}, ...KINDS.map((kind, i) => el("li", {}, this.buttons[i],
        el("span", { class: "soft" }, ` ${t(`mapFileHint_${kind}`)}`)))),
      el("p", { class: "hint" }, t("mapFilesHint")), this.error);
  }

  /** @param {string} kind */
  async store(kind) {
    const body = await this.body();
    if (!body) {
      this.refuse(t("mapFilesNone"));
      return;
    }
    this.error.hidden = true;
    for (const button of this.buttons) button.disabled = true;
    try {
      const response = await ask(`download/map.${kind}`, body);
      const missing = Number(response.headers.get("X-Points-Missing"));
      const name = /filename="([^"]+)"/.exec(response.headers.get("Content-Disposition") ?? "");
      saveFile(await response.blob(), name?.[1] ?? `latolato_map.${kind}`);
      tell(t(missing ? "mapStoredPart" : "stored", { name: name?.[1] ?? kind, missing }));
    } catch (error) {
      if (error instanceof Refusal) this.refuse(error.message);
      else if (error instanceof Offline) this.refuse(t("offline"));
      else throw error;
    } finally {
      for (const button of this.buttons) button.disabled = false;
    }
  }

  /** @param {string} text */
  refuse(text) {
    this.error.textContent = text;
    this.error.hidden = false;
  }
}
