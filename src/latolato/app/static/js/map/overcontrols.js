/** What can be drawn over a map, to be switched on and off: contour lines, theory, trials. */

import { splitQuantity } from "../model/units.js";
import { el, freshId } from "../page/dom.js";
import { readQuantity, withPoints } from "../page/entry.js";
import { short, shownUnit } from "../page/unit_text.js";
import { localList, t } from "../strings.js";
import { axisLabel, sizeOf } from "./axes.js";
import { choice, problemOf, tick } from "./fields.js";
import { MOST_LEVELS } from "./levels.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Variable} Variable */
/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("./fields.js").Shown} Shown */

/** Stands in the address for contour lines of what has the colours. */
export const OF_COLOURS = "colours";

export class OverControls {
  /**
   * @param {Registry} registry
   * @param {(values: Record<string, any>) => void} keep keeps values in the address
   * @param {(texts: string[]) => void} files called with the texts of tables of trials and of curves
   */
  constructor(registry, keep, files) {
    this.registry = registry;
    this.keep = keep;
    /** What contour lines are drawn of. @type {Shown} */
    this.quantity = { unit: "1", units: [] };
    this.contours = choice(t("mapContours"), (v) => {
      this.problem.show(null);
      keep({ contours: v || null, levels: null });
    });
    const id = freshId();
    this.levels = el("input", { id, type: "text", autocomplete: "off", spellcheck: "false",
      on: { change: () => this.read(keep) } });
    this.unit = el("span", { class: "unit" });
    this.problem = problemOf(this.levels);
    this.levelBox = el("div", { class: "field levels" }, el("label", { for: id }, t("mapLevels")),
      el("span", { class: "entry" }, this.levels, this.unit), this.problem.line);
    this.contourNote = el("p", { class: "hint", role: "status" });
    this.tongue = tick(t("mapTongue"), (on) => keep({ tongue: on ? null : 0 }));
    this.lift = tick(t("mapLift"), (on) => keep({ lift: on ? null : 0 }));
    this.note = el("p", { class: "hint" });
    this.curves = el("div", { class: "fields" });
    this.curveNote = el("p", { class: "hint", role: "status" });
    /** @type {[string, HTMLInputElement][]} the boxes of bifurcation curves by their names */
    this.boxes = [];
    const file = el("input", { type: "file", accept: ".csv,text/csv", id: "map-trials", multiple: true,
      on: { change: async () => files(await Promise.all(Array.from(file.files ?? [], (each) => each.text()))) } });
    this.file = file;
    this.trialNote = el("p", { class: "hint", role: "status" });
    this.parts = [this.contours.root, this.levelBox, this.contourNote, this.tongue.root,
      this.lift.root, this.note, this.curves, this.curveNote,
      el("div", { class: "field preset" }, el("label", { for: "map-trials" }, t("mapTrials")),
        el("p", { class: "hint" }, t("mapTrialsHint")), file), this.trialNote];
  }

  /** @param {(values: Record<string, any>) => void} keep */
  read(keep) {
    const text = this.levels.value.trim();
    const levels = levelsOf(this.registry, text, this.quantity);
    const many = levels !== null && levels.length > MOST_LEVELS;
    this.problem.show(!levels ? t("noLevels", { text, example: localList(["10", "20", "50"]) })
      : many ? t("tooManyLevels", { most: MOST_LEVELS, count: levels.length }) : null);
    if (levels && !many) keep({ levels: levels.length ? levels.join(",") : null });
  }

  /**
   * Show what contour lines there may be of a map, and what is switched on.
   * @param {Grid} grid
   * @param {Record<string, string>} extra
   * @param {string[]} off names of bifurcation curves that are switched off
   */
  showChoices(grid, extra, off) {
    const names = new Map(grid.variables.filter((v) => !v.classes.length)
      .map((v) => [v.name, v.label]));
    const chosen = extra["map.contours"] ?? "";
    this.contours.show([{ value: "", text: t("mapContoursNone") },
      { value: OF_COLOURS, text: t("mapContoursColours") },
      ...[...names].map(([value, text]) => ({ value, text }))],
    chosen === OF_COLOURS || names.has(chosen) ? chosen : "");
    this.levelBox.hidden = this.contourNote.hidden = !this.contours.select.value;
    this.tongue.box.checked = extra["map.tongue"] !== "0";
    this.lift.box.checked = extra["map.lift"] !== "0";
    for (const [name, box] of this.boxes) box.checked = !off.includes(name);
    const levels = extra["map.levels"];
    if (document.activeElement !== this.levels && this.problem.line.hidden)
      this.levels.value = levels ? this.text(levels) : "";
  }

  /** @param {string} levels numbers in SI units */
  text(levels) {
    const size = this.quantity.units[0]?.size ?? 1;
    return localList(levels.split(",").map((v) => short(Number(v) / size, 6)));
  }

  /**
   * Say which contour lines are drawn, or why none are.
   * @param {Variable | null} variable
   * @param {import("./over.js").Drawn | null} drawn
   * @param {boolean} isLater whether they wait for the map
   * @param {string[]} notes
   */
  showContours(variable, drawn, isLater, notes) {
    if (!variable) {
      this.contourNote.textContent = "";
      return;
    }
    this.quantity = variable;
    this.unit.textContent = shownUnit(variable.units[0]?.name ?? "");
    this.levels.setAttribute("aria-label", t("mapLevelsOf", { what: axisLabel(variable) }));
    const values = localList((drawn?.levels ?? []).map((v) => short(v / sizeOf(variable), 4)));
    this.levels.placeholder = values;
    const sentences = [...notes];
    if (isLater) sentences.push(t("mapContoursLater"));
    if (drawn && !drawn.levels.length) sentences.push(t("mapContoursFlat"));
    else if (drawn && !drawn.lines) sentences.push(t("mapContoursNowhere"));
    if (drawn?.tiny) sentences.push(t("mapContoursTiny", { count: drawn.tiny }));
    this.contourNote.textContent = sentences.join(" ");
    if (this.levels.value && document.activeElement !== this.levels && this.problem.line.hidden
      && drawn)
      this.levels.value = values;
  }

  /**
   * Show which curves there are, and why others are not.
   * @param {import("./theory.js").NamedLine[]} lines
   * @param {string[]} notes
   */
  showCurves(lines, notes) {
    this.tongue.box.disabled = !lines.some(({ name }) => name === "tongue");
    this.lift.box.disabled = !lines.some(({ name }) => name === "lift_off");
    this.note.textContent = notes.join(" ");
  }

  /**
   * Show which bifurcation curves there are, and why others are not.
   * @param {import("./curves.js").PlacedCurve[]} curves
   * @param {string[]} notes
   * @param {() => string[]} off returns the names of those that are switched off
   */
  showBifurcations(curves, notes, off) {
    const made = curves.map(({ name, label, xs }) => ({ name, ...tick(
      t("mapCurve", { label, points: xs.length }), (on) => {
        const others = off().filter((each) => each !== name);
        this.keep({ off: (on ? others : [...others, name]).join(",") || null });
      }) }));
    this.boxes = made.map(({ name, box }) => [name, box]);
    this.curves.replaceChildren(...made.map(({ root }) => root));
    this.curveNote.textContent = [...(curves.length ? [t("mapCurvesHint")] : []), ...notes].join(" ");
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

/**
 * Return the numbers of a text such as "0.5, 1, 2 kJ" in SI units, increasing, none of an empty
 * text; null if a part is no number.
 * A unit at the end is that of all numbers without one of their own.
 * @param {Pick<Registry, "units" | "prefixes">} registry
 * @param {string} text
 * @param {Shown} quantity
 * @returns {number[] | null}
 */
export function levelsOf(registry, text, { unit, units }) {
  const parts = text.trim() ? withPoints(text, true).split(",").map((part) => part.trim()) : [];
  const unitOf = (/** @type {string | undefined} */ part) => splitQuantity(part ?? "")?.unit;
  const usual = unitOf(parts.at(-1)) || units[0]?.name || "1";
  const levels = parts.map((part) => readQuantity(registry,
    unitOf(part) === "" && usual !== "1" ? `${part} ${usual}` : part, unit).value);
  if (levels.some(Number.isNaN)) return null;
  return [...new Set(levels)].sort((a, b) => a - b);
}
