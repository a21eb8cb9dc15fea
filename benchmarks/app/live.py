"""The live view beside the numbers asked of it: cost of a move, key to motion, pictures a second.

A page of a server of its own, in headless Chromium; slow processors are Chromium's own throttling.
Key to motion is the time from a key press to the picture whose motion has the change in it, counted
in pictures too.
"""

from __future__ import annotations

import os
import statistics
from typing import Any

from pages import browsing, serving

KEYS = 60
SECONDS = 4.0
MOVES = 2000
COST = """moves => {
  const { toy } = window.latolato.views.live;
  const begun = performance.now();
  for (let k = 0; k < moves; k += 1) {
    toy.advance(toy.time + 1 / 60);
    toy.energies;
  }
  return (performance.now() - begun) / moves;
}"""
PICTURES = """async ms => {
  const { toy } = window.latolato.views.live;
  const picture = () => new Promise(requestAnimationFrame);
  const begun = await picture();
  const { time } = toy;
  let [last, count, longest] = [begun, 0, 0];
  while (last - begun < ms) {
    const now = await picture();
    longest = Math.max(longest, now - last);
    [last, count] = [now, count + 1];
  }
  return { rate: (1000 * count) / (last - begun), longest,
    speed: (1000 * (toy.time - time)) / (last - begun) };
}"""
PRESSED = """async keys => {
  const view = window.latolato.views.live;
  const picture = () => new Promise(requestAnimationFrame);
  const found = [];
  for (let k = 0; k < keys; k += 1) {
    await new Promise(done => setTimeout(done, 140 + 13 * (k % 7)));
    const begun = performance.now();
    view.parts.canvas.dispatchEvent(new KeyboardEvent("keydown",
      { key: k % 2 ? "ArrowDown" : "ArrowUp", bubbles: true, cancelable: true }));
    const { time } = view.toy;
    let pictures = 0;
    while (view.toy.time === time) {
      await picture();
      pictures += 1;
    }
    found.push([performance.now() - begun, pictures]);
  }
  return found;
}"""


def line(what: str, value: str, asked: str = "") -> None:
    """Print one result beside what is asked."""
    print(f"{what:58} {value:>22}   {asked}")


def shown(page: Any, what: str, asked: str) -> None:
    """Measure and print how often a page draws."""
    seen = page.evaluate(PICTURES, 1000 * SECONDS)
    value = f"{seen['rate']:.1f} | {seen['longest']:.0f} ms | {seen['speed']:.2f}"
    line(f"{what}: pictures a second | longest | speed", value, asked)


def main() -> None:
    """Measure and print."""
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
    with serving() as server, browsing() as browser:
        page = browser.new_page(base_url=server.address)
        page.goto("/?view=live")
        page.wait_for_selector("[data-ready]")
        page.wait_for_timeout(1500)
        throttle = page.context.new_cdp_session(page)
        page.evaluate(COST, 200)
        line("one move of 1/60 s, with energies", f"{1e3 * page.evaluate(COST, MOVES):.0f} us")
        for name in ("1", "10"):
            page.get_by_label("Speed", exact=True).select_option(name)
            for slower in (1, 4):
                throttle.send("Emulation.setCPUThrottlingRate", {"rate": slower})
                page.wait_for_timeout(500)
                what = f"{name}x" + (f", processor {slower} times slower" if slower > 1 else "")
                shown(page, what, "60" if slower == 1 else "50" if name == "1" else "")
            throttle.send("Emulation.setCPUThrottlingRate", {"rate": 1})
        page.get_by_label("Speed", exact=True).select_option("1")
        page.get_by_role("application").focus()
        keys = page.evaluate(PRESSED, KEYS)
        delays = sorted(delay for delay, _ in keys)
        line("key to the picture of changed motion, median | longest",
             f"{statistics.median(delays):.1f} | {delays[-1]:.1f} ms", "one picture")  # fmt: skip
        line("pictures until then, most", str(max(pictures for _, pictures in keys)), "1")


if __name__ == "__main__":
    main()
