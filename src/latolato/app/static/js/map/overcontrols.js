/** What can be drawn over a map, to be switched on and off: contour lines, theory, curves, trials. */

import { el, refresh, tick } from "../page/dom.js";
import { short } from "../page/unit_text.js";
import { localList, t } from "../strings.js";
import { axisLabel, sizeOf } from "./axes.js";
import { choice, numberField } from "../page/fields.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Variable} Variable */

/** Stands in the address for contour lines of what has the colours. */
export const OF_COLOURS = "colours";

export class OverControls {
  /**
   * @param {import("../model/registry.js").Registry} registry
   * @param {(values: Record<string, any>) => void} keep keeps values in the address
   * @param {(files: import("./over.js").TextFile[]) => void} files called with tables of trials and of curves
   */
  constructor(registry, keep, files) {
    this.registry = registry;
    this.keep = keep;
    this.contours = choice(t("mapContours"), (v) => keep({ contours: v || null, levels: null }));
    /** The field of levels, once there is what they are of. @type {import("../page/knob.js").Knob | null} */
    this.levels = null;
    this.levelBox = el("div", { class: "levels" });
    this.contourNote = el("p", { class: "hint", role: "status" });
    this.lines = el("div", { class: "fields" });
    this.lineNote = el("p", { class: "hint", role: "status" });
    /** @type {[string, HTMLInputElement][]} the boxes of lines by their names */
    this.boxes = [];
    const file = el("input", { type: "file", accept: ".csv,text/csv", id: "map-trials", multiple: true,
      on: { change: async () => files(await Promise.all(Array.from(file.files ?? [],
        async (each) => ({ name: each.name, text: await each.text() })))) } });
    this.trialNote = el("p", { class: "hint", role: "status" });
    this.parts = [this.contours.root, this.levelBox, this.contourNote, this.lines, this.lineNote,
      el("div", { class: "field preset" }, el("label", { for: "map-trials" }, t("mapTrials")),
        el("p", { class: "hint" }, t("mapTrialsHint")), file), this.trialNote];
  }

  /**
   * Show what contour lines there may be of a map, and what is switched on.
   * @param {Grid} grid
   * @param {Record<string, string>} extra
   * @param {string[]} off names of lines that are switched off
   */
  showChoices(grid, extra, off) {
    const names = new Map(grid.variables.filter((v) => !v.classes.length).map((v) => [v.name, v.label]));
    const chosen = extra["map.contours"] ?? "";
    this.contours.show([{ value: "", text: t("mapContoursNone") },
      { value: OF_COLOURS, text: t("mapContoursColours") },
      ...[...names].map(([value, text]) => ({ value, text }))],
    chosen === OF_COLOURS || names.has(chosen) ? chosen : "");
    this.levelBox.hidden = this.contourNote.hidden = !this.contours.select.value;
    for (const [name, box] of this.boxes) box.checked = !off.includes(name);
  }

  /**
   * Say which contour lines are drawn, or why none are.
   * @param {Variable | null} variable
   * @param {string | null} text of their levels, null for round ones
   * @param {import("./over.js").Drawn | null} drawn
   * @param {boolean} isLater whether they wait for the map
   * @param {string[]} notes
   */
  showContours(variable, text, drawn, isLater, notes) {
    this.contourNote.textContent = "";
    if (!variable) return;
    refresh(this.levelBox, variable.name, () => {
      this.levels = numberField(this.registry, t("mapLevels"), variable, (_, levels) =>
        this.keep({ levels: levels || null }), { isList: true, mayBeEmpty: true });
      this.levels.input.setAttribute("aria-label", t("mapLevelsOf", { what: axisLabel(variable) }));
      return [this.levels.root];
    });
    this.levels?.read(text);
    if (this.levels)
      this.levels.input.placeholder = localList((drawn?.levels ?? []).map((v) => short(v / sizeOf(variable), 4)));
    const sentences = [...notes];
    if (isLater) sentences.push(t("mapContoursLater"));
    if (drawn && !drawn.levels.length) sentences.push(t("mapContoursFlat"));
    else if (drawn && !drawn.lines) sentences.push(t("mapContoursNowhere"));
    if (drawn?.tiny) sentences.push(t("mapContoursTiny", { count: drawn.tiny }));
    this.contourNote.textContent = sentences.join(" ");
  }

  /**
   * Show which lines there are, and why others are not.
   * @param {import("./overlay_curves.js").Line[]} lines
   * @param {string[]} notes
   * @param {() => string[]} off returns the names of those that are switched off, also of other maps
   */
  showLines(lines, notes, off) {
    const made = lines.map(({ name, label, colour, xs }) => ({ name, ...tick(
      colour ? t("mapCurve", { label, points: xs.length }) : label, (on) => {
        const others = off().filter((each) => each !== name);
        this.keep({ off: (on ? others : [...others, name]).join(",") || null });
      }) }));
    this.boxes = made.map(({ name, box }) => [name, box]);
    this.lines.replaceChildren(...made.map(({ root }) => root));
    const hints = lines.some(({ colour }) => colour) ? [t("mapCurvesHint")] : [];
    this.lineNote.textContent = [...hints, ...notes].join(" ");
  }

  /**
   * Say how many trials there are, or what is wrong with their table.
   * @param {{trials: import("./chart.js").Trials, outside: number} | null} placed
   * @param {string[]} notes
   */
  showTrials(placed, notes) {
    this.trialNote.textContent = placed ? t("mapTrialCount",
      { count: placed.trials.xs.length, outside: placed.outside }) : notes.join(" ");
  }
}
