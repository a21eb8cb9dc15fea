/** The videos of this page and what was done with them; nothing here draws. */

import { t } from "../strings.js";
import { clipBlock, clipCopy, Desk } from "./desk.js";
import { Track } from "./track.js";

/** @typedef {import("./handles.js").Place} Place */
/**
 * @typedef {{id: number, key: string, name: string, epoch: number, file: File | null, url: string,
 *   about: {width: number, height: number, frames: number, duration: number} | null,
 *   places: Record<string, Place>, proposed: Record<string, Place>, radius: number,
 *   isFound: boolean, isPartly: boolean, isProposed: boolean, truth: Record<string, number>,
 *   track: Track | null,
 *   fits: Record<string, any>, warnings: string[], noTrial: string | null, error: string | null,
 *   field: string | null, stage: string | null, share: number, mode: "setup" | "result",
 *   cancel: () => void, files: Set<string>, tracked: number}} Clip
 */

export class Session {
  /** @param {() => void} changed called at every change */
  constructor(changed) {
    this.changed = changed;
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
   * @returns {Clip}
   */
  begin(name, file) {
    this.count += 1;
    /** @type {Clip} */
    const clip = { id: this.count, key: "", name, epoch: 0, file, url: "", about: null, places: {},
      proposed: {}, radius: 0, isFound: false, isPartly: false, isProposed: true, truth: {},
      track: null, fits: {},
      warnings: [], noTrial: null, error: null, field: null, stage: null, share: 0, mode: "setup",
      cancel: () => {}, files: new Set(), tracked: 0 };
    this.clips.push(clip);
    this.clip = clip;
    return clip;
  }

  /**
   * Return what a job found, null if it failed or was cancelled; the clip shows how far it is.
   * @param {Clip} clip
   * @param {(tell: import("./desk.js").Tell) => import("./desk.js").Job} start
   */
  async work(clip, start) {
    clip.error = clip.field = null;
    clip.stage = "waiting";
    clip.share = 0;
    const job = start((stage, share) => {
      clip.stage = stage;
      clip.share = share;
      this.changed();
    });
    clip.cancel = job.cancel;
    this.changed();
    try {
      return await job.promise;
    } catch (error) {
      const aborted = error instanceof DOMException && error.name === "AbortError";
      clip.error = aborted ? t("cancelled") : /** @type {Error} */ (error).message;
      clip.field = /** @type {any} */ (error).field ?? null;
      return null;
    } finally {
      clip.stage = null;
      clip.cancel = () => {};
      this.changed();
    }
  }

  /**
   * Upload a video and look at it.
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
    const sent = await this.work(clip, (tell) =>
      desk.upload(/** @type {File} */ (clip.file), tell));
    if (!sent) return;
    clip.key = sent.clip;
    clip.epoch = desk.epoch;
    const found = await this.work(clip, (tell) => desk.job({ do: "look", clip: clip.key }, tell));
    if (found) await this.seen(clip, found);
  }

  /**
   * Have an example filmed; returns it when it is there.
   * @param {string} kind
   */
  async example(kind) {
    const clip = this.begin(t(`example_${kind}`), null);
    const found = await this.work(clip, (tell) => this.desk.job({ do: "example", kind }, tell));
    if (!found) return null;
    clip.key = found.clip;
    clip.epoch = this.desk.epoch;
    clip.truth = found.truth;
    await this.seen(clip, found);
    return clip;
  }

  /**
   * @param {Clip} clip
   * @param {any} found
   */
  async seen(clip, found) {
    const isNew = clip.about === null;
    clip.about = found;
    if (!clip.url) clip.url = await clipCopy(clip.key, "shown.mp4");
    clip.isFound = Boolean(found.proposal?.pivot);
    clip.isPartly = Boolean(found.proposal) && !clip.isFound;
    clip.proposed = placesOf(found);
    clip.radius = found.proposal?.radius ?? 0.03 * Math.min(found.width, found.height);
    if (isNew) clip.places = { ...clip.proposed };
    this.changed();
  }

  /**
   * See that the server has a clip, which it has not after it was started again.
   * @param {Clip} clip
   */
  async ensure(clip) {
    if (this.isKept(clip)) return true;
    if (!clip.file || !this.desk.hello) {
      clip.error = t("clipsLost");
      this.changed();
      return false;
    }
    await this.send(clip);
    return clip.error === null;
  }

  /**
   * Track a clip.
   * @param {Clip} clip
   * @param {Record<string, any>} description
   */
  async track(clip, description) {
    if (!(await this.ensure(clip))) return;
    const found = await this.work(clip, (progress) =>
      this.desk.job({ do: "track", clip: clip.key, description }, progress));
    if (!found) return;
    const track = new Track(await clipBlock(clip.key, "points.bin"));
    clip.track = track;
    clip.fits = found.fits;
    clip.warnings = found.warnings;
    clip.noTrial = found.no_trial;
    clip.mode = "result";
    clip.files = new Set();
    clip.tracked += 1;
    this.trials = found.trials;
    track.isDriven = Boolean(found.fits.drive?.values);
    await this.lay(clip, found.fits);
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
    const found = await this.work(clip, (progress) =>
      this.desk.job({ do: "fit", kind, clip: clip.key, description }, progress));
    if (!found) return;
    clip.fits = { ...clip.fits, [kind]: found };
    await this.lay(clip, { [kind]: found });
  }

  /**
   * Take the computed motion of a clip if a fit made one.
   * @param {Clip} clip
   * @param {Record<string, any>} fits
   */
  async lay(clip, fits) {
    if (clip.track && Object.values(fits).some((fit) => fit.model))
      clip.track.model = await clipBlock(clip.key, "model.bin");
    this.changed();
  }

  /**
   * Have a file made; returns whether it is there.
   * @param {Clip} clip
   * @param {string} file
   */
  async make(clip, file) {
    const found = await this.work(clip, (tell) =>
      this.desk.job({ do: "export", file, clip: clip.key }, tell));
    if (found) clip.files.add(file);
    this.changed();
    return found !== null;
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
    const found = await this.desk.job({ do: "remove", clip: clip.key }).promise.catch(() => null);
    if (found) this.trials = found.trials;
    this.changed();
  }
}

/**
 * Return handles where pivot and balls were found, or somewhere to begin with.
 * @param {any} found
 * @returns {Record<string, Place>}
 */
function placesOf({ width, height, proposal }) {
  const place = (/** @type {number[]} */ [u, v]) => ({ u, v });
  const balls = proposal?.balls ?? [[0.6 * width, 0.7 * height]];
  /** @type {Record<string, Place>} */
  const found = { pivot: place(proposal?.pivot ?? [0.5 * width, 0.2 * height]),
    ball_1: place(balls[0]) };
  if (balls[1]) found.ball_2 = place(balls[1]);
  return found;
}
