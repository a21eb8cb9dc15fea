/** What stands on the page of a live toy. */

import { el, freshId } from "../shared/dom.js";
import { t, tr } from "../strings.js";

/**
 * @typedef {{pause: () => void, push: () => void, restart: () => void, high: () => void,
 *   low: () => void, speed: (times: number) => void, shake: () => void,
 *   hang: (suspension: string) => void}} Actions
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
  const energy = strip(t("curveEnergy", { whose: t("bothBalls") }),
    [["kinetic", "kinetic"], ["potential", "potential"], ["total", "ink"]]);
  return {
    canvas: el("canvas", { class: "scene grabbable", tabindex: "0", role: "application",
      "aria-label": t("liveStage"), "aria-describedby": "live-keys" }),
    toggle: el("button", { type: "button", class: "play", on: { click: actions.pause } },
      t("pause")),
    push: button(t("push"), "P", actions.push),
    restart: button(t("restart"), "R", actions.restart),
    shake: button(t("shakeIt"), "S", actions.shake),
    high: button(t("highFrequency", { ratio: ratios.high }), "1", actions.high),
    low: button(t("lowFrequency", { ratio: ratios.low }), "2", actions.low),
    speed: el("select", { id: freshId(), on: { change: (/** @type {Event} */ event) =>
      actions.speed(Number(/** @type {HTMLSelectElement} */ (event.target).value)) } },
    ...SPEEDS.map((speed) => el("option", { value: String(speed), selected: speed === 1 },
      t("speedText", { speed })))),
    hang: el("select", { id: freshId(), on: { change: (/** @type {Event} */ event) =>
      actions.hang(/** @type {HTMLSelectElement} */ (event.target).value) } },
    ...["rod", "string"].map((each) => el("option", { value: each }, tr(each)))),
    status: el("p", { class: "readout" }),
    angle,
    energy,
    more: el("details", { class: "more-curves" }, el("summary", {}, t("energyCurves")), energy.figure),
  };
}

/**
 * Return the page of a live toy.
 * @param {ReturnType<typeof makeParts>} parts
 * @param {{button: HTMLElement, result: HTMLElement}} keeper begins and ends a recording, and
 *   reports the last one
 * @param {{field: HTMLElement, headline: HTMLElement}} preset
 * @param {HTMLElement} knobs
 * @param {import("../shared/senses.js").Senses} senses sound, description and the list of keys
 */
export function layOut(parts, keeper, preset, knobs, senses) {
  return el("div", { class: "view live" }, el("div", { class: "desk" }, preset.headline,
    el("div", { class: "bench" },
      el("section", { class: "stage" }, parts.canvas,
        parts.status, el("div", { class: "stage-tools" }, senses.toggle),
        el("div", { class: "stage-messages" })),
      el("div", { class: "panel" }, parts.angle.figure,
        el("div", { class: "transport row" }, parts.toggle, parts.push, parts.restart, parts.shake, keeper.button,
          el("label", { for: parts.speed.id }, t("speed")), parts.speed), senses.root),
      keeper.result),
    el("aside", { class: "side" },
      el("div", { class: "card" }, preset.field, el("div", { class: "field hanging" },
        el("label", { for: parts.hang.id }, t("hangsOn")), parts.hang)), knobs,
      el("section", { class: "card trick" }, el("h2", {}, t("liveTry")),
        el("div", { class: "row" }, parts.high, el("span", {}, t("liveThen")), parts.low),
        el("details", { class: "about" }, el("summary", {}, t("liveWhy")), el("p", {}, t("liveHint")),
          el("ol", {}, el("li", {}, t("liveStep1")), el("li", {}, t("liveStep2"))),
          el("p", { class: "hint" }, t("liveMore")))),
      parts.more, el("p", { class: "hint", id: "live-keys" }, t("liveKeys")))));
}

/**
 * @param {string} label
 * @param {[string, string][]} curves names and colours
 */
function strip(label, curves) {
  const canvas = el("canvas", { class: "strip", role: "img", "aria-label": label });
  const values = Object.fromEntries(curves.map(([name]) => [name, el("output", {})]));
  const legend = el("ul", { class: "legend" }, ...curves.map(([name, paint]) =>
    el("li", { class: `of-${name}` }, el("span", { class: `key ${paint}` }), t(name), " ", values[name])));
  const title = el("strong", {}, label);
  const figure = el("figure", { class: "panel" }, el("figcaption", {}, title, legend,
    el("span", { class: "axis" }, t("lastSeconds"))), canvas);
  return { canvas, figure, title, values };
}

/**
 * Let arrow keys steer the toy, unless the focus is elsewhere on the page by now, as in a story. A
 * frame shows the focus as soon as somebody uses keys.
 * @param {HTMLCanvasElement} canvas
 */
export function takeKeys(canvas) {
  const { activeElement, body } = document;
  if (activeElement !== body && !activeElement?.closest("#views")) return;
  canvas.classList.add("unasked");
  const reveal = () => canvas.classList.remove("unasked");
  canvas.focus({ preventScroll: true });
  canvas.addEventListener("blur", reveal, { once: true });
  window.addEventListener("keydown", reveal, { once: true });
}
