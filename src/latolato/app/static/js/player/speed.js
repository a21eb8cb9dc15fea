/** The menu of playback speeds. */

import { t } from "../strings.js";
import { el, freshId } from "../page/dom.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];

/**
 * Return a label and a menu of speeds up to the fastest one.
 * @param {number} fastest
 * @param {(speed: number) => void} [choose] called with a speed that was chosen
 * @returns {[HTMLLabelElement, HTMLSelectElement]}
 */
export function speedMenu(fastest, choose = () => {}) {
  const id = freshId();
  const menu = el("select", { id, on: { change: () => choose(Number(menu.value)) } },
    ...SPEEDS.filter((speed) => speed <= fastest).map((speed) =>
      el("option", { value: String(speed), selected: speed === 1 }, t("speedText", { speed }))));
  return [el("label", { for: id }, t("speed")), menu];
}
