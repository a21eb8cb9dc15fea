/**
 * Sentences about a motion, from its events: what happens, where things are, what is drawn.
 *
 * Every function returns names of whole sentences of `languages/en.json` with the values of their gaps.
 */

import { isSlack } from "./hang.js";
import { isClack, wrapped } from "./events.js";
import { range } from "./motion.js";
import { t } from "../strings.js";
import { short } from "../page/unit_text.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./events.js").Log} Log */
/** @typedef {import("./events.js").Event} Event */
/** @typedef {{name: string, values: Record<string, string | number>}} SpokenSentence */

// Heights that differ by a smaller share are the same.
const SAME = 0.04;
// Of so many swings without order one can say that they have none; they are looked for in a stretch
// that is so much longer.
const MANY = 20;
const LONGER = 8;
const LONGEST_PATTERN = 4;
// Of steps that are up and down at random two in three change their sign, of those of beats few.
const RANDOM = 0.5;
// Swings that come to order differ less and less.
const LASTING = 0.7;
// Balls that part by less rattle.
const TINY = 2; // degrees
// What was said is said again if a number in it changed by more.
const NEWS = 5; // degrees
// Balls whose centres are nearer than so many of their radii touch.
const TOUCH = 1.02;

/**
 * @param {string} name
 * @param {Record<string, string | number>} [values]
 * @returns {SpokenSentence}
 */
const sentence = (name, values = {}) => ({ name, values });

/** @param {SpokenSentence[]} sentences */
export const inText = (sentences) => sentences.map(({ name, values }) => t(name, values)).join(" ");

/** @param {Log} log */
const subject = (log) => (log.isPair ? "balls" : "ball");

/** @param {Event} event */
const turnsRound = ({ kind }) => kind === "dip" || kind === "peak";

/**
 * The side, "bottom" or "top", on which balls rest on each other at an instant; null if they do not.
 * @param {Log} log
 * @param {number} time
 */
function restAt(log, time) {
  for (let i = log.after(time) - 1; i >= 0; i -= 1) {
    const { kind, angle } = log.events[i];
    if (kind === "rest") return Math.abs(angle) < 90 ? "bottom" : "top";
    if (kind === "release" || isClack(log.events[i])) return null;
  }
  return null;
}

/**
 * Return how high the ball that swings highest comes, each time [degrees].
 * @param {Event[]} events
 */
function heightsOf(events) {
  /** @type {Record<string, number[]>} */
  const each = {};
  for (const { kind, ball, angle } of events)
    if (kind === "peak" || kind === "top") (each[ball] ??= []).push(Math.abs(angle));
  const all = Object.entries(each);
  if (all.length < 2) return all[0]?.[1] ?? [];
  // Each ball of a pair has peaks of its own and takes part in every clack.
  const [ball] = all.filter(([name]) => name !== "both")
    .reduce((a, b) => (Math.max(...b[1]) > Math.max(...a[1]) ? b : a));
  return events.filter((e) => e.kind === "top" || (e.kind === "peak" && e.ball === ball))
    .map(({ angle }) => Math.abs(angle));
}

/**
 * @param {Event[]} events
 * @param {string} kind
 */
const count = (events, kind) => events.filter((e) => e.kind === kind).length;

/**
 * Return how often events of a kind happen in a second, with one decimal.
 * @param {Event[]} events
 * @param {string} kind
 */
function rateOf(events, kind) {
  const times = events.filter((e) => e.kind === kind).map(({ time }) => time);
  return ((times.length - 1) / (times[times.length - 1] - times[0])).toFixed(1);
}

/**
 * Return how heights follow each other.
 * @param {number[]} heights
 * @returns {"grows" | "dies" | "steady" | "varies"}
 */
export function patternOf(heights) {
  const [low, high] = [Math.min(...heights), Math.max(...heights)];
  const same = SAME * high;
  if (high - low <= same) return "steady";
  const steps = stepsOf(heights);
  const change = heights[heights.length - 1] - heights[0];
  if (change > same && steps.every((step) => step > -same / 2)) return "grows";
  if (change < -same && steps.every((step) => step < same / 2)) return "dies";
  return "varies";
}

/** @param {number[]} values */
const stepsOf = (values) => values.slice(1).map((value, i) => value - values[i]);

/**
 * Return after how many items a row of them repeats, 0 if it does not.
 * @template T
 * @param {T[]} items
 * @param {(one: T, other: T) => boolean} isSame
 */
function periodOf(items, isSame) {
  for (let n = 1; n <= LONGEST_PATTERN && 2 * n < items.length; n += 1)
    if (items.every((item, i) => i < n || isSame(item, items[i - n]))) return n;
  return 0;
}

/**
 * Return whether heights jump up and down as those of chaos do, and go on doing so.
 * @param {number[]} heights
 */
function isWild(heights) {
  if (heights.length < MANY) return false;
  const steps = stepsOf(heights);
  const flips = steps.slice(1).filter((step, i) => step * steps[i] < 0).length;
  const spread = (/** @type {number[]} */ values) => Math.max(...values) - Math.min(...values);
  const half = heights.length >> 1;
  return flips > RANDOM * (steps.length - 1)
    && spread(heights.slice(half)) > LASTING * spread(heights.slice(0, half));
}

/**
 * Return an angle in words: whole degrees, small ones with two digits.
 * @param {number} angle [degrees]
 */
const degrees = (angle) => (Math.abs(angle) < 10 ? short(angle, 2) : String(Math.round(angle)));

/**
 * Return the best sentence about a stretch of time, null if there is nothing to say about it.
 * @param {Log} log
 * @param {number} from
 * @param {number} to
 * @param {number} [since] when what drives the motion changed last
 * @returns {SpokenSentence | null}
 */
export function bestSentence(log, from, to, since = 0) {
  return newsOf(log, from, to) ?? summaryOf(log, from, to, since) ?? newestOf(log, from, to);
}

/**
 * Return whether a sentence says more than the last one did.
 * @param {SpokenSentence} next
 * @param {SpokenSentence | null} last
 */
export function isNews(next, last) {
  if (next.name !== last?.name || /_(grows|dies)$/.test(next.name)) return true;
  const least = next.name.startsWith("tellPeak") ? 0 : NEWS;
  return Object.entries(next.values).some(([key, value]) =>
    Math.abs(Number(value) - Number(last.values[key])) > least);
}

/**
 * A sentence about what happens for the first time, begins or ends; null for nothing new.
 * @param {Log} log
 * @param {number} from
 * @param {number} to
 */
function newsOf(log, from, to) {
  const events = log.between(from, to);
  const isFirst = (/** @type {string} */ kind) => events.some((e) => e.kind === kind)
    && !log.between(-Infinity, from).some((e) => e.kind === kind);
  if (isFirst("top")) return sentence("tellFirst_top");
  const rests = restAt(log, to);
  const catches = events.filter(({ kind }) => kind === "rest").length;
  if (catches > 2 && events.some(({ kind }) => kind === "release")) return sentence("tellCatches");
  if (rests && catches) return sentence(`tellRest_${rests}`);
  if (!rests && events.some(({ kind }) => kind === "release")) return sentence("tellRelease");
  if (isFirst("turn")) return sentence(`tellFirstTurn_${subject(log)}`);
  if (isFirst("bottom")) return sentence("tellFirst_bottom");
  for (const kind of ["slack", "taut"]) if (isFirst(kind)) return sentence(`tellFirst_${kind}_${subject(log)}`);
  return null;
}

/**
 * A sentence about what happens all the time, null if it is too little for that.
 * @param {Log} log
 * @param {number} from
 * @param {number} to
 * @param {number} since
 */
function summaryOf(log, from, to, since) {
  const events = log.between(from, to);
  const [below, above, turns] = ["bottom", "top", "turn"].map((kind) => count(events, kind));
  const rests = restAt(log, to);
  const heights = heightsOf(events);
  const span = to - from;
  const who = subject(log);
  if (rests && !events.length) return sentence(`tellHang_${rests}`);
  const longer = log.between(Math.max(since, to - LONGER * span), to);
  if (turns > 1 && !heights.length)
    return sentence(`tellTurns_${who}`, { rate: rateOf(events, "turn") });
  if (turns > 0) return sentence(`tellTumbles_${who}_${tumble(longer)}`);
  const ways = [...log.between(-Infinity, from).filter(turnsRound).slice(-1), ...events.filter(turnsRound)]
    .map(({ angle }) => Math.abs(angle));
  if (ways.length > 1 && Math.min(...ways) > 90 && !below && !count(events, "low"))
    return sentence(`tellUpright_${who}`, { angle: Math.ceil(180 - Math.min(...ways)) });
  if (heights.length < 3) return null;
  if (above) return clacksAbove(events, below, above);
  const edge = Math.max(...events.filter((e) => e.kind === "bottom").map((e) => Math.abs(e.angle)));
  if (below && Math.max(...heights) - edge < TINY) return sentence("tellRattle");
  return swings(below ? "tellClack" : `tellSwing_${who}`, heights, heightsOf(longer));
}

/**
 * Return whether balls that swing and turn over do so in an order that repeats.
 * @param {Event[]} events
 */
function tumble(events) {
  const kinds = events.filter(({ kind }) => kind === "peak" || kind === "turn").map(({ kind }) => kind);
  return kinds.length >= MANY && !periodOf(kinds, (a, b) => a === b) ? "wild" : "varies";
}

/**
 * A sentence about clacks above the hand.
 * @param {Event[]} events
 * @param {number} below how often balls clack below the hand
 * @param {number} above
 */
function clacksAbove(events, below, above) {
  const kinds = events.filter(isClack).map(({ kind }) => kind);
  const inTurn = kinds.every((kind, i) => i === 0 || kind !== kinds[i - 1]);
  if (inTurn && above > 1 && !events.some(({ kind }) => kind === "peak"))
    return sentence("tellInTurn", { rate: rateOf(events, "top") });
  return below ? sentence("tellMixed", { below, above }) : sentence("tellAbove", { above });
}

/**
 * @param {string} about
 * @param {number[]} heights
 * @param {number[]} longer heights of a longer stretch, for what has no order in this one
 */
function swings(about, heights, longer) {
  let pattern = /** @type {string} */ (patternOf(heights));
  const close = SAME * Math.max(...heights);
  const isSame = (/** @type {number} */ a, /** @type {number} */ b) => Math.abs(a - b) < close;
  const period = pattern === "varies" ? periodOf(longer, isSame) : 0;
  if (period > 1) pattern = "repeats";
  else if (pattern === "varies" && isWild(longer)) pattern = "wild";
  const [low, high] = [Math.min(...heights), Math.max(...heights)].map(degrees);
  return sentence(`${about}_${pattern}`,
    { low, high, angle: degrees(heights[heights.length - 1]), count: period });
}

/**
 * A sentence about the last event, null if there is none.
 * @param {Log} log
 * @param {number} from
 * @param {number} to
 */
function newestOf(log, from, to) {
  const events = log.between(from, to);
  const event = events.findLast(({ kind }) => kind === "peak") ?? events.findLast(isClack)
    ?? events.findLast(({ kind }) => kind === "dip");
  if (!event) return null;
  const { kind, ball } = event;
  const angle = degrees(Math.abs(event.angle));
  if (isClack(event)) return sentence(`tellOnce_${kind}`);
  return sentence(kind === "dip" ? `tellDip_${ball}` : `tellPeak_${ball}`, { angle });
}

/**
 * Return how a toy hangs and how its hand moves.
 * @param {Motion} motion
 */
export function startSentence(motion) {
  const { drive, drive_amplitude: amplitude, drive_frequency: frequency } = motion.about.options;
  const moves = amplitude > 0 && frequency > 0 ? "shakes" : drive === "fixed_pivot" || amplitude === 0
    ? "still" : "moves";
  return sentence(`start_${motion.balls.length > 1 ? "balls" : "ball"}_${moves}`, {
    way: short(100 * amplitude, 3), rate: (frequency / (2 * Math.PI)).toFixed(1) });
}

/**
 * Return whether two balls touch.
 * @param {Motion} motion
 * @param {ReturnType<Motion["pose"]>["balls"]} balls
 */
function touch(motion, [one, other]) {
  return other !== undefined && Math.hypot(one.x - other.x, one.y - other.y)
    < TOUCH * (motion.radius(one.ball) + motion.radius(other.ball));
}

/**
 * Sentences on the positions of balls and hand at an instant.
 * @param {Motion} motion
 * @param {number} time
 * @returns {SpokenSentence[]}
 */
export function placesOf(motion, time) {
  const { balls, height, across } = motion.pose(time);
  const [hand, aside] = [100 * height, 100 * across];
  return [
    ...(touch(motion, balls)
      ? [sentence(`place_touch_${Math.cos(balls[0].angle) > 0 ? "below" : "above"}`)]
      : balls.map(({ ball, angle }) => {
        const away = Math.round(wrapped(angle));
        const side = Math.abs(away) === 180 ? "up" : away > 0 ? "right" : away < 0 ? "left" : "down";
        return sentence(`place_${ball.name}_${side}`, { angle: Math.abs(away) });
      })),
    ...(Math.abs(hand) < 0.05 ? []
      : [sentence(`hand_${hand > 0 ? "above" : "below"}`, { height: short(Math.abs(hand), 2) })]),
    ...(Math.abs(aside) < 0.05 ? []
      : [sentence(`hand_${aside > 0 ? "right" : "left"}`, { way: short(Math.abs(aside), 2) })]),
    ...balls.filter(({ ball, distance }) => isSlack(distance, ball.length)).map(({ ball, distance }) =>
      sentence(`slack_${ball.name}`, { distance: short(100 * distance, 3) })),
  ];
}

/**
 * A sentence on a chart: between which values its curves lie.
 * @param {string} quantity "angle", "energy" or "power"
 * @param {ArrayLike<number>[]} curves
 */
export function curvesOf(quantity, curves) {
  const ends = curves.flatMap((values) => range(values));
  const read = quantity === "angle" ? degrees : (/** @type {number} */ value) => short(value, 2);
  return sentence(`curve_${quantity}`, { low: read(Math.min(...ends)), high: read(Math.max(...ends)) });
}
