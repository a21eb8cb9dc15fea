/** The language of the page: which ones there are, which one is wanted, and the choice of another. */

import { loadJson } from "../kernels/files.js";
import { translateRegistry } from "../model/registry.js";
import { ENGLISH, languageCode, setLanguage, t, tr } from "../strings.js";
import { el, notify } from "./dom.js";
import { keep, recall } from "./preferences.js";
import { format } from "./state.js";

/** @typedef {import("../model/registry.js").Registry} Registry */
/** @typedef {import("./state.js").Page} Page */

const KEPT = "latolato.language";
// As in app.css.
const NARROW = "(max-width: 800px)";

/**
 * Return the first of some languages that there is, English if there is none; "id" serves "id-ID".
 * @param {Registry["languages"]} languages
 * @param {readonly string[]} wanted tags such as "id" or "en-GB"
 */
export function firstOf(languages, wanted) {
  return wanted.flatMap((tag) => [tag, tag.split("-")[0]])
    .find((code) => Object.hasOwn(languages, code)) ?? ENGLISH;
}

/**
 * Set the page's language, and translate the texts of the registry.
 * @param {Registry} registry
 * @param {string} code one of the registry's
 */
export async function speak(registry, code) {
  if (code !== ENGLISH) speakTable(registry, code, await loadJson(`languages/${code}.json`));
}

/**
 * Set the page's language to that of a table, once: after a language other than English it stays.
 * @param {Registry} registry
 * @param {string} code
 * @param {import("../strings.js").Language} table
 */
export function speakTable(registry, code, table) {
  if (languageCode() !== ENGLISH) return;
  setLanguage(code, table);
  translateRegistry(registry, tr);
}

/**
 * Set a whole page's language to that of its address, else that chosen before, else that which the
 * browser prefers; and offer the others.
 * @param {Page} page
 */
export async function speakInPage({ registry, store }) {
  const { languages } = registry;
  const { lang } = store.state;
  const asked = lang ? [lang] : [];
  const code = firstOf(languages, [...asked, recall(KEPT) ?? "", ...navigator.languages]);
  const isUnknown = lang && ![lang, lang.split("-")[0]].includes(firstOf(languages, asked));
  await speak(registry, code).catch(() => notify(t("languageUnread", languages[code])));
  document.documentElement.lang = languageCode();
  if (isUnknown) {
    notify(t("languageUnknown", { name: lang, spoken: languages[languageCode()].name }));
    store.state = { ...store.state, lang: undefined };
  }
  const select = /** @type {HTMLSelectElement} */ (document.getElementById("language"));
  // A phone's header has room for the name alone.
  const short = (/** @type {string} */ name) => (matchMedia(NARROW).matches ? { label: name } : {});
  select.replaceChildren(...Object.entries(languages).map(([each, { name, beta }]) =>
    el("option", { value: each, lang: each, selected: each === languageCode(), ...short(name) },
      beta ? t("languageBeta", { name }) : name)));
  select.setAttribute("aria-label", t("language"));
  select.hidden = false;
  select.addEventListener("change", () => {
    keep(KEPT, select.value);
    location.assign(format({ ...store.state, lang: select.value }));
  });
}
