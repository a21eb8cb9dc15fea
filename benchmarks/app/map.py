"""Maps in the application, measured in a headless Chromium beside what is asked.

``python benchmarks/app/map.py``: the first coarse map (50 x 50, 300 s, walls), how often the
picture of a map of 200 x 200 changes, how soon work ends when its page goes, and how soon the
server answers others meanwhile. Kernels should be in the disk cache: run it twice.
"""

from __future__ import annotations

import json
import os
import statistics
import threading
import time
import urllib.request
from typing import Any

from pages import browsing, serving

FIRST = "/?view=map&map.scenario=fig05_push&map.size=50"
# Notes when the picture changes, from the moment the map is asked for.
WATCH = """() => {
  const view = window.latolato.views.map;
  window.pictures = [];
  const compute = view.compute.bind(view);
  view.compute = (request) => {
    window.pictures = [];
    window.begun = performance.now();
    compute(request);
  };
  const paint = view.chart.paint.bind(view.chart);
  view.chart.paint = () => {
    paint();
    if (view.job && !view.job.ended) window.pictures.push(performance.now() - window.begun);
  };
  const finish = view.finish.bind(view);
  view.finish = (block) => {
    finish(block);
    window.ended = performance.now() - window.begun;
  };
}"""
RESULT = "() => ({ pictures: window.pictures, end: window.ended })"


def recompute(page: Any, size: int) -> list[float]:
    """Return when the pictures of a new map came [s]; the last one is when it was done."""
    done = int(page.locator("[data-done]").get_attribute("data-done"))
    page.evaluate(
        """([size, duration]) => {
          const view = window.latolato.views.map;
          view.controls.keep({ size, duration });
          view.stopOrGo();
        }""",
        # The server keeps what it has computed: other runs each time.
        [size, 300.0 + 1e-3 * done],
    )
    page.wait_for_selector(f"[data-done='{done + 1}']", timeout=300_000)
    found = page.evaluate(RESULT)
    return [ms / 1e3 for ms in [*found["pictures"], found["end"]]]


def answers(address: str, stop: threading.Event) -> list[float]:
    """Return how long small answers of the server take until `stop` is set [s]."""
    found = []
    while not stop.is_set():
        begun = time.perf_counter()
        with urllib.request.urlopen(address + "static/icon.svg") as answer:
            answer.read()
        found.append(time.perf_counter() - begun)
        time.sleep(0.02)
    return found


def cpu_of(process: int) -> float:
    """Return the processor time that a process has used [s]."""
    with open(f"/proc/{process}/stat") as file:
        parts = file.read().rsplit(")", 1)[1].split()
    return (int(parts[11]) + int(parts[12])) / os.sysconf("SC_CLK_TCK")


def measure() -> dict[str, Any]:
    """Return the figures."""
    with serving() as server, browsing() as browser:
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        begun = time.perf_counter()
        page.goto(server.address.rstrip("/") + FIRST)
        page.wait_for_selector("[data-done]", timeout=120_000)
        opened = time.perf_counter() - begun
        page.evaluate(WATCH)
        coarse = [recompute(page, 50)[-1] for _ in range(5)]
        stop, waits = threading.Event(), []
        thread = threading.Thread(target=lambda: waits.extend(answers(server.address, stop)))
        thread.start()
        fine = recompute(page, 200)
        stop.set()
        thread.join()
        gaps = [b - a for a, b in zip([0.0, *fine], fine, strict=False)]
        page.evaluate("() => window.latolato.views.map.controls.keep({ size: 400 })")
        time.sleep(1.5)
        page.evaluate("() => window.latolato.views.map.stop()")
        time.sleep(0.1)
        before = cpu_of(server.pid)
        time.sleep(1.0)
        idle = cpu_of(server.pid) - before
    return {
        "page opened and 50 x 50 done, fresh server [s]": opened,
        "50 x 50 on show, best of 5 [s]": min(coarse),
        "50 x 50 on show, median [s]": statistics.median(coarse),
        "200 x 200 first picture [s]": fine[0],
        "200 x 200 done [s]": fine[-1],
        "200 x 200 pictures": len(fine),
        "200 x 200 longest time without a new picture [s]": max(gaps),
        "other answers meanwhile, median [ms]": 1e3 * statistics.median(waits),
        "other answers meanwhile, 99 % [ms]": 1e3 * sorted(waits)[int(0.99 * len(waits))],
        "processor time in the second after leaving a map [s]": idle,
    }


ASKED = {
    "50 x 50 on show, best of 5 [s]": 1.0,
    "200 x 200 longest time without a new picture [s]": 0.5,
}


def main() -> None:
    """Print the figures beside those asked."""
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    found = measure()
    for name, value in found.items():
        asked = f"asked at most {ASKED[name]:g}" if name in ASKED else ""
        print(f"{name:55} {value:9.3f}  {asked}")
    print(json.dumps(found))


if __name__ == "__main__":
    main()
