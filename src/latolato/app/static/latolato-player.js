/**
 * `<latolato-player>`: the player of a run as an element of any page.
 *
 *     <script type="module" src="latolato-player.js"></script>
 *     <latolato-player scenario="fig04a_push" duration="20 s"></latolato-player>
 *
 * Its attributes are the options of the command line, with dashes, and `scenario`; the run is computed
 * again when one changes. A ball that is dragged changes those of the start. All elements of a page speak the language that `lang` names
 * on the first of them or around it, English if none does. It sends no message and asks no other site for anything.
 *
 * @module
 */

import { loadRegistry } from "./js/model/registry.js";
import { EmbeddedPlayer } from "./js/player/embedded.js";
import { firstOf, speak } from "./js/page/language.js";
import { inLanguage } from "./js/page/refusals.js";
import { withStart } from "./js/player/start.js";
import { ENGLISH } from "./js/strings.js";

// Attributes of all elements, which are no options.
const OF_ELEMENTS = /^(id|class|style|slot|title|lang|dir|hidden|tabindex|role|part|data-.*|aria-.*)$/;

/** The language of the page is set once: texts on show stay as they are. @type {Promise<void> | null} */
let language = null;

class LatolatoPlayer extends HTMLElement {
  constructor() {
    super();
    /** @type {EmbeddedPlayer | null} */
    this.inset = null;
    /** Counts what was asked for: an older run may be shown on the way, but is not announced. */
    this.turn = 0;
    this.observer = new MutationObserver(() => void this.compute());
  }

  async connectedCallback() {
    language ??= this.speak().catch((error) => console.warn(error));
    await language;
    if (!this.isConnected || this.inset) return;
    this.inset = new EmbeddedPlayer(this);
    this.inset.player.start.enable((degrees) => this.startAt(degrees));
    this.observer.observe(this, { attributes: true });
    void this.compute();
  }

  /** Let the page speak the language of the element. */
  async speak() {
    const tag = this.closest("[lang]")?.getAttribute("lang") ?? ENGLISH;
    const registry = await loadRegistry();
    await speak(registry, firstOf(registry.languages, [tag]));
  }

  disconnectedCallback() {
    this.observer.disconnect();
    this.inset?.leave();
    this.inset = null;
  }

  /** The player on show, for programs of the page. */
  get player() {
    return this.inset?.player ?? null;
  }

  /** Return what the attributes ask for. */
  get request() {
    const options = Object.fromEntries([...this.attributes]
      .filter(({ name }) => !OF_ELEMENTS.test(name) && name !== "scenario")
      .map(({ name, value }) => [name.replaceAll("-", "_"), value]));
    return { scenario: this.getAttribute("scenario"), options };
  }

  /**
   * Let the attributes ask for the run that begins with the balls at rest at these angles.
   * @param {number[]} degrees
   */
  startAt(degrees) {
    const { options } = this.request;
    const started = withStart(options, this.player?.motion?.about.options ?? {}, degrees);
    this.removeAttribute("initial-offset");
    for (const [name, value] of Object.entries(started))
      if (value !== options[name]) this.setAttribute(name.replaceAll("_", "-"), value);
  }

  /**
   * Return a refusal that calls options as the page around wrote them.
   * @param {string} text
   */
  withAttributes(text) {
    const names = { ...this.inset?.runner?.registry.options, ...this.request.options };
    return text.replace(/\w+/g, (word) => (Object.hasOwn(names, word) ? word.replaceAll("_", "-") : word));
  }

  async compute() {
    const { inset } = this;
    this.turn += 1;
    const { turn } = this;
    try {
      await inset?.load();
      // It may have left the page, or come back as another one.
      if (!inset || inset !== this.inset) return;
      if (!(await inset.compute(this.request)) || turn !== this.turn) return;
    } catch (error) {
      if (turn !== this.turn) return;
      inset?.refuse(this.withAttributes(inLanguage(/** @type {Error} */ (error))));
    }
    this.dispatchEvent(new Event("computed"));
  }
}

customElements.define("latolato-player", LatolatoPlayer);
