// Runs requests with the module of a site: node latolato_in_node.mjs SITE REQUESTS ANSWERS
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [site, requests, answers] = process.argv.slice(2);
const { InputError, simulate } = await import(pathToFileURL(`${site}/latolato.js`));
const results = [];
for (const { scenario, options } of JSON.parse(readFileSync(requests, "utf8"))) {
  try {
    const run = await simulate({ scenario, ...options });
    results.push(Object.fromEntries(Object.entries(run).map(([name, value]) => [name,
      ArrayBuffer.isView(value) ? Array.from(value)
        : Array.isArray(value) && ArrayBuffer.isView(value[0]) ? value.map((row) => Array.from(row))
        : value])));
  } catch (error) {
    if (!(error instanceof InputError)) throw error;
    results.push({ error: error.message, parameter: error.parameter });
  }
}
writeFileSync(answers, JSON.stringify(results));
