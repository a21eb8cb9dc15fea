// What pages make of drives: node drives_in_node.mjs SITE REQUESTS ANSWERS
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [site, requests, answers] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${site}/js/${name}.js`));
const [{ specify }, { run }, { blockOf }, { loadRegistry }] = await Promise.all(
  ["case", "simulate", "run_block", "registry"].map((name) => load(`model/${name}`)));
const [{ format, parse }, { readable }] = await Promise.all(
  ["state", "link_parts"].map((name) => load(`page/${name}`)));
const [{ questionOf }, { pointsOf }] = await Promise.all(
  ["question", "plan"].map((name) => load(`map/${name}`)));
const { computeMap, countSteps, moduleOf } = await load("kernels/map");
const { loadKernels, loadLayout } = await load("kernels/load");
const { cosineOf } = await load("toy/drive");
const registry = await loadRegistry();
const layout = await loadLayout();

/** Return a map's values, cell by cell, and whether its points run in lanes. */
async function mapOf(request) {
  const { plan } = await questionOf(registry, layout, request);
  const count = plan.x.values.length * plan.y.values.length;
  const points = pointsOf(layout, plan, Array.from({ length: count }, (_, cell) => cell));
  const kernels = await loadKernels(moduleOf(points));
  const { values, problems } = computeMap(kernels, points);
  return { values: [...values.final_angle].map(String), problems: [...problems].map((k) => layout.problems[k].name),
    in_lanes: countSteps(kernels, points).in_lanes, module: moduleOf(points) };
}

/** Return the run that a link leads to, and what comes of it. */
async function answered({ link, map, refused }) {
  const { state, left } = readable(registry, parse(link), ["toy"]);
  const each = await specify(registry, { scenario: state.scenario, options: state.options });
  const { arrays, about } = blockOf(run(each));
  const error = refused && await specify(registry, { options: refused }).catch(({ message }) => message);
  return { left, link: format(state), angle: [...arrays.angle], pivot_height: [...arrays.pivot_height],
    time: [...arrays.time], is_sinusoidal: about.is_sinusoidal, begins: cosineOf(each),
    python: about.python, map: await mapOf(map), error };
}

const results = [];
for (const request of JSON.parse(readFileSync(requests, "utf8"))) results.push(await answered(request));
writeFileSync(answers, JSON.stringify(results));
