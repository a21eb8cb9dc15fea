/** Units in which a person likes to read, kept in the browser from one visit to the next. */

const KEY = "latolato.scenario.units";
/** @type {Record<string, string> | null} */
let known = null;

/** Return the units that were chosen, by option. */
function habits() {
  if (known) return known;
  try {
    known = { ...JSON.parse(localStorage.getItem(KEY) ?? "{}") };
  } catch {
    known = {}; // spoiled by somebody, or the browser keeps nothing
  }
  return /** @type {Record<string, string>} */ (known);
}

/**
 * Return the unit that was chosen last for an option, if any.
 * @param {string} option
 * @returns {string | undefined}
 */
export function habit(option) {
  return habits()[option];
}

/**
 * Keep a choice.
 * @param {string} option
 * @param {string} unit
 */
export function keepHabit(option, unit) {
  habits()[option] = unit;
  try {
    localStorage.setItem(KEY, JSON.stringify(known));
  } catch {
    // The choice holds for this visit.
  }
}
