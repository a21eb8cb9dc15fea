/** What parameters must be, in the sentences that Python says: `latolato.core.registry`. */

/** @typedef {import("./registry.js").Option} Option */

/** Input that breaks a rule; its parts are those of `latolato.core.errors.InputError`. */
export class InputError extends Error {
  /**
   * @param {string} rule the rest of a sentence that begins with the parameter's name, or a whole
   *   one in which `{parameter}` stands for it
   * @param {{parameter?: string, value?: any, wayOut?: string, fields?: string[]}} [about] `value` is what
   *   was given, `fields` name those of a map that hold what is wrong
   */
  constructor(rule, about = {}) {
    super(worded(rule, about, about.parameter));
    this.name = "InputError";
    this.rule = rule;
    this.about = about;
    this.parameter = about.parameter ?? null;
  }

  /**
   * Return the whole text with another name for the parameter.
   * @param {string} name
   * @param {(text: string) => string} [translated] each of its parts
   */
  worded(name, translated) {
    return worded(this.rule, this.about, name, translated);
  }
}

/** What is right, and left to the installed program. */
export class BeyondPageError extends InputError {
  /**
   * @param {string} what the subject of a sentence
   * @param {string} parameter
   */
  constructor(what, parameter) {
    super(`${what} computed by the installed program, not in a page`, { parameter });
  }
}

/**
 * Return the error that says what is wrong and how to mend it, as `latolato.physics.problems.refusal`.
 * @param {import("../kernels/begin.js").Reported} problem
 * @param {string[]} [fields] those of a map that hold what is wrong
 */
export function refusal({ rule, way_out: wayOut, values, reported, parameter, value }, fields) {
  const named = Object.fromEntries(values.map((name, i) => [name, reported[i]]));
  const filled = (/** @type {string} */ text) => text.replace(/\{(\w+):(?:\.(\d+))?g\}/g,
    (_, name, digits) => general(named[name], Number(digits ?? 6)));
  return new InputError(filled(rule), { ...(parameter ? { parameter } : {}), ...(value ? { value: named[value] } : {}),
    ...(wayOut ? { wayOut: filled(wayOut) } : {}), ...(fields ? { fields } : {}) });
}

/**
 * @param {string} rule
 * @param {{parameter?: string, value?: any, wayOut?: string}} about
 * @param {string} [name]
 * @param {(text: string) => string} [translated]
 */
function worded(rule, about, name, translated = (text) => text) {
  let text = translated(rule);
  if (about.parameter !== undefined)
    text = !text.includes("{parameter}") ? `${name} ${text}`
      // A label has quotes of its own.
      : (name?.startsWith("\u201c") ? text.replaceAll("'{parameter}'", "{parameter}") : text)
        .replaceAll("{parameter}", String(name));
  if ("value" in about) text += `, ${translated("got")} ${literal(about.value)}`;
  if (about.wayOut !== undefined) text += `; ${translated(about.wayOut)}`;
  return text.replace(/\s+/g, " ").trim();
}

/**
 * Return a value as Python writes it.
 * @param {any} value
 * @returns {string}
 */
export function literal(value) {
  if (value === null || value === undefined) return "None";
  if (typeof value === "boolean") return value ? "True" : "False";
  if (typeof value === "number") return general(value, 9);
  if (typeof value === "string") {
    const text = value.replace(/[\\\n\r\t]/g, (mark) => JSON.stringify(mark).slice(1, -1));
    return text.includes("'") && !text.includes('"') ? `"${text}"` : `'${text.replaceAll("'", "\\'")}'`;
  }
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (typeof value !== "object") return String(value);
  return `{${Object.entries(value).map((pair) => pair.map(literal).join(": ")).join(", ")}}`;
}

/**
 * Return a number as C's `%g` writes it.
 * @param {number} value
 * @param {number} [digits]
 */
export function general(value, digits = 6) {
  if (Number.isNaN(value)) return "nan";
  if (!Number.isFinite(value)) return value > 0 ? "inf" : "-inf";
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  const exponent = Number(power);
  const plain = (/** @type {string} */ text) => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  if (exponent < -4 || exponent >= digits) {
    const size = String(Math.abs(exponent)).padStart(2, "0");
    return `${plain(mantissa)}e${exponent < 0 ? "-" : "+"}${size}`;
  }
  return plain(value.toFixed(digits - 1 - exponent));
}

/**
 * Return a number that keeps the limits of an option, in the order in which Python checks them.
 * @param {Option} option
 * @param {string} parameter what errors call it
 * @param {any} value
 * @returns {number}
 */
export function checkedNumber({ unit, limits, whole }, parameter, value) {
  const kind = unit === "1" ? "a number" : `a number in ${unit}`;
  if (whole) return checkedWhole(limits, parameter, value);
  if (typeof value !== "number" || !Number.isFinite(value)) throw new InputError(`must be ${kind}`, { parameter, value });
  return within(limits, parameter, value);
}

/**
 * @param {Option["limits"]} limits
 * @param {string} parameter
 * @param {any} value
 * @returns {number}
 */
function checkedWhole(limits, parameter, value) {
  if (!Number.isInteger(value)) throw new InputError("must be a whole number", { parameter, value });
  return within(limits, parameter, value, BigInt(value));
}

/**
 * @param {Option["limits"]} limits
 * @param {string} parameter
 * @param {number} value
 * @param {number | bigint} [shown] as errors write it
 */
function within(limits, parameter, value, shown = value) {
  for (const { is_lower, end, is_open, rule, way_out: wayOut } of limits) {
    const holds = is_lower ? value > end : value < end;
    if (!holds && (is_open || value !== end)) throw new InputError(rule, { parameter, value: shown, wayOut });
  }
  return value;
}

/**
 * Return one of the words that an option may be.
 * @param {Option} option
 * @param {string} parameter what errors call it
 * @param {any} value
 * @returns {string}
 */
export function checkedChoice({ choices }, parameter, value) {
  if (choices.includes(value)) return value;
  const words = choices.map(literal);
  const last = words.pop();
  const guess = suggest(String(value), choices);
  throw new InputError(`must be ${words.join(", ")} or ${last}`,
    { parameter, value, ...(guess.startsWith("did") ? { wayOut: guess } : {}) });
}

// The part of a name that a typo leaves, and the shortest part of one that is recognised.
const LIKENESS = 0.55;
const SHORTEST_PART = 3;

/**
 * Return a closing clause such as "did you mean 'length'?", or a list of what is known.
 * @param {string} name
 * @param {string[]} known
 */
export function suggest(name, known) {
  const within = name.includes("_") ? name.slice(name.indexOf("_") + 1) : "";
  if (known.includes(within)) return `did you mean '${within}'?`;
  const plain = (/** @type {string} */ text) => text.toLowerCase().replaceAll("-", "_");
  const typed = plain(name);
  const isLong = typed.length >= SHORTEST_PART;
  const longer = known.filter((each) => plain(each).startsWith(typed));
  if (longer.length === 1 && isLong) return `did you mean '${longer[0]}'?`;
  const likeness = known.map((each) => likenessOf(typed, plain(each)));
  const best = Math.max(...likeness);
  if (best >= LIKENESS) return `did you mean '${known[likeness.indexOf(best)]}'?`;
  const holders = known.filter((each) => plain(each).includes(typed));
  if (holders.length === 1 && isLong) return `did you mean '${holders[0]}'?`;
  return `known are ${known.join(", ")}`;
}

/**
 * Return 1 - (slips that turn one name into the other)/(letters of the longer one); a slip drops,
 * adds or changes a letter or swaps two neighbours.
 * @param {string} name
 * @param {string} other
 */
function likenessOf(name, other) {
  const longer = Math.max(name.length, other.length);
  if (longer === 0 || Math.min(name.length, other.length) < LIKENESS * longer) return 0;
  /** @type {number[]} */
  let before = [];
  let row = Array.from({ length: other.length + 1 }, (_, j) => j);
  for (let i = 0; i < name.length; i += 1) {
    const last = row;
    const next = [i + 1];
    for (let j = 0; j < other.length; j += 1) {
      let slips = Math.min(last[j + 1] + 1, next[j] + 1, last[j] + Number(name[i] !== other[j]));
      if (i > 0 && j > 0 && name[i] === other[j - 1] && name[i - 1] === other[j])
        slips = Math.min(slips, before[j - 1] + 1);
      next.push(slips);
    }
    [before, row] = [last, next];
  }
  return 1 - row[other.length] / longer;
}

/**
 * Return why a value is no list of numbers.
 * @param {string | null} unit
 * @param {{parameter: string, value: any}} about
 */
export function noList(unit, about) {
  return unit === "1" ? new InputError("must be a sequence of numbers", about)
    : new InputError(`must be a sequence of numbers in ${unit}`, about);
}
