// What pages say of runs: node sentences_in_node.mjs SITE REQUESTS ANSWERS
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [site, requests, answers] = process.argv.slice(2);
const load = (/** @type {string} */ name) => import(pathToFileURL(`${site}/js/${name}.js`));
const [{ specify }, { run }, { blockOf }, { loadRegistry }, { Motion }, { logOf }, describe] =
  await Promise.all(["model/case", "model/simulate", "model/run_block", "model/registry", "player/motion",
    "player/events", "player/describe"].map(load));
const registry = await loadRegistry();
const results = [];
for (const { scenario, end, step } of JSON.parse(readFileSync(requests, "utf8"))) {
  const motion = new Motion(blockOf(run(await specify(registry, { scenario, options: {} }))));
  const log = logOf(motion);
  const told = [];
  for (let from = 0; from + step <= end; from += step) {
    const said = describe.bestSentence(log, from, from + step);
    if (said) told.push({ from, to: from + step, ...said, text: describe.inText([said]) });
  }
  const angles = motion.balls.map((ball) => motion.values("angle", ball.row)
    .map((/** @type {number} */ angle) => (ball.sign * angle * 180) / Math.PI));
  results.push({ told, start: describe.startSentence(motion), places: describe.placesOf(motion, 0),
    curve: describe.curvesOf("angle", angles) });
}
writeFileSync(answers, JSON.stringify(results));
