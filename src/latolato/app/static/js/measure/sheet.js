/** A table of another program before it is imported: what was recognised, and what its columns are. */

import { el } from "../page/dom.js";
import { choice } from "../page/fields.js";
import { sentenceInLanguage } from "../page/refusals.js";
import { shownUnit } from "../page/unit_text.js";
import { capitalised, t } from "../strings.js";

/**
 * @typedef {import("../model/rules.js").Sentence} Sentence
 * @typedef {{position: number, name: string, path: string, unit: string, unit_from: Sentence | string,
 *   kind: string}} SheetColumn
 * @typedef {{name: string, rows: number, first_rows: string[][], columns: SheetColumn[],
 *   roles: Record<string, number>, question: Sentence | null}} Part
 *
 * What the server recognised, and what somebody chose: which part of the file, and what each column
 * is and in which unit, by its position.
 * @typedef {{about: Sentence, notes: Sentence[], parts: Part[], isOwn: boolean, part: number,
 *   roles: Record<number, string>, units: Record<number, string>,
 *   angleFrom: string, yAxis: string, decimal: string}} Sheet
 */

/** A column that is not imported. */
const NONE = "";
/** Numbers of frames, which are a time with a frame rate. */
const FRAMES = "frame";

/**
 * Return a table with the choices that the server proposes.
 * @param {any} table as the server recognised it
 * @returns {Sheet}
 */
export function sheetOf({ about, notes, sections, is_own: isOwn }) {
  return chosen({ about, notes, parts: sections, isOwn, part: 0, roles: {}, units: {},
    angleFrom: "down", yAxis: "up", decimal: "" }, 0);
}

/**
 * Return a table with another part of the file on show, as the server proposes it.
 * @param {Sheet} sheet
 * @param {number} part
 * @returns {Sheet}
 */
export function chosen(sheet, part) {
  const { roles, columns } = sheet.parts[part];
  return { ...sheet, part,
    roles: Object.fromEntries(Object.entries(roles).map(([role, position]) => [position, role])),
    units: Object.fromEntries(columns.map(({ position, unit }) => [position, unit])) };
}

/**
 * Return whether a column has one of some roles.
 * @param {Sheet} sheet
 * @param {RegExp} roles
 */
function has(sheet, roles) {
  return Object.values(sheet.roles).some((role) => roles.test(role));
}

/**
 * Return whether times on a clock end in a part that may count frames: 0:00:03:12.
 * @param {Sheet} sheet
 */
function countsParts({ parts, part, roles }) {
  const { columns, first_rows: rows } = parts[part];
  const time = columns.find(({ position }) => roles[position] === "time");
  return time?.kind === "texts" && rows.some((row) => row[time.position - 1].split(":").length > 3);
}

/**
 * Flags of the facts that a table's columns leave open: a frame rate, the pivot's position, and the
 * directions of angles and of y.
 * @param {Sheet} sheet
 */
export function openOf(sheet) {
  const isOpen = !sheet.isOwn;
  return { frames: isOpen && (has(sheet, /^frame$/) || !has(sheet, /^time$/) || countsParts(sheet)),
    pivot: isOpen && has(sheet, /^ball_/) && !has(sheet, /^pivot_/),
    angles: isOpen && has(sheet, /^angle_\d/), heights: isOpen && has(sheet, /_y$/) };
}

/**
 * The description of an import for a table: section, columns, directions and decimal sign.
 * @param {Sheet} sheet
 */
export function choicesOf(sheet) {
  const { parts, part, roles, units, angleFrom, yAxis, decimal } = sheet;
  const { name, columns } = parts[part];
  const { angles, heights } = openOf(sheet);
  const named = columns.filter(({ position }) => roles[position]).map(({ position, unit }) => {
    const isFrames = roles[position] === FRAMES;
    const own = isFrames ? unit || "1" : units[position];
    return [isFrames ? "time" : roles[position],
      own && own !== unit ? `${position} [${own}]` : String(position)];
  });
  return { columns: Object.fromEntries(named), section: name || null, decimal: decimal || null,
    angle_from: angles ? angleFrom : null, y_axis: heights ? yAxis : null };
}

/**
 * Return what must be chosen before a table can be used, as a sentence, "" for nothing: something that was measured,
 * the other coordinate of a ball, and units.
 * @param {Sheet} sheet
 * @param {Record<string, string[]>} known the units that each role may have
 */
export function lackOf(sheet, known) {
  const { parts, part, roles, units, isOwn } = sheet;
  if (isOwn) return "";
  if (!has(sheet, /^(angle|angular|ball|pivot)_/)) return t("rolesMissing");
  const quoted = (/** @type {string[]} */ names) => names.map((name) => `\u201c${name}\u201d`).join(", ");
  const others = Object.values(roles).filter((role) => role.startsWith("ball_"))
    .map((role) => (role.endsWith("x") ? role.replace(/x$/, "y") : role.replace(/y$/, "x")))
    .filter((role) => !has(sheet, new RegExp(`^${role}$`)));
  if (others.length) return t("roleMissing", { names: quoted(others.map((role) => t(`role_${role}`))) });
  // Times on a clock have no unit.
  const unitless = parts[part].columns.filter(({ position, kind }) => kind !== "texts"
    && known[roles[position]]?.length && !known[roles[position]].includes(units[position]));
  return unitless.length ? t("unitMissing", { names: quoted(unitless.map(({ path }) => path)) }) : "";
}

/** The card that shows a table. */
export class SheetCard {
  /**
   * @param {Record<string, string[]>} roles what a column may be, each with its units
   * @param {(change: Partial<Sheet>) => void} changed
   */
  constructor(roles, changed) {
    this.roles = roles;
    this.changed = changed;
    this.content = "";
    /** @type {Sheet | null} */
    this.sheet = null;
    /** What shows the choices for each column. @type {(() => void)[]} */
    this.heads = [];
    this.root = el("section", { class: "card recognised" });
  }

  /**
   * Show a table and what was chosen; its heads keep the focus.
   * @param {import("./session.js").Clip} clip
   */
  update({ id, sheet }) {
    this.sheet = sheet;
    if (!sheet) return;
    const content = [id, sheet.part].join();
    if (content !== this.content) this.build(sheet);
    this.content = content;
    for (const read of this.heads) read();
  }

  /** @param {Sheet} sheet */
  build(sheet) {
    const { parts, part, isOwn, about, notes } = sheet;
    const { rows, first_rows: first, columns, question } = parts[part];
    this.heads = [];
    const sentence = (/** @type {string} */ kind, /** @type {string} */ text) =>
      el("p", { class: kind }, `${capitalised(text)}.`);
    const heads = columns.map((column) => (isOwn ? el("th", { scope: "col" }, column.path)
      : this.head(column)));
    const body = first.map((row) => el("tr", {},
      ...columns.map(({ position }) => el("td", {}, row[position - 1]))));
    this.root.replaceChildren(
      el("h2", {}, isOwn ? t("sheet") : capitalised(sentenceInLanguage(about))),
      isOwn ? el("p", { class: "notice" }, t("sheetOwn")) : "",
      ...notes.map((note) => sentence("hint", sentenceInLanguage(note))),
      question === null || isOwn ? "" : sentence("hint", sentenceInLanguage(question)),
      parts.length > 1 ? this.choice(sheet) : "",
      isOwn ? "" : el("p", { class: "hint" }, t("sheetHint")),
      el("div", { class: "table-scroll", tabindex: "0", role: "region", "aria-label": t("sheet") },
        el("table", {}, el("thead", {}, el("tr", {}, ...heads)), el("tbody", {}, ...body))),
      el("p", { class: "hint" }, t("sheetRows", { shown: first.length, count: rows })));
  }

  /** @param {Sheet} sheet */
  choice({ parts, part }) {
    const { root, show } = choice(t("sheetPart"), (value) => this.changed({ part: Number(value) }), { isBeside: true });
    show(parts.map(({ name }, k) => ({ value: String(k), text: name })), String(part));
    return root;
  }

  /**
   * Return the head of a column: its name, what it is, and its unit where the file leaves it open.
   * @param {SheetColumn} column
   */
  head({ position, path, unit, unit_from: inferred, kind }) {
    const role = el("select", { "aria-label": t("roleOf", { name: path }), on: {
      change: () => this.changed({ roles: withRole(this.sheet?.roles ?? {}, position, role.value) }),
    } }, ...[NONE, ...Object.keys(this.roles)].map((each) =>
      el("option", { value: each }, t(`role_${each || "none"}`))));
    const units = el("select", { "aria-label": t("unitOf", { name: path }), on: {
      change: () => this.changed({ units: { ...this.sheet?.units, [position]: units.value } }) } });
    const stated = el("span", { class: "unit" }, unit && `[${shownUnit(unit)}]`);
    this.heads.push(() => {
      const { roles, units: chosenUnits } = /** @type {Sheet} */ (this.sheet);
      const now = roles[position] ?? NONE;
      const known = this.roles[now] ?? [];
      // One of something else is as good as none.
      const own = known.includes(chosenUnits[position]) ? chosenUnits[position] : "";
      // Times on a clock have no unit.
      const isOpen = known.length > 0 && kind !== "texts"
        && (inferred !== "" || !known.includes(unit));
      const listed = own ? known : ["", ...known];
      if (units.dataset.list !== listed.join()) {
        units.dataset.list = listed.join();
        units.replaceChildren(...listed.map((each) =>
          el("option", { value: each }, each ? shownUnit(each) : t("unitOpen"))));
      }
      role.value = now;
      units.value = own;
      units.hidden = !isOpen;
      // What the file states stays beside what is chosen instead.
      stated.hidden = isOpen && inferred !== "";
      units.setAttribute("aria-invalid", String(own === ""));
    });
    return el("th", { scope: "col" }, el("span", { class: "column" }, path, " ", stated), role, units);
  }
}

/**
 * Return the roles of columns after one of them took a role, which another one loses.
 * @param {Record<number, string>} roles
 * @param {number} position
 * @param {string} role
 */
function withRole(roles, position, role) {
  const others = Object.entries(roles).filter(([place, each]) =>
    Number(place) !== position && each !== role);
  return Object.fromEntries([...others, ...(role === NONE ? [] : [[position, role]])]);
}
