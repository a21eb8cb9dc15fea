/** What the address keeps of the axes of a map. */

/** @typedef {"x" | "y"} Which */
/** @typedef {{extra: Record<string, string>, shown: any}} Axes the address, and what is on show */

/**
 * Return an axis as the address has it; what it does not say is as usual, on show or on its way.
 * @param {Axes} axes
 * @param {Which} which
 */
function axisOf({ extra, shown }, which) {
  const seen = shown?.[which];
  const name = extra[`map.${which}`] ?? seen?.name ?? null;
  const log = extra[`map.${which}log`];
  return { name, low: extra[`map.${which}low`] ?? null, high: extra[`map.${which}high`] ?? null,
    log: log === undefined ? Boolean(seen?.log) && seen.name === name : log === "1" };
}

/**
 * Return what the address keeps of an axis.
 * @param {Which} which
 * @param {{name: string | null, low: any, high: any, log: boolean}} axis
 */
function keys(which, { name, low, high, log }) {
  return { [which]: name, [`${which}low`]: low, [`${which}high`]: high,
    [`${which}log`]: log ? 1 : null };
}

/**
 * Return what the address keeps of an axis of which one end was changed; an empty end stands for
 * the usual one.
 * @param {Axes} axes
 * @param {Which} which
 * @param {"low" | "high"} side
 * @param {number | null} value
 */
export function ended(axes, which, side, value) {
  return keys(which, { ...axisOf(axes, which), [side]: value });
}

/**
 * Return what the address keeps of an axis that is made logarithmic or linear; one that begins
 * at zero gets the usual start. A stored map has its points, and its spacing alone is kept.
 * @param {Axes} axes
 * @param {Which} which
 * @param {boolean} on
 */
export function spaced(axes, which, on) {
  if (axes.extra["map.stored"]) return { [`${which}log`]: on ? 1 : 0 };
  const now = axisOf(axes, which);
  const low = on && !(Number(now.low) > 0) ? null : now.low;
  return { ...keys(which, { ...now, low, log: on }), [`${which}log`]: on ? 1 : 0 };
}

/**
 * Return what the address keeps when another parameter is shown along an axis; that of the other
 * axis changes places with this one.
 * @param {Axes} axes
 * @param {Which} which
 * @param {string} name
 */
export function turned(axes, which, name) {
  const [own, other] = [axisOf(axes, which), axisOf(axes, which === "x" ? "y" : "x")];
  if (name !== other.name)
    return { ...keys(which, { name, low: null, high: null, log: false }), at: null };
  return { ...keys(which, other), ...keys(which === "x" ? "y" : "x", own), at: null };
}
