// Runs requests as pages do: node runs_in_node.mjs SITE REQUESTS ANSWERS
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [site, requests, answers] = process.argv.slice(2);
const load = (/** @type {string} */ name) => import(pathToFileURL(`${site}/js/model/${name}.js`));
const [{ specify }, { run }, { blockOf }, files, { loadRegistry }] = await Promise.all(
  ["case", "simulate", "run_block", "run_files", "registry"].map(load));
const registry = await loadRegistry();
const results = [];
for (const request of JSON.parse(readFileSync(requests, "utf8"))) {
  const block = blockOf(run(await specify(registry, request)));
  const { options, balls, python, command } = block.about;
  results.push({ options, balls, python, command, strobe: [...block.arrays.strobe],
    toml: files.tomlOf(registry, block, "run.toml"), csv: files.columnsTable(registry, block),
    contacts: files.contactsTable(registry, block) });
}
writeFileSync(answers, JSON.stringify(results));
