/** What mouse, finger and keys do on a map: choose a point, drag a box, pan, zoom. */

import { followKeys } from "../page/keys.js";
import { pan, scale, zoom } from "./travel.js";

// A press that moves less is a click.
const CLICK = 5; // pixels of the page
const PAN_SHARE = 0.2;
/** @type {Record<string, [number, number]>} */
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

/**
 * Let a map follow the hand; returns what its keys do.
 * @param {import("./view.js").MapView} view
 */
export function followHand(view) {
  const { field, chart, cursor, tools } = view;
  const { canvas } = chart;
  /** @type {{x: number, y: number, at: [number, number], pans: boolean} | null} */
  let pressed = null;
  const moved = (/** @type {PointerEvent} */ e) =>
    pressed !== null && Math.hypot(e.clientX - pressed.x, e.clientY - pressed.y) > CLICK;
  const end = () => {
    pressed = null;
    chart.band = null;
    chart.shift = [0, 0];
    chart.draw();
  };
  canvas.addEventListener("pointerdown", (e) => {
    const at = chart.at(e);
    if (!at || e.button !== 0) return;
    pressed = { x: e.clientX, y: e.clientY, at, pans: e.shiftKey || tools.panning };
    canvas.setPointerCapture(e.pointerId);
  });
  canvas.addEventListener("pointermove", (e) => {
    if (!pressed) return cursor.describe(chart.at(e));
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
    if (!far) void cursor.pick(...at);
    else if (pans && chart.grid) {
      const { width, height } = chart.frame();
      const ratio = window.devicePixelRatio || 1;
      pan(view, Math.round((-(e.clientX - x) * ratio * chart.grid.width) / width),
        Math.round(((e.clientY - y) * ratio * chart.grid.height) / height));
    } else if (band) zoom(view, () => band);
  });
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("pointerleave", () => { if (!pressed) cursor.describe(); });
  const move = (/** @type {KeyboardEvent} */ { key, shiftKey }) => {
    const [x, y] = WAYS[key];
    const [columns, rows] = [chart.grid?.width ?? 0, chart.grid?.height ?? 0].map((n) =>
      Math.max(1, Math.round(PAN_SHARE * n)));
    if (shiftKey) pan(view, x * columns, y * rows);
    else cursor.step(x, y);
  };
  /** @type {import("../page/keys.js").KeyActions} */
  const actions = {
    ...Object.fromEntries(Object.keys(WAYS).map((key) => [key, { text: "keyCross", act: move }])),
    Enter: { text: "keyRun", act: () => void cursor.run() },
    c: { text: "keyCurve", act: () => void cursor.stepOnCurve(1) },
    C: { text: "keyCurve", act: () => void cursor.stepOnCurve(-1) },
    "+": { text: "keyZoomIn", act: () => scale(view, 0.5) },
    "=": { text: "keyZoomIn", act: () => scale(view, 0.5) },
    "-": { text: "keyZoomOut", act: () => scale(view, 2) },
    Escape: { text: "keyEndDrag", act: end },
  };
  followKeys(field, actions);
  return actions;
}
