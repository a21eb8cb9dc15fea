/**
 * `<latolato-player>`: the player of a run as an element of any page.
 *
 *     <script type="module" src="latolato-player.js"></script>
 *     <latolato-player scenario="fig04a_push" duration="20 s"></latolato-player>
 *
 * Its attributes are the options of the command line, with dashes, and `scenario`; the run is computed
 * anew when one changes. It sends no message and asks no other site for anything.
 *
 * @module
 */

import { Runner } from "./js/model/client.js";
import { loadRegistry } from "./js/model/registry.js";
import { followTheme } from "./js/notebook.js";
import { el } from "./js/shared/dom.js";
import { Motion } from "./js/shared/motion.js";
import { Player } from "./js/shared/player.js";

const SHEETS = ["vendor/uPlot.css", "app.css", "notebook.css"];
// Attributes of all elements, which are no options.
const OF_ELEMENTS = /^(id|class|style|slot|title|lang|dir|hidden|tabindex|role|part|data-.*|aria-.*)$/;

/** @type {Promise<CSSStyleSheet> | null} */
let sheet = null;

/** Return the style of the player's inside, which has a root of its own. */
function loadSheet() {
  sheet ??= Promise.all(SHEETS.map(async (name) => (await fetch(new URL(name, import.meta.url))).text()))
    .then((texts) => {
      const made = new CSSStyleSheet();
      made.replaceSync(texts.join("\n").replace(/:root((?:\[[^\]]*\]|:not\([^)]*\))+)/g, ":host($1)")
        .replaceAll(":root", ":host"));
      return made;
    });
  return sheet;
}

class LatolatoPlayer extends HTMLElement {
  constructor() {
    super();
    this.inside = this.attachShadow({ mode: "open" });
    this.message = el("p", { class: "error", role: "alert", hidden: true });
    this.place = el("div", { class: "player notebook", tabindex: "-1" });
    this.inside.append(this.message, this.place);
    /** @type {Runner | null} */
    this.runner = null;
    /** @type {Player | null} */
    this.player = null;
    this.observer = new MutationObserver(() => void this.compute());
    this.unfollow = () => {};
  }

  connectedCallback() {
    this.observer.observe(this, { attributes: true });
    this.unfollow = followTheme(this);
    void this.compute();
  }

  disconnectedCallback() {
    this.observer.disconnect();
    this.unfollow();
    this.runner?.end();
    this.player?.destroy();
    this.runner = this.player = null;
    this.place.replaceChildren();
  }

  /** Return what the attributes ask for. */
  get request() {
    const options = Object.fromEntries([...this.attributes]
      .filter(({ name }) => !OF_ELEMENTS.test(name) && name !== "scenario")
      .map(({ name, value }) => [name.replaceAll("-", "_"), value]));
    return { scenario: this.getAttribute("scenario"), options };
  }

  async compute() {
    try {
      const [registry, style] = await Promise.all([loadRegistry(), loadSheet()]);
      if (!this.isConnected) return;
      this.inside.adoptedStyleSheets = [style];
      this.runner ??= new Runner(registry);
      const block = await this.runner.compute(this.request);
      this.player ??= new Player(this.place);
      this.player.show(new Motion(block));
      this.message.hidden = true;
    } catch (error) {
      const { name, message } = /** @type {Error} */ (error);
      if (name === "AbortError") return;
      this.message.textContent = message;
      this.message.hidden = false;
    }
    this.dispatchEvent(new Event("computed"));
  }
}

customElements.define("latolato-player", LatolatoPlayer);
