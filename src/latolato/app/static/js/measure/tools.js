/** Tools below the picture of a clip: the frames to use, the frame to point in, corrections. */

import { el } from "../page/dom.js";
import { t } from "../strings.js";

/** @typedef {import("./session.js").Clip} Clip */

/** Flags of samples that nobody need look at. */
const FINE = ["ok", "collision", "manual"];

export class Tools {
  /**
   * @param {{frame: () => number, go: (frame: number) => void, changed: () => void,
   *   track: () => void}} on the frame of the file on show, what shows another one, and what to do
   *   after a change and to track again
   */
  constructor(on) {
    this.on = on;
    /** @type {Clip | null} */
    this.clip = null;
    this.isByHand = false;
    const button = (/** @type {string} */ name, /** @type {(clip: Clip) => void} */ act) =>
      el("button", { type: "button", class: "plain", on: { click: () => {
        if (!this.clip) return;
        act(this.clip);
        on.changed();
      } } }, t(name));
    this.point = button("pointHere", (clip) => {
      clip.clickFrame = on.frame();
    });
    this.first = button("startHere", (clip) => {
      clip.first = on.frame();
      if (clip.last !== null && clip.last <= clip.first) clip.last = null;
    });
    this.last = button("endHere", (clip) => {
      clip.last = on.frame();
      if (clip.first !== null && clip.first >= clip.last) clip.first = null;
    });
    this.all = button("allFrames", (clip) => { clip.first = clip.last = null; });
    this.used = el("output", { class: "hint" });
    this.setup = el("div", { class: "row" }, this.point, this.first, this.last, this.all,
      this.used);
    this.next = button("nextDoubtful", (clip) => this.toNext(clip));
    this.hand = button("byHand", () => { this.isByHand = !this.isByHand; });
    this.again = el("button", { type: "button", class: "play", on: { click: on.track } },
      t("trackAgain"));
    this.hint = el("span", { class: "hint" }, t("byHandHint"));
    this.list = el("ul", { class: "chips" });
    this.result = el("div", { class: "row" }, this.next, this.hand, this.again, this.hint);
    this.root = el("div", { class: "clip-tools" }, this.setup, this.result, this.list);
  }

  /**
   * Show what can be done with a clip, and what was chosen.
   * @param {Clip} clip
   */
  update(clip) {
    if (clip !== this.clip) this.isByHand = false;
    this.clip = clip;
    const isSetup = clip.mode === "setup";
    this.setup.hidden = !isSetup;
    this.result.hidden = isSetup || !clip.track;
    this.next.disabled = !clip.track || doubtful(clip.track).length === 0;
    this.again.hidden = this.hint.hidden = !this.isByHand;
    this.again.disabled = clip.stage !== null;
    this.hand.setAttribute("aria-pressed", String(this.isByHand));
    const { first, last, about } = clip;
    this.all.hidden = first === null && last === null;
    this.used.textContent = [t("pointedIn", { frame: clip.clickFrame }),
      this.all.hidden ? t("usedAll") : t("usedFrames", {
        first: first ?? 0, last: last ?? (about?.frames ?? 1) - 1 })].join(" ");
    this.list.hidden = clip.corrections.length === 0;
    this.list.replaceChildren(...clip.corrections.map((each) => this.chip(clip, each)));
    this.moved();
  }

  /** Heed which frame is on show. */
  moved() {
    if (this.clip) this.point.disabled = this.on.frame() === this.clip.clickFrame;
  }

  /**
   * @param {Clip} clip
   * @param {Clip["corrections"][number]} correction
   */
  chip(clip, correction) {
    const ball = t(clip.places.ball_2 ? `ball_${correction.ball}` : "ball");
    const name = t("correction", { frame: correction.frame, ball });
    return el("li", {},
      el("button", { type: "button", class: "link",
        on: { click: () => this.on.go(correction.frame) } }, name),
      el("button", { type: "button", class: "plain", "aria-label": t("clipRemove", { name }),
        on: { click: () => {
          clip.corrections = clip.corrections.filter((each) => each !== correction);
          this.on.changed();
        } } }, "×"));
  }

  /**
   * Show the next frame in which a ball was not plainly seen, after the last one the first.
   * @param {Clip} clip
   */
  toNext({ track }) {
    const frames = track ? doubtful(track) : [];
    this.on.go(frames.find((frame) => frame > this.on.frame()) ?? frames[0]);
  }
}

/**
 * Return the frames of the file in which a ball was not plainly seen.
 * @param {import("./track.js").Track} track
 */
function doubtful(track) {
  const balls = Array.from({ length: track.count }, (_, b) => b);
  return Array.from(track.time, (_, k) => k)
    .filter((k) => balls.some((b) => !FINE.includes(track.flag(k, b))))
    .map((k) => k + track.firstFrame);
}

/**
 * Return the places of a clip that have a handle in a frame of the file, and how balls are drawn.
 * @param {Clip} clip
 * @param {number} frame
 * @param {boolean} isByHand whether balls of a tracked clip are corrected
 * @returns {Record<string, import("./handles.js").HandlePlace> | null}
 */
export function handlesOf(clip, frame, isByHand) {
  const { places, track } = clip;
  if (clip.mode === "result") {
    if (!isByHand || !track) return null;
    return Object.fromEntries(track.places(frame - track.firstFrame).balls.map((seen, b) => {
      const own = clip.corrections.find((each) => each.frame === frame && each.ball === b + 1);
      const place = own ?? (Number.isFinite(seen.u) ? seen : places[`ball_${b + 1}`]);
      return [`ball_${b + 1}`, { u: place.u, v: place.v }];
    }));
  }
  const isShown = (/** @type {string} */ name) => (name.startsWith("region") ? clip.hasRegion
    : name.startsWith("stick") ? clip.hasStick
      : frame === clip.clickFrame && !(name === "pivot" && clip.isPivotOutside));
  return Object.fromEntries(Object.entries(places).filter(([name]) => isShown(name)));
}

/**
 * The first positions of a region's corners and a stick's ends [pixels].
 * @param {{width: number, height: number}} size
 * @returns {Record<string, import("./handles.js").HandlePlace>}
 */
export function toolPlaces({ width, height }) {
  const at = (/** @type {number} */ x, /** @type {number} */ y) => ({
    u: Math.round(x * width), v: Math.round(y * height) });
  return { region_1: at(0.05, 0.05), region_2: at(0.95, 0.95),
    stick_1: at(0.1, 0.3), stick_2: at(0.1, 0.7) };
}

/**
 * Return frames, region, stick and corrections, as the description of a clip has them.
 * @param {Clip} clip
 */
export function toolsOf(clip) {
  const { region_1: one, region_2: other, stick_1: end, stick_2: tip } = clip.places;
  const sorted = (/** @type {number} */ a, /** @type {number} */ b) =>
    [Math.min(a, b), Math.max(a, b)];
  const [left, right] = sorted(one.u, other.u);
  const [top, bottom] = sorted(one.v, other.v);
  return {
    click_frame: clip.clickFrame, first_frame: clip.first, last_frame: clip.last,
    shape: clip.shape,
    region: clip.hasRegion ? [left, top, right, bottom] : null,
    stick: clip.hasStick ? [[end.u, end.v], [tip.u, tip.v]] : null,
    corrections: clip.corrections.map(({ frame, ball, u, v }) => [frame, ball, u, v]),
  };
}
