/** What fits and trials say, in cards and a table. */

import { inputError } from "../page/api.js";
import { el } from "../page/dom.js";
import { inLanguage, sentenceInLanguage } from "../page/refusals.js";
import { besideUnit, DEGREE, localShort, shownUnit, symbolParts, toPlace, withSigma } from "../page/unit_text.js";
import { local, t, tr } from "../strings.js";

/** @typedef {{value: number, sigma: number, low: number, high: number, unit: {name: string, size: number},
 *   label: string, symbol: string}} FitValue */
/** @typedef {{kind: string, error?: Told, verdict?: Sentence | string, values?: Record<string, FitValue>,
 *   play?: Record<string, any>}} Fit */

/** @typedef {import("./desk.js").FitKind} FitKind */
/** @typedef {import("../model/rules.js").Sentence} Sentence */
/** What the server says: a sentence, or why something was refused. @typedef {string | Sentence | Parts} Told */
/** @typedef {import("../page/api.js").Parts} Parts */

/**
 * Return the card of a fit; what is no headline is behind "more".
 * @param {Fit} fit
 * @param {FitKind} kind
 * @param {Record<string, number>} truth of a synthetic clip
 * @param {(options: Record<string, any>) => void} play
 * @param {Node} again what does it once more
 */
export function fitCard(fit, kind, truth, play, again) {
  const values = fit.values ?? {};
  const first = kind.headline.length > 0 ? kind.headline : Object.keys(values);
  const main = first.filter((name) => name in values);
  const rest = Object.keys(values).filter((name) => !main.includes(name));
  const table = (/** @type {string[]} */ names) =>
    fitTable(tr(kind.title), names, values, truth);
  return el("section", { class: "card fit", "data-fit": fit.kind },
    el("h2", {}, tr(kind.title)), table(main),
    el("p", { class: "hint" }, told(fit.verdict ?? "")),
    rest.length > 0 && el("details", { class: "inner" }, el("summary", {}, t("moreNumbers")),
      table(rest)),
    el("div", { class: "actions" }, fit.play && el("button", { type: "button",
      on: { click: () => play(fit.play ?? {}) } }, t("openInToy")), again));
}

/**
 * Return the card of a fit that waits for a click.
 * @param {FitKind} kind
 * @param {Node} button
 */
export function waitingCard(kind, button) {
  return el("section", { class: "card" }, el("h2", {}, tr(kind.title)),
    el("p", { class: "hint" }, tr(kind.hint)), el("div", { class: "actions" }, button));
}

/**
 * Return the card of the fits that a clip does not allow, with the reasons.
 * @param {Fit[]} fits
 * @param {Record<string, FitKind>} kinds
 */
export function refusedCard(fits, kinds) {
  return el("section", { class: "card" }, el("h2", {}, t("notHere")),
    ...fits.map((fit) => el("p", { class: "hint" },
      el("strong", {}, tr(kinds[fit.kind].title)), ": ", told(fit.error ?? ""))));
}

/**
 * Return what the server said in the language of the page.
 * @param {Told} text
 */
function told(text) {
  return typeof text === "object" && "rule" in text ? inLanguage(inputError(text)) : sentenceInLanguage(text);
}

/**
 * @param {string} title
 * @param {string[]} names
 * @param {Record<string, FitValue>} values
 * @param {Record<string, number>} truth
 */
function fitTable(title, names, values, truth) {
  return el("div", { class: "table-scroll", tabindex: "0", role: "region",
    "aria-label": title },
  el("table", {}, head(["quantity", "fitted"]),
    el("tbody", {}, ...names.map((name) => {
      const { value, sigma, low, high, unit, label, symbol } = values[name];
      const inUnit = (/** @type {number} */ x) => x / unit.size;
      const unitText = shownUnit(unit.name);
      const truthText = name in truth && t("truthIs", {
        value: localShort(inUnit(truth[name]), 5), percent: percent(value / truth[name] - 1) });
      return el("tr", { "data-name": name, "data-value": String(value) },
        el("td", {}, `${tr(label)} `, el("i", {}, ...symbolParts(symbol).map(({ text, place }) =>
          (place === "line" ? text : el(place, {}, text))))),
        el("td", { class: "number" }, el("strong", {}, withSigma(inUnit(value), inUnit(sigma))),
          besideUnit("", unitText), el("small", {},
            [low, high].map((end) => toPlace(inUnit(end), inUnit(sigma))).join(" … ")),
          truthText && el("small", {}, truthText)));
    }))));
}

/** @param {string[]} names of texts */
function head(names) {
  return el("thead", {}, el("tr", {},
    ...names.map((name) => el("th", { scope: "col" }, t(name)))));
}

/** @param {number} share */
function percent(share) {
  const text = local((100 * share).toFixed(Math.abs(share) < 0.001 ? 3 : 2).replace("-", "−"));
  return `${share >= 0 ? "+" : ""}${text} %`;
}

/**
 * Return the table of trials: those of the server, and videos that are none with the reason.
 * @param {any[]} trials
 * @param {{name: string, key: string, reason: Told | null}[]} clips
 * @param {(clip: string) => void} open
 */
export function trialTable(trials, clips, open) {
  const degrees = (/** @type {number} */ v, /** @type {number} */ s) =>
    withSigma(v / DEGREE, s / DEGREE);
  const link = (/** @type {string} */ key, /** @type {string} */ name) =>
    el("button", { type: "button", class: "link", on: { click: () => open(key) } }, name);
  const nameOf = (/** @type {any} */ row) =>
    clips.find(({ key }) => key === row.clip)?.name ?? row.source;
  const rows = trials.map((row) => el("tr", {},
    el("td", {}, row.set), el("td", {}, link(row.clip, nameOf(row))),
    el("td", {}, withSigma(1000 * row.drive_amplitude, 1000 * row.drive_amplitude_sigma)),
    el("td", {}, withSigma(row.drive_frequency, row.drive_frequency_sigma)),
    el("td", {}, localShort(row.frequency_ratio ?? NaN, 4)),
    el("td", {}, degrees(row.largest_angle, row.largest_angle_sigma)),
    el("td", {}, degrees(row.largest_angle_after_transient, row.largest_angle_after_transient_sigma)),
    el("td", {}, t(`class_${row.class}`), row.borderline ? ` (${t("borderline")})` : ""),
    el("td", { class: "soft" }, told(row.note))));
  const named = new Set(trials.map((row) => row.clip));
  const others = clips.filter(({ key }) => !named.has(key)).map(({ key, name, reason }) =>
    el("tr", {}, el("td", {}, "–"), el("td", {}, link(key, name)),
      el("td", { colspan: "7", class: "soft" }, reason === null ? t("notTracked") : told(reason))));
  const heads = ["set", "video", "trialAmplitude", "trialFrequency", "trialRatio", "trialLargest",
    "trialAfterTransient", "trialClass", "note"];
  return el("div", { class: "table-scroll", tabindex: "0", role: "region",
    "aria-label": t("trials") },
  el("table", {}, head(heads), el("tbody", {}, ...rows, ...others)));
}
