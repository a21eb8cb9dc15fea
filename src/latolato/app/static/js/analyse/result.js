/** The result of an analysis: picture, numbers, files, and lines of Python and shell that compute it. */

import { codeBlocks } from "../page/code.js";
import { el, saveFile } from "../page/dom.js";
import { fileOf } from "../page/jobs.js";
import { short } from "../page/unit_text.js";
import { ENGLISH, t } from "../strings.js";

/** @typedef {import("../page/block.js").Block} Block */
/** @typedef {{name: string, unit: string, label: string, ends: [number, number]}} Side */
/** @typedef {{box: [number, number, number, number], x: Side | null, y: Side | null}} PicturePanel */

/** @type {Record<string, string>} */
const TYPES = {
  nc: "application/x-netcdf", csv: "text/csv", png: "image/png", svg: "image/svg+xml",
};
// Dots of a picture in the height of a line: with 200 to an inch its letters are as large as ours.
const DOTS = 25;
// An arrow key moves the mark by this share of a panel.
const STEP = 0.01;
/** @type {Record<string, number[]>} */
const ARROWS = {
  ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP],
};

/**
 * Return the values that a point of a panel stands for, as texts of options.
 * @param {PicturePanel} panel
 * @param {number} x share of the panel's width
 * @param {number} y share of its height, from below
 * @returns {Record<string, string>}
 */
export function valuesAt(panel, x, y) {
  /** @type {Record<string, string>} */
  const values = {};
  /** @type {[Side | null, number][]} */
  const sides = [[panel.x, x], [panel.y, y]];
  for (const [side, share] of sides) {
    if (!side) continue;
    const value = short(side.ends[0] + share * (side.ends[1] - side.ends[0]), 5);
    values[side.name] = side.unit ? `${value} ${side.unit}` : value;
  }
  return values;
}

export class ResultCard {
  /**
   * @param {Block} block
   * @param {import("./view.js").Analysis} analysis
   * @param {(text: string) => string} inWords puts what the page calls it for names of options
   * @param {(values: Record<string, string>, words: string) => void} chosen called for a point
   */
  constructor(block, analysis, inWords, chosen) {
    const { about } = block;
    this.title = analysis.title;
    this.panels = /** @type {PicturePanel[]} */ (about.panels);
    this.chosen = chosen;
    this.at = { panel: 0, x: 0.5, y: 0.5 };
    this.mark = el("span", { class: "mark", hidden: true });
    this.choice = el("p", { class: "chosen", role: "status" });
    const files = Object.keys(TYPES).filter((kind) => kind in block.arrays);
    const save = (/** @type {string} */ kind) => () =>
      saveFile(fileOf(block, kind, TYPES[kind]), `${about.analysis}.${kind}`);
    const notes = about.warnings.map((/** @type {string} */ text) =>
      el("p", { class: "notes" }, t("warning", { text: inWords(text).replaceAll("_", " ") })));
    this.after = el("div", { class: "after" });
    this.root = el("div", { class: "main" },
      el("section", { class: "card" }, ...notes, block.arrays.png ? this.picture(block) : null,
        el("p", { class: "reading-of" }, analysis.reading), this.choice),
      this.after,
      el("section", { class: "card" }, el("h2", {}, t("numbers")),
        el("div", { class: "table-scroll", tabindex: "0", role: "region",
          "aria-label": t("numbers") },
          el("table", { class: "numbers", lang: ENGLISH }, el("tbody", {},
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
    // On a phone it scrolls.
    if (!this.panels.length) return el("div", { class: "picture", tabindex: "0", role: "region",
      "aria-label": t("pictureOf", { name }) }, image);
    const place = el("div", { class: "picture points", tabindex: "0", role: "application",
      "aria-label": t("pointsOf", { name }), on: {
        click: (/** @type {MouseEvent} */ event) => this.click(event, place),
        keydown: (/** @type {KeyboardEvent} */ event) => this.key(event),
      } }, el("div", { class: "sheet" }, image, this.mark));
    return el("div", {}, place, el("p", { class: "hint" }, t("pointsHint")));
  }

  /**
   * @param {MouseEvent} event
   * @param {HTMLElement} place
   */
  click(event, place) {
    const sheet = /** @type {HTMLElement} */ (place.firstElementChild).getBoundingClientRect();
    const x = (event.clientX - sheet.left) / sheet.width;
    const y = (event.clientY - sheet.top) / sheet.height;
    const panel = this.panels.findIndex(({ box }) =>
      x >= box[0] && x <= box[2] && y >= box[1] && y <= box[3]);
    if (panel < 0) return;
    const { box } = this.panels[panel];
    this.at = { panel, x: (x - box[0]) / (box[2] - box[0]), y: (box[3] - y) / (box[3] - box[1]) };
    this.move();
    this.choose();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const step = ARROWS[event.key];
    if (step) {
      const clip = (/** @type {number} */ share) => Math.min(1, Math.max(0, share));
      this.at.x = clip(this.at.x + step[0]);
      this.at.y = clip(this.at.y + step[1]);
      this.move();
      this.choice.textContent = this.said();
    } else if (event.key === "Enter") this.choose();
    else return;
    event.preventDefault();
  }

  /** Put the mark where it is. */
  move() {
    const { box } = this.panels[this.at.panel];
    this.mark.hidden = false;
    this.mark.style.left = `${100 * (box[0] + this.at.x * (box[2] - box[0]))}%`;
    this.mark.style.top = `${100 * (box[3] - this.at.y * (box[3] - box[1]))}%`;
  }

  /** The values of the marked point in words. */
  said() {
    const { panel, x, y } = this.at;
    const { x: across, y: up } = this.panels[panel];
    return Object.entries(valuesAt(this.panels[panel], x, y)).map(([name, text]) =>
      `${[across, up].find((side) => side?.name === name)?.label}: ${text}`).join(", ");
  }

  choose() {
    this.choice.textContent = "";
    this.chosen(valuesAt(this.panels[this.at.panel], this.at.x, this.at.y), this.said());
  }
}
