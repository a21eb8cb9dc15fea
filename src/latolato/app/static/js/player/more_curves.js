/** What is shown of a run when somebody asks: energies and powers, portrait, section, ledger, contacts. */

import { local, t } from "../strings.js";
import { Curves } from "./curves.js";
import { el } from "../page/dom.js";
import { KINDS } from "./events.js";
import { scaled } from "./traces.js";
import { DEGREE, localShort } from "../page/unit_text.js";
import { XYPlot } from "./xy_plot.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("./clock.js").Clock} Clock */
/** @typedef {import("./curves.js").Panel} Panel */

const MOST_ROWS = 200;
/** What the table of contacts says about velocities, and its heads. @type {Record<string, string>} */
const CONTACT_COLUMNS = { angular_velocity_before: "before", angular_velocity_after: "after",
  radial_velocity_before: "outwardsBefore", radial_velocity_after: "outwardsAfter" };
// Sections begin with this share of the run left out, which remembers the start.
const SETTLED = 0.2;
// Of the balls, from the back to the front.
const PAINTS = ["left", "right"];
const LENGTH = { unit: "cm", size: 1e-2 }; // m

/** @type {Panel[]} */
const ENERGY_PANELS = [
  {
    label: (motion) => t("curveEnergy", { whose: whose(motion) }),
    quantity: "energy",
    curves: (motion) => [
      { label: t("kinetic"), paint: "kinetic", values: summed(motion, "kinetic_energy") },
      { label: t("potential"), paint: "potential", values: summed(motion, "potential_energy") },
      { label: t("total"), paint: "ink", values: summed(motion, "total_energy") },
    ],
  },
  {
    label: (motion) => t("curvePower", { whose: whose(motion) }),
    quantity: "power",
    height: 140,
    curves: (motion) => [
      { label: t("drivePower"), paint: "gain", values: summed(motion, "drive_power") },
      { label: t("dampingPower"), paint: "loss", values: summed(motion, "damping_power") },
    ],
  },
];

/** How far balls on strings are from the hand. @type {Panel} */
const DISTANCE_PANEL = {
  label: t("curveDistance", { unit: LENGTH.unit }),
  height: 140,
  curves: (motion) => motion.balls.filter(({ row }, i) => i === 0 || row > 0).map((ball) => ({
    label: motion.balls.some(({ row }) => row > 0) ? t(ball.name) : t("distance"),
    paint: ball.name === "left" ? "left" : "right",
    values: scaled(motion.values("distance", ball.row) ?? [], 1 / LENGTH.size),
  })),
};

/** The content of a drawer, which computes and draws while the drawer is open. */
export class MoreCurves {
  /**
   * @param {HTMLDetailsElement} root the drawer
   * @param {Clock} clock
   * @param {Curves} angles that show the same stretch of time
   */
  constructor(root, clock, angles) {
    this.root = root;
    this.clock = clock;
    this.angles = angles;
    /** @type {Motion | null} */
    this.motion = null;
    /** @type {Motion | null} */
    this.pinned = null;
    const curves = el("div", { class: "curves" });
    const [phase, section] = ["phase", "section"].map((name) =>
      el("div", { class: "chart", role: "img", "aria-label": t(name) }));
    this.contacts = el("div", { class: "table-scroll", tabindex: "0", role: "region",
      "aria-label": t("contacts") });
    this.ledger = el("div", { class: "ledger" });
    this.ledgerTitle = el("h2", {});
    const card = (/** @type {Node} */ title, /** @type {(Node | string)[]} */ ...content) =>
      el("section", { class: "card" }, title, ...content);
    const head = (/** @type {string} */ name) => el("h2", {}, t(name));
    root.addEventListener("toggle", () => this.draw());
    root.append(curves, el("div", { class: "cards" }, card(head("phase"), phase),
        card(head("section"), el("p", { class: "hint" }, t("sectionHint")), section),
        card(this.ledgerTitle, el("p", { class: "hint" }, t("ledgerHint")), this.ledger),
        card(head("contacts"), this.contacts)));
    this.curves = new Curves(curves, clock, ENERGY_PANELS);
    this.curves.onZoom = (from, to) => angles.zoom(from, to);
    const labels = { x: `${t("angle")} [°]`, y: `${t("angularVelocity")} [rad/s]` };
    this.makePlots = () => ({ phase: new XYPlot(phase, labels, PAINTS),
      section: new XYPlot(section, labels, PAINTS, { hasDots: true }) });
    /** Made when they are first shown. @type {{phase: XYPlot, section: XYPlot} | null} */
    this.plots = null;
  }

  /**
   * Show a run: now if the drawer is open, else when it is opened again.
   * @param {Motion} motion
   * @param {Motion | null} pinned
   */
  show(motion, pinned) {
    this.motion = motion;
    this.pinned = pinned;
    this.curves.motion = null;
    this.draw();
  }

  /** What is drawn, null while the drawer is closed. */
  get drawn() {
    return this.curves.motion;
  }

  draw() {
    const { motion, pinned } = this;
    if (!this.root.open) this.curves.motion = null;
    if (!this.root.open || !motion || this.drawn === motion) return;
    this.curves.panels = motion.isString ? [...ENERGY_PANELS, DISTANCE_PANEL] : ENERGY_PANELS;
    if (motion.grows) {
      this.curves.show(motion);
      return;
    }
    this.plots ??= this.makePlots();
    this.curves.show(motion, pinned, [
      () => this.showPhase(motion),
      () => this.showSection(motion),
      () => this.showLedger(motion),
      () => this.showContacts(motion),
    ]);
    this.curves.setSpan(...this.angles.span);
    this.move(this.clock.time);
  }

  /**
   * Show a stretch of time.
   * @param {number} from
   * @param {number} to
   */
  setSpan(from, to) {
    if (this.drawn && !this.drawn.grows) this.curves.setSpan(from, to);
  }

  /** @param {number} time */
  move(time) {
    const { drawn } = this;
    if (!drawn || drawn.grows) return;
    this.plots?.phase.mark(byPaint(drawn.balls, (ball) => ({
      x: drawn.angle(ball, time) / DEGREE,
      y: ball.sign * drawn.at("angular_velocity", time, ball.row),
    })));
  }

  /** @param {Motion} motion */
  showPhase(motion) {
    this.plots?.phase.show(byPaint(motion.balls, (ball) => ({
      xs: scaled(motion.values("angle", ball.row) ?? [], ball.sign / DEGREE),
      ys: scaled(motion.values("angular_velocity", ball.row) ?? [], ball.sign),
    })));
  }

  /** @param {Motion} motion */
  showSection(motion) {
    const instants = motion.strobes().filter((s) => s >= SETTLED * motion.end);
    this.plots?.section.show(byPaint(motion.balls.filter((b, i) => i === 0 || b.row > 0), (ball) => ({
      xs: instants.map((s) => motion.angle(ball, s) / DEGREE),
      ys: instants.map((s) => ball.sign * motion.at("angular_velocity", s, ball.row)),
    })));
  }

  /** @param {Motion} motion */
  showContacts(motion) {
    const count = motion.contacts.length;
    if (!count) {
      this.contacts.replaceChildren(el("p", { class: "hint" }, t("noContacts")));
      return;
    }
    const two = motion.block.shapes.angular_velocity_before[0];
    const cells = (/** @type {string} */ name, /** @type {number} */ i) =>
      Array.from({ length: two }, (_, k) => localShort(motion.values(name, k)?.[i] ?? NaN, 4)).join(", ");
    const columns = Object.keys(CONTACT_COLUMNS).filter((name) => name in motion.block.arrays);
    const rows = [];
    for (let i = 0; i < Math.min(count, MOST_ROWS); i += 1) {
      const at = motion.contacts[i];
      rows.push(el("tr", {},
        el("td", {}, el("button", { type: "button", class: "link", on: { click: () => this.clock.seek(at) } },
          localShort(at, 6))),
        el("td", {}, kindOf(motion, i)),
        ...columns.map((name) => el("td", {}, cells(name, i)))));
    }
    this.contacts.replaceChildren(
      el("table", {}, el("thead", {}, el("tr", {}, ...["time", "kind", ...columns.map((name) => CONTACT_COLUMNS[name])]
        .map((name) => el("th", { scope: "col" }, t(name))))), el("tbody", {}, ...rows)),
      count > MOST_ROWS ? el("p", { class: "hint" }, t("contactsMore", { shown: MOST_ROWS, count })) : "");
  }

  /** @param {Motion} motion */
  showLedger(motion) {
    this.ledgerTitle.textContent = t("ledger", { whose: whose(motion) });
    const rows = ledgerRows(motion);
    const side = (/** @type {string} */ title, /** @type {(p: {energy: number}) => boolean} */ is) => [
      el("h3", {}, t(title)),
      ...rows.filter(is).map(({ name, share, energy, paint }) => el("div", { class: "ledger-row" },
        el("span", {}, t(name)),
        el("span", { class: "bar" }, bar(share, paint)),
        el("output", {}, `${local((100 * share).toFixed(1))} %`),
        el("output", { class: "soft" }, `${localShort(Math.abs(energy), 4)} J`)))];
    this.ledger.replaceChildren(
      ...side("cameIn", (row) => row.energy > 0), ...side("wentOut", (row) => row.energy <= 0));
  }

  destroy() {
    this.curves.destroy();
    this.plots?.phase.destroy();
    this.plots?.section.destroy();
  }
}

/**
 * Return of how many balls an energy is.
 * @param {{balls: any[]}} motion
 */
function whose({ balls }) {
  return t(balls.length > 1 ? "bothBalls" : "perBall");
}

/**
 * Return a quantity of all balls on show together: a mirrored ball counts as much as its twin.
 * @param {Motion} motion
 * @param {string} name
 */
function summed(motion, name) {
  const rows = motion.balls.map((ball) => motion.values(name, ball.row));
  const sum = new Float64Array(motion.time.length);
  for (const values of rows)
    if (values) for (let i = 0; i < sum.length; i += 1) sum[i] += values[i];
  return sum;
}

/**
 * Return something of each ball, by the paint of the ball.
 * @template T
 * @param {import("./motion.js").MotionBall[]} balls
 * @param {(ball: import("./motion.js").MotionBall) => T} of
 * @returns {Record<string, T>}
 */
function byPaint(balls, of) {
  return Object.fromEntries(balls.map((ball) => [ball.name === "left" ? "left" : "right", of(ball)]));
}

/**
 * The kind of a contact, with its ball if it is not of both.
 * @param {Motion} motion
 * @param {number} i
 */
function kindOf(motion, i) {
  const kind = t(KINDS[motion.block.arrays.contact_kind[i]]);
  const ball = motion.balls[(motion.values("contact_ball")?.[i] ?? 0) - 1];
  return ball ? `${kind}, ${t(ball.name)}` : kind;
}

/** How many balls one row of the ledger stands for. */
function ballsPerLedger(/** @type {Motion} */ motion) {
  return motion.balls.length > 1 && motion.balls.every((b) => b.row === 0) ? 2 : 1;
}

/**
 * The energy ledger [J]: sources (positive) and sinks or rests (negative), with shares of all that
 * came in: those of each side sum to one.
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
    { name: "retension", energy: -last("retension_loss"), paint: "flash" },
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
