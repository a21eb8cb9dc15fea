/** Contact words: the word of a number, and the words of a map with their colours. */

/** @typedef {import("./grid.js").Grid} Grid */
/** @typedef {import("./grid.js").Variable} Variable */
/**
 * What contact words have: the codes of the classes but the last, and the colours of the commonest
 * other words. The last class are those that are rarer.
 * @typedef {{codes: number[], further: string[]} | null} Words
 */

const LETTERS = "BTRS";

/**
 * Return the word that a number stands for; `latolato.contact_words` does the same.
 * @param {Variable} variable
 * @param {number} code
 */
export function wordOf(variable, code) {
  const known = variable.words?.codes.indexOf(code) ?? -1;
  if (known >= 0) return variable.classes[known][0];
  let word = "";
  for (let left = code; left >= LETTERS.length; left = Math.floor(left / LETTERS.length))
    word = LETTERS[left % LETTERS.length] + word;
  return word;
}

/**
 * Return the classes of a map's variable and how to find the place of a value among them. Of contact
 * words these are the words of the map, in the order of `classes_of` in Python.
 * @param {Grid} grid
 * @param {number} k place of the variable
 * @returns {{classes: [string, string][], place: (value: number) => number}}
 */
export function classesOf(grid, k) {
  const variable = grid.variables[k];
  if (!variable.words) return { classes: variable.classes, place: Math.round };
  const { codes, further } = variable.words;
  /** @type {Map<number, number>} */
  const counts = new Map();
  for (const code of grid.values[k])
    if (!Number.isNaN(code)) counts.set(code, (counts.get(code) ?? 0) + 1);
  const others = [...counts].filter(([code]) => !codes.includes(code))
    .sort(([a, m], [b, n]) => n - m || a - b).map(([code]) => code);
  const shown = codes.filter((code) => counts.has(code));
  /** @type {[string, string][]} */
  const classes = shown.map((code) => variable.classes[codes.indexOf(code)]);
  for (const [i, code] of others.slice(0, further.length).entries()) {
    shown.push(code);
    classes.push([wordOf(variable, code), further[i]]);
  }
  if (others.length > further.length) classes.push(variable.classes[codes.length]);
  const places = new Map(shown.map((code, i) => [code, i]));
  return { classes, place: (code) => places.get(code) ?? shown.length };
}
