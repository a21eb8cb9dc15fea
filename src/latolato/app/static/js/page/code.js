/** Lines of code on show, each with a button that copies them. */

import { t } from "../strings.js";
import { el, notify } from "./dom.js";

/**
 * Return an element for each text.
 * @param {string[]} texts
 */
export function codeBlocks(texts) {
  return texts.map((text) => el("div", { class: "code" }, el("pre", { tabindex: "0" }, text),
    el("button", { type: "button", class: "plain", on: { click: async () => {
      await navigator.clipboard.writeText(text);
      notify(t("copied"));
    } } }, t("copy"))));
}
