// Moves toys as `toys.py` asks: node toys.mjs FOLDER
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { startKernels } from "../../src/latolato/app/static/js/kernels/load.js";
import { cosineOf } from "../../src/latolato/app/static/js/toy/drive.js";
import { columnsTable, contactsTable } from "../../src/latolato/app/static/js/model/run_files.js";
import { specify } from "../../src/latolato/app/static/js/model/case.js";
import { Toy } from "../../src/latolato/app/static/js/toy/toy.js";

const [folder] = process.argv.slice(2);
const { registry, toys } = JSON.parse(readFileSync(join(folder, "toys.json"), "utf8"));
const modules = {};
const done = [];

/** What shakes a pivot with this amplitude and frequency. */
function leadOf({ amplitude, frequency }) {
  return { rate: 2, dampingRatio: 0.5, at: (wall) => ({ height: 0,
    acceleration: -amplitude * frequency ** 2 * Math.cos(frequency * wall / 1000) }) };
}

for (const [number, { request, ticks, actions }] of toys.entries()) {
  const each = await specify(registry, request);
  const { name } = each.kernels;
  const kernels = (modules[name] ??= await startKernels(name));
  const toy = new Toy(kernels, each, cosineOf(each));
  let since = null;
  const steps = [];
  const angles = [];
  for (let tick = 0; tick < ticks; tick += 1) {
    for (const [at, name, value] of actions.filter(([at]) => at === tick)) {
      if (name === "keep") since = toy.time;
      else toy[name](name === "shake" ? leadOf(value) : value);
    }
    toy.advance((tick + 1) / 60, 1000 * (tick + 1) / 60);
    angles.push(toy.angles);
    steps.push(kernels.get(toy.run, "settings.step"));
  }
  const kept = since === null ? null : toy.minute.keep(toy.system, since);
  const again = kept?.again();
  if (kept) for (const [table, name] of [[columnsTable, "csv"], [contactsTable, "contacts.csv"]])
    writeFileSync(join(folder, `${number}.${name}`), table(registry, kept.block(again)));
  done.push({ angles, steps, controls: toy.controls, isSinusoidal: registry.drives[each.drive.kind].sinusoidal,
    kept: kept && { options: kept.options(), byHand: kept.byHand,
      deviation: again && kept.deviation(again) } });
}
writeFileSync(join(folder, "done.json"), JSON.stringify(done));
