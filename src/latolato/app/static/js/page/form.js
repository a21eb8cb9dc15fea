/** Fields for every parameter of a system and a drive, made from the server's registry. */

import { t, tr } from "../strings.js";
import { el, freshId } from "./dom.js";
import { readEntry, readQuantity } from "./entry.js";
import { choice } from "./fields.js";
import { explanation, Knob, symbolOf } from "./knob.js";
import { heldOptions, hungOn, START, textIn, textsOf, withLaws, withOptions } from "./option_texts.js";
import { localShort, shownUnit } from "./unit_text.js";

/** @typedef {import("./state.js").Store} Store */
/** @typedef {import("./option_texts.js").FieldOption} FieldOption */

// What only balls on strings have.
const OF_STRINGS = ["string_restitution", "initial_distance"];
// What a run can do without: taut strings begin at their length.
const MAY_BE_EMPTY = ["initial_distance"];

export class Form {
  /**
   * @param {HTMLElement} root
   * @param {any} registry
   * @param {Store} store
   * @param {() => Partial<import("./state.js").State>} [beside] what changes in the same step as an option
   */
  constructor(root, registry, store, beside = () => ({})) {
    this.root = root;
    this.registry = registry;
    this.store = store;
    this.beside = beside;
    /** @type {Record<string, any>} */
    this.resolved = {};
    /** @type {Map<string, {read: (text: any) => void, error: (text: string | null) => void,
     *   forget?: () => void, isRefused?: () => boolean, unit?: () => import("./unit_text.js").Unit}>} */
    this.fields = new Map();
    this.shape = "";
    /** The units that fields have shown, by option. @type {Record<string, string>} */
    this.units = {};
    /** Options that have no one value here, as they vary over a map. */
    this.varied = /** @type {Set<string>} */ (new Set());
    this.openGroups = new Set(["system", "drive", "start"]);
    this.general = el("p", { class: "error", role: "alert", hidden: true });
  }

  /** Return the kinds of system and drive on show. */
  get kinds() {
    const { options } = this.store.state;
    const { systems, drives } = this.registry;
    const { system, drive } = options;
    return {
      system: Object.hasOwn(systems, system) ? system : this.resolved.system ?? "latolato",
      drive: Object.hasOwn(drives, drive) ? drive : this.resolved.drive ?? "fixed_pivot",
    };
  }

  /**
   * Show what a run had.
   * @param {Record<string, any>} resolved options in SI units
   */
  show(resolved) {
    this.resolved = resolved;
    this.error(null);
    this.build();
    this.read();
  }

  /** The registry, in which options have the units that their fields show. */
  get registryInWords() {
    const options = { ...this.registry.options };
    for (const [name, { unit }] of this.fields)
      if (unit && name in options) options[name] = { ...options[name], units: [unit()] };
    return { ...this.registry, options };
  }

  /** Show what the options are now. */
  read() {
    for (const [name, field] of this.fields) field.read(this.text(name));
  }

  /** Forget what was typed and refused. */
  forget() {
    for (const { forget } of this.fields.values()) forget?.();
  }

  /**
   * Show why a run was refused, beside the field that it is about.
   * @param {string | null} text
   * @param {string | null} [field]
   */
  error(text, field = null) {
    this.build();
    for (const [name, each] of this.fields) each.error(name === field ? text : null);
    const own = text !== null && !this.root.querySelector(".field .error:not([hidden])");
    if (text !== null && !own)
      for (const place of this.root.querySelectorAll("details"))
        if (place.querySelector(".error:not([hidden])")) place.open = true;
    this.general.hidden = !own;
    this.general.textContent = own ? text : "";
  }

  /**
   * Return the text of an option: what the user gave, else what the run had.
   * @param {string} name
   * @returns {string | null}
   */
  text(name) {
    return textIn(this.registry, this.store.state.options, this.resolved, name);
  }

  /**
   * Set one option, and take back those that say the same in another way.
   * @param {string} name
   * @param {string | null} text
   */
  give(name, text) {
    this.giveAll({ [name]: text });
  }

  /**
   * Set some options, null takes one back, and take back those that cannot be given beside them.
   * @param {Record<string, string | null>} changed
   */
  giveAll(changed) {
    this.set(withOptions(this.registry, this.store.state.options, changed));
  }

  /** Put these options into the state. @param {Record<string, string>} options */
  set(options) {
    this.store.set({ ...this.beside(), options });
  }

  build() {
    const { system, drive } = this.kinds;
    const offset = this.text("initial_offset") !== null;
    const isString = this.text("suspension") === "string";
    const shape = JSON.stringify([system, drive, offset, isString, [...this.varied]]);
    if (shape === this.shape) return;
    this.shape = shape;
    // New fields keep the units of those that they replace.
    for (const [name, { unit }] of this.fields) if (unit) this.units[name] = unit().name;
    this.fields.clear();
    const laws = { system, drive };
    const isShown = (/** @type {string} */ name) => isString || !OF_STRINGS.includes(name);
    const groups = /** @type {const} */ (["system", "drive"]).map((part) => this.group(
      part, this.withRatios(this.registry[`${part}s`][laws[part]].options).filter(isShown)));
    const start = START.filter((name) => name !== (offset ? "initial_angle" : "initial_offset")).filter(isShown);
    const rest = Object.keys(this.registry.options).filter((name) =>
      ["tolerance", "contact", "rest_speed"].includes(name));
    this.root.replaceChildren(
      this.general, ...groups, this.group("start", start), this.group("solver", rest));
  }

  /**
   * Return options with the ratio to the natural frequency after each driving frequency.
   * @param {string[]} names
   */
  withRatios(names) {
    const ratios = Object.entries(this.registry.ratios);
    return names.flatMap((name) => [name, ...ratios.filter(([ratio, frequency]) =>
      frequency === name && !this.registry.options[ratio].several).map(([ratio]) => ratio)]);
  }

  /**
   * @param {"system" | "drive" | "start" | "solver"} part
   * @param {string[]} names
   */
  group(part, names) {
    const body = el("div", { class: "fields" });
    if (part === "system" || part === "drive") body.append(this.choice(part));
    const lists = names.filter((name) => this.registry.options[name].several && name !== "times");
    if (lists.length > 1) body.append(this.table(lists));
    for (const name of names) if (!lists.includes(name) || lists.length < 2) body.append(this.field(name));
    return el("details", {
      open: this.openGroups.has(part),
      on: { toggle: (/** @type {Event} */ e) => {
        const open = /** @type {HTMLDetailsElement} */ (e.target).open;
        this.openGroups[open ? "add" : "delete"](part);
      } },
    }, el("summary", {}, t(part)), body);
  }

  /** @param {"system" | "drive"} part */
  choice(part) {
    // Measured heights come from an experiment, not from a form.
    const laws = Object.fromEntries(Object.entries(this.registry[`${part}s`]).filter(([name, law]) =>
      name === this.kinds[part] || /** @type {any} */ (law).options.every((/** @type {string} */ o) =>
        this.registry.options[o].default !== null || this.registry.options[o].usual !== null)));
    const { root, select, show } = choice(t(part), (value) => {
      const kinds = { ...this.kinds, [part]: value };
      this.set(withLaws(this.registry, heldOptions(this.registry, this.store.state.options, this.resolved,
        this.kinds, kinds), this.resolved, kinds.system, kinds.drive));
    }, { isBeside: true });
    show(Object.entries(laws).map(([value, { title, description }]) => ({ value, title: description, text: tr(title) })),
      this.kinds[part]);
    this.fields.set(part, { read: () => { select.value = this.kinds[part]; }, error: () => {} });
    return root;
  }

  /** @param {string} name */
  field(name) {
    /** @type {FieldOption} */
    const option = this.registry.options[name];
    if (this.varies(name))
      return el("div", { class: "field" }, el("span", {}, `${this.label(name, option)} `, symbolOf(option)),
        el("span", { class: "soft" }, t("mapVaries")));
    const { choices } = option;
    if (option.switch) return this.switchField(name, option);
    if (choices.length) return this.choiceField(name, option, choices);
    return this.numberField(name, option);
  }

  /**
   * Return whether an option, or the ratio equivalent to it, varies here.
   * @param {string} name
   */
  varies(name) {
    const twins = Object.entries(this.registry.ratios ?? {}).find((pair) => pair.includes(name));
    return (twins ?? [name]).some((each) => this.varied.has(each));
  }

  /**
   * @param {string} name
   * @param {FieldOption} option
   */
  label(name, option) {
    const side = /^(right|left)_/.exec(name)?.[1];
    return side ? `${option.label}, ${t(side)}` : option.label;
  }

  /**
   * @param {string} name
   * @param {FieldOption} option
   * @param {boolean} [mayBeEmpty]
   */
  numberField(name, option, mayBeEmpty = MAY_BE_EMPTY.includes(name)) {
    const knob = new Knob(name, option, { label: this.label(name, option),
      isList: this.isList(option), mayBeEmpty, registry: this.registry, unitChosen: () => this.read(),
      take: (text) => this.give(name, text || null) });
    knob.chosen = this.units[name] ?? "";
    const read = (/** @type {string | null} */ text) =>
      knob.read(text, this.store.state.options[name] !== undefined);
    this.fields.set(name, { read, error: (text) => knob.error(text), forget: () => knob.forget(),
      isRefused: () => knob.isRefused, unit: () => knob.unit });
    read(this.text(name));
    return knob.root;
  }

  /**
   * Return whether an option takes several numbers.
   * @param {FieldOption} option
   */
  isList(option) {
    return option.several
      || (option.for_each_ball === true && this.registry.systems[this.kinds.system].angles === 2);
  }

  /**
   * @param {string} name
   * @param {FieldOption} option
   */
  switchField(name, option) {
    const [id, aboutId] = [freshId(), freshId()];
    const box = el("input", { id, type: "checkbox", on: { change: () =>
      this.give(name, box.checked ? "true" : "false") } });
    this.fields.set(name, { read: (text) => { box.checked = text === "true"; }, error: () => {} });
    box.checked = this.text(name) === "true";
    return el("div", { class: "field choice" },
      el("label", { for: id }, option.isExplained ? option.label : option.description), box, explanation(option, aboutId));
  }

  /**
   * @param {string} name
   * @param {FieldOption} option
   * @param {string[]} choices
   */
  choiceField(name, option, choices) {
    const { root, select, show } = choice(option.label || option.description, (value) => (name === "suspension"
      ? this.giveAll(hungOn(this.store.state.options, this.resolved, value))
      : this.give(name, value)), { isBeside: true });
    show(choices.map((value) => ({ value, text: option.labels?.[value] ?? tr(value) })), this.text(name) ?? choices[0]);
    this.fields.set(name, { read: (text) => { select.value = text ?? choices[0]; }, error: () => {} });
    const about = explanation(option, freshId());
    if (about) root.append(about);
    return root;
  }

  /**
   * Return choices whose values are one text, with commas between.
   * @param {string} name
   * @param {FieldOption} option
   * @param {string[]} labels of each choice
   */
  choicesField(name, option, labels) {
    const aboutId = freshId();
    const values = (/** @type {string | null} */ text) => (text ?? "").split(",").map((each) => each.trim());
    const fields = labels.map((label) => choice(label, () =>
      this.give(name, fields.map(({ select }) => select.value).join(", ")), { isBeside: true }));
    const entries = option.choices.map((value) => ({ value, text: option.labels?.[value] ?? tr(value) }));
    const read = (/** @type {string | null} */ text) => fields.forEach(({ show }, k) => show(entries, values(text)[k] ?? ""));
    this.fields.set(name, { read, error: () => {} });
    read(this.text(name));
    return el("div", { class: "field", role: "group", "aria-label": option.label },
      ...fields.map(({ root }) => root), explanation(option, aboutId));
  }

  /**
   * Return a table whose columns are lists of one length: stages of a schedule, heights of a pivot.
   * @param {string[]} names
   */
  table(names) {
    /** @type {FieldOption[]} */
    const options = names.map((name) => this.registry.options[name]);
    const unit = (/** @type {number} */ k) => options[k].units[0] ?? { name: "", size: 1 };
    const body = el("tbody", {});
    const error = el("p", { class: "error", hidden: true });
    /** @type {number[][]} */
    let columns = names.map(() => []);
    const write = () => {
      this.giveAll(textsOf(this.registry, Object.fromEntries(names.map((name, k) => [name, columns[k]]))));
    };
    const texts = () => JSON.stringify(columns.map((column, k) => column.map((v) => localShort(v / unit(k).size))));
    /** What is on show: the cells, in one of which somebody may type, stay until it changes. */
    let shown = "";
    const draw = () => {
      if (texts() === shown) return;
      shown = texts();
      body.replaceChildren(...columns[0].map((_, i) => el("tr", {},
        ...names.map((_name, k) => el("td", {}, el("input", {
          type: "text", inputmode: "decimal",
          "aria-label": `${options[k].description || options[k].label} ${i + 1}`,
          value: localShort((columns[k][i] ?? NaN) / unit(k).size),
          on: { change: (/** @type {Event} */ e) => {
            const input = /** @type {HTMLInputElement} */ (e.target);
            const { values: [value], problem } = readEntry(input.value,
              { registry: this.registry, usual: unit(k), unit: options[k].unit,
                example: localShort(columns[k][i] / unit(k).size) });
            input.setAttribute("aria-invalid", String(problem !== null));
            if (problem !== null) {
              error.hidden = false;
              error.textContent = problem;
              return;
            }
            columns[k][i] = value;
            input.value = localShort(value / unit(k).size);
            shown = texts();
            write();
          } },
        }))),
        el("td", {}, el("button", { type: "button", class: "plain",
          disabled: columns[0].length < 2,
          "aria-label": t("removeRow", { number: i + 1 }),
          on: { click: () => {
            columns.forEach((c) => c.splice(i, 1));
            write();
          } } }, "×")))));
    };
    names.forEach((name, k) => this.fields.set(name, {
      read: (text) => {
        columns[k] = (text ?? "").split(",").filter(Boolean).map((/** @type {string} */ part) =>
          readQuantity(this.registry, part, options[k].unit).value);
        draw();
      },
      error: (text) => {
        if (k > 0 && text === null && !error.hidden) return;
        error.hidden = text === null;
        error.textContent = text ?? "";
      },
    }));
    for (const name of names) this.fields.get(name)?.read(this.text(name));
    const add = el("button", { type: "button", class: "plain", on: { click: () => {
      const rows = Math.max(...columns.map((c) => c.length));
      columns.forEach((c, k) => {
        while (c.length < rows) c.push(c[c.length - 1] ?? 0); // a column that an address left short
        const last = c[c.length - 1] ?? 0;
        c.push(k === 0 ? last + (c.length > 1 ? last - c[c.length - 2] : 1) : last);
      });
      write();
    } } }, t("addRow"));
    return el("div", { class: "field list" },
      el("table", {}, el("thead", {}, el("tr", {},
        ...options.map((o, k) => el("th", { scope: "col" },
          `${o.description || o.label} [${shownUnit(unit(k).name)}]`)), el("td", {}))), body), add, error);
  }
}
