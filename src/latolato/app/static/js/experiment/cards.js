/** The cards beside a film: where videos come from, which there are, and what can be taken home. */

import { el, freshId } from "../shared/dom.js";
import { t } from "../strings.js";
import { filmAddress } from "./desk.js";

/** @typedef {import("./session.js").Film} Film */
/** @typedef {import("./session.js").Session} Session */

const EXPORTS = { csv: "track.csv", nc: "track.nc", toml: "setup.toml", overlay: "overlay.mp4",
  report: "report.html" };
const MADE = ["nc", "overlay", "report"];

/**
 * Return the card into which videos are dropped, with examples for those who have none.
 * @param {import("./desk.js").Hello} hello
 * @param {(file: File) => void} add
 * @param {(kind: string) => void} example
 */
export function dropCard(hello, add, example) {
  const id = freshId();
  const input = el("input", { id, type: "file", accept: "video/*", multiple: true, on: {
    change: () => {
      for (const file of input.files ?? []) add(file);
      input.value = "";
    } } });
  const { upload, duration, pixels } = hello.limits;
  return el("section", { class: "card" },
    el("div", { class: "dropzone" }, el("label", { for: id }, t("filmDrop")), input,
      el("p", { class: "hint" }, t("filmDropHint", { size: upload / 1e6, minutes: duration / 60,
        pixels: t("megapixels", { count: (pixels / 1e6).toFixed(1) }) })),
      el("p", { class: "hint" }, t("filmPrivate"))),
    el("p", { class: "hint" }, t("exampleHint")),
    el("div", { class: "actions" }, ...hello.examples.map((kind) => el("button", {
      type: "button", on: { click: () => example(kind) } }, t(`example_${kind}`)))));
}

/**
 * Return the films of a session, each with a button that opens and one that removes it.
 * @param {Session} session
 * @param {(film: Film) => void} open
 */
export function filmList(session, open) {
  return el("section", { class: "card", hidden: session.films.length === 0 },
    el("h2", {}, t("films")),
    el("ul", { class: "films" }, ...session.films.map((film) => el("li", {},
      el("button", { type: "button", class: "plain pick",
        "aria-pressed": film === session.film ? "true" : "false",
        on: { click: () => open(film) } },
      film.name, film.stage ? " …" : ""),
      el("button", { type: "button", class: "plain",
        "aria-label": t("filmRemove", { name: film.name }),
        on: { click: () => void session.remove(film) } }, "×")))));
}

/**
 * Return the downloads of a tracked film.
 * @param {Session} session
 * @param {Film} film
 */
export function exportsCard(session, film) {
  const stem = film.name.replace(/\.[^.]*$/, "");
  const saved = (/** @type {string} */ file) => (file === EXPORTS.toml
    ? `${stem}.${EXPORTS.csv}.track.toml` : `${stem}.${file}`);
  const link = (/** @type {string} */ file, /** @type {string} */ text) =>
    el("a", { href: filmAddress(film.key, file), download: saved(file) }, text);
  const make = async (/** @type {string} */ file) => {
    if (await session.make(film, file)) link(file, "").click();
  };
  return el("section", { class: "card" }, el("h2", {}, t("exports")),
    el("ul", { class: "plain-list" }, ...Object.entries(EXPORTS).map(([name, file]) => el("li", {},
      !MADE.includes(name) || film.files.has(file) ? link(file, t(`export_${name}`))
        : el("button", { type: "button", class: "link", disabled: film.stage !== null,
          on: { click: () => void make(file) } }, t(`export_${name}`))))));
}
