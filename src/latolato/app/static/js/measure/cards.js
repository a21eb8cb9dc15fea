/** The cards beside a clip: where videos and tables come from, which there are, and what can be taken home. */

import { codeBlocks } from "../page/code.js";
import { el, freshId } from "../page/dom.js";
import { short, withSigma } from "../page/unit_text.js";
import { t } from "../strings.js";
import { clipAddress } from "./desk.js";

/** @typedef {import("./session.js").Clip} Clip */
/** @typedef {import("./session.js").Session} Session */

const EXPORTS = { csv: "track.csv", nc: "track.nc", toml: "setup.toml", overlay: "overlay.mp4",
  report: "report.html" };
const MADE = ["nc", "overlay", "report"];
/** What there is of a table, which has no picture. */
const OF_TABLE = ["csv", "nc"];
/** With how many digits numbers are shown from which another one follows. @type {Record<string, number>} */
const DIGITS = { more: 3, sigma: 2 };
/** Pictures of the guide; each has a text. */
const GUIDE = ["hang", "place", "frame"];

/**
 * Return the card into which videos and tables are dropped, with examples for those who have none.
 * @param {import("./desk.js").Hello} hello
 * @param {(file: File) => void} add
 * @param {(kind: string) => void} example
 */
export function dropCard(hello, add, example) {
  const id = freshId();
  const input = el("input", { id, type: "file", accept: ["video/*", ...hello.tables.endings].join(),
    multiple: true, on: {
    change: () => {
      for (const file of input.files ?? []) add(file);
      input.value = "";
    } } });
  const { upload, duration, pixels } = hello.limits;
  return el("section", { class: "card" },
    el("div", { class: "dropzone" }, el("label", { for: id }, t("clipDrop")), input,
      el("p", { class: "hint" }, t("clipDropHint", { size: upload / 1e6, minutes: duration / 60,
        pixels: t("megapixels", { count: (pixels / 1e6).toFixed(1) }) })),
      el("p", { class: "hint" }, t("clipDropTables")),
      el("p", { class: "hint" }, t("clipPrivate"))),
    el("p", { class: "hint" }, t("exampleHint")),
    el("div", { class: "actions" }, ...hello.examples.map((kind) => el("button", {
      type: "button", on: { click: () => example(kind) } }, t(`example_${kind}`)))));
}

/** Return the card that tells how to film a pendulum. */
export function guideCard() {
  return el("section", { class: "card guide" }, el("h2", {}, t("film")),
    el("ol", {}, ...GUIDE.map((name) => el("li", {},
      el("img", { src: `film/${name}.svg`, alt: "", width: "320", height: "200" }),
      el("p", {}, t(`film_${name}`))))),
    el("p", { class: "hint" }, t("filmMore")));
}

/**
 * Return the clips of a session, each with a button that opens and one that removes it.
 * @param {Session} session
 * @param {(clip: Clip) => void} open
 */
export function clipList(session, open) {
  return el("section", { class: "card", hidden: session.clips.length === 0 },
    el("h2", {}, t("clips")),
    el("ul", { class: "clips" }, ...session.clips.map((clip) => el("li", {},
      el("button", { type: "button", class: "plain pick",
        "aria-pressed": clip === session.clip ? "true" : "false",
        on: { click: () => open(clip) } },
      clip.name, clip.stage ? " …" : ""),
      el("button", { type: "button", class: "plain",
        "aria-label": t("clipRemove", { name: clip.name }),
        on: { click: () => void session.remove(clip) } }, "×")))));
}

/**
 * The answer of a video: a few numbers in large type, each with its uncertainty.
 * @param {Clip["answer"]} answer
 */
export function answerNumbers(answer) {
  return el("dl", { class: "numbers" }, ...answer.map(({ name, value, sigma, units, given }) => {
    const [number, ...rest] = withSigma(value, sigma).split(/(?= ± )/);
    const words = Object.fromEntries(Object.entries(given ?? {}).map(([key, each]) =>
      [key, short(each, DIGITS[key] ?? 6)]));
    return el("div", { "data-answer": name, "data-value": String(value) },
      el("dt", {}, t(`answer_${name}${words.more ? "_ball" : ""}`, words)),
      el("dd", {}, number, el("small", {}, ...rest, units && ` ${units}`)));
  }));
}

/**
 * Return the lines that do the same as the page.
 * @param {string[]} code in Python and for a shell
 */
export function codeCard(code) {
  return el("details", { class: "card" }, el("summary", {}, t("code")),
    el("p", { class: "hint" }, t("codeFits")), ...codeBlocks(code));
}

/**
 * Return the downloads of a tracked clip.
 * @param {Session} session
 * @param {Clip} clip
 */
export function exportsCard(session, clip) {
  const stem = clip.name.replace(/\.[^.]*$/, "");
  const saved = (/** @type {string} */ file) => (file === EXPORTS.toml
    ? `${stem}.${EXPORTS.csv}.track.toml` : `${stem}.${file}`);
  const link = (/** @type {string} */ file, /** @type {string} */ text) =>
    el("a", { href: clipAddress(clip.key, file), download: saved(file) }, text);
  const make = async (/** @type {string} */ file) => {
    if (await session.make(clip, file)) link(file, "").click();
  };
  const files = Object.entries(EXPORTS).filter(([name]) => !clip.sheet || OF_TABLE.includes(name));
  return el("section", { class: "card" }, el("h2", {}, t("download")),
    el("ul", { class: "plain-list" }, ...files.map(([name, file]) => el("li", {},
      !MADE.includes(name) || clip.files.has(file) ? link(file, t(`export_${name}`))
        : el("button", { type: "button", class: "link", disabled: clip.stage !== null,
          on: { click: () => void make(file) } }, t(`export_${name}`))))));
}
