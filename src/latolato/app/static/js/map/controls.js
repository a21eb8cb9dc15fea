/** What can be chosen of a map: parameters, axes, observable, size, colours, what is drawn over. */

import { el, refresh, tick } from "../page/dom.js";
import { stopped } from "../page/refusals.js";
import { localShort, plainSymbol } from "../page/unit_text.js";
import { t } from "../strings.js";
import { firstStride, nameOf, PAGE, spaced, turned, USUAL_SIZE } from "./address.js";
import { variedBy } from "./choices.js";
import { SCALES } from "./colours.js";
import { choice, numberField } from "../page/fields.js";
import { OverControls } from "./overcontrols.js";

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("../page/knob.js").Knob} Knob */

// As in app.css.
const NARROW = "(max-width: 800px)";
const SIZES = [25, 50, 100, 200, 400];
const TIME = { unit: "s", units: [{ name: "s", size: 1 }] };
// What stays of an address when the map is of something else.
const KEPT = ["map.size", "map.scale", "map.contours"];

export class MapControls {
  /**
   * @param {any} registry
   * @param {import("../page/state.js").Store} store
   * @param {(files: import("./over.js").TextFile[]) => void} files called with tables of trials and of curves
   */
  constructor(registry, store, files) {
    this.registry = registry;
    this.store = store;
    /** @type {string[]} */
    this.stored = [];
    /** The map that was begun last. @type {import("./question.js").MapQuestion | null} */
    this.question = null;
    /** Fields of numbers by their keys in the address. @type {Record<string, Knob>} */
    this.numbers = {};
    /** The key of the number that was changed last. */
    this.last = "";
    const keep = (/** @type {Record<string, any>} */ values) => this.keep(values);
    this.source = choice(t("mapSource"), (value) => this.choose(value));
    this.about = el("p", { class: "hint" });
    this.sides = { x: this.side("x", "mapX", "mapLogX"), y: this.side("y", "mapY", "mapLogY") };
    this.observable = choice(t("mapObservable"), (v) => keep({ observable: v, low: null, high: null }));
    this.meaning = el("p", { class: "hint" });
    this.ball = choice(t("mapBall"), (v) => keep({ ball: v }));
    this.ball.root.hidden = true;
    this.select = el("div", { class: "fields" });
    this.size = choice(t("mapSize"), (v) => keep({ size: v || null }));
    /** What is of maps that the page computes. */
    this.computed = el("div", { class: "fields" }, this.size.root, this.number("duration", "mapDuration", TIME),
      this.number("transient", "mapTransient", TIME, t("mapTransientHint")));
    this.scale = choice(t("mapScale"), (v) => keep({ scale: v }));
    this.log = tick(t("mapLog"), (on) => keep({ log: on ? 1 : 0, low: null, high: null }));
    this.log.box.setAttribute("aria-label", t("mapLogColours"));
    /** Values of the darkest and the brightest colour on show. @type {[number, number]} */
    this.limits = [0, 1];
    this.ends = el("div", { class: "fields" });
    this.colours = el("div", { class: "fields" }, this.scale.root, this.log.root, this.ends);
    this.over = new OverControls(registry, keep, files);
    // A phone has the picture first.
    this.top = el("div", { class: "source" }, this.source.root, el("details", { class: "about", open: !matchMedia(NARROW).matches },
      el("summary", {}, t("presetAbout")), el("p", { class: "hint" }, t("mapIntro")), this.about));
    const group = (/** @type {string} */ title, /** @type {boolean} */ open, /** @type {Node[]} */ ...parts) =>
      el("details", { open }, el("summary", {}, t(title)), el("div", { class: "fields" }, ...parts));
    const { x, y } = this.sides;
    this.root = el("div", { class: "form" },
      group("mapAxes", true, x.name.root, x.ends, x.log.root, y.name.root, y.ends, y.log.root, this.select),
      group("mapWhat", true, this.observable.root, this.meaning, this.ball.root, this.computed),
      group("mapColours", false, this.colours), group("mapOver", false, ...this.over.parts));
  }

  /**
   * Return the fields of an axis.
   * @param {"x" | "y"} which
   * @param {string} title
   * @param {string} logTitle
   */
  side(which, title, logTitle) {
    const log = tick(t("mapLog"), (on) => this.keep(spaced(this.store.state.extra, this.question, which, on)));
    log.box.setAttribute("aria-label", t(logTitle));
    return { name: choice(t(title), (v) => this.keep(turned(this.store.state.extra, this.question, which, v))),
      ends: el("div", { class: "two" }), log };
  }

  /**
   * Return the field of a number that the address has under a key.
   * @param {string} key
   * @param {string} label
   * @param {import("../page/fields.js").Shown} quantity
   * @param {string} [hint]
   * @param {(value: number | null) => void} [take]
   */
  number(key, label, quantity, hint = "", take = (value) => this.keep({ [key]: value })) {
    this.numbers[key] = numberField(this.registry, t(label), quantity, (value) => {
      this.last = key;
      take(value);
    }, { hint, mayBeEmpty: ["low", "high"].includes(key) });
    return this.numbers[key].root;
  }

  /**
   * Keep values of the view in the address; null takes one out.
   * @param {Record<string, any>} values
   */
  keep(values) {
    const extra = { ...this.store.state.extra };
    for (const [name, value] of Object.entries(values)) {
      if (value === null) delete extra[`map.${name}`];
      else extra[`map.${name}`] = String(value);
    }
    this.store.set({ extra }, "extra");
  }

  /**
   * Keep an end of the colours, null for the usual one; one beyond the other end is refused.
   * @param {"low" | "high"} side
   * @param {(number | null)[]} ends
   * @param {number | null} value
   */
  limit(side, [low, high], value) {
    if (this.log.box.checked && value !== null && value <= 0) this.numbers[side].refuse(t("mapLogLimit"), null);
    else if (low === null || high === null || low < high) this.keep({ [side]: value });
    else this.numbers[side].refuse(t("mapLimits"), null);
  }

  /** @param {string} value */
  choose(value) {
    const { extra, options, scenario } = this.store.state;
    const kept = Object.fromEntries(Object.entries(extra).filter(([name]) =>
      !name.startsWith("map.") || KEPT.includes(name)));
    const isPage = value === PAGE;
    kept[value.startsWith("f:") ? "map.stored" : "map.scenario"] = isPage ? PAGE : value.slice(2);
    this.store.set({ extra: kept, options: isPage ? options : {}, scenario: isPage ? scenario : null }, "preset");
  }

  /**
   * Say at a field why the map was refused: at the one of these that was changed last. Null takes it away.
   * @param {string | null} text
   * @param {string[]} [names]
   */
  refuse(text, names = []) {
    const own = names.filter((name) => name in this.numbers);
    const chosen = own.includes(this.last) ? this.last : own[0];
    for (const [name, field] of Object.entries(this.numbers)) field.error(name === chosen ? text : null);
  }

  /**
   * Show where the parameters come from.
   * @param {{scenario: string | null, stored: string | null}} from
   */
  showSource({ scenario, stored }) {
    const sweeps = Object.entries(this.registry.scenarios).filter(([, s]) => s.sweep);
    const called = (/** @type {any} */ s) => (s.figure ? t("mapFigure", { title: s.title, figure: s.figure }) : s.title);
    const entries = [
      ...sweeps.map(([name, s]) => ({ value: `s:${name}`, title: s.description, text: called(s), group: t("mapShipped") })),
      ...this.stored.map((name) => ({ value: `f:${name}`, text: name, group: t("mapStored") })),
      { value: PAGE, text: t("mapPage"), group: t("mapOwn") },
    ];
    this.source.show(entries, stored ? `f:${stored}` : scenario ? `s:${scenario}` : PAGE);
    if (stored) return;
    const sweep = this.registry.scenarios[scenario ?? ""];
    // The whole name: the box above may be too narrow for its end.
    this.about.replaceChildren(...(sweep ? [el("strong", {}, stopped(called(sweep))), " ", sweep.description] : []));
  }

  /** Show how many points the address asks for, also where they are none of the usual numbers. */
  showSize() {
    const size = this.store.state.extra["map.size"] ?? "";
    const sizes = [...new Set([...SIZES, Number(size) || USUAL_SIZE])].sort((a, b) => a - b);
    this.size.show([{ value: "", text: t("mapSizeFirst", { n: USUAL_SIZE / firstStride() }) },
      ...sizes.map((n) => ({ value: String(n), text: t("mapSizeText", { n, points: n * n }) }))], size);
  }

  /**
   * Show what a computed map may be made of.
   * @param {import("./question.js").MapQuestion} question
   */
  showChoices(question) {
    const { registry, options, choices, shown, duration, transient } = this.question = question;
    const names = variedBy(registry, options).map((name) => {
      const { label, symbol } = registry.axes[name];
      return { value: name, text: `${label} ${plainSymbol(symbol)}`.trim(), title: name };
    });
    for (const [which, { name, ends, log }] of this.eachSide()) {
      const axis = question[which];
      const keep = (/** @type {string} */ key) => (/** @type {number | null} */ value) =>
        this.keep({ [which]: nameOf(this.store.state.extra, this.question, which), [key]: value });
      name.show(names, axis.name);
      refresh(ends, axis.name, () => [["low", "mapFrom"], ["high", "mapTo"]].map(([side, label]) =>
        this.number(which + side, label, axis, "", keep(which + side))));
      this.numbers[`${which}low`].read(String(axis.low));
      this.numbers[`${which}high`].read(String(axis.high));
      log.box.checked = axis.log;
      log.text.textContent = t("mapLog");
    }
    this.observable.show(choices.map(({ name, label, description, together }) => ({ value: name, text: label,
      title: description, group: t(together ? "mapTogether" : "mapAlone") })), shown);
    this.numbers.duration.read(String(duration));
    this.numbers.transient.read(String(transient));
    this.select.replaceChildren();
    this.showComputed(true);
  }

  /** Return both axes with their fields. */
  eachSide() {
    return /** @type {["x" | "y", MapControls["sides"]["x"]][]} */ (Object.entries(this.sides));
  }

  /** @param {boolean} isComputed whether the map on show is computed, and not stored */
  showComputed(isComputed) {
    for (const { name, ends } of Object.values(this.sides)) name.root.hidden = ends.hidden = !isComputed;
    this.computed.hidden = !isComputed;
  }

  /**
   * Show what a stored map may be looked at by.
   * @param {Grid} grid
   */
  showStored(grid) {
    const { about } = grid;
    const stored = /** @type {import("./grid.js").Stored} */ (about.stored);
    this.observable.show(stored.names.map((name) => ({ value: name, text: this.labelOf(name) })),
      about.observable);
    for (const [which, { log }] of this.eachSide()) {
      log.box.checked = grid[which].log;
      log.text.textContent = t("mapLogOf", { name: grid[which].label });
    }
    this.select.replaceChildren(...stored.select.map(({ dim, label, values, unit, index }) => {
      const made = choice(this.labelOf(dim, label), (v) => this.keep({ [`at_${dim}`]: v, at: null }));
      made.show(values.map((/** @type {string} */ v, /** @type {number} */ i) => ({ value: String(i), text: unit === "1" ? v : `${v} ${unit}` })), String(index));
      return made.root;
    }));
    this.about.textContent = stored.description.replace(/\$([^$]+)\$/g,
      (/** @type {string} */ _, /** @type {string} */ tex) => plainSymbol(tex));
    this.showComputed(false);
  }

  /**
   * @param {string} name
   * @param {string} [other]
   */
  labelOf(name, other = name) {
    for (const { variables } of /** @type {any[]} */ (Object.values(this.registry.observables)))
      if (name in variables) return variables[name].label;
    return this.registry.quantities[name]?.label ?? other;
  }

  /**
   * Show how values become colours.
   * @param {Grid} grid
   * @param {import("./chart.js").Look} look
   */
  showLook(grid, { variable: k, scale, log, limits }) {
    const { extra } = this.store.state;
    const variable = grid.variables[k];
    this.observable.select.value = variable.name;
    this.scale.show(SCALES.map((name) => ({ value: name, text: name })), scale);
    this.log.box.checked = log;
    this.limits = limits;
    refresh(this.ends, variable.name, () => [
      this.number("low", "mapLow", variable, "", (value) => this.limit("low", [value, this.limits[1]], value)),
      this.number("high", "mapHigh", variable, "", (value) => this.limit("high", [this.limits[0], value], value))]);
    for (const [i, side] of ["low", "high"].entries()) {
      const field = this.numbers[side];
      field.read(`map.${side}` in extra ? String(limits[i]) : null);
      field.input.placeholder = localShort(limits[i] / field.unit.size, 4);
    }
    this.colours.hidden = variable.classes.length > 0;
    const balls = grid.variables.filter((v) => v.name === variable.name && v.ball);
    this.ball.root.hidden = balls.length < 2;
    this.ball.show(balls.map((v) => ({ value: v.ball ?? "", text: t(v.ball ?? "right") })),
      variable.ball ?? "");
    const known = Object.values(this.registry.observables).find((/** @type {any} */ o) => variable.name in o.variables);
    this.meaning.textContent = (/** @type {any} */ (known)?.description ?? "")
      .replaceAll("`", "").replaceAll("+-", "±").replaceAll("_", " ");
  }
}
