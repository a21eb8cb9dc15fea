/** What mouse, finger and keys do on a map: choose a point, drag a box, pan, zoom. */

import { followKeys } from "../page/keys.js";

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {import("./chart.js").ChartBox} ChartBox */
/**
 * @typedef {{hover: (at: [number, number] | null) => void, pick: (x: number, y: number) => void,
 *   box: (box: ChartBox) => void, pan: (columns: number, rows: number) => void, back: () => void,
 *   scale: (by: number) => void, step: (columns: number, rows: number) => void,
 *   enter: () => void, curve: (by: number) => void}} PointerListener
 */

// A press that moves less is a click.
const CLICK = 5; // pixels of the page
const PAN_SHARE = 0.2;
/** @type {Record<string, [number, number]>} */
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

/**
 * Let a canvas follow the hand; returns what its keys do.
 * @param {HTMLElement} root what has the focus
 * @param {MapChart} chart
 * @param {PointerListener} listener
 * @param {() => boolean} panning whether dragging pans without the Shift key
 */
export function followHand(root, chart, listener, panning) {
  const { canvas } = chart;
  /** @type {{x: number, y: number, at: [number, number], pans: boolean} | null} */
  let pressed = null;
  const moved = (/** @type {PointerEvent} */ e) =>
    pressed !== null && Math.hypot(e.clientX - pressed.x, e.clientY - pressed.y) > CLICK;
  const end = () => {
    pressed = null;
    chart.band = null;
    chart.shift = [0, 0];
  };
  canvas.addEventListener("pointerdown", (e) => {
    const at = chart.at(e);
    if (!at || e.button !== 0) return;
    pressed = { x: e.clientX, y: e.clientY, at, pans: e.shiftKey || panning() };
    canvas.setPointerCapture(e.pointerId);
  });
  canvas.addEventListener("pointermove", (e) => {
    if (!pressed) return listener.hover(chart.at(e));
    if (!moved(e)) return;
    if (pressed.pans) {
      const ratio = window.devicePixelRatio || 1;
      chart.shift = [(e.clientX - pressed.x) * ratio, (e.clientY - pressed.y) * ratio];
    } else {
      const [x, y] = chart.at(e, true) ?? pressed.at;
      const [a, b] = pressed.at;
      chart.band = [Math.min(a, x), Math.max(a, x), Math.min(b, y), Math.max(b, y)];
    }
    chart.draw();
  });
  canvas.addEventListener("pointerup", (e) => {
    if (!pressed) return;
    const { at, pans, x, y } = pressed;
    const far = moved(e);
    const { band } = chart;
    end();
    chart.draw();
    if (!far) listener.pick(...at);
    else if (pans && chart.grid) {
      const { width, height } = chart.frame();
      const ratio = window.devicePixelRatio || 1;
      listener.pan(Math.round((-(e.clientX - x) * ratio * chart.grid.width) / width),
        Math.round(((e.clientY - y) * ratio * chart.grid.height) / height));
    } else if (band) listener.box(band);
  });
  canvas.addEventListener("pointercancel", () => { end(); chart.draw(); });
  canvas.addEventListener("pointerleave", () => { if (!pressed) listener.hover(null); });
  const move = (/** @type {KeyboardEvent} */ { key, shiftKey }) => {
    const [x, y] = WAYS[key];
    const [columns, rows] = [chart.grid?.width ?? 0, chart.grid?.height ?? 0].map((n) =>
      Math.max(1, Math.round(PAN_SHARE * n)));
    if (shiftKey) listener.pan(x * columns, y * rows);
    else listener.step(x, y);
  };
  const leave = () => {
    if (!pressed) {
      listener.back();
      return;
    }
    end();
    chart.draw();
  };
  /** @type {import("../page/keys.js").KeyActions} */
  const actions = {
    ...Object.fromEntries(Object.keys(WAYS).map((key) => [key, { text: "keyCross", act: move }])),
    Enter: { text: "keyRun", act: () => listener.enter() },
    c: { text: "keyCurve", act: () => listener.curve(1) },
    C: { text: "keyCurve", act: () => listener.curve(-1) },
    "+": { text: "keyZoomIn", act: () => listener.scale(0.5) },
    "=": { text: "keyZoomIn", act: () => listener.scale(0.5) },
    "-": { text: "keyZoomOut", act: () => listener.scale(2) },
    Escape: { text: "keyZoomBack", act: leave },
  };
  followKeys(root, actions);
  return actions;
}
