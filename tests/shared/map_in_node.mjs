// Maps as a page computes them, with threads for workers: JSON of `map_in_node.py` from stdin.
import { readFileSync } from "node:fs";

import { loadLayout } from "../../src/latolato/app/static/js/kernels/load.js";
import { variablesOf } from "../../src/latolato/app/static/js/map/plan.js";
import { Pool } from "../../src/latolato/app/static/js/map/pool.js";
import { PageWorker } from "./page_worker.mjs";

const WORKER = new URL("../../src/latolato/app/static/js/map/worker.js", import.meta.url);

/** Return what comes of a map: its cells in order, and when pictures of how many cells came. */
function computed(pool, plan, variables) {
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
          cells.values.forEach((row, i) => {
            values[i][cell] = Number.isFinite(row[k]) ? row[k] : `${row[k]}`;
          });
        });
      },
      onDone: () => resolve({ pictures, status, values, variables }),
      onError: reject,
    });
  });
}

const { plans, workers } = JSON.parse(readFileSync(0, "utf8"));
const layout = await loadLayout();
const pool = new Pool(workers, () => new PageWorker(WORKER));
const results = [];
for (const plan of plans) {
  const estimate = await pool.estimate(plan);
  results.push({ estimate, ...await computed(pool, plan, variablesOf(layout, plan)) });
}
pool.close();
process.stdout.write(JSON.stringify(results));
