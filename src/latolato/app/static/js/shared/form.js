/** Fields for every parameter of a system and a drive, made from the server's registry. */

import { t } from "../strings.js";
import { el, freshId } from "./dom.js";
import { habit, keepHabit } from "./habits.js";
import { heldOptions, START, textOf, withLaws } from "./laws.js";
import { parseQuantity, short, shownUnit, symbolParts, toSi } from "./units.js";

/** @typedef {import("./state.js").Store} Store */
/** @typedef {import("./laws.js").Option} Option */

// A slider moves in so many steps.
const STEPS = 400;

export class Form {
  /**
   * @param {HTMLElement} root
   * @param {any} registry
   * @param {Store} store
   */
  constructor(root, registry, store) {
    this.root = root;
    this.registry = registry;
    this.store = store;
    /** @type {Record<string, any>} */
    this.resolved = {};
    /** @type {Map<string, {read: (text: any) => void, error: (text: string | null) => void}>} */
    this.fields = new Map();
    this.shape = "";
    /** @type {Record<string, string>} units that were chosen, by option */
    this.units = {};
    /** Options that have no one value here, as they vary over a map. */
    this.varied = /** @type {Set<string>} */ (new Set());
    this.openGroups = new Set([t("system"), t("drive"), t("start")]);
    this.general = el("p", { class: "error", role: "alert", hidden: true });
  }

  /** Return the element that has the focus, also inside of a root of its own. */
  get focused() {
    return /** @type {Document | ShadowRoot} */ (this.root.getRootNode()).activeElement;
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
    for (const [name, field] of this.fields) field.read(this.text(name));
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
    const text = this.store.state.options[name];
    if (text !== undefined) return text;
    const value = this.resolved[name] ?? this.registry.options[name].default;
    return value === undefined || value === null ? null : textOf(this.registry.options[name], value);
  }

  build() {
    const { system, drive } = this.kinds;
    const offset = this.text("initial_offset") !== null;
    const shape = JSON.stringify([system, drive, offset, [...this.varied]]);
    if (shape === this.shape) return;
    this.shape = shape;
    this.fields.clear();
    const laws = { system, drive };
    const groups = /** @type {const} */ (["system", "drive"]).map((part) => this.group(
      t(part), part, this.registry[`${part}s`][laws[part]].options));
    const start = START.filter((name) => name !== (offset ? "initial_angle" : "initial_offset"));
    const rest = Object.keys(this.registry.options).filter((name) =>
      ["tolerance", "contact", "rest_speed"].includes(name));
    this.root.replaceChildren(
      this.general, ...groups, this.group(t("start"), null, start), this.group(t("more"), null, rest));
  }

  /**
   * @param {string} title
   * @param {"system" | "drive" | null} part
   * @param {string[]} names
   */
  group(title, part, names) {
    const body = el("div", { class: "fields" });
    if (part) body.append(this.choice(part));
    const lists = names.filter((name) => this.registry.options[name].several && name !== "times");
    if (lists.length > 1) body.append(this.table(lists));
    for (const name of names) if (!lists.includes(name) || lists.length < 2) body.append(this.field(name));
    return el("details", {
      open: this.openGroups.has(title),
      on: { toggle: (/** @type {Event} */ e) => {
        const open = /** @type {HTMLDetailsElement} */ (e.target).open;
        this.openGroups[open ? "add" : "delete"](title);
      } },
    }, el("summary", {}, title), body);
  }

  /** @param {"system" | "drive"} part */
  choice(part) {
    // Measured heights come from an experiment, not from a form.
    const laws = Object.fromEntries(Object.entries(this.registry[`${part}s`]).filter(([name, law]) =>
      name === this.kinds[part] || /** @type {any} */ (law).options.every((/** @type {string} */ o) =>
        this.registry.options[o].default !== null || this.registry.options[o].usual !== null)));
    const id = freshId();
    const select = el("select", { id, on: { change: () => {
      const kinds = { ...this.kinds, [part]: select.value };
      this.store.set({ options: withLaws(this.registry, heldOptions(this.registry,
        this.store.state.options, this.resolved, this.kinds, kinds), this.resolved, kinds.system,
      kinds.drive) });
    } } }, ...Object.entries(laws).map(([name, law]) =>
      el("option", { value: name, title: /** @type {any} */ (law).description },
        /** @type {any} */ (law).title)));
    select.value = this.kinds[part];
    this.fields.set(part, { read: () => { select.value = this.kinds[part]; }, error: () => {} });
    return el("div", { class: "field choice" }, el("label", { for: id }, t(part)), select);
  }

  /** @param {string} name */
  field(name) {
    /** @type {Option} */
    const option = this.registry.options[name];
    if (this.varied.has(name) || (name === "drive_frequency" && this.varied.has("frequency_ratio")))
      return el("div", { class: "field" }, el("span", {}, ...this.label(name, option)),
        el("span", { class: "soft" }, t("mapVaries")));
    const { choices } = option;
    if (option.switch) return this.switchField(name, option);
    if (choices.length) return this.choiceField(name, option, choices);
    return this.numberField(name, option);
  }

  /**
   * @param {string} name
   * @param {Option} option
   */
  label(name, option) {
    const side = /^(right|left)_/.exec(name)?.[1];
    const symbol = symbolParts(option.symbol).map(({ text, place }) =>
      (place === "line" ? text : el(place, {}, text)));
    return [`${option.label}${side ? `, ${t(side)}` : ""} `, symbol.length ? el("i", {}, ...symbol) : ""];
  }

  /**
   * @param {string} name
   * @param {Option} option
   */
  numberField(name, option) {
    const id = freshId();
    const errorId = freshId();
    const units = option.units;
    const named = (/** @type {string | undefined} */ unit) => units.find((u) => u.name === unit);
    const unitOf = () =>
      named(this.units[name]) ?? named(habit(name)) ?? units[0] ?? { name: "", size: 1 };
    const input = el("input", { id, type: "text", inputmode: "decimal", autocomplete: "off",
      spellcheck: "false", "aria-describedby": errorId });
    const select = units.length > 1
      ? el("select", { "aria-label": t("unitOf", { name: option.label }) },
        ...units.map((u) => el("option", { value: u.name }, shownUnit(u.name))))
      : el("span", { class: "unit" }, shownUnit(units[0]?.name ?? ""));
    const slider = option.suggested
      ? el("input", { type: "range", min: "0", max: String(STEPS), step: "1",
        "aria-label": t("sliderOf", { name: option.label }) })
      : null;
    const error = el("p", { class: "error", id: errorId, hidden: true });
    /** @type {number | null} */
    let si = null;
    /** What is typed and not yet taken stays, and what was taken as it was typed. */
    let isDraft = false;
    /** @type {string | undefined} */
    let taken;
    /** Limits of the slider in SI units, held while it moves. */
    const ends = () => {
      const [low, high] = option.suggested ?? [0, 1];
      return si === null ? [low, high] : [Math.min(low, si), Math.max(high, si)];
    };
    let limits = ends();
    const write = () => {
      isDraft = false;
      const parsed = parseQuantity(input.value);
      const several = input.value.includes(",");
      const two = START.includes(name) && this.registry.systems[this.kinds.system].angles === 2;
      if (several && !option.several && !two) {
        error.hidden = false;
        error.textContent = t("oneNumber", { text: input.value.replace(",", ".").trim() });
        input.setAttribute("aria-invalid", "true");
      } else if (several) {
        const parts = input.value.split(",").map((part) => part.trim());
        const unit = parts.every((p) => Number.isFinite(Number(p))) ? ` ${unitOf().name}` : "";
        this.store.option(name, parts.map((p) => `${p}${unit}`).join(", "));
      } else if (input.value.trim() === "") this.store.option(name, null);
      else {
        const unit = parsed && parsed.unit === "" && unitOf().name !== "1" ? ` ${unitOf().name}` : "";
        this.store.option(name, `${input.value.trim()}${unit}`);
      }
      taken = this.store.state.options[name];
    };
    input.addEventListener("input", () => { isDraft = true; });
    input.addEventListener("change", write);
    if (slider) {
      slider.addEventListener("input", () => {
        const share = Number(slider.value) / STEPS;
        const value = limits[0] + share * (limits[1] - limits[0]);
        const unit = unitOf();
        const text = short(value / unit.size, 4);
        input.value = text;
        si = Number(text) * unit.size;
        this.store.option(name, unit.name === "1" || !unit.name ? text : `${text} ${unit.name}`);
      });
      slider.addEventListener("change", () => { limits = ends(); });
    }
    if (select instanceof HTMLSelectElement) {
      select.addEventListener("change", () => {
        this.units[name] = select.value;
        keepHabit(name, select.value);
        read(this.text(name));
      });
    }
    /** @param {string | null} text */
    const read = (text) => {
      if (text === null) {
        if (this.focused !== input) input.value = "";
        return;
      }
      const quantity = parseQuantity(text);
      if (!(name in this.units) && quantity && units.some((u) => u.name === quantity.unit) &&
        this.store.state.options[name] !== undefined) this.units[name] = quantity.unit;
      if (select instanceof HTMLSelectElement) select.value = unitOf().name;
      if (this.focused === input && (isDraft || text === taken)) return;
      if (text.includes(",")) {
        const numbers = text.split(",").map((/** @type {string} */ part) => toSi(part, [...units, { name: option.unit, size: 1 }]));
        input.value = numbers.map((v) => (v === null ? "?" : short(v / unitOf().size))).join(", ");
        return;
      }
      si = toSi(text, [...units, { name: option.unit, size: 1 }]);
      input.value = si === null ? text : short(si / unitOf().size);
      if (slider && si !== null && this.focused !== slider) limits = ends();
      if (slider && si !== null)
        slider.value = String(Math.round((STEPS * (si - limits[0])) / (limits[1] - limits[0])));
    };
    this.fields.set(name, {
      read,
      error: (text) => {
        error.hidden = text === null;
        error.textContent = text ?? "";
        input.setAttribute("aria-invalid", String(text !== null));
      },
    });
    read(this.text(name));
    return el("div", { class: "field" },
      el("label", { for: id, title: option.description }, ...this.label(name, option)),
      el("span", { class: "entry" }, input, select), slider, error);
  }

  /**
   * @param {string} name
   * @param {Option} option
   */
  switchField(name, option) {
    const id = freshId();
    const box = el("input", { id, type: "checkbox", on: { change: () =>
      this.store.option(name, box.checked ? "true" : "false") } });
    this.fields.set(name, { read: (text) => { box.checked = text === "true"; }, error: () => {} });
    box.checked = this.text(name) === "true";
    return el("div", { class: "field choice" }, el("label", { for: id }, option.description), box);
  }

  /**
   * @param {string} name
   * @param {Option} option
   * @param {string[]} choices
   */
  choiceField(name, option, choices) {
    const id = freshId();
    const select = el("select", { id, on: { change: () => this.store.option(name, select.value) } },
      ...choices.map((each) => el("option", { value: each }, each)));
    const read = (/** @type {string | null} */ text) => { select.value = text ?? choices[0]; };
    this.fields.set(name, { read, error: () => {} });
    read(this.text(name));
    return el("div", { class: "field choice" },
      el("label", { for: id }, option.label || option.description), select);
  }

  /**
   * Return a table whose columns are lists of one length: stages of a schedule, heights of a pivot.
   * @param {string[]} names
   */
  table(names) {
    /** @type {Option[]} */
    const options = names.map((name) => this.registry.options[name]);
    const unit = (/** @type {number} */ k) => options[k].units[0] ?? { name: "", size: 1 };
    const body = el("tbody", {});
    const error = el("p", { class: "error", hidden: true });
    /** @type {number[][]} */
    let columns = names.map(() => []);
    const write = () => {
      /** @type {Record<string, string>} */
      const changed = { ...this.store.state.options };
      names.forEach((name, k) => {
        changed[name] = columns[k].map((v) => `${short(v / unit(k).size, 12)} ${unit(k).name}`).join(", ");
      });
      this.store.set({ options: changed });
    };
    const draw = () => {
      body.replaceChildren(...columns[0].map((_, i) => el("tr", {},
        ...names.map((_name, k) => el("td", {}, el("input", {
          type: "text", inputmode: "decimal",
          "aria-label": `${options[k].description || options[k].label} ${i + 1}`,
          value: short((columns[k][i] ?? NaN) / unit(k).size),
          on: { change: (/** @type {Event} */ e) => {
            const input = /** @type {HTMLInputElement} */ (e.target);
            const value = Number(input.value.trim().replace("−", "-") || NaN) * unit(k).size;
            input.setAttribute("aria-invalid", String(!Number.isFinite(value)));
            if (!Number.isFinite(value)) {
              error.hidden = false;
              error.textContent = t("noNumber", { text: input.value });
              return;
            }
            columns[k][i] = value;
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
        const units = [...options[k].units, { name: options[k].unit, size: 1 }];
        columns[k] = (text ?? "").split(",").filter(Boolean).map((/** @type {string} */ part) => toSi(part, units) ?? NaN);
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
