// Answers to hostile input, a line of JSON each, with the modules of a site: node fuzz_in_node.mjs SITE
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const folder = `${pathToFileURL(process.argv[2])}/js/`;
const load = (name) => import(folder + name);
const { format, parse } = await load("page/state.js");
const { partText, readable } = await load("page/link_parts.js");
const { specify } = await load("model/case.js");
const { loadRegistry } = await load("model/registry.js");
const { InputError } = await load("model/rules.js");
const { run } = await load("model/simulate.js");
const { parseTrials } = await load("map/trials.js");
const registry = await loadRegistry();
const SHORT = 2; // s

/** Return how a request ends: with a refusal, or with a run if that is short. */
async function ended(request) {
  try {
    const each = await specify(registry, request);
    if (each.duration > SHORT || each.noise || each.system.naturalFrequency > 100) return "accepted";
    return run(each, 1000).status.split(" ")[0];
  } catch (error) {
    if (error instanceof InputError) return error.message;
    throw error;
  }
}

const kinds = {
  async address(search) {
    const whole = parse(search);
    const same = format(parse(format(whole))) === format(whole);
    const views = ["toy", "map"];
    const { state, left } = readable(registry, whole, views);
    const again = readable(registry, parse(format(state)), views);
    return { same, ended: await ended(whole), lines: left.map(partText), again: again.left.length, known: views.includes(state.view) };
  },
  async request(request) {
    return { ended: await ended(request) };
  },
  trials(text) {
    try {
      const { amplitude, frequency, ratio, kinds } = parseTrials(registry, text);
      const lengths = [amplitude, frequency, ratio, kinds].map((each) => each.length);
      const isPlain = amplitude.every((each) => each > 0 && Number.isFinite(each))
        && kinds.every((each) => [0, 1, 2].includes(each));
      return { ended: "read", sound: isPlain && new Set(lengths).size === 1 };
    } catch (error) {
      if (error instanceof InputError) return { ended: error.message, sound: true };
      throw error;
    }
  },
};

for await (const line of createInterface({ input: process.stdin })) {
  // JSON has no NaN and no infinity.
  const [kind, input] = JSON.parse(line, (_, value) =>
    (Object.hasOwn(Object(value), "number") ? Number(value.number) : value));
  const answer = await Promise.resolve(kinds[kind](input)).catch((error) => ({ fault: `${error.stack}` }));
  const polluted = Object.keys(Object.prototype).length > 0 || {}.x !== undefined;
  console.log(JSON.stringify({ ...answer, polluted }));
}
