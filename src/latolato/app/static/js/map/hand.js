/** What mouse, finger and keys do on a map: choose a point, drag a box, pan, zoom. */

/** @typedef {import("./chart.js").MapChart} MapChart */
/** @typedef {import("./chart.js").Box} Box */
/**
 * @typedef {{hover: (at: [number, number] | null) => void, pick: (x: number, y: number) => void,
 *   box: (box: Box) => void, pan: (columns: number, rows: number) => void, back: () => void,
 *   scale: (by: number) => void, step: (columns: number, rows: number) => void,
 *   enter: () => void}} Listener
 */

// A press that moves less is a click.
const CLICK = 5; // pixels of the page
const PAN_SHARE = 0.2;
/** @type {Record<string, [number, number]>} */
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

/**
 * Let a canvas follow the hand.
 * @param {HTMLElement} root what has the focus
 * @param {MapChart} chart
 * @param {Listener} listener
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
  root.addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const far = [chart.grid?.width ?? 0, chart.grid?.height ?? 0].map((n) =>
      Math.max(1, Math.round(PAN_SHARE * n)));
    const way = WAYS[e.key];
    if (way && e.shiftKey) listener.pan(way[0] * far[0], way[1] * far[1]);
    else if (way) listener.step(way[0], way[1]);
    else if (e.key === "Enter") listener.enter();
    else if (e.key === "Escape") {
      if (pressed) { end(); chart.draw(); } else listener.back();
    } else if (e.key === "+" || e.key === "=") listener.scale(0.5);
    else if (e.key === "-") listener.scale(2);
    else return;
    e.preventDefault();
  });
}
