/** What stands on the page of a live toy. */

import { el, freshId } from "../shared/dom.js";
import { t } from "../strings.js";

/**
 * @typedef {{pause: () => void, push: () => void, restart: () => void, high: () => void,
 *   low: () => void, speed: (times: number) => void, sound: (on: boolean) => void}} Actions
 */

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];

/**
 * Return the elements of the view by name.
 * @param {{high: number, low: number}} ratios of the two stages of Fig. 12
 * @param {Actions} actions
 */
export function makeParts(ratios, actions) {
  const button = (/** @type {string} */ text, /** @type {string} */ key,
    /** @type {() => void} */ click) => el("button", { type: "button", on: { click } },
    text, el("kbd", { "aria-hidden": "true" }, key));
  const angle = strip(t("curveAngle"), [["right", "right"], ["left", "left"]]);
  const energy = strip(t("curveEnergy"),
    [["kinetic", "kinetic"], ["potential", "potential"], ["total", "ink"]]);
  return {
    canvas: el("canvas", { class: "scene grabbable", tabindex: "0", role: "application",
      "aria-label": t("liveStage"), "aria-describedby": "live-keys" }),
    toggle: el("button", { type: "button", class: "play", on: { click: actions.pause } },
      t("pause")),
    push: button(t("push"), "P", actions.push),
    restart: button(t("restart"), "R", actions.restart),
    high: button(t("highFrequency", { ratio: ratios.high }), "1", actions.high),
    low: button(t("lowFrequency", { ratio: ratios.low }), "2", actions.low),
    speed: el("select", { id: freshId(), on: { change: (/** @type {Event} */ event) =>
      actions.speed(Number(/** @type {HTMLSelectElement} */ (event.target).value)) } },
    ...SPEEDS.map((speed) => el("option", { value: String(speed), selected: speed === 1 },
      t("speedText", { speed })))),
    sound: el("input", { type: "checkbox", on: { change: (/** @type {Event} */ event) =>
      actions.sound(/** @type {HTMLInputElement} */ (event.target).checked) } }),
    status: el("p", { class: "readout" }),
    knobs: el("div", { class: "fields" }),
    angle,
    energy,
  };
}

/**
 * Return the page of a live toy.
 * @param {ReturnType<typeof makeParts>} parts
 * @param {HTMLElement} record button that begins and ends a recording
 * @param {HTMLElement} recorded the line about the last one
 * @param {HTMLElement} preset
 */
export function layOut(parts, record, recorded, preset) {
  return el("div", { class: "view live" },
    el("section", { class: "stage" }, parts.canvas, parts.status,
      el("div", { class: "row" }, parts.toggle, parts.push, parts.restart, record,
        el("label", { for: parts.speed.id }, t("speed")), parts.speed,
        el("label", { class: "check" }, parts.sound, t("sound")),
        el("div", { class: "stage-tools" })),
      recorded, el("div", { class: "stage-messages" })),
    el("div", { class: "side" },
      el("section", { class: "card trick" }, el("h2", {}, t("liveTry")), el("p", {}, t("liveHint")),
        el("ol", {}, el("li", {}, t("liveStep1"), " ", parts.high),
          el("li", {}, t("liveStep2"), " ", parts.low)),
        el("p", { class: "hint" }, t("liveMore"))),
      el("section", { class: "card" }, el("h2", {}, t("liveControls")), parts.knobs,
        el("p", { class: "hint", id: "live-keys" }, t("liveKeys"))),
      el("section", { class: "card" }, preset)),
    el("div", { class: "curves" }, parts.angle.figure, parts.energy.figure));
}

/**
 * @param {string} label
 * @param {[string, string][]} curves names and colours
 */
function strip(label, curves) {
  const canvas = el("canvas", { class: "strip", role: "img", "aria-label": label });
  const legend = el("ul", { class: "legend" }, ...curves.map(([name, paint]) =>
    el("li", { class: `of-${name}` }, el("span", { class: `key ${paint}` }), t(name))));
  const figure = el("figure", { class: "panel" },
    el("figcaption", {}, el("strong", {}, label), legend), canvas,
    el("p", { class: "axis" }, t("lastSeconds")));
  return { canvas, figure };
}
