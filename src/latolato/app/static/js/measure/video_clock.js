/** The clock of a video: its instants are those of the frames that the browser shows. */

import { Clock } from "../player/clock.js";
import { before } from "../player/motion.js";

// Times of the container are whole ticks: a frame shows a little before or after its number says.
const SLACK = 2e-4; // s

export class ClipClock extends Clock {
  /** @param {HTMLVideoElement} video */
  constructor(video) {
    super();
    this.video = video;
    /** Times of the frames in the file that is played, and in the scene [s]. */
    this.media = /** @type {ArrayLike<number>} */ (new Float64Array([0]));
    this.times = /** @type {ArrayLike<number>} */ (new Float64Array([0]));
    this.index = 0;
    /** @type {number | null} */
    this.wanted = null;
    video.loop = true;
    video.addEventListener("seeked", () => {
      this.present(video.currentTime);
      if (this.wanted !== null) this.ask(this.wanted);
    });
    video.addEventListener("pause", () => this.update());
    video.addEventListener("playing", () => this.update());
    if ("requestVideoFrameCallback" in video) {
      const next = () => video.requestVideoFrameCallback((_, meta) => {
        this.present(meta.mediaTime + SLACK);
        next();
      });
      next();
    } else {
      /** @type {any} */ (video).addEventListener("timeupdate",
        () => this.present(this.video.currentTime));
    }
  }

  /**
   * Take the times of another clip's frames.
   * @param {ArrayLike<number>} media in the file [s]
   * @param {ArrayLike<number>} times in the scene, from 0 [s]
   */
  load(media, times) {
    this.media = media;
    this.times = times;
    this.end = times[times.length - 1];
    this.index = Math.min(this.index, times.length - 1);
    this.time = times[this.index];
    this.notify();
  }

  update() {
    this.playing = !this.video.paused;
    this.notify();
  }

  play() {
    this.video.playbackRate = this.rate();
    void this.video.play().catch(() => this.update());
  }

  pause() {
    this.video.pause();
  }

  /** Return how fast the file is played so that the scene has the speed of the clock. */
  rate() {
    const span = this.media[this.media.length - 1] / (this.end || 1) || 1;
    return Math.min(Math.max(this.speed * span, 0.0625), 16);
  }

  /** @param {number} speed */
  hurry(speed) {
    this.speed = speed;
    this.video.playbackRate = this.rate();
  }

  /** @param {number} time */
  seek(time) {
    const i = before(this.times, time);
    const next = Math.min(i + 1, this.times.length - 1);
    this.go(time - this.times[i] > this.times[next] - time ? next : i);
  }

  /**
   * Show a frame.
   * @param {number} index
   */
  go(index) {
    const whole = Math.min(Math.max(Math.round(index), 0), this.times.length - 1);
    if (this.video.seeking) this.wanted = whole;
    else this.ask(whole);
  }

  /** @param {number} index */
  ask(index) {
    this.wanted = null;
    const { media } = this;
    const gap = index + 1 < media.length ? media[index + 1] - media[index]
      : media[index] - (media[index - 1] ?? 0);
    this.video.currentTime = media[index] + 0.5 * gap;
  }

  /** @param {number} time of the file that is on show */
  present(time) {
    const { media } = this;
    const last = media[media.length - 1];
    const slack = last - (media[media.length - 2] ?? last) + SLACK;
    // A part of the file is played over and over.
    if (this.playing && (time < media[0] - slack || time > last + slack)) {
      this.go(0);
      return;
    }
    this.index = before(this.media, time);
    this.time = this.times[this.index];
    this.notify();
  }
}
