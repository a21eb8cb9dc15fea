// Stories as pages read and compute them: node stories_in_node.mjs SITE QUESTIONS ANSWERS
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [site, questions, answers] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${site}/js/${name}.js`));
const [{ specify }, { run }, { blockOf }, { loadRegistry }, { quantity, withPeriod }, { runOnShow, shownBy },
  { challengeRequest, scoreOfGuess, scoreOfRun }] = await Promise.all(["model/case", "model/simulate", "model/run_block",
  "model/registry", "story/numbers", "story/look", "story/scores"].map(load));
const registry = await loadRegistry();
const { numbers, scores } = JSON.parse(readFileSync(questions, "utf8"));
const plain = (value) => (Number.isFinite(value) ? value : null);
const blockFor = async (request) => blockOf(run(await specify(registry, request), 30_000));

const found = [];
for (const { look, options, name, angle } of numbers) {
  const state = shownBy({ extra: {} }, look, {});
  state.options = { ...state.options, ...options };
  const request = runOnShow(registry, state);
  found.push(plain(quantity(name, await withPeriod(registry, request, await blockFor(request)), angle)));
}
const reached = [];
for (const { challenge, options } of scores)
  reached.push(plain(options.guess ? scoreOfGuess(registry, challenge, options.guess)
    : scoreOfRun(registry, challenge.task, await blockFor(challengeRequest(registry, challenge, options)))));
writeFileSync(answers, JSON.stringify({ numbers: found, scores: reached }));
