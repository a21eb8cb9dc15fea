/** The player: animation, transport and curves of one run, on one clock. */

import { t } from "../strings.js";
import { Clack } from "./clack.js";
import { Clock } from "./clock.js";
import { Curves, scaled } from "./curves.js";
import { el, freshId } from "./dom.js";
import { followKeys } from "./keys.js";
import { Later } from "./later.js";
import { range } from "./motion.js";
import { Plane } from "./plane.js";
import { Scene } from "./scene.js";
import { Start } from "./start.js";
import { short } from "./units.js";

/** @typedef {import("./motion.js").Motion} Motion */

const DEGREES = 180 / Math.PI;
const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
// Text and slider of the instant follow at this rate; the pictures at every frame.
const READ_EVERY = 100; // ms
const SCRUB_STEPS = 10000;
const KINDS = ["bottom", "top", "rest", "release"];
const MOST_ROWS = 200;
// Sections begin with this share of the run left out, which remembers the start.
const SETTLED = 0.2;

/** @type {import("./curves.js").Panel[]} */
export const PANELS = [
  {
    label: t("curveAngle"),
    curves: (motion) => motion.balls.map((ball) => ({
      label: motion.balls.length > 1 ? t(ball.name) : t("angle"),
      paint: ball.name === "left" ? "left" : "right",
      values: scaled(motion.values("angle", ball.row) ?? [], ball.sign * DEGREES),
    })),
  },
  {
    label: t("curveEnergy"),
    curves: (motion) => [
      { label: t("kinetic"), paint: "kinetic", values: summed(motion, "kinetic_energy") },
      { label: t("potential"), paint: "potential", values: summed(motion, "potential_energy") },
      { label: t("total"), paint: "ink", values: summed(motion, "total_energy") },
    ],
  },
  {
    label: t("curvePower"),
    height: 140,
    curves: (motion) => [
      { label: t("drivePower"), paint: "gain", values: summed(motion, "drive_power") },
      { label: t("dampingPower"), paint: "loss", values: summed(motion, "damping_power") },
    ],
  },
];

/**
 * Return a quantity of all balls on show together: a mirrored ball counts as much as its twin.
 * @param {Motion} motion
 * @param {string} name
 */
export function summed(motion, name) {
  const rows = motion.balls.map((ball) => motion.values(name, ball.row));
  const sum = new Float64Array(motion.time.length);
  for (const values of rows)
    if (values) for (let i = 0; i < sum.length; i += 1) sum[i] += values[i];
  return sum;
}

/** How many balls one row of the ledger stands for. */
function ballsPerLedger(/** @type {Motion} */ motion) {
  return motion.balls.length > 1 && motion.balls.every((b) => b.row === 0) ? 2 : 1;
}

export class Player {
  /**
   * @param {HTMLElement} root
   */
  constructor(root) {
    this.clock = new Clock();
    this.root = root;
    /** @type {Motion | null} */
    this.motion = null;
    /** @type {Motion | null} */
    this.pinned = null;
    this.readAt = 0;
    this.later = new Later();
    const canvas = el("canvas", { class: "scene", role: "img", "aria-label": t("animation") });
    this.transport = this.makeTransport();
    const curves = el("div", { class: "curves" });
    const phase = el("canvas", { class: "plane", role: "img", "aria-label": t("phase") });
    const section = el("canvas", { class: "plane", role: "img", "aria-label": t("section") });
    this.contacts = el("div", { class: "table-scroll", tabindex: "0", role: "region",
      "aria-label": t("contacts") });
    this.ledger = el("div", { class: "ledger" });
    this.cards = el("div", { class: "cards" },
      el("section", { class: "card" }, el("h2", {}, t("phase")), phase),
      el("section", { class: "card" }, el("h2", {}, t("section")),
        el("p", { class: "hint" }, t("sectionHint")), section),
      el("section", { class: "card" }, el("h2", {}, t("ledger")),
        el("p", { class: "hint" }, t("ledgerHint")), this.ledger),
      el("section", { class: "card" }, el("h2", {}, t("contacts")), this.contacts));
    root.append(el("div", { class: "stage" }, canvas, this.transport), curves, this.cards);
    this.scene = new Scene(canvas);
    this.start = new Start(this.scene, this.clock);
    canvas.after(this.scene.legend, this.start.said);
    this.clack = new Clack();
    this.scene.onContact = (k) => {
      const { arrays } = /** @type {Motion} */ (this.motion).block;
      if (arrays.contact_kind[k] > 1) return;
      this.clack.sound(Math.abs(arrays.angular_velocity_before[k]) / this.fastest);
    };
    this.fastest = 1;
    this.curves = new Curves(curves, this.clock, PANELS);
    const labels = { x: `${t("angle")} [°]`, y: `${t("angularVelocity")} [rad/s]` };
    this.phase = new Plane(phase, labels);
    this.section = new Plane(section, labels);
    this.clock.subscribe((time) => this.move(time));
    /** @type {Record<string, () => void>} what each key does */
    this.actions = { " ": () => this.clock.toggle(), ",": () => this.stepBy(-1),
      ".": () => this.stepBy(1) };
    followKeys(root, this.actions);
  }

  makeTransport() {
    const id = freshId();
    this.button = el("button", { type: "button", class: "play", on: { click: () => this.clock.toggle() } },
      t("play"));
    this.scrub = el("input", { type: "range", min: "0", max: String(SCRUB_STEPS), step: "1", value: "0",
      class: "scrub", "aria-label": t("scrub"), on: { input: () => {
        this.clock.seek((Number(this.scrub.value) / SCRUB_STEPS) * this.clock.end);
      } } });
    this.timeText = el("output", { class: "time" });
    this.speed = el("select", { id, on: { change: () => {
      this.clock.speed = Number(this.speed.value);
    } } }, ...SPEEDS.map((s) => el("option", { value: String(s), selected: s === 1 },
      t("speedText", { speed: s }))));
    this.loop = el("input", { type: "checkbox", checked: true, on: { change: () => {
      this.clock.looping = this.loop.checked;
    } } });
    const arrows = el("input", { type: "checkbox", on: { change: () => {
      this.scene.showArrows(arrows.checked);
    } } });
    const sound = el("input", { type: "checkbox", on: { change: () => {
      this.clack.on = sound.checked;
    } } });
    return el("div", { class: "transport" },
      el("div", { class: "row" }, this.button,
        el("button", { type: "button", class: "plain", "aria-label": t("stepBack"),
          on: { click: () => this.stepBy(-1) } }, "◂"),
        el("button", { type: "button", class: "plain", "aria-label": t("stepForward"),
          on: { click: () => this.stepBy(1) } }, "▸"),
        this.scrub, this.timeText),
      el("div", { class: "row" },
        el("label", { for: id }, t("speed")), this.speed,
        el("label", { class: "check" }, this.loop, t("loop")),
        el("label", { class: "check", title: t("arrowsHint") }, arrows, t("arrows")),
        el("label", { class: "check" }, sound, t("sound"))));
  }

  /**
   * Show a run, and keep the instant if it has it.
   * @param {Motion} motion
   */
  show(motion) {
    this.motion = motion;
    this.clock.end = motion.end;
    if (this.clock.time > motion.end) this.clock.time = 0;
    this.scene.show(motion);
    const [slow, fast] = range(motion.block.arrays.angular_velocity_before ?? []);
    this.fastest = Math.max(-slow, fast, 1e-9);
    this.later.run([
      ...this.curves.show(motion, this.pinned),
      () => this.showPhase(),
      () => this.showSection(),
      () => this.showLedger(),
      () => this.showContacts(),
    ]);
    this.move(this.clock.time);
    this.start.play();
  }

  /** Keep the run on show behind the next ones, or let it go. */
  togglePin() {
    this.pinned = this.pinned ? null : this.motion;
    this.scene.pinned = this.pinned;
    this.scene.draw();
    if (this.motion) this.later.run(this.curves.show(this.motion, this.pinned));
    return this.pinned !== null;
  }

  showPhase() {
    const motion = /** @type {Motion} */ (this.motion);
    const shapes = motion.balls.map((ball) => ({
      xs: scaled(motion.values("angle", ball.row) ?? [], ball.sign * DEGREES),
      ys: scaled(motion.values("angular_velocity", ball.row) ?? [], ball.sign),
      paint: ball.name === "left" ? "left" : "right",
    }));
    this.phase.show(shapes.slice().reverse());
  }

  showSection() {
    const motion = /** @type {Motion} */ (this.motion);
    const instants = motion.strobes().filter((s) => s >= SETTLED * motion.end);
    const dots = motion.balls.filter((b, i) => i === 0 || b.row > 0).map((ball) => ({
      xs: instants.map((s) => motion.angle(ball, s) * DEGREES),
      ys: instants.map((s) => ball.sign * motion.at("angular_velocity", s, ball.row)),
      paint: ball.name === "left" ? "left" : "right",
      dots: true,
      size: 3,
    }));
    this.section.show(dots);
  }

  showContacts() {
    const motion = /** @type {Motion} */ (this.motion);
    const count = motion.contacts.length;
    if (!count) {
      this.contacts.replaceChildren(el("p", { class: "hint" }, t("noContacts")));
      return;
    }
    const kinds = motion.block.arrays.contact_kind;
    const two = motion.block.shapes.angular_velocity_before[0];
    const cells = (/** @type {string} */ name, /** @type {number} */ i) =>
      Array.from({ length: two }, (_, k) => short(motion.values(name, k)?.[i] ?? NaN, 4)).join(", ");
    const rows = [];
    for (let i = 0; i < Math.min(count, MOST_ROWS); i += 1) {
      const at = motion.contacts[i];
      rows.push(el("tr", {},
        el("td", {}, el("button", { type: "button", class: "link", on: { click: () => this.clock.seek(at) } },
          short(at, 6))),
        el("td", {}, t(KINDS[kinds[i]])),
        el("td", {}, cells("angular_velocity_before", i)),
        el("td", {}, cells("angular_velocity_after", i))));
    }
    this.contacts.replaceChildren(
      count > MOST_ROWS ? el("p", { class: "hint" }, t("contactsMore", { shown: MOST_ROWS, count })) : "",
      el("table", {}, el("thead", {}, el("tr", {}, ...[t("time"), t("kind"), t("before"), t("after")]
        .map((name) => el("th", { scope: "col" }, name)))), el("tbody", {}, ...rows)));
  }

  showLedger() {
    const motion = /** @type {Motion} */ (this.motion);
    const rows = ledgerRows(motion);
    const side = (/** @type {string} */ title, /** @type {(p: {energy: number}) => boolean} */ is) => [
      el("h3", {}, t(title)),
      ...rows.filter(is).map(({ name, share, energy, paint }) => el("div", { class: "ledger-row" },
        el("span", {}, t(name)),
        el("span", { class: "bar" }, bar(share, paint)),
        el("output", {}, `${(100 * share).toFixed(1)} %`),
        el("output", { class: "soft" }, `${short(Math.abs(energy), 4)} J`)))];
    this.ledger.replaceChildren(
      ...side("cameIn", (row) => row.energy > 0), ...side("wentOut", (row) => row.energy <= 0));
  }

  /** @param {number} steps */
  stepBy(steps) {
    const motion = this.motion;
    if (!motion) return;
    this.clock.pause();
    this.clock.seek(this.clock.time + (steps * motion.end) / (motion.time.length - 1));
  }

  /** @param {number} time */
  move(time) {
    const motion = this.motion;
    if (!motion) return;
    this.scene.move(time);
    const marks = motion.balls.map((ball) => ({
      x: motion.angle(ball, time) * DEGREES,
      y: ball.sign * motion.at("angular_velocity", time, ball.row),
      paint: ball.name === "left" ? "left" : "right",
    }));
    this.phase.mark(marks);
    const label = this.clock.playing ? t("pause") : t("play");
    if (this.button && this.button.textContent !== label) this.button.textContent = label;
    const now = performance.now();
    if (this.clock.playing && now - this.readAt < READ_EVERY) return;
    this.readAt = now;
    if (this.timeText) this.timeText.textContent = t("timeText", { time: time.toFixed(2) });
    const { activeElement } = /** @type {Document | ShadowRoot} */ (this.root.getRootNode());
    if (this.scrub && activeElement !== this.scrub || this.clock.playing)
      /** @type {HTMLInputElement} */ (this.scrub).value =
        String(Math.round((SCRUB_STEPS * time) / (this.clock.end || 1)));
  }

  destroy() {
    this.later.run([]);
    this.clock.pause();
    this.clack.close();
    this.curves.destroy();
    this.scene.release();
    this.phase.release();
    this.section.release();
  }
}

/**
 * Return where the energy came from (positive) and where it went or what is left (negative), with
 * shares of all that came in: those of each side sum to one.
 * @param {Motion} motion
 * @returns {{name: string, energy: number, share: number, paint: string}[]}
 */
export function ledgerRows(motion) {
  const times = ballsPerLedger(motion);
  const last = (/** @type {string} */ name) => times * (motion.about.ledger[name] ?? 0);
  const [first, end] = [0, motion.time.length - 1].map((i) => motion.balls.reduce((sum, ball) =>
    sum + (motion.values("total_energy", ball.row)?.[i] ?? 0), 0));
  const parts = [
    { name: "atStart", energy: first, paint: "soft" },
    { name: "drivePower", energy: last("drive_work"), paint: "gain" },
    { name: motion.about.by_hand ? "hand" : "noise", energy: last("noise_work"), paint: "soft" },
    { name: "dampingPower", energy: -last("damping_loss"), paint: "loss" },
    { name: "impacts", energy: -last("impact_loss"), paint: "force" },
    { name: "capture", energy: -last("capture_loss"), paint: "left" },
    { name: "left_over", energy: -end, paint: "right" },
  ];
  const came = parts.reduce((sum, { energy }) => sum + Math.max(energy, 0), 0);
  return parts.filter((p) => Math.abs(p.energy) > 1e-9 * came || p.name === "left_over")
    .map((part) => ({ ...part, share: came ? Math.abs(part.energy) / came : 0 }));
}

/**
 * @param {number} share
 * @param {string} paint
 */
function bar(share, paint) {
  const inner = el("span", { class: `fill ${paint}` });
  inner.style.width = `${Math.min(100, 100 * Math.abs(share))}%`;
  return inner;
}
