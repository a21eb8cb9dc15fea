/** What parameters must be, in the sentences that Python says: `latolato.core.registry` and `latolato.core.rules`. */

/**
 * @typedef {import("./registry.js").Option} Option
 *
 * The rule and the way out of an error, with gaps as in Python's format strings: `latolato.core.rules`.
 * @typedef {{rule: string, way_out: string}} Rule
 *
 * A sentence of a rule: its English text, and what stands in its gaps, which may be a word of English
 * or a sentence itself.
 * @typedef {{name: string, part: "rule" | "way_out", text: string, values: Record<string, Value>}} Sentence
 * @typedef {string | number | {word: string} | Sentence} Value
 *
 * Another language: a sentence by the name of its rule, undefined where it lacks that, words, how what was given
 * is written, the gaps of a sentence in the units that people read, and what people call a parameter that a sentence
 * names in a gap such as `{@end}`, or what sets it to a value: `{@end=2}`.
 * @typedef {{sentence: (name: string, part: "rule" | "way_out") => string | undefined, word: (text: string) => string,
 *   given: (value: any) => string, values: (values: Sentence["values"]) => Sentence["values"],
 *   label: (parameter: string, value?: string) => string}} RuleLanguage
 */

/** @type {Record<string, Rule>} */
const RULES = {};
/** @type {RuleLanguage} */
const ENGLISH = { sentence: () => undefined, word: (text) => text, given: literal, values: (values) => values,
  label: pythonName };
// A gap, and how many digits a number in it has.
const GAP = /\{(@|@?\w+(?:=\w+)?)(?::(?:\.(\d+))?(g))?\}/g;
const DIGITS = 6;
// From this power of ten on a number in a sentence is written with it.
const POWER = 6;

/**
 * Return what Python calls a parameter, or what sets it to a word or a number.
 * @param {string} parameter
 * @param {string} [value]
 */
export function pythonName(parameter, value) {
  return value === undefined ? parameter : `${parameter}=${/^\d/.test(value) ? value : literal(value)}`;
}

/**
 * Take the rules of a registry.
 * @param {Record<string, Rule>} rules by name
 */
export function learnRules(rules) {
  Object.assign(RULES, rules);
}

/**
 * Return a sentence of a rule.
 * @param {string} name
 * @param {Sentence["values"]} [values]
 * @param {Sentence["part"]} [part]
 * @returns {Sentence}
 */
export function sentenceOf(name, values = {}, part = "rule") {
  return { name, part, text: RULES[name][part], values };
}

/**
 * Return the text of a sentence; a text stays, or is translated as a whole.
 * @param {string | Sentence} sentence
 * @param {RuleLanguage} [language]
 * @returns {string}
 */
export function say(sentence, language = ENGLISH) {
  if (typeof sentence === "string") return language.word(sentence);
  const { name, part, text } = sentence;
  const values = language.values(sentence.values);
  // A translation leaves it to the English text how numbers are written.
  const digits = Object.fromEntries(Array.from(text.matchAll(GAP), ([, gap, count, isGeneral]) =>
    [gap, isGeneral ? Number(count ?? DIGITS) : 0]));
  return (language.sentence(name, part) ?? text).replace(GAP, (whole, gap) => {
    if (gap === "@") return "{parameter}";
    if (gap.startsWith("@")) {
      const [parameter, value] = gap.slice(1).split("=");
      return language.label(parameter, value);
    }
    const value = values[gap];
    if (value === undefined) return whole;
    if (typeof value === "number" && digits[gap]) return asRead(general(value, digits[gap]));
    if (typeof value !== "object") return String(value);
    return "word" in value ? language.word(value.word) : say(value, language);
  });
}

/** Input that breaks a rule; its parts are those of `latolato.core.errors.InputError`. */
export class InputError extends Error {
  /**
   * @param {string | Sentence} rule the rest of a sentence that begins with the parameter's name, or a whole
   *   one in which `{parameter}` stands for it
   * @param {{parameter?: string, value?: any, shown?: string, wayOut?: string | Sentence, fields?: string[],
   *   where?: string}} [about] `value` is what was given, `shown` how it is written if not as Python does, `fields`
   *   name those of a map that hold what is wrong, and `where` is the file that holds it
   */
  constructor(rule, about = {}) {
    super(worded(rule, about, about.parameter, ENGLISH));
    this.name = "InputError";
    this.rule = rule;
    this.about = about;
    this.parameter = about.parameter ?? null;
  }

  /**
   * Return the whole text in another language, with another name for the parameter.
   * @param {string} name
   * @param {RuleLanguage} language
   */
  worded(name, language) {
    return worded(this.rule, this.about, name, language);
  }
}

/**
 * Return the error of input that breaks a rule, as `latolato.core.rules.broken_rule`.
 * @param {string} name
 * @param {InputError["about"]} [about] a way out that is given takes the place of the rule's
 * @param {Sentence["values"]} [values]
 */
export function brokenRule(name, about = {}, values = {}) {
  const wayOut = RULES[name].way_out ? { wayOut: sentenceOf(name, values, "way_out") } : {};
  return new InputError(sentenceOf(name, values), { ...wayOut, ...about });
}

/**
 * Return names of which one is meant, as `latolato.core.rules.either_of`.
 * @param {string[]} names
 * @returns {Value}
 */
export function eitherOf(names) {
  const words = names.map((word) => /** @type {Value} */ ({ word }));
  return words.reduce((first, other) => sentenceOf("either_of", { first, other }));
}

/**
 * Return what people call parameters that are all needed, as `latolato.core.rules.each_of`.
 * @param {string[]} parameters
 * @returns {Value}
 */
export function eachOf(parameters) {
  const names = parameters.map((name) => /** @type {Value} */ ({ name: "", part: "rule", text: `{@${name}}`, values: {} }));
  return names.reduce((first, other) => sentenceOf("each_of", { first, other }));
}

/** What is right, and left to the installed program. */
export class BeyondPageError extends InputError {
  /**
   * @param {string} rule
   * @param {string} parameter
   * @param {string} name of what pages do not have
   */
  constructor(rule, parameter, name) {
    super(sentenceOf(rule, { name }), { parameter });
  }
}

/**
 * Return the error that says what is wrong and how to mend it, as `latolato.physics.problems.refusal`.
 * @param {import("../kernels/begin.js").Reported} problem
 * @param {string[]} [fields] those of a map that hold what is wrong
 */
export function refusal({ name, rule, way_out: wayOut, values: names, reported, parameter, value }, fields) {
  const values = Object.fromEntries(names.map((each, i) => [each, reported[i]]));
  return new InputError({ name, part: "rule", text: rule, values }, {
    ...(parameter ? { parameter } : {}), ...(value ? { value: values[value] } : {}),
    ...(wayOut ? { wayOut: { name, part: "way_out", text: wayOut, values } } : {}), ...(fields ? { fields } : {}) });
}

/**
 * @param {string | Sentence} rule
 * @param {InputError["about"]} about
 * @param {string | undefined} name
 * @param {RuleLanguage} language
 */
function worded(rule, about, name, language) {
  let text = say(rule, language);
  if (about.parameter !== undefined)
    text = !text.includes("{parameter}") ? `${name} ${text}`
      // A label has quotes of its own.
      : (name?.startsWith("\u201c") ? text.replaceAll("'{parameter}'", "{parameter}") : text)
        .replaceAll("{parameter}", String(name));
  if ("value" in about) text += `, ${language.word("got")} ${about.shown ?? language.given(about.value)}`;
  if (about.wayOut !== undefined) text += `; ${say(about.wayOut, language)}`;
  if (about.where !== undefined) text = `${about.where}: ${text}`;
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
 * Return a number that a program wrote as people write it, as `latolato.core.errors.as_read`.
 * @param {string} number
 */
export function asRead(number) {
  const [digits, power] = number.split("e");
  if (power !== undefined && !(Number(power) >= 0 && Number(power) < POWER))
    return `${/^-?1$/.test(digits) ? digits.slice(0, -1) : `${digits} × `}10${superscript(Number(power))}`.replace("-", "−");
  const text = power === undefined ? number : String(Number(number));
  return text.replace("-", /^-[0.]*$/.test(text) ? "" : "−");
}

/**
 * Return the exponent of a power of ten as it stands above the line.
 * @param {number} power
 */
export function superscript(power) {
  return String(power).replace(/./g, (c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]);
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
  if (whole) return checkedWhole(limits, parameter, value);
  if (typeof value !== "number" || !Number.isFinite(value))
    throw brokenRule(unit === "1" ? "number" : "number_in_unit", { parameter, value }, { unit });
  return within(limits, parameter, value);
}

/**
 * Return the lower and the upper end of a range, null where there is none.
 * @param {Option["limits"]} limits
 */
export function rangeOf(limits) {
  return [true, false].map((isLower) => limits.find((limit) => limit.is_lower === isLower) ?? null);
}

/**
 * @param {Option["limits"]} limits
 * @param {string} parameter
 * @param {any} value
 * @returns {number}
 */
function checkedWhole(limits, parameter, value) {
  if (!Number.isInteger(value)) throw brokenRule("whole_number", { parameter, value });
  return within(limits, parameter, value, BigInt(value));
}

/**
 * @param {Option["limits"]} limits
 * @param {string} parameter
 * @param {number} value
 * @param {number | bigint} [shown] as errors write it
 */
function within(limits, parameter, value, shown = value) {
  for (const { is_lower, end, is_open, rule, values } of limits) {
    const holds = is_lower ? value > end : value < end;
    if (!holds && (is_open || value !== end)) throw brokenRule(rule, { parameter, value: shown }, values);
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
  const last = String(words.pop());
  const guess = suggest(String(value), choices);
  throw brokenRule("choice", { parameter, value, ...(guess.name === "meant" ? { wayOut: guess } : {}) },
    { words: words.join(", "), last });
}

// The part of a name that a typo leaves, and the shortest part of one that is recognised.
const LIKENESS = 0.55;
const SHORTEST_PART = 3;

/**
 * Return a closing clause such as "did you mean 'length'?", or a list of what is known.
 * @param {string} name
 * @param {string[]} known
 * @returns {Sentence}
 */
export function suggest(name, known) {
  const meant = (/** @type {string} */ each) => sentenceOf("meant", { name: each });
  const within = name.includes("_") ? name.slice(name.indexOf("_") + 1) : "";
  if (known.includes(within)) return meant(within);
  const plain = (/** @type {string} */ text) => text.toLowerCase().replaceAll("-", "_");
  const typed = plain(name);
  const isLong = typed.length >= SHORTEST_PART;
  const longer = known.filter((each) => plain(each).startsWith(typed));
  if (longer.length === 1 && isLong) return meant(longer[0]);
  const likeness = known.map((each) => likenessOf(typed, plain(each)));
  const best = Math.max(...likeness);
  if (best >= LIKENESS) return meant(known[likeness.indexOf(best)]);
  const holders = known.filter((each) => plain(each).includes(typed));
  if (holders.length === 1 && isLong) return meant(holders[0]);
  return sentenceOf("known", { names: (holders.length > 0 && isLong ? holders : known).join(", ") });
}

/**
 * Return the error of a name that nothing has.
 * @param {string} kind of what it should name
 * @param {string} name
 * @param {string[]} known
 */
export function unknown(kind, name, known) {
  return brokenRule("unknown", {}, { kind: { word: kind }, name, hint: suggest(name, known) });
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
  return brokenRule(unit === "1" ? "numbers" : "numbers_in_unit", about, { unit: String(unit) });
}
