/** A small player: the animation and the angles of one run. */

import { t } from "../strings.js";
import { Clock } from "./clock.js";
import { Curves } from "./curves.js";
import { el } from "../page/dom.js";
import { Scene } from "./scene.js";
import { anglePanel } from "./timeline.js";

/** @typedef {import("./motion.js").Motion} Motion */

export class Preview {
  constructor() {
    this.clock = new Clock();
    const canvas = el("canvas", { class: "scene small", role: "img",
      "aria-label": t("animation") });
    const curves = el("div", { class: "curves" });
    this.button = el("button", { type: "button", class: "play",
      on: { click: () => this.clock.toggle() } }, t("play"));
    this.time = el("output", { class: "time" });
    this.root = el("div", { class: "preview" }, canvas,
      el("div", { class: "row" }, this.button, this.time), curves);
    this.scene = new Scene(canvas);
    this.curves = new Curves(curves, this.clock, [anglePanel()]);
    this.clock.subscribe((time) => {
      this.scene.move(time);
      const label = t(this.clock.playing ? "pause" : "play");
      if (this.button.textContent !== label) this.button.textContent = label;
      const text = t("timeText", { time: time.toFixed(1) });
      if (this.time.textContent !== text) this.time.textContent = text;
    });
  }

  /** @param {Motion} motion */
  show(motion) {
    this.clock.end = motion.end;
    this.scene.show(motion);
    this.curves.show(motion);
    this.clock.seek(0);
  }

  /** Stop the clock. */
  rest() {
    this.clock.pause();
  }
}
