/** A motion for those who hear it: its description, its clacks and tones, and its keys. */

import { t } from "../strings.js";
import { el, freshId, tick } from "../page/dom.js";
import { keep, recall } from "../page/preferences.js";
import { KeyList } from "../page/keys.js";
import { sayOffline } from "../page/messages.js";

/** @typedef {import("../page/keys.js").KeyActions} KeyActions */
/** @typedef {import("./live_region.js").LiveRegion} LiveRegion */
/** @typedef {import("./motion.js").Motion} Motion */

// What passed in a longer time of the page, as after a jump, is not heard.
const LONGEST = 0.3; // s

export class Accessibility {
  /**
   * @param {HTMLCanvasElement} stage
   * @param {() => {title: string, actions: KeyActions}[]} keys of the view
   */
  constructor(stage, keys) {
    /** Loaded when it is first wanted. @type {import("./sound.js").Sound | null} */
    this.sound = null;
    /** What is wanted of it. */
    this.wanted = { clacks: false, tones: false };
    /** Says what happens; loaded when the first motion is on show. @type {LiveRegion | null} */
    this.liveRegion = null;
    /** The motion on show. @type {Motion | null} */
    this.motion = null;
    /** Called when the stage is described again, so that others are as well. */
    this.onDescribe = () => {};
    /** Returns what an option is called, if its changes are to be mentioned.
     * @type {(option: string) => string | undefined} */
    this.nameOf = () => undefined;
    /** What screen readers read aloud when it changes. */
    this.line = el("p", { class: "narration unseen", "aria-live": "polite" });
    /** What the stage shows, where a reader looks for that. */
    this.about = el("p", { class: "unseen", id: freshId() });
    this.keys = new KeyList(keys);
    this.heard = 0;
    /** The speed at which balls are as loud as it gets [rad/s]. */
    this.loudest = 1;
    const { line, about } = this;
    const others = stage.getAttribute("aria-describedby");
    stage.setAttribute("aria-describedby", others ? `${about.id} ${others}` : about.id);
    const choice = (/** @type {string} */ name, /** @type {string} */ title,
      /** @type {(on: boolean) => void} */ turn) => {
      const key = `latolato.${name}`;
      const { root, box } = tick(t(name), (on) => {
        keep(key, String(on));
        turn(on);
      });
      box.checked = recall(key) === "true";
      turn(box.checked);
      root.title = title;
      return root;
    };
    /** Stands on the stage. */
    this.toggle = choice("sound", t("soundHint"), (on) => void this.hear({ clacks: on }));
    // Screen readers are silent about what is in a closed `details`, which shows no dialog either.
    /** Say what happens now, and show it to who asks. */
    this.answer = async () => {
      line.classList.remove("unseen");
      await this.load();
      this.liveRegion?.answer();
    };
    this.root = el("div", { class: "senses" },
      el("details", { class: "about" }, el("summary", {}, t("listenAndRead")), el("div", { class: "row" },
        choice("tone", t("toneHint"), (on) => void this.hear({ tones: on })),
        choice("describe", t("describeHint"), (on) => { line.classList.toggle("unseen", !on); }),
        el("button", { type: "button", class: "plain", on: { click: () => this.answer() } },
          t("whatHappens"), el("kbd", { "aria-hidden": "true" }, "W")),
        this.keys.button)),
      line, about, this.keys.dialog);
  }

  /**
   * Play clacks or tones from now on, or no longer.
   * @param {{clacks?: boolean, tones?: boolean}} wanted
   */
  async hear(wanted) {
    Object.assign(this.wanted, wanted);
    if (!this.sound && !Object.values(wanted).includes(true)) return;
    const module = await import("./sound.js").catch(sayOffline);
    if (!module) return;
    this.sound ??= new module.Sound();
    Object.assign(this.sound, this.wanted);
  }

  /** Return the keys that every motion has. @returns {KeyActions} */
  actions() {
    return {
      w: { text: "keyWhat", act: () => this.answer() },
      "?": { text: "keyHelp", act: () => this.keys.open() },
    };
  }

  /**
   * Describe a motion.
   * @param {Motion} motion
   * @param {boolean} [begins] whether it is of another toy, or the same one again, and not a run of other
   *   parameters
   */
  follow(motion, begins = false) {
    this.motion = motion;
    if (!this.liveRegion) void this.load();
    else if (begins) this.liveRegion.begin(motion);
    else this.liveRegion.replace(motion);
  }

  /** Say no more about the motion. */
  leave() {
    this.motion = null;
    this.liveRegion?.show(null);
  }

  /** Load what describes motions, and describe the one on show. */
  async load() {
    if (this.liveRegion) return;
    const module = await import("./live_region.js").catch(sayOffline);
    if (!module || this.liveRegion) return;
    this.liveRegion = new module.LiveRegion(this.line, this.about, this.onDescribe, this.nameOf);
    if (this.motion) this.liveRegion.begin(this.motion);
  }

  /**
   * Follow the motion to an instant.
   * @param {number} time
   * @param {boolean} isPlaying
   * @param {number} speed seconds of the motion in one of the page
   */
  move(time, isPlaying, speed) {
    const { sound, liveRegion } = this;
    const since = time - this.heard;
    if (isPlaying && liveRegion?.motion) {
      const { motion, log } = liveRegion;
      if (sound?.clacks && since > 0 && since < LONGEST * speed)
        for (const { time: at, kind, speed: closing } of log.between(this.heard, time))
          if (kind === "bottom" || kind === "top")
            sound.clack((time - at) / speed, closing / this.loudest, kind);
      if (sound?.tones) sound.follow(motion.balls.map((ball) => motion.angle(ball, time)));
    }
    this.heard = time;
    liveRegion?.move(time, isPlaying);
  }

  close() {
    this.liveRegion?.end();
    this.sound?.close();
  }
}
