/** The examples of "Use it in your own page": a player and a run with the values of two forms. */

const SITE = new URL("../../", import.meta.url);
const ATTRIBUTES = {
  scenario: "fig04a_push", duration: "20 s", "drive-amplitude": "15 cm", damping: "0.02",
};
const PARAMETERS = {
  length: 1, mass: 0.8, damping: 0.02, radius: 0.1, restitution: 0.9, drive_amplitude: 0.2,
  drive_frequency: 6.26, initial_angle: 0.3, duration: 20,
};

/** Return the element of this page with this id. */
const by = (id) => document.getElementById(id);

/** Fill a form with a field for each value; `use` gets all values, now and after each change. */
function makeForm(form, values, button, use) {
  const fields = Object.entries(values).map(([name, value]) => {
    const input = Object.assign(document.createElement("input"), { name, value, spellcheck: false });
    const label = document.createElement("label");
    label.append(name, input);
    return label;
  });
  const submit = Object.assign(document.createElement("button"), { textContent: button });
  form.replaceChildren(...fields, submit);
  const give = () => use(Object.fromEntries(new FormData(form)));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    give();
  });
  give();
}

/** Show a player with these attributes, and how a page writes them. */
function play(values) {
  const player = by("latolato-place").firstElementChild ?? document.createElement("latolato-player");
  const given = Object.entries(values).filter(([, value]) => value !== "");
  for (const name of Object.keys(values)) if (values[name] === "") player.removeAttribute(name);
  for (const [name, value] of given) player.setAttribute(name, value);
  if (!player.isConnected) by("latolato-place").append(player);
  const text = given.map(([name, value]) => ` ${name}="${value.replaceAll('"', "&quot;")}"`).join("");
  by("latolato-markup").textContent = '<script type="module" src="toy/latolato-player.js"></script>\n'
    + `<latolato-player${text}></latolato-player>`;
}

/** Return a value as code: a number, or a text with its unit. */
function literal(value) {
  return value.trim() !== "" && Number.isFinite(Number(value)) ? Number(value) : value;
}

/** Compute a run, show its code and what came of it. */
async function compute(simulate, values) {
  const filled = Object.entries(values).filter(([, value]) => value !== "");
  const parameters = { system: "latolato", drive: "harmonic",
    ...Object.fromEntries(filled.map(([name, value]) => [name, literal(value)])) };
  const lines = Object.entries(parameters).map(([name, value]) => `  ${name}: ${JSON.stringify(value)},`);
  by("latolato-program").textContent = 'import { simulate } from "./toy/latolato.js";\n\n'
    + `const run = await simulate({\n${lines.join("\n")}\n});\n`
    + "console.log(run.contact_time.length, run.energy_residual, run.status);";
  try {
    const run = await simulate(parameters);
    const said = document.createElement("p");
    said.textContent = `Contacts: ${run.contact_time.length}. Energy residual: `
      + `${run.energy_residual.toExponential(1)} J. The run is ${run.status}.`;
    by("latolato-result").replaceChildren(said, curve(run.time, run.angle));
  } catch (error) {
    by("latolato-result").textContent = error.message;
  }
}

/** Return a picture of the angle over time. */
function curve(time, angle) {
  const [width, height] = [640, 160];
  const low = angle.reduce((least, each) => Math.min(least, each));
  const high = angle.reduce((most, each) => Math.max(most, each), low + 1e-9);
  const points = Array.from(angle, (each, i) => `${((width * time[i]) / time.at(-1)).toFixed(1)},`
    + `${(1 + ((height - 2) * (high - each)) / (high - low)).toFixed(1)}`);
  const make = (name, attributes, ...children) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.append(...children);
    return element;
  };
  const label = `angle of the right ball over ${time.at(-1)} s, from ${low.toFixed(3)} to `
    + `${high.toFixed(3)} rad`;
  return make("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label },
    make("polyline", { points: points.join(" "), fill: "none", stroke: "currentColor" }));
}

try {
  const [{ simulate }] = await Promise.all([import(new URL("latolato.js", SITE)),
    import(new URL("latolato-player.js", SITE))]);
  by("latolato-alone").remove();
  makeForm(by("latolato-attributes"), ATTRIBUTES, "Show", play);
  makeForm(by("latolato-parameters"), PARAMETERS, "Run", (values) => compute(simulate, values));
} catch (error) {
  // Without the site, the page says what it needs.
  if (!(error instanceof TypeError)) throw error;
}
