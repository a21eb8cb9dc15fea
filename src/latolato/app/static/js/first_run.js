/** What the first motion is computed with loads beside the page's modules, which take longer. */

import { beginWorker } from "./model/worker.js";
import { HELD, parse } from "./page/state.js";

const { view, extra } = parse(location.search);
// A toy in a hand needs it for the runs that are kept, also when the server is gone by then.
export const firstWorker = view === "toy" ? beginWorker() : null;
if (view === "toy" && HELD in extra) {
  // The hand itself is computed in the page. What fails is asked for again when the hand takes the toy.
  import("./kernels/load.js").then(({ loadAhead }) => loadAhead()).catch(() => {});
  import("./toy/hand.js").catch(() => {});
}
