/** The videos of this page and what was done with them; nothing here draws. */

import { t } from "../strings.js";
import { Desk, filmBlock, filmCopy } from "./desk.js";
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
 *   cancel: () => void, files: Set<string>, tracked: number}} Film
 */

export class Session {
  /** @param {() => void} changed called at every change */
  constructor(changed) {
    this.changed = changed;
    /** @type {Film[]} */
    this.films = [];
    /** @type {Film | null} */
    this.film = null;
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
   * Return whether the server has a film and what was made of it.
   * @param {Film | null} film
   */
  isKept(film) {
    return Boolean(film?.key && this.desk.hello && film.epoch === this.desk.epoch);
  }

  /**
   * Return a film that is on its way.
   * @param {string} name
   * @param {File | null} file
   * @returns {Film}
   */
  begin(name, file) {
    this.count += 1;
    /** @type {Film} */
    const film = { id: this.count, key: "", name, epoch: 0, file, url: "", about: null, places: {},
      proposed: {}, radius: 0, isFound: false, isPartly: false, isProposed: true, truth: {},
      track: null, fits: {},
      warnings: [], noTrial: null, error: null, field: null, stage: null, share: 0, mode: "setup",
      cancel: () => {}, files: new Set(), tracked: 0 };
    this.films.push(film);
    this.film = film;
    return film;
  }

  /**
   * Return what a job found, null if it failed or was cancelled; the film shows how far it is.
   * @param {Film} film
   * @param {(tell: import("./desk.js").Tell) => import("./desk.js").Job} start
   */
  async work(film, start) {
    film.error = film.field = null;
    film.stage = "waiting";
    film.share = 0;
    const job = start((stage, share) => {
      film.stage = stage;
      film.share = share;
      this.changed();
    });
    film.cancel = job.cancel;
    this.changed();
    try {
      return await job.promise;
    } catch (error) {
      const aborted = error instanceof DOMException && error.name === "AbortError";
      film.error = aborted ? t("cancelled") : /** @type {Error} */ (error).message;
      film.field = /** @type {any} */ (error).field ?? null;
      return null;
    } finally {
      film.stage = null;
      film.cancel = () => {};
      this.changed();
    }
  }

  /**
   * Upload a video and look at it.
   * @param {File} file
   */
  async add(file) {
    const film = this.begin(file.name, file);
    await this.send(film);
  }

  /**
   * Upload the file of a film; its places stay if it had some.
   * @param {Film} film
   */
  async send(film) {
    const { desk } = this;
    const sent = await this.work(film, (tell) =>
      desk.upload(/** @type {File} */ (film.file), tell));
    if (!sent) return;
    film.key = sent.film;
    film.epoch = desk.epoch;
    const found = await this.work(film, (tell) => desk.job({ do: "look", film: film.key }, tell));
    if (found) await this.seen(film, found);
  }

  /**
   * Have an example filmed; returns it when it is there.
   * @param {string} kind
   */
  async example(kind) {
    const film = this.begin(t(`example_${kind}`), null);
    const found = await this.work(film, (tell) => this.desk.job({ do: "example", kind }, tell));
    if (!found) return null;
    film.key = found.film;
    film.epoch = this.desk.epoch;
    film.truth = found.truth;
    await this.seen(film, found);
    return film;
  }

  /**
   * @param {Film} film
   * @param {any} found
   */
  async seen(film, found) {
    const isNew = film.about === null;
    film.about = found;
    if (!film.url) film.url = await filmCopy(film.key, "shown.mp4");
    film.isFound = Boolean(found.proposal?.pivot);
    film.isPartly = Boolean(found.proposal) && !film.isFound;
    film.proposed = placesOf(found);
    film.radius = found.proposal?.radius ?? 0.03 * Math.min(found.width, found.height);
    if (isNew) film.places = { ...film.proposed };
    this.changed();
  }

  /**
   * See that the server has a film, which it has not after it was started again.
   * @param {Film} film
   */
  async ensure(film) {
    if (this.isKept(film)) return true;
    if (!film.file || !this.desk.hello) {
      film.error = t("filmsLost");
      this.changed();
      return false;
    }
    await this.send(film);
    return film.error === null;
  }

  /**
   * Track a film.
   * @param {Film} film
   * @param {Record<string, any>} description
   */
  async track(film, description) {
    if (!(await this.ensure(film))) return;
    const found = await this.work(film, (progress) =>
      this.desk.job({ do: "track", film: film.key, description }, progress));
    if (!found) return;
    const track = new Track(await filmBlock(film.key, "points.bin"));
    film.track = track;
    film.fits = found.fits;
    film.warnings = found.warnings;
    film.noTrial = found.no_trial;
    film.mode = "result";
    film.files = new Set();
    film.tracked += 1;
    this.trials = found.trials;
    track.isDriven = Boolean(found.fits.drive?.values);
    await this.lay(film, found.fits);
  }

  /**
   * Do one fit again.
   * @param {Film} film
   * @param {string} kind
   * @param {Record<string, any>} description
   */
  async fit(film, kind, description) {
    if (!this.isKept(film)) {
      film.error = t("filmsLost");
      this.changed();
      return;
    }
    const found = await this.work(film, (progress) =>
      this.desk.job({ do: "fit", kind, film: film.key, description }, progress));
    if (!found) return;
    film.fits = { ...film.fits, [kind]: found };
    await this.lay(film, { [kind]: found });
  }

  /**
   * Take the computed motion of a film if a fit made one.
   * @param {Film} film
   * @param {Record<string, any>} fits
   */
  async lay(film, fits) {
    if (film.track && Object.values(fits).some((fit) => fit.model))
      film.track.model = await filmBlock(film.key, "model.bin");
    this.changed();
  }

  /**
   * Have a file made; returns whether it is there.
   * @param {Film} film
   * @param {string} file
   */
  async make(film, file) {
    const found = await this.work(film, (tell) =>
      this.desk.job({ do: "export", file, film: film.key }, tell));
    if (found) film.files.add(file);
    this.changed();
    return found !== null;
  }

  /**
   * Remove a film here and on the server.
   * @param {Film} film
   */
  async remove(film) {
    film.cancel();
    this.films = this.films.filter((each) => each !== film);
    if (this.film === film) this.film = this.films[this.films.length - 1] ?? null;
    if (film.url) URL.revokeObjectURL(film.url);
    this.changed();
    if (!this.isKept(film)) return;
    const found = await this.desk.job({ do: "remove", film: film.key }).promise.catch(() => null);
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
