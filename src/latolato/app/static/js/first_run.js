/** What the first motion is computed with loads beside the page's modules, which take longer. */

import { beginWorker } from "./model/worker.js";
import { HELD, parse } from "./page/state.js";

const { view, extra } = parse(location.search);
const isHeld = HELD in extra;
export const firstWorker = view === "toy" && !isHeld ? beginWorker() : null;
if (view === "toy" && isHeld) {
  // A toy in a hand is computed in the page. What fails is asked for again when the hand takes it.
  import("./kernels/load.js").then(({ loadAhead }) => loadAhead()).catch(() => {});
  import("./toy/hand.js").catch(() => {});
}
