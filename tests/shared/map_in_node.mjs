// Maps as a page computes them, with threads for workers: JSON of `map_in_node.py` from stdin.
import { readFileSync } from "node:fs";

import { loadLayout } from "../../src/latolato/app/static/js/kernels/load.js";

import { gridOf } from "../../src/latolato/app/static/js/map/about.js";
import { variedBy } from "../../src/latolato/app/static/js/map/choices.js";
import { ownMap } from "../../src/latolato/app/static/js/map/open.js";
import { Pool } from "../../src/latolato/app/static/js/map/pool.js";

import { csvOf, mapTables } from "../../src/latolato/app/static/js/map/table.js";
import { specify } from "../../src/latolato/app/static/js/model/case.js";
import { learnRules } from "../../src/latolato/app/static/js/model/rules.js";
import { run } from "../../src/latolato/app/static/js/model/simulate.js";
import { PageWorker } from "./page_worker.mjs";

const WORKER = new URL("../../src/latolato/app/static/js/map/map_worker.js", import.meta.url);
const { requests, registry, workers, scalar } = JSON.parse(readFileSync(0, "utf8"));
learnRules(registry.rules);
// As in a browser that lacks vectors.
if (scalar) WebAssembly.validate = () => false;
const layout = await loadLayout();
const pool = new Pool(workers, () => new PageWorker(WORKER));

const plain = (value) => (Number.isFinite(value) ? value : `${value}`);

/** Return what a view shows of a request: the map, its files, the run of a point, or a refusal. */
async function shown({ request, run: cell, planned }) {
  const heard = {};
  try {
    const { question, estimate } = await ownMap(registry, pool, request,
      ({ choices, options }) => { heard.choices = { variables: choices,
        axes: variedBy(registry, options).map((name) => ({ name, ...registry.axes[name] })) }; });
    const grid = gridOf(question);
    heard.about = grid.about;
    heard.sides = Object.fromEntries(["x", "y"].map((which) => [which, { ...grid[which],
      values: [...grid[which].values], edges: [...grid[which].edges] }]));
    if (planned) return heard;
    heard.steps = estimate.steps;
    heard.points = [];
    await pool.compute(question.plan, estimate, { stride: request.stride, onCells: (cells, { points }) => {
      grid.put(cells);
      heard.points.push(points);
    } });
    heard.status = [...grid.status];
    heard.values = grid.values.map((row) => Array.from(row, plain));
    heard.tables = mapTables(question);
    try {
      heard.csv = csvOf(question, grid);
    } catch (error) {
      heard.csv = error.message;
    }
    if (cell !== undefined) {
      const options = grid.optionsOf(cell);
      const found = run(await specify(registry, { options }));
      heard.run = { options, largest: Math.max(...found.columns.angle[0].map(Math.abs)),
        final: found.columns.angle.map((angles) => angles.at(-1)),
        tops: found.contacts.kind.filter((kind) => layout.contact_kinds[kind] === "top").length };
    }
    return heard;
  } catch ({ message }) {
    return { ...heard, error: message };
  }
}

const results = [];
for (const each of requests) results.push(await shown(each));
pool.close();
process.stdout.write(JSON.stringify(results));
