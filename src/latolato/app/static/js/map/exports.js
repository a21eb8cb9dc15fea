/** The menu from which the map on show is stored: its numbers and its picture. */

import { el, notify, saveFile } from "../page/dom.js";
import { fileOf, JobLine } from "../page/jobs.js";
import { t } from "../strings.js";
import { lookOf } from "./colours.js";
import { pictureOf } from "./image.js";
import { csvOf, tablesOf } from "./table.js";

/** @typedef {import("./view.js").MapView} MapView */

// What the page writes by itself, and what the installed program writes.
const OWN = ["csv", "screen"];
/** @type {Record<string, string>} */
const NAMES = { screen: "mapFile_screen", png: "mapFile_png" };
const OF_PROGRAM = ["nc", "png", "svg"];
// What the program calls lines of theory.
/** @type {Record<string, string>} */
const THEORY = { tongue: "tongue", lift: "lift_off" };

export class MapFiles {
  /** @param {MapView} view */
  constructor(view) {
    this.view = view;
    this.job = new JobLine();
    const { server } = view.page.registry;
    const entry = (/** @type {string} */ kind, /** @type {() => Promise<void>} */ store) => el("li", {},
      el("button", { type: "button", on: { click: () => void this.store(store) } }, t(NAMES[kind] ?? `file_${kind}`)),
      el("span", { class: "soft" }, ` ${t(`mapFileHint_${kind}`)}`));
    this.root = el("details", { class: "card downloads", on: {
      keydown: (/** @type {KeyboardEvent} */ event) => {
        if (event.key === "Escape") this.root.open = false;
      } } },
      el("summary", {}, t("download")),
      el("ul", {}, ...OWN.map((kind) => entry(kind, () => this.write(kind))),
        ...(server ? OF_PROGRAM : []).map((kind) => entry(kind, () => this.make(kind)))),
      el("p", { class: "hint" }, t(server ? "mapFilesHint" : "mapFilesProgram")), this.job.root);
  }

  /** @param {() => Promise<void>} work */
  async store(work) {
    this.job.error.hidden = true;
    if (!this.view.grid) {
      this.job.refuse(t("mapFilesNone"));
      return;
    }
    try {
      await work();
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      this.job.refuse(error.message);
    }
  }

  /**
   * The name of a file of the map on show.
   * @param {string} ending
   */
  nameOf(ending) {
    const { request, question } = this.view;
    const { scenario, stored } = request;
    const base = stored ? stored.replace(/\.(zarr\.zip|zarr|nc|csv|parquet)$/, "")
      : `latolato_map_${scenario ?? question?.options.system}`;
    return `${base}.${ending}`;
  }

  /**
   * Write a file in the page; a stored map has its table from the program.
   * @param {string} kind
   */
  async write(kind) {
    const { view } = this;
    const { question } = view;
    const grid = /** @type {import("./grid.js").Grid} */ (view.grid);
    if (kind === "screen") {
      this.keep(await pictureOf(view), this.nameOf("png"), 0);
      return;
    }
    if (!question) {
      await this.make("csv");
      return;
    }
    const missing = grid.width * grid.height - grid.done;
    this.keep(new Blob([csvOf(question, grid)], { type: "text/csv" }),
      this.nameOf(missing ? "unfinished.csv" : "csv"), missing);
  }

  /**
   * Let the program make a file; it computes a map of the page once more.
   * @param {string} kind
   */
  async make(kind) {
    const { view } = this;
    const request = { kind, ...fileRequestOf(view, /** @type {import("./grid.js").Grid} */ (view.grid)) };
    const block = await this.job.run("ws/map/file", request);
    if (!block) return;
    const { type, missing } = block.about;
    this.keep(fileOf(block, "file", type), this.nameOf(missing ? `unfinished.${kind}` : kind), missing);
  }

  /**
   * @param {Blob} file
   * @param {string} name
   * @param {number} missing points that are not computed
   */
  keep(file, name, missing) {
    saveFile(file, name);
    notify(t(missing ? "mapStoredPart" : "stored", { name, missing }));
  }

  /** Cancel a file that is being made. */
  stop() {
    this.job.stop();
  }
}

/**
 * The request for a file of the map on show: which map it is, a stored one or one of the page by
 * its runs and its sweep, and how it looks.
 * @param {MapView} view
 * @param {import("./grid.js").Grid} grid
 */
function fileRequestOf({ chart, over, page, question, request }, grid) {
  const { variable, scale, log, limits } = lookOf(grid, page.store.state.extra);
  const { name, ball } = grid.variables[variable];
  const contours = over.question();
  const contoured = contours && grid.variables[contours.variable];
  const levels = [...new Set(chart.contours.map(({ level }) => level))];
  const map = question ? tablesOf(question) : { stored: request.stored, select: request.select };
  return { ...map, xlog: grid.x.log, ylog: grid.y.log, observable: name, ball, scale, log, limits,
    contours: contoured && levels.length
      ? { observable: contoured.name, ball: contoured.ball, levels } : null,
    overlays: over.shown().flatMap(({ name }) => THEORY[name] ?? []), trials: over.trials,
    curves: over.shownCurves().map((curve) => curve.text) };
}
