"""Play in a headless Chromium: cold start, slider to painted curve, frames, size of the page.

Beside each figure stands what is asked for. Nothing is asserted: machines differ.
"""

from __future__ import annotations

import statistics
from typing import Any
from urllib.parse import urlsplit

from pages import browsing, serving

COLD_STARTS = 9
# Calls a function once the next frame is painted: a message comes after it, as a timer may not.
PAINTED = """(tell) => requestAnimationFrame(() => {
  const after = new MessageChannel();
  after.port1.onmessage = tell;
  after.port2.postMessage(0);
})"""
# Notes on a page that begins when the frame with its first curve was painted [ms of the epoch].
# Waiting for the curve from outside would be coarse: a browser is asked twice a second only.
WATCH = f"""new MutationObserver((_, self) => {{
  if (!document.querySelector("[data-runs]")) return;
  self.disconnect();
  ({PAINTED})(() => {{ window.shown = performance.timeOrigin + performance.now(); }});
}}).observe(document, {{ subtree: true, childList: true, attributeFilter: ["data-runs"] }});"""
# Moves a slider back and forth; resolves with the times from input event to painted curve [ms].
SLIDE = """async ({ label, count }) => {
  const slider = document.querySelector(`input[type=range][aria-label="${label}"]`);
  const view = document.querySelector("[data-runs]");
  const found = [];
  for (let i = 0; i < count; i += 1) {
    const runs = view.dataset.runs;
    slider.value = String(Number(slider.value) + (i % 2 ? -3 : 3));
    const begun = performance.now();
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await new Promise((resolve) => {
      const look = () => {
        if (view.dataset.runs !== runs) (PAINTED)(resolve);
        else setTimeout(look, 1);
      };
      look();
    });
    found.push(performance.now() - begun);
    await new Promise((resolve) => setTimeout(resolve, 60));
  }
  return found;
}""".replace("PAINTED", PAINTED)
FRAMES = """async (seconds) => {
  const player = window.latolato.views.play.player;
  player.clock.speed = 10;
  player.clock.seek(0);
  player.clock.play();
  const times = [];
  await new Promise((resolve) => {
    const begun = performance.now();
    const look = (now) => {
      times.push(now);
      if (performance.now() - begun < 1000 * seconds) requestAnimationFrame(look);
      else resolve();
    };
    requestAnimationFrame(look);
  });
  player.clock.pause();
  return (1000 * (times.length - 1)) / (times[times.length - 1] - times[0]);
}"""


def new_page(browser: Any) -> tuple[Any, list[Any]]:
    """Return an empty page and the list of its responses."""
    page = browser.new_context(viewport={"width": 1400, "height": 1000}).new_page()
    responses: list[Any] = []
    page.on("response", lambda response: responses.append(response))
    return page, responses


def show_run(page: Any, address: str, samples: int) -> None:
    """Show a 300 s run on a page."""
    page.goto(f"{address}?scenario=fig04b_push&duration=300%20s&samples={samples}")
    page.wait_for_selector("[data-runs]", timeout=120_000)


def open_page(browser: Any, address: str, samples: int) -> Any:
    """Return a page that shows a 300 s run."""
    page, _ = new_page(browser)
    show_run(page, address, samples)
    return page


def cold_start(browser: Any) -> float:
    """Return the time from the start of the server to the first curve of a waiting browser [s]."""
    page, _ = new_page(browser)
    page.add_init_script(WATCH)
    with serving() as server:
        show_run(page, server.address, 30_000)
        shown: float = page.wait_for_function("() => window.shown").json_value()
    page.close()
    return 1e-3 * shown - server.begun


def main() -> None:
    """Print the figures."""
    with serving():
        pass  # files of Python and kernels are in the cache of the machine now
    with browsing() as browser:
        shown = [cold_start(browser) for _ in range(COLD_STARTS)]
        print(
            f"first curve {statistics.median(shown):.2f} s after a cold start, "
            f"{min(shown):.2f} to {max(shown):.2f} s in {COLD_STARTS} (asked 1.5)"
        )
    with browsing() as browser, serving() as server:
        page, responses = new_page(browser)
        show_run(page, server.address, 30_000)
        own = urlsplit(server.address).netloc
        outside = [r.url for r in responses if urlsplit(r.url).netloc != own]
        files = [r for r in responses if "/api/run" not in r.url]
        size = sum(len(r.body()) for r in files)
        print(f"page {size / 1e6:.2f} MB in {len(files)} files (asked 1.6 MB)")
        print(f"requests to elsewhere: {len(outside)} (asked 0)")
        page.close()
        for samples, asked in ((30_000, 60), (100_000, 100)):
            page = open_page(browser, server.address, samples)
            found = page.evaluate(SLIDE, {"label": "driving amplitude, slider", "count": 40})
            late = sorted(found)[int(0.9 * len(found))]
            print(
                f"slider to painted curve at {samples} samples: median "
                f"{statistics.median(found):.0f} ms, nine of ten within {late:.0f} ms "
                f"(asked {asked})"
            )
            page.close()
        page = open_page(browser, server.address, 30_000)
        print(f"frames at 10x: {page.evaluate(FRAMES, 5):.1f} per second (asked 60)")
        slow = page.context.new_cdp_session(page)
        slow.send("Emulation.setCPUThrottlingRate", {"rate": 4})
        print(f"with a four times slower processor: {page.evaluate(FRAMES, 5):.1f} (asked 50)")


if __name__ == "__main__":
    main()
