/** What can be chosen of a map: parameters, axes, observable, size, colours, what is drawn over. */

import { el } from "../page/dom.js";
import { stopped } from "../page/link_parts.js";
import { plainSymbol } from "../page/unit_text.js";
import { t } from "../strings.js";
import { ended, firstStride, PAGE, spaced, turned, USUAL_SIZE } from "./address.js";
import { SCALES } from "./colours.js";
import { choice, QuantityField, tick } from "./fields.js";
import { OverControls } from "./overcontrols.js";

/** @typedef {import("../page/state.js").Store} Store */
/** @typedef {import("./grid.js").Grid} Grid */

const SIZES = [25, 50, 100, 200, 400];

export class MapControls {
  /**
   * @param {any} registry
   * @param {Store} store
   * @param {(texts: string[]) => void} files called with the texts of tables of trials and of curves
   */
  constructor(registry, store, files) {
    this.registry = registry;
    this.store = store;
    /** @type {string[]} */
    this.stored = [];
    const set = (/** @type {Record<string, any>} */ values) => this.keep(values);
    const number = (/** @type {string} */ name, /** @type {string} */ key, hint = "") =>
      new QuantityField(registry, t(name), (v) => set({ [key]: v }), { hint: hint ? t(hint) : "" });
    this.source = choice(t("mapSource"), (value) => this.choose(value));
    this.about = el("p", { class: "hint" });
    this.x = choice(t("mapX"), (v) => set(turned(this.now(), "x", v)));
    this.y = choice(t("mapY"), (v) => set(turned(this.now(), "y", v)));
    const log = (/** @type {"x" | "y"} */ which, /** @type {string} */ name) => {
      const made = tick(t("mapLog"), (on) => set(spaced(this.now(), which, on)));
      made.box.setAttribute("aria-label", t(name));
      return made;
    };
    this.logs = { x: log("x", "mapLogX"), y: log("y", "mapLogY") };
    const end = (/** @type {string} */ name, /** @type {"x" | "y"} */ which,
      /** @type {"low" | "high"} */ side) => new QuantityField(registry, t(name), (value) =>
      set(ended(this.now(), which, side, value)));
    this.ends = { xlow: end("mapFrom", "x", "low"), xhigh: end("mapTo", "x", "high"),
      ylow: end("mapFrom", "y", "low"), yhigh: end("mapTo", "y", "high") };
    /** @type {any} */
    this.choices = null;
    this.observable = choice(t("mapObservable"), (v) =>
      set({ observable: v, low: null, high: null }));
    this.meaning = el("p", { class: "hint" });
    this.ball = choice(t("mapBall"), (v) => set({ ball: v }));
    this.ball.root.hidden = true;
    this.select = el("div", { class: "fields" });
    this.size = choice(t("mapSize"), (v) => set({ size: v || null }));
    this.duration = number("mapDuration", "duration");
    this.transient = number("mapTransient", "transient", "mapTransientHint");
    this.scale = choice(t("mapScale"), (v) => set({ scale: v }));
    this.log = tick(t("mapLog"), (on) => set({ log: on ? 1 : 0, low: null, high: null }));
    this.low = new QuantityField(registry, t("mapLow"), (v) => this.limit("low", v),
      { mayBeEmpty: true });
    this.high = new QuantityField(registry, t("mapHigh"), (v) => this.limit("high", v),
      { mayBeEmpty: true });
    /** @type {[number, number]} values of the darkest and the brightest colour on show */
    this.limits = [0, 1];
    this.log.box.setAttribute("aria-label", t("mapLogColours"));
    this.over = new OverControls(registry, set, files);
    this.top = el("div", { class: "source" }, this.source.root,
      el("p", { class: "hint" }, t("mapIntro")), this.about);
    this.root = el("div", { class: "form" },
      this.group("mapAxes", true, this.x.root, this.pair("xlow", "xhigh"), this.logs.x.root,
        this.y.root, this.pair("ylow", "yhigh"), this.logs.y.root, this.select),
      this.group("mapWhat", true, this.observable.root, this.meaning, this.ball.root,
        this.size.root, this.duration.root, this.transient.root),
      this.group("mapColours", false, this.scale.root, this.log.root,
        this.low.root, this.high.root),
      this.group("mapOver", false, ...this.over.parts));
  }

  /**
   * @param {string} title
   * @param {boolean} open
   * @param {...Node} parts
   */
  group(title, open, ...parts) {
    return el("details", { open }, el("summary", {}, t(title)),
      el("div", { class: "fields" }, ...parts));
  }

  /**
   * @param {"xlow" | "ylow"} low
   * @param {"xhigh" | "yhigh"} high
   */
  pair(low, high) {
    return el("div", { class: "two" }, this.ends[low].root, this.ends[high].root);
  }

  /** Return the axes as the address has them; what was on show last may be out of date. */
  now() {
    return { extra: this.store.state.extra, shown: this.choices };
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
   * Keep an end of the colours; one beyond the other end is refused.
   * @param {"low" | "high"} side
   * @param {number | null} value
   */
  limit(side, value) {
    const [low, high] = this.limits;
    const fits = value === null || (side === "low" ? value < high : value > low);
    if (fits) this.keep({ [side]: value });
    else this[side].problem.show(t("mapLimits"));
  }

  /** @param {string} value */
  choose(value) {
    const { extra } = this.store.state;
    const kept = Object.fromEntries(Object.entries(extra).filter(([name]) =>
      !name.startsWith("map.") || ["map.size", "map.scale", "map.contours"].includes(name)));
    const [kind, name] = value === PAGE ? ["", ""] : [value.slice(0, 1), value.slice(2)];
    if (kind === "s" || value === PAGE) kept["map.scenario"] = name || PAGE;
    if (kind === "f") kept["map.stored"] = name;
    const options = value === PAGE ? this.store.state.options : {};
    const scenario = value === PAGE ? this.store.state.scenario : null;
    this.store.set({ extra: kept, options, scenario }, "preset");
  }

  /**
   * Say at a field why the map was refused: at the one of these that was changed last. Null takes it away.
   * @param {string | null} text
   * @param {string[]} [names]
   */
  refuse(text, names = []) {
    /** @type {Record<string, QuantityField>} */
    const fields = { ...this.ends, duration: this.duration, transient: this.transient };
    const own = names.filter((name) => name in fields);
    const chosen = own.find((name) => fields[name].isNew) ?? own[0];
    for (const [name, field] of Object.entries(fields)) field.refuse(name === chosen ? text : null);
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
   * @param {import("./about.js").Choices} choices
   */
  showChoices(choices) {
    this.choices = choices;
    const axes = choices.axes.map((/** @type {any} */ a) => {
      const symbol = plainSymbol(a.symbol);
      const text = `${a.label}${symbol ? ` ${symbol}` : ""}`;
      return { value: a.name, text, title: a.name };
    });
    this.x.show(axes, choices.x.name);
    this.y.show(axes, choices.y.name);
    const { axes: known } = this.registry;
    for (const which of /** @type {("x" | "y")[]} */ (["x", "y"])) {
      const axis = known[choices[which].name];
      this.ends[`${which}low`].show(choices[which].low, axis);
      this.ends[`${which}high`].show(choices[which].high, axis);
      this.logs[which].box.checked = choices[which].log;
    }
    this.observable.show(choices.variables.map((/** @type {any} */ v) => ({ value: v.name,
      text: v.label, title: v.description,
      group: t(v.together ? "mapTogether" : "mapAlone") })), choices.observable);
    const seconds = { unit: "s", units: [{ name: "s", size: 1 }, { name: "min", size: 60 }] };
    this.duration.show(choices.duration, seconds);
    this.transient.show(choices.transient, seconds);
    this.parts(true);
  }

  /**
   * Show what a stored map may be looked at by.
   * @param {import("./grid.js").Begin["about"]} about
   */
  showStored(about) {
    const stored = /** @type {import("./grid.js").Stored} */ (about.stored);
    this.observable.show(stored.names.map((name) => ({ value: name, text: this.labelOf(name) })),
      about.observable);
    for (const which of /** @type {("x" | "y")[]} */ (["x", "y"])) {
      this.logs[which].box.checked = about[which].log;
      this.logs[which].text.textContent = t("mapLogOf", { name: about[which].label });
    }
    this.select.replaceChildren(...stored.select.map((/** @type {any} */ each) => {
      const label = this.labelOf(each.dim, each.label);
      const made = choice(label, (v) => this.keep({ [`at_${each.dim}`]: v, at: null }));
      made.show(each.values.map((/** @type {string} */ v, /** @type {number} */ i) =>
        ({ value: String(i), text: each.unit === "1" ? v : `${v} ${each.unit}` })),
      String(each.index));
      return made.root;
    }));
    this.about.textContent = stored.description.replace(/\$([^$]+)\$/g,
      (/** @type {string} */ _, /** @type {string} */ tex) => plainSymbol(tex));
    this.parts(false);
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

  /** @param {boolean} computed */
  parts(computed) {
    const ends = Object.values(this.ends).map((end) => end.root);
    for (const part of [this.x.root, this.y.root, this.size.root, this.duration.root,
      this.transient.root, ...ends]) part.hidden = !computed;
    if (!computed) return;
    this.select.replaceChildren();
    for (const { text } of Object.values(this.logs)) text.textContent = t("mapLog");
  }

  /**
   * Show how values become colours.
   * @param {Grid} grid
   * @param {import("./chart.js").Look} look
   */
  showLook(grid, look) {
    const { extra } = this.store.state;
    const variable = grid.variables[look.variable];
    this.scale.show(SCALES.map((name) => ({ value: name, text: name })), look.scale);
    this.log.box.checked = look.log;
    this.limits = look.limits;
    this.low.show(look.limits[0], variable, "map.low" in extra);
    this.high.show(look.limits[1], variable, "map.high" in extra);
    const classes = variable.classes.length > 0;
    for (const part of [this.scale.root, this.log.root, this.low.root, this.high.root])
      part.hidden = classes;
    const balls = grid.variables.filter((v) => v.name === variable.name && v.ball);
    this.ball.root.hidden = balls.length < 2;
    this.ball.show(balls.map((v) => ({ value: v.ball ?? "", text: t(v.ball ?? "right") })),
      variable.ball ?? "");
    const known = Object.values(this.registry.observables).find((/** @type {any} */ o) =>
      variable.name in o.variables);
    const words = /** @type {any} */ (known)?.description ?? "";
    const plain = words.replaceAll("`", "").replaceAll("+-", "±").replaceAll("_", " ");
    this.meaning.textContent = plain;
  }
}
