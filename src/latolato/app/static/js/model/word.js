/** The contact word of a run, from its contacts: `latolato.observables.word`. */

/** @typedef {import("../page/block.js").Block} Block */
/** @typedef {{letter: number, time: number, velocity: number}} Letter */

export const LETTERS = "BTRS";
// Defaults of `ContactWord`: the longest response that is looked for, in drive periods, and how near letters recur.
const LONGEST = 16;
const TOLERANCE = 1e-4; // rad
// Periods watched for each of the longest response.
const REPEATS = 3;
const MOST_LETTERS = 26;
// Twice the longest word, so that it is seen to repeat.
const HELD_LETTERS = 2 * MOST_LETTERS;
const [B, T, R, S] = [0, 1, 2, 3];

/**
 * Return the contact word of each ball of a run, as `latolato.simulation.summary` does; none without a drive
 * that repeats itself, null for a run of less than three drive periods.
 * @param {Block} block
 * @returns {(string | null)[]}
 */
export function wordsOf({ about, arrays, shapes }) {
  const { drive_period: period, attributes, contact_kinds: names } = about;
  if (!period) return [];
  const { contact_time: times, contact_kind: kinds, angular_velocity: velocity } = arrays;
  const table = [...kinds].map((kind) => names[kind]);
  const last = table.findLast((kind) => kind === "rest" || kind === "release");
  const rows = (/** @type {string} */ name) => {
    const [count, size] = shapes[name];
    return Array.from({ length: count }, (_, k) => arrays[name].subarray(k * size, (k + 1) * size));
  };
  const isStill = velocity && rows("angular_velocity").every((each) => each.at(-1) === 0)
    && (attributes.contact ?? "none") !== "none";
  const held = last === undefined ? isStill : last === "rest";
  return rows("angular_velocity_before").map((before) => wordOfRun(
    { times, kinds: table, velocities: before }, { period, duration: attributes.duration, held }));
}

/**
 * @param {{times: ArrayLike<number>, kinds: string[], velocities: ArrayLike<number>}} contacts
 * @param {{period: number, duration: number, held: boolean}} run
 */
function wordOfRun({ times, kinds, velocities }, { period, duration, held }) {
  const periods = Math.floor((duration / period) * (1 + 1e-9));
  if (periods < REPEATS) return null;
  const longest = Math.min(LONGEST, Math.floor(periods / REPEATS));
  const [begin, end] = [(periods - REPEATS * longest) * period, periods * period];
  /** @type {Letter[]} */
  const letters = [];
  // Impacts on one side wait for another letter, because a rest would make one letter of them.
  /** @type {Letter[]} */
  let side = [];
  const store = (/** @type {Letter[]} */ some) => {
    letters.push(...some);
    side = [];
  };
  kinds.forEach((kind, i) => {
    const about = { time: times[i], velocity: velocities[i] };
    if (kind === "bottom" || kind === "top") {
      const letter = kind === "bottom" ? B : T;
      if (side[0]?.letter !== letter) store(side.slice(-HELD_LETTERS));
      side.push({ letter, ...about });
    } else if (kind === "rest") {
      store(side.slice(0, 1));
      if (letters.at(-1)?.letter !== R) letters.push({ letter: R, ...about });
    } else if (kind === "slack") {
      store(side.slice(-HELD_LETTERS));
      letters.push({ letter: S, ...about });
    }
  });
  let repeats = side.length;
  const latest = (side.at(-1) ?? letters.at(-1))?.time ?? -Infinity;
  if (end - latest > longest * period) {
    if (held) return LETTERS[R];
    // A contact that was watched and did not come again is no word either.
    return latest < begin ? "no contact" : "no word";
  }
  // Impacts on one side may be all that there is. Else they may end at rest, not seen yet.
  if (letters.length && letters[letters.length - 1].time >= begin) store(side.slice(0, 1));
  else {
    store(side.slice(-HELD_LETTERS));
    repeats = 0;
  }
  const seen = letters.slice(-HELD_LETTERS);
  while (seen.length && seen[0].time < begin) seen.shift();
  for (let lag = 1; lag <= Math.min(MOST_LETTERS, seen.length >> 1); lag += 1)
    if (recurs(seen, lag, longest, period) && goesOn(seen, lag, { end, period, repeats }))
      return leastTurn(seen.slice(-lag).map(({ letter }) => letter));
  return "no word";
}

/**
 * Return whether all letters recur so many letters later: the same one, some drive periods later, as fast.
 * @param {Letter[]} letters
 * @param {number} lag
 * @param {number} longest
 * @param {number} period
 */
function recurs(letters, lag, longest, period) {
  const last = letters.length - 1;
  const periods = Math.floor((letters[last].time - letters[last - lag].time) / period + 0.5);
  if (!(periods >= 1 && periods <= longest)) return false;
  const phase = 2 * Math.PI / period;
  return letters.slice(lag).every((late, k) => {
    const early = letters[k];
    const apart = late.time - early.time - periods * period;
    return late.letter === early.letter
      && Math.max(Math.abs(apart) * phase, Math.abs(late.velocity - early.velocity) / phase) <= TOLERANCE;
  });
}

/**
 * Return whether the letter after the last one, as the word has it, is not overdue. With repeats at the end,
 * of which the last letter is the first, it is the next one that differs.
 * @param {Letter[]} letters
 * @param {number} lag
 * @param {{end: number, period: number, repeats: number}} run
 */
function goesOn(letters, lag, { end, period, repeats }) {
  const last = letters.length - 1;
  let following = last - lag + 1;
  if (repeats > 0)
    while (following < last && letters[following].letter === letters[last].letter) following += 1;
  const gap = letters[following].time - letters[last - lag].time;
  return end - letters[last].time - gap <= TOLERANCE * period / (2 * Math.PI);
}

/**
 * Return the word of letters that recur: of all letters with which they may begin, the first in order.
 * @param {number[]} letters
 */
function leastTurn(letters) {
  const turns = letters.map((_, k) => [...letters.slice(k), ...letters.slice(0, k)].join(""));
  return [...turns.sort()[0]].map((digit) => LETTERS[Number(digit)]).join("");
}
