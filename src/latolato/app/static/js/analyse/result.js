/** The result of an analysis: picture, numbers, files, and lines of Python and shell that compute it. */

import { codeBlocks } from "../page/code.js";
import { el, saveFile } from "../page/dom.js";
import { fileOf } from "../page/jobs.js";
import { inWords } from "../page/option_labels.js";
import { sentenceInLanguage } from "../page/refusals.js";
import { t } from "../strings.js";

/** @typedef {import("../page/block.js").Block} Block */

/** @typedef {import("../model/rules.js").Sentence} Sentence */
/** @typedef {import("../model/rules.js").Value} Value */

/** @type {Record<string, string>} */
const TYPES = {
  nc: "application/x-netcdf", csv: "text/csv", png: "image/png", svg: "image/svg+xml",
};
// Dots of a picture in the height of a line: with 200 to an inch its letters are as large as ours.
const DOTS = 25;

export class ResultCard {
  /**
   * @param {Block} block
   * @param {import("./view.js").Analysis} analysis
   * @param {Record<string, {label: string}>} words what options, parameters and analyses are called
   * @param {(start: Record<string, string>) => void} begin called to analyse the motion from another start
   */
  constructor(block, analysis, words, begin) {
    const { about } = block;
    this.title = analysis.title;
    const files = Object.keys(TYPES).filter((kind) => kind in block.arrays);
    const save = (/** @type {string} */ kind) => () =>
      saveFile(fileOf(block, kind, TYPES[kind]), `${about.analysis}.${kind}`);
    const notes = about.warnings.map((/** @type {string | Sentence} */ each) => {
      const start = startIn(each);
      return el("p", { class: "notes" },
        t("warning", { text: inWords(sentenceInLanguage(each, words), words).replaceAll("_", " ") }),
        ...(start ? [" ", el("button", { type: "button", on: { click: () => begin(start) } }, t("analyseThatMotion"))] : []));
    });
    this.root = el("div", { class: "main" },
      el("section", { class: "card" }, ...notes, block.arrays.png ? this.picture(block) : null,
        // Of a curve without a point there is nothing to read.
        about.points === 0 ? null : el("p", { class: "reading-of" }, analysis.reading)),
      el("section", { class: "card" }, el("h2", {}, t("numbers")),
        el("div", { class: "table-scroll", tabindex: "0", role: "region",
          "aria-label": t("numbers") },
          el("table", { class: "numbers" }, el("tbody", {},
            ...about.lines.map((/** @type {[string, string]} */ [name, text]) => el("tr", {},
              el("th", { scope: "row" }, name), el("td", {}, text)))))),
        this.actions = el("div", { class: "actions" }, ...files.map((kind) =>
          el("button", { type: "button", on: { click: save(kind) } }, t(`file_${kind}`))))),
      el("details", { class: "card" }, el("summary", {}, t("code")),
        el("p", { class: "hint" }, t("codeOfAnalysis")), ...codeBlocks([about.python, about.command])));
  }

  /** @param {Block} block */
  picture(block) {
    // Not the SVG, whose texts depend on the fonts that are there.
    const address = URL.createObjectURL(fileOf(block, "png", TYPES.png));
    const name = this.title;
    // Its size is in the file's first bytes: what comes below stays where it is.
    const { buffer, byteOffset } = /** @type {Uint8Array} */ (block.arrays.png);
    const [width, height] = [16, 20].map((at) => new DataView(buffer, byteOffset).getUint32(at));
    const image = el("img", { src: address, alt: t("pictureOf", { name }), width, height,
      on: { load: () => URL.revokeObjectURL(address) } });
    image.style.setProperty("--full", `${width / DOTS}rem`);
    return el("div", { class: "picture" }, image);
  }
}

/**
 * Return the state in which a run settles, as the options of a start, if a note is of that.
 * @param {Value} note
 * @returns {Record<string, string> | undefined}
 */
function startIn(note) {
  if (typeof note !== "object" || !("values" in note)) return undefined;
  const { name, values } = note;
  if (name !== "run_elsewhere") return Object.values(values).map(startIn).find((start) => start);
  const each = (/** @type {Value} */ listed) => Object.values(/** @type {Sentence} */ (listed).values)
    .map((quantity) => /** @type {Sentence} */ (quantity).values).map(({ value, unit }) => `${value}${unit}`).join(", ");
  return { initial_angle: each(values.angle), initial_angular_velocity: each(values.velocity) };
}
