/** Choices of a person, kept in the browser from one visit to the next. */

/** @template T */
class Habits {
  /** @param {string} key in the browser's storage */
  constructor(key) {
    this.key = key;
    /** @type {Record<string, T> | null} */
    this.known = null;
  }

  /** Return what was chosen, now or the last time. */
  get all() {
    if (this.known) return this.known;
    try {
      this.known = { ...JSON.parse(localStorage.getItem(this.key) ?? "{}") };
    } catch {
      this.known = {}; // spoiled by somebody, or the browser keeps nothing
    }
    return /** @type {Record<string, T>} */ (this.known);
  }

  /**
   * Keep a choice.
   * @param {string} name
   * @param {T} value
   */
  keep(name, value) {
    this.all[name] = value;
    try {
      localStorage.setItem(this.key, JSON.stringify(this.all));
    } catch {
      // The choice holds for this visit.
    }
  }
}

/** The unit that was chosen last for each option. @type {Habits<string>} */
export const unitHabits = new Habits("latolato.scenario.units");
/** Which descriptions and sounds are on. @type {Habits<boolean>} */
export const senseHabits = new Habits("latolato.senses");
