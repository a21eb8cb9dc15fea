/** The menu from which the map on show is stored: its numbers and its picture. */

import { el, notify, saveFile } from "../page/dom.js";
import { FileQueue, fileOf } from "../page/jobs.js";
import { t } from "../strings.js";
import { lookOf } from "./colours.js";
import { pictureOf } from "./image.js";
import { csvOf, mapTables, pointsOnShow } from "./table.js";

/** @typedef {import("./view.js").MapView} MapView */

// What the page writes by itself, but the table of a stored map, and what the installed program writes.
const OWN = ["csv", "screen"];
const OF_PROGRAM = ["nc", "png", "svg"];
/** @type {Record<string, string>} */
const NAMES = { screen: "mapFile_screen", png: "mapFile_png" };
// What the program calls lines of theory.
/** @type {Record<string, string>} */
const THEORY = { tongue: "tongue", lift: "lift_off" };

export class MapFiles {
  /** @param {MapView} view */
  constructor(view) {
    this.view = view;
    this.files = new FileQueue();
    const { server } = view.page.registry;
    const entry = (/** @type {string} */ kind) => el("li", {},
      el("button", { type: "button", on: { click: () => void this.store(kind) } }, t(fileText(kind))),
      el("span", { class: "soft" }, ` ${t(`mapFileHint_${kind}`)}`));
    this.root = el("details", { class: "card downloads", on: {
      keydown: (/** @type {KeyboardEvent} */ event) => {
        if (event.key === "Escape") this.root.open = false;
      } } },
      el("summary", {}, t("download")),
      el("ul", {}, ...[...OWN, ...(server ? OF_PROGRAM : [])].map(entry)),
      el("p", { class: "hint" }, t(server ? "mapFilesHint" : "mapFilesProgram")), this.files.job.root);
  }

  /**
   * Store a file of the map on show.
   * @param {string} kind
   */
  async store(kind) {
    const { view, files } = this;
    const { job } = files;
    const { grid, question } = view;
    job.error.hidden = true;
    if (!grid) {
      job.refuse(t("mapFilesNone"));
      return;
    }
    try {
      const name = baseOf(view);
      if (kind === "screen") saveMap(await pictureOf(view), `${name}_screen`, "png", 0);
      else if (kind === "csv" && question) {
        const { x, y, missing } = pointsOnShow(question, grid);
        saveMap(new Blob([csvOf(question, grid)], { type: "text/csv" }), `${name}_${x.values.length}x${y.values.length}`, kind, missing);
      } else {
        const request = { kind, ...fileRequestOf(view, grid) };
        await files.add(t(fileText(kind)), async () => {
          const block = await job.run("ws/map/file", request);
          const whole = question ? `${name}_${grid.width}x${grid.height}` : name;
          if (block) saveMap(fileOf(block, "file", block.about.type), whole, kind, block.about.missing);
        });
      }
    } catch (error) {
      if (!(error instanceof Error)) throw error;
      job.refuse(error.message);
    }
  }

  /** Cancel the files that are being made. */
  stop() {
    this.files.stop();
  }
}

/**
 * Return the name of the text for a kind of file.
 * @param {string} kind
 */
function fileText(kind) {
  return NAMES[kind] ?? `file_${kind}`;
}

/**
 * Return the name of the files of the map on show, without their endings.
 * @param {MapView} view
 */
function baseOf({ request: { scenario, stored }, question }) {
  return stored ? stored.replace(/\.(zarr\.zip|zarr|nc|csv|parquet)$/, "")
    : `latolato_map_${scenario ?? question?.options.system}`;
}

/**
 * @param {Blob} file
 * @param {string} base
 * @param {string} ending
 * @param {number} missing points that are not computed
 */
function saveMap(file, base, ending, missing) {
  const name = `${base}${missing ? ".unfinished" : ""}.${ending}`;
  saveFile(file, name);
  notify(t(missing ? "mapStoredPart" : "stored", { name, missing }));
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
  const map = question ? mapTables(question) : { stored: request.stored, select: request.select };
  return { ...map, xlog: grid.x.log, ylog: grid.y.log, observable: name, ball, scale, log, limits,
    contours: contoured && levels.length
      ? { observable: contoured.name, ball: contoured.ball, levels } : null,
    overlays: over.shown().flatMap(({ name }) => THEORY[name] ?? []), trials: over.trials?.text ?? null,
    curves: over.shownCurves().map((curve) => curve.text) };
}
