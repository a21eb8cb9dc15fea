/** The description of a video or a table: scale, masses, camera, directions, how many balls. */

import { el, tick } from "../page/dom.js";
import { readQuantity } from "../page/entry.js";
import { choice } from "../page/fields.js";
import { Form } from "../page/form.js";
import { leaveOut } from "../page/link_parts.js";
import { short } from "../page/unit_text.js";
import { withLabels } from "../page/option_labels.js";
import { warningsText } from "../page/refusals.js";
import { t } from "../strings.js";
import { isAsFound, isSeen } from "./session.js";
import { openOf } from "./sheet.js";

const FIRST = ["length", "length_sigma", "radius", "mass"];
const REST = ["damping", "restitution", "gravity"];
const CAMERA = ["slow_motion", "row_time", "lens_k1", "lens_k2"];
// What a template and a stick need.
const SIZES = ["patch", "stick_length"];
// What a table needs that has frames and no time, or places without a pivot.
const PIVOT = ["pivot_x", "pivot_y"];
// What fits use of a table.
const PART = ["start", "end"];
const OF_TABLE = ["frame_rate", ...PIVOT, ...PART];
const NAMES = [...FIRST, ...SIZES, ...REST, ...CAMERA, ...OF_TABLE];

export class Setup {
  /**
   * @param {import("../page/state.js").Page} page its address keeps the quantities, after "measure."
   * @param {Record<string, any>} fields as the server describes them
   * @param {{changed: () => void, count: (balls: number) => void, track: () => void,
   *   mode: (mode: "setup" | "result") => void, reset: () => void, cancel: () => void,
   *   tool: (change: Partial<import("./session.js").Clip>) => void,
   *   sheet: (change: Partial<import("./sheet.js").Sheet>) => void,
   *   sign: (decimal: string) => void}} on
   */
  constructor(page, fields, on) {
    const { store } = page;
    this.fields = fields;
    /** @type {Record<string, string>} */
    this.values = {};
    for (const name of NAMES) {
      const kept = store.state.extra[`measure.${name}`];
      if (kept) this.values[name] = kept;
    }
    const known = [...NAMES, "example"].map((name) => `measure.${name}`);
    leaveOut(page, Object.keys(store.state.extra).filter((key) => key.startsWith("measure.")
      && !known.includes(key)));
    let before = store.state.extra;
    store.subscribe(({ extra }, changed) => {
      for (const name of changed === "address" ? NAMES : []) {
        const key = `measure.${name}`;
        if (extra[key] !== before[key]) own.take(name, extra[key] ?? null);
      }
      before = extra;
    });
    const own = /** @type {any} */ ({
      state: { options: this.values },
      option: (/** @type {string} */ name, /** @type {string | null} */ value) => {
        own.take(name, value);
        store.keep(`measure.${name}`, value);
      },
      set: (/** @type {{options: Record<string, string>}} */ { options }) => {
        for (const name of new Set([...Object.keys(this.values), ...Object.keys(options)]))
          if (options[name] !== this.values[name]) own.option(name, options[name] ?? null);
      },
      take: (/** @type {string} */ name, /** @type {string | null} */ value) => {
        if (value === null) delete this.values[name];
        else this.values[name] = value;
        this.form.fields.get(name)?.read(value);
        this.tellWrong();
        on.changed();
      },
    });
    const { units, prefixes } = page.registry;
    this.form = new Form(el("div", {}), { units, prefixes, alternatives: [], options: fields }, own);
    this.isReady = false;
    const fieldOf = (/** @type {string} */ name) => this.form.numberField(name, fields[name], true);
    const choiceOf = (/** @type {string} */ label, /** @type {Record<string, string>} */ texts,
      /** @type {(value: string) => void} */ change) => {
      const made = choice(t(label), change, { isBeside: true });
      made.show(Object.entries(texts).map(([value, text]) => ({ value, text })), "");
      return made;
    };
    this.count = choiceOf("ballCount", { 1: "1", 2: "2" }, (balls) => on.count(Number(balls)));
    this.outside = tick(t("pivotOutside"), (isPivotOutside) => on.tool({ isPivotOutside }));
    this.shape = choiceOf("shape", { disc: t("shape_disc"), template: t("shape_template") },
      (shape) => on.tool({ shape }));
    this.hasRegion = tick(t("hasRegion"), (hasRegion) => on.tool({ hasRegion }));
    this.hasStick = tick(t("hasStick"), (hasStick) => on.tool({ hasStick }));
    this.patch = fieldOf("patch");
    this.stickLength = fieldOf("stick_length");
    this.angleFrom = choiceOf("angleFrom", { down: t("angleFrom_down"), right: t("angleFrom_right") },
      (angleFrom) => on.sheet({ angleFrom }));
    // Without a sign, the reader of tables finds it.
    const signs = { "": t("decimal_found"), ".": t("decimal_point"), ",": t("decimal_comma") };
    this.decimal = choiceOf("decimal", signs, (decimal) => on.sheet({ decimal }));
    // Beside the refusal of a file that leaves it open.
    this.sign = choiceOf("decimal", signs, on.sign);
    this.yDown = tick(t("yDown"), (isDown) => on.sheet({ yAxis: isDown ? "down" : "up" }));
    this.rate = fieldOf("frame_rate");
    this.pivot = el("div", { class: "fields" }, el("p", { class: "hint" }, t("pivotHint")),
      ...PIVOT.map(fieldOf));
    this.part = el("div", { class: "fields" }, ...PART.map(fieldOf));
    const camera = el("div", { class: "fields" }, this.shape.root, this.patch, this.hasStick.root,
      this.stickLength, this.hasRegion.root, ...CAMERA.map(fieldOf));
    const scale = el("p", { class: "hint" }, t("scaleHint"));
    this.sheetScale = el("p", { class: "hint" }, t("sheetScaleHint"));
    const quantities = el("div", { class: "fields", on: { change: () => this.tellWrong() } },
      this.count.root, this.rate, this.pivot, this.angleFrom.root, this.yDown.root,
      ...FIRST.map(fieldOf), scale, this.sheetScale, this.part, this.form.general,
      el("details", { class: "inner" }, el("summary", {}, t("more")),
        el("div", { class: "fields" }, camera, ...REST.map(fieldOf), this.decimal.root)));
    /** What only videos have. */
    this.ofVideo = [this.count.root, camera, scale];
    const button = (/** @type {string} */ name, /** @type {() => void} */ click,
      /** @type {string} */ kind = "") => el("button", { type: "button", class: kind,
      on: { click } }, t(name));
    this.track = button("track", on.track, "play");
    this.again = button("setupAgain", () => on.mode("setup"));
    this.back = button("setupBack", () => on.mode("result"));
    this.reset = button("findAgain", on.reset);
    this.cancel = button("cancel", on.cancel);
    this.hint = el("p", { class: "hint" });
    this.notice = el("p", { class: "notice" });
    this.clock = el("p", { class: "notice" });
    this.bar = el("progress", { max: 1, "aria-label": t("job_bar") });
    /** Which work goes on, announced when it is another one, and how much of it is done. */
    this.stage = el("span", { role: "status" });
    this.share = el("span", {});
    this.failed = el("p", { class: "error", role: "alert" });
    this.busy = el("div", { class: "busy" }, this.bar, el("span", {}, this.stage, " ", this.share), this.cancel);
    this.body = el("div", { class: "fields" }, this.notice, this.outside.root, this.clock, this.hint,
      quantities,
      el("div", { class: "actions" }, this.track, this.again, this.back, this.reset));
    this.title = el("h2", {});
    this.root = el("section", { class: "card" }, this.title,
      this.busy, this.failed, this.sign.root, this.body);
  }

  /**
   * Show how far a clip is, what can be done next, and what went wrong.
   * @param {import("./session.js").Clip} clip
   * @param {string} lack what must be chosen before a table can be used, "" for nothing
   */
  update(clip, lack) {
    const isSetup = clip.mode === "setup";
    const { sheet } = clip;
    this.busy.hidden = clip.stage === null;
    if (clip.share) this.bar.value = clip.share;
    else this.bar.removeAttribute("value");
    const text = clip.stage ? t("stageOf", { stage: t(`stage_${clip.stage}`) }) : "";
    if (this.stage.textContent !== text) this.stage.textContent = text;
    this.share.textContent = clip.share ? t("progressOf", { percent: Math.round(100 * clip.share) }) : "";
    this.title.textContent = isSeen(clip) ? t("setup") : clip.name;
    this.body.hidden = !isSeen(clip);
    this.isReady = isSeen(clip) && clip.stage === null && lack === "";
    this.track.textContent = t(sheet ? "sheetUse" : clip.track ? "trackAgain" : "track");
    this.track.hidden = !isSetup;
    this.hint.hidden = !isSetup || (sheet !== null && lack === "");
    this.hint.textContent = sheet ? lack : `${t("setupHint")} ${t(`circle_${clip.shape}`)}`;
    this.again.hidden = isSetup;
    this.back.hidden = !isSetup || !clip.track;
    const isFound = isAsFound(clip);
    this.reset.hidden = !isSetup || isFound || !clip.hasPivot;
    this.notice.textContent = t(clip.hasPivot ? "setupFound"
      : clip.hasBalls ? "setupNoPivot" : "setupNotFound");
    this.notice.hidden = !isSetup || !isFound || clip.isPivotOutside || sheet !== null;
    this.outside.root.hidden = !isSetup || sheet !== null;
    for (const part of this.ofVideo) part.hidden = sheet !== null;
    this.showSheet(sheet, isSetup);
    this.outside.box.checked = clip.isPivotOutside;
    this.shape.select.value = clip.shape;
    this.hasRegion.box.checked = clip.hasRegion;
    this.hasStick.box.checked = clip.hasStick;
    this.patch.hidden = clip.shape === "disc";
    this.stickLength.hidden = !clip.hasStick;
    const { damage, clock } = clip.about ?? {};
    this.clock.textContent = [damage ? warningsText([damage]) : "", clockText(clock)].join(" ").trim();
    this.clock.hidden = !this.clock.textContent;
    const isOwn = clip.field !== null && clip.field in this.fields && isSeen(clip);
    this.tellWrong();
    if (isOwn) this.error(clip.error, clip.field);
    this.failed.hidden = !clip.error || isOwn;
    this.sign.root.hidden = clip.field !== "decimal";
    this.sign.select.value = sheet?.decimal ?? clip.decimal;
    // It begins with the name of a file.
    this.failed.textContent = isOwn ? "" : withLabels(clip.error ?? "", this.fields);
    this.count.select.value = clip.places.ball_2 ? "2" : "1";
  }

  /**
   * Show what the columns of a table leave open, nothing for a video and for a result.
   * @param {import("./sheet.js").Sheet | null} sheet
   * @param {boolean} isSetup
   */
  showSheet(sheet, isSetup) {
    const open = sheet && isSetup && openOf(sheet);
    this.rate.hidden = !open || !open.frames;
    this.pivot.hidden = !open || !open.pivot;
    this.angleFrom.root.hidden = !open || !open.angles;
    this.yDown.root.hidden = !open || !open.heights;
    this.decimal.root.hidden = !sheet || !isSetup || sheet.isOwn;
    this.sheetScale.hidden = this.part.hidden = !sheet;
    this.angleFrom.select.value = sheet?.angleFrom ?? "down";
    this.yDown.box.checked = sheet?.yAxis === "down";
    this.decimal.select.value = sheet?.decimal ?? "";
  }

  /**
   * Return the quantities that belong to a clip, as texts with units.
   * @param {import("./session.js").Clip} clip
   */
  quantities({ sheet, shape, hasStick }) {
    const open = sheet && openOf(sheet);
    const ofVideo = [...CAMERA, ...(shape === "disc" ? [] : ["patch"]), ...(hasStick ? ["stick_length"] : [])];
    const asked = [...FIRST, ...REST, ...(sheet ? PART : ofVideo),
      ...(open?.frames ? ["frame_rate"] : []), ...(open?.pivot ? PIVOT : [])];
    return Object.fromEntries(Object.entries(this.values).filter(([name]) => asked.includes(name)));
  }

  /**
   * Take other values.
   * @param {Record<string, string>} values as texts with units
   */
  fill(values) {
    for (const [name, text] of Object.entries(values)) {
      this.values[name] = text;
      this.form.fields.get(name)?.read(text);
    }
    this.tellWrong();
  }

  /** Tell a text that is no quantity beside its field; nothing is tracked until it is mended. */
  tellWrong() {
    const wrong = Object.keys(this.values).find((name) => Number.isNaN(this.number(name))) ?? null;
    this.error(wrong === null ? null : t("noNumber", { text: this.values[wrong] }), wrong);
    const isRefused = [...this.form.fields.values()].some((field) => field.isRefused?.());
    this.track.disabled = !this.isReady || wrong !== null || isRefused;
  }

  /**
   * Return a quantity in SI units, null for one that is not given and NaN for a text that is none.
   * @param {string} name
   */
  number(name) {
    const text = this.values[name];
    return text === undefined ? null : readQuantity(this.form.registry, text, this.fields[name].unit).value;
  }

  /**
   * Show why something was refused, beside its field if it has one.
   * @param {string | null} text
   * @param {string | null} [field]
   */
  error(text, field = null) {
    for (const [name, each] of this.form.fields) each.error(name === field ? text : null);
    for (const place of text === null ? [] : this.body.querySelectorAll("details"))
      if (place.querySelector(".error:not([hidden])")) place.open = true;
    const own = text !== null && !(field && this.form.fields.has(field));
    this.form.general.hidden = !own;
    this.form.general.textContent = own ? text : "";
  }
}

/**
 * A sentence about slow motion by the file's clock, empty for one that plays as it was filmed.
 * @param {NonNullable<import("./session.js").Clip["about"]>["clock"] | undefined} clock
 */
export function clockText(clock) {
  if (!clock || clock.slow_motion === 1) return "";
  return t(clock.is_sure ? "slowMotionDeclared" : "slowMotionPossible", {
    filmed: short(clock.capture_rate, 4), shown: short(clock.shown_rate, 4),
    factor: short(clock.slow_motion, 3) });
}
