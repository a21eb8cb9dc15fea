/** The videos and tables of this page and what was done with them; nothing here draws. */

import { askJson } from "../page/api.js";
import { inner } from "../page/block.js";
import { t } from "../strings.js";
import { clipCopy, Desk } from "./desk.js";
import { sheetOf } from "./sheet.js";
import { toolPlaces } from "./tools.js";
import { Track } from "./track.js";

/** @typedef {import("./handles.js").HandlePlace} HandlePlace */
/**
 * @typedef {{width: number, height: number, frames: number, duration: number,
 *   clock: {capture_rate: number, shown_rate: number, slow_motion: number, is_sure: boolean},
 *   damage: import("../model/rules.js").Sentence | null,
 *   proposal: {pivot: number[] | null, balls: number[][], radius: number, click_frame: number} | null}} ClipAbout
 * @typedef {{name: string, value: number, sigma: number, units: string,
 *   given?: Record<string, number>}} Answer
 */
/** @typedef {ReturnType<typeof newClip>} Clip */

/**
 * Return a video or a table that is on its way.
 * @param {number} id
 * @param {string} name
 * @param {File | null} file null for an example
 */
function newClip(id, name, file) {
  return { id, name, file, key: "", epoch: 0, url: "",
    /** What the server saw in a video, or recognised in a table. */
    about: /** @type {ClipAbout | null} */ (null), sheet: /** @type {import("./sheet.js").Sheet | null} */ (null),
    times: /** @type {ArrayLike<number>} */ ([0]), radius: 0,
    hasPivot: false, hasBalls: false, proposed: /** @type {Record<string, HandlePlace>} */ ({}),
    /** What somebody chose. */
    decimal: "", clickFrame: 0, first: /** @type {number | null} */ (null),
    last: /** @type {number | null} */ (null), hasRegion: false, hasStick: false, shape: "disc",
    isPivotOutside: false, places: /** @type {Record<string, HandlePlace>} */ ({}),
    /** Which of pivot and balls somebody moved or confirmed; the others are where they were found. */
    pointed: /** @type {Set<string>} */ (new Set()),
    corrections: /** @type {{frame: number, ball: number, u: number, v: number}[]} */ ([]),
    /** What came of it. */
    mode: /** @type {"setup" | "result"} */ ("setup"), tracked: 0, track: /** @type {Track | null} */ (null),
    finding: /** @type {(string | import("../model/rules.js").Sentence)[]} */ ([]),
    answer: /** @type {Answer[]} */ ([]), fits: /** @type {Record<string, any>} */ ({}),
    warnings: /** @type {(string | import("../model/rules.js").Sentence)[]} */ ([]),
    noTrial: /** @type {import("./results.js").Told | null} */ (null),
    code: /** @type {string[]} */ ([]), files: /** @type {Set<string>} */ (new Set()),
    truth: /** @type {Record<string, number>} */ ({}),
    /** How far work is, and what went wrong. */
    stage: /** @type {string | null} */ (null), share: 0, cancel: () => {},
    error: /** @type {string | null} */ (null), field: /** @type {string | null} */ (null) };
}

export class Session {
  /**
   * @param {() => void} changed called at every change
   * @param {(error: Error) => [string, string | null]} worded the text of an error in the words of the page, and
   *   the field that it is about
   */
  constructor(changed, worded) {
    this.changed = changed;
    this.worded = worded;
    /** @type {Clip[]} */
    this.clips = [];
    /** @type {Clip | null} */
    this.clip = null;
    /** @type {any[]} */
    this.trials = [];
    this.count = 0;
    this.desk = new Desk((open) => {
      // A server that was started again knows nothing of what was done before.
      if (open) this.trials = [];
      changed();
    });
  }

  /**
   * Return whether the server has a clip and what was made of it.
   * @param {Clip | null} clip
   */
  isKept(clip) {
    return Boolean(clip?.key && this.desk.hello && clip.epoch === this.desk.epoch);
  }

  /**
   * Return a clip that is on its way.
   * @param {string} name
   * @param {File | null} file
   */
  begin(name, file) {
    this.count += 1;
    const clip = newClip(this.count, name, file);
    this.clips.push(clip);
    this.clip = clip;
    return clip;
  }

  /**
   * Return the result of work, null if it failed or was cancelled; the clip shows how far it is.
   * @template T
   * @param {Clip} clip
   * @param {(follow: import("./desk.js").Follow) => Promise<T>} start
   */
  async work(clip, start) {
    clip.error = clip.field = null;
    clip.stage = "waiting";
    clip.share = 0;
    const own = new AbortController();
    clip.cancel = () => own.abort();
    this.changed();
    try {
      return await start({ signal: own.signal, notify: ({ state, progress = 0 }) => {
        clip.stage = state;
        clip.share = progress;
        this.changed();
      } });
    } catch (error) {
      const aborted = error instanceof DOMException && error.name === "AbortError";
      const { input, field = null } = /** @type {any} */ (error);
      [clip.error, clip.field] = aborted ? [t("cancelled"), null] : this.worded(input ?? error);
      clip.field ??= field;
      return null;
    } finally {
      clip.stage = null;
      clip.cancel = () => {};
      this.changed();
    }
  }

  /**
   * Upload a file and look at it.
   * @param {File} file
   */
  async add(file) {
    const clip = this.begin(file.name, file);
    await this.send(clip);
  }

  /**
   * Upload the file of a clip; its places stay if it had some.
   * @param {Clip} clip
   */
  async send(clip) {
    const { desk } = this;
    const key = await this.work(clip, (follow) =>
      desk.upload(/** @type {File} */ (clip.file), follow));
    if (!key) return;
    clip.key = key;
    clip.epoch = desk.epoch;
    await this.look(clip);
  }

  /**
   * Have the server say what a clip is.
   * @param {Clip} clip
   */
  async look(clip) {
    const { key, decimal } = clip;
    const block = await this.work(clip, (follow) =>
      this.desk.job({ do: "look", clip: key, decimal: decimal || null }, follow));
    if (block) await this.seen(clip, block);
  }

  /**
   * Have an example filmed; returns it when it is there.
   * @param {string} kind
   */
  async example(kind) {
    const clip = this.begin(t(`example_${kind}`), null);
    const block = await this.work(clip, (follow) =>
      this.desk.job({ do: "example", kind, desk: this.desk.hello?.desk }, follow));
    if (!block) return null;
    clip.key = block.about.clip;
    clip.epoch = this.desk.epoch;
    clip.truth = block.about.truth;
    await this.seen(clip, block);
    return clip;
  }

  /**
   * @param {Clip} clip
   * @param {import("../page/block.js").Block} block
   */
  async seen(clip, block) {
    const isNew = !isSeen(clip);
    const about = /** @type {any} */ (block.about);
    if (about.table) {
      if (isNew) clip.sheet = { ...sheetOf(about.table), decimal: clip.decimal };
      this.changed();
      return;
    }
    clip.about = about;
    clip.times = block.arrays.time;
    if (!clip.url) clip.url = await clipCopy(clip.key, "copy.mp4");
    const { proposal, width, height } = about;
    clip.hasPivot = Boolean(proposal?.pivot);
    clip.hasBalls = Boolean(proposal);
    clip.proposed = proposedPlaces(about);
    clip.radius = proposal?.radius ?? 0.03 * Math.min(width, height);
    if (isNew) {
      clip.places = { ...toolPlaces(about), ...clip.proposed };
      clip.clickFrame = proposal?.click_frame ?? 0;
      if (about.damage) clip.last = about.frames - 1;
    }
    this.changed();
  }

  /**
   * Send a clip again to a server that was started again.
   * @param {Clip} clip
   */
  async sendAgain(clip) {
    if (!clip.file || !this.desk.hello) {
      clip.error = t("clipsLost");
      this.changed();
      return false;
    }
    await this.send(clip);
    return clip.error === null;
  }

  /**
   * Track a video, or import a table.
   * @param {Clip} clip
   * @param {Record<string, any>} description
   */
  async track(clip, description) {
    // Work that begins at once shows its Cancel button, which then takes the focus.
    if (!this.isKept(clip) && !(await this.sendAgain(clip))) return;
    const block = await this.work(clip, (follow) =>
      this.desk.job({ do: clip.sheet ? "import" : "track", clip: clip.key, description }, follow));
    if (!block) return;
    const { finding, answer, fits, warnings, no_trial: noTrial, trials, code = [] } = block.about;
    const track = new Track(inner(block, "points"));
    Object.assign(clip, { track, finding, answer, fits, warnings, noTrial, code });
    clip.mode = "result";
    clip.files = new Set();
    clip.tracked += 1;
    this.trials = trials;
    track.isDriven = Boolean(fits.drive?.values);
    this.lay(clip, fits, block);
  }

  /**
   * Do one fit again.
   * @param {Clip} clip
   * @param {string} kind
   * @param {Record<string, any>} description
   */
  async fit(clip, kind, description) {
    if (!this.isKept(clip)) {
      clip.error = t("clipsLost");
      this.changed();
      return;
    }
    const block = await this.work(clip, (follow) =>
      this.desk.job({ do: "fit", kind, clip: clip.key, description }, follow));
    if (!block) return;
    const fits = { [kind]: block.about };
    clip.fits = { ...clip.fits, ...fits };
    this.lay(clip, fits, block);
  }

  /**
   * Take the computed motion of a clip if a fit made one.
   * @param {Clip} clip
   * @param {Record<string, any>} fits
   * @param {import("../page/block.js").Block} block
   */
  lay(clip, fits, block) {
    if (clip.track && Object.values(fits).some((fit) => fit.model))
      clip.track.model = inner(block, "model");
    this.changed();
  }

  /**
   * Have a file made; returns whether it is there.
   * @param {Clip} clip
   * @param {string} file
   */
  async make(clip, file) {
    const block = await this.work(clip, (follow) =>
      this.desk.job({ do: "export", file, clip: clip.key }, follow));
    if (block) clip.files.add(file);
    this.changed();
    return block !== null;
  }

  /**
   * Remove a clip here and on the server.
   * @param {Clip} clip
   */
  async remove(clip) {
    clip.cancel();
    this.clips = this.clips.filter((each) => each !== clip);
    if (this.clip === clip) this.clip = this.clips[this.clips.length - 1] ?? null;
    if (clip.url) URL.revokeObjectURL(clip.url);
    this.changed();
    if (!this.isKept(clip)) return;
    const rest = await askJson("api/experiment/remove", { clip: clip.key }).catch(() => null);
    if (rest) this.trials = rest.trials;
    this.changed();
  }
}

/**
 * Return whether the server has read a file.
 * @param {Clip} clip
 */
export function isSeen({ about, sheet }) {
  return about !== null || sheet !== null;
}

/**
 * Return whether pivot and balls are those that were found.
 * @param {Clip} clip
 */
export function isAsFound({ about, clickFrame, places, pointed, proposed }) {
  return pointed.size === 0 && clickFrame === (about?.proposal?.click_frame ?? 0)
    && ("ball_2" in places) === ("ball_2" in proposed);
}

/**
 * Return where pivot and balls are, and whether they were found instead of pointed at.
 * @param {Clip} clip
 */
export function pivotAndBalls({ isPivotOutside, places, pointed }) {
  const { pivot, ...others } = places;
  const balls = ["ball_1", "ball_2"].filter((name) => name in others);
  const pair = (/** @type {HandlePlace} */ { u, v }) => [u, v];
  const isFound = !isPivotOutside && !pointed.has("pivot");
  return { pivot: isPivotOutside ? "outside" : pair(pivot), balls: balls.map((name) => pair(others[name])),
    is_pivot_found: isFound, is_proposed: isFound || balls.some((name) => !pointed.has(name)) };
}

/**
 * Return handles where pivot and balls are proposed, or somewhere to begin with.
 * @param {any} about
 * @returns {Record<string, HandlePlace>}
 */
function proposedPlaces({ width, height, proposal }) {
  const place = (/** @type {number[]} */ [u, v]) => ({ u, v });
  const balls = proposal?.balls ?? [[0.6 * width, 0.7 * height]];
  /** @type {Record<string, HandlePlace>} */
  const places = { pivot: place(proposal?.pivot ?? [0.5 * width, 0.2 * height]),
    ball_1: place(balls[0]) };
  if (balls[1]) places.ball_2 = place(balls[1]);
  return places;
}
