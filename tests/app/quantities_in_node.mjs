// Quantities as pages read them: node quantities_in_node.mjs STATIC REQUESTS ANSWERS
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [site, requests, answers] = process.argv.slice(2);
const load = (name) => import(pathToFileURL(`${site}/js/${name}.js`));
const [{ toSi }, { InputError, learnRules }, { readEntry }, { shownUnit }, { withControls }] = await Promise.all(
  ["model/units", "model/rules", "page/entry", "page/unit_text", "toy/held_options"].map(load));
const { registry, texts, units, controls } = JSON.parse(readFileSync(requests, "utf8"));
learnRules(registry.rules);

function inModel(text, unit) {
  try {
    return String(toSi(registry, "given", text, unit));
  } catch (error) {
    if (!(error instanceof InputError)) throw error;
    return error.message;
  }
}

function inField(text, unit) {
  const usual = { name: unit, size: 1 };
  const { values, problem } = readEntry(text, { registry, usual, unit });
  return problem === null ? values[0] : null;
}

writeFileSync(answers, JSON.stringify({
  model: texts.map(([text, unit]) => inModel(text, unit)),
  fields: texts.map(([text, unit]) => inField(text, unit)),
  units: units.map(([number, unit, si]) => {
    const text = `${number} ${shownUnit(unit)}`;
    return { text, values: [inField(`${number} ${unit}`, si), inField(text, si)] };
  }),
  controls: Object.fromEntries(Object.entries(withControls(registry, {}, "latolato", controls, "damping"))
    .filter(([name]) => name in controls)
    .map(([name, text]) => [name, inField(text, registry.options[name].unit)])),
}));
