// Maps as a page computes them, with threads for workers: JSON of `map_in_node.py` from stdin.
import { readFileSync } from "node:fs";

import { loadLayout } from "../../src/latolato/app/static/js/kernels/load.js";

import { Grid } from "../../src/latolato/app/static/js/map/grid.js";
import { PageJob } from "../../src/latolato/app/static/js/map/job.js";
import { variablesOf } from "../../src/latolato/app/static/js/map/plan.js";
import { Pool } from "../../src/latolato/app/static/js/map/pool.js";

import { csvOf, tablesOf } from "../../src/latolato/app/static/js/map/table.js";
import { specify } from "../../src/latolato/app/static/js/model/case.js";
import { learnRules } from "../../src/latolato/app/static/js/model/rules.js";
import { run } from "../../src/latolato/app/static/js/model/simulate.js";
import { PageWorker } from "./page_worker.mjs";

const WORKER = new URL("../../src/latolato/app/static/js/map/map_worker.js", import.meta.url);
const { plans = [], requests = [], registry, workers, scalar } = JSON.parse(readFileSync(0, "utf8"));
if (registry) learnRules(registry.rules);
// As in a browser that lacks vectors.
if (scalar) WebAssembly.validate = () => false;
const layout = await loadLayout();
const pool = new Pool(workers, () => new PageWorker(WORKER));

const plain = (value) => (Number.isFinite(value) ? value : `${value}`);

/** Return what comes of a map: its cells in order, and when pictures of how many cells came. */
function computed(plan, variables) {
  const count = plan.x.values.length * plan.y.values.length;
  const status = new Array(count).fill(null);
  const values = variables.map(() => new Array(count).fill(null));
  const pictures = [];
  const begin = performance.now();
  return new Promise((resolve, reject) => {
    pool.start(plan, {
      onCells(cells, { points }) {
        pictures.push({ seconds: (performance.now() - begin) / 1e3, points });
        cells.cell.forEach((cell, k) => {
          status[cell] = cells.status[k];
          cells.values.forEach((row, i) => { values[i][cell] = plain(row[k]); });
        });
      },
      onDone: () => resolve({ pictures, status, values, variables }),
      onError: reject,
    });
  });
}

/** Return what a view shows of a request: the map, its files, the run of a point, or a refusal. */
function shown({ request, run: cell, planned }) {
  return new Promise((resolve) => {
    const heard = {};
    let grid;
    const job = new PageJob(registry, pool, request, true, {
      choices: (choices) => { heard.choices = choices; },
      begin: (begin) => {
        grid = new Grid(begin);
        heard.about = grid.about;
        heard.sides = Object.fromEntries(Object.entries(begin.arrays).map(([name, all]) => [name, [...all]]));
        if (planned) {
          job.cancel();
          resolve(heard);
        }
      },
      cells: (cells) => grid.put(cells), restarted: () => {}, asks: () => {},
      done: async () => {
        heard.status = [...grid.status];
        heard.values = grid.values.map((row) => Array.from(row, plain));
        heard.tables = tablesOf(job.question);
        try {
          heard.csv = csvOf(job.question, grid);
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
        resolve(heard);
      },
      refused: ({ message }) => resolve({ ...heard, error: message }),
    });
  });
}

const results = [];
for (const plan of plans) {
  const estimate = await pool.estimate(plan);
  results.push({ estimate, ...await computed(plan, variablesOf(layout, plan)) });
}
for (const each of requests) results.push(await shown(each));
pool.close();
process.stdout.write(JSON.stringify(results));
