"""The pages beside the figures asked of them, all in one go, in a headless Chromium.

The static site is served by a plain file server. Each figure stands beside the one that is asked;
the first lines say how fast native code is in the same run, for machines differ. Key to motion and
slider to curve are times from an event to the picture that shows what comes of it. Maps have walls,
300 s and e = 1; their pictures are counted by ``data-pictures`` and ``data-done`` of the view.

``python benchmarks/pages.py [toy hand maps size server]``
"""

from __future__ import annotations

import contextlib
import gzip
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import latolato as ll
from latolato.app.site import write_site

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
COLD_STARTS = 7
SLIDES = 40
KEYS = 40
PAGES = 20
# Live is measured so often with sound and description, and as often without.
SENSES = 5
SECONDS = 4.0
# Maps are measured so often; runs of other lengths are other maps.
COARSE_MAPS = 5
PATIENCE = 300_000

# Calls a function once the next frame is painted: a message comes after it, as a timer may not.
PAINTED = """(tell) => requestAnimationFrame(() => {
  const after = new MessageChannel();
  after.port1.onmessage = tell;
  after.port2.postMessage(0);
})"""
# Notes when the frame with the first curve of a run was painted, or the first that moved in a hand.
WATCH_START = f"""const look = () => {{
  const moves = window.latolato?.views.toy?.hand?.toy?.time > 0;
  if (!moves && !document.querySelector("[data-runs]")) requestAnimationFrame(look);
  else ({PAINTED})(() => {{ window.shown = performance.now(); }});
}};
requestAnimationFrame(look);"""
# Moves a slider back and forth; returns the times from input event to painted curve [ms].
SLIDE = """async ({ label, count }) => {
  const slider = document.querySelector(`input[type=range][aria-label="${label}"]`);
  const view = document.querySelector("[data-runs]");
  const times = [];
  for (let i = 0; i < count; i += 1) {
    const painted = new Promise((resolve) => new MutationObserver((_, self) => {
      self.disconnect();
      (PAINTED)(resolve);
    }).observe(view, { attributeFilter: ["data-runs"] }));
    slider.value = String(Number(slider.value) + (i % 2 ? -3 : 3));
    const begun = performance.now();
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await painted;
    times.push(performance.now() - begun);
    await new Promise((resolve) => setTimeout(resolve, 200 + 7 * (i % 5)));
  }
  return times;
}""".replace("PAINTED", PAINTED)
FRAMES = """async (ms) => {
  const picture = () => new Promise(requestAnimationFrame);
  const begun = await picture();
  let [last, count] = [begun, 0];
  while (last - begun < ms) [last, count] = [await picture(), count + 1];
  return (1000 * count) / (last - begun);
}"""
PRESS = """async (count) => {
  const view = window.latolato.views.toy.hand;
  const times = [];
  for (let k = 0; k < count; k += 1) {
    await new Promise((done) => setTimeout(done, 140 + 13 * (k % 7)));
    const begun = performance.now();
    view.player.scene.canvas.dispatchEvent(new KeyboardEvent("keydown",
      { key: k % 2 ? "ArrowDown" : "ArrowUp", bubbles: true, cancelable: true }));
    const { time } = view.toy;
    let pictures = 0;
    while (view.toy.time === time) {
      await new Promise(requestAnimationFrame);
      pictures += 1;
    }
    times.push([performance.now() - begun, pictures]);
  }
  return times;
}"""
# Asks for another map by the address; returns when its pictures came and when it was done [ms].
NEW_MAP = """async (search) => {
  const view = document.querySelector("[data-done]");
  const { done } = view.dataset;
  const times = [];
  const begun = performance.now();
  const ended = new Promise((resolve) => {
    const observer = new MutationObserver(() => {
      times.push(performance.now() - begun);
      if (view.dataset.done !== done) resolve(observer.disconnect());
    });
    observer.observe(view, { attributeFilter: ["data-pictures", "data-done"] });
  });
  history.replaceState(null, "", search);
  dispatchEvent(new PopStateEvent("popstate"));
  await ended;
  return times;
}"""


def line(what: str, measured: str, asked: str = "") -> None:
    """Print one figure beside what is asked."""
    print(f"{what:58} {measured:>24}   {asked}", flush=True)


@contextlib.contextmanager
def serving(command: list[str], said: str) -> Iterator[tuple[str, int]]:
    """Yield the address that a server prints, and its process."""
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        found = next(filter(None, (re.search(said, text) for text in process.stdout)))
        try:
            yield found[1], process.pid
        finally:
            process.terminate()


@contextlib.contextmanager
def browsing() -> Iterator[Any]:
    """Yield the system's Chromium."""
    from playwright.sync_api import sync_playwright

    path = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if path is None:
        raise SystemExit("these benchmarks need Chromium: apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(_ARGUMENTS))
        yield browser
        browser.close()


def new_page(browser: Any) -> Any:
    """Return a page without anything cached."""
    return browser.new_context(viewport={"width": 1400, "height": 1000}).new_page()


def least(work: Callable[[], object], turns: int = 3) -> float:
    """Return the least time that some work takes [s]."""
    times = []
    for _ in range(turns):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return min(times)


def native() -> None:
    """Print how fast native code does the same work here."""
    push = ll.load_scenario("fig04b_push")
    for samples in (30_000, 100_000):
        times = np.linspace(0.0, 300.0, samples)
        seconds = least(partial(push.record, times=times, duration=300.0))
        line(f"native: run of 300 s, {samples} samples", f"{1e3 * seconds:.0f} ms")
    axes = {"drive_amplitude": np.linspace(0, 0.5, 50), "frequency_ratio": np.linspace(0, 5, 50)}
    seconds = least(partial(ll.load_scenario("fig05_push").sweep, axes=axes))
    line("native: map of 50 x 50", f"{seconds:.2f} s")


def first_pictures(browser: Any, address: str) -> None:
    """Print how soon a visitor who was never here sees something."""
    for view, what in (
        ("toy&toy.hand=1", "first moving picture, cold"),
        ("toy", "first curve, cold"),
    ):
        shown = []
        for _ in range(COLD_STARTS):
            page = new_page(browser)
            page.add_init_script(WATCH_START)
            page.goto(f"{address}?view={view}")
            shown.append(page.wait_for_function("() => window.shown").json_value() / 1e3)
            page.context.close()
        line(what, f"{statistics.median(shown):.2f} s", "1.0 s")


def toy(browser: Any, address: str) -> None:
    """Print how Play follows a slider, and how smooth it is."""
    first_pictures(browser, address)
    for samples, asked in ((30_000, 25), (100_000, 50)):
        page = new_page(browser)
        page.goto(f"{address}?scenario=fig04b_push&duration=300 s&samples={samples}")
        page.wait_for_selector("[data-runs]", timeout=PATIENCE)
        page.wait_for_timeout(1000)
        given = {"label": "How far the hand moves, slider", "count": SLIDES}
        times = sorted(page.evaluate(SLIDE, given))
        measured = f"{statistics.median(times):.0f} ms, 9 of 10 {times[int(0.9 * SLIDES)]:.0f} ms"
        line(f"slider to painted curve, {samples} samples", measured, f"{asked} ms")
        page.context.close()


def hand(browser: Any, address: str) -> None:
    """Print how soon a toy in a hand follows a key, and how smooth it is."""
    page = new_page(browser)
    page.goto(f"{address}?view=toy&toy.hand=1")
    page.wait_for_selector("[data-ready]")
    page.wait_for_timeout(1500)
    keys = page.evaluate(PRESS, KEYS)
    delays = sorted(delay for delay, _ in keys)
    measured = f"{statistics.median(delays):.1f} ms, at most {max(p for _, p in keys)} pictures"
    line("hand: input to changed motion", measured, "1 picture")
    page.locator(".transport").get_by_label("Speed").select_option("10")
    throttle = page.context.new_cdp_session(page)
    for slower, asked in ((1, "60"), (4, "50")):
        throttle.send("Emulation.setCPUThrottlingRate", {"rate": slower})
        page.wait_for_timeout(500)
        rate = page.evaluate(FRAMES, 1000 * SECONDS)
        more = "" if slower == 1 else f", processor {slower} times slower"
        line(f"hand: pictures a second at 10x{more}", f"{rate:.1f}", asked)
    throttle.send("Emulation.setCPUThrottlingRate", {"rate": 1})
    page.locator(".transport").get_by_label("Speed").select_option("1")
    page.get_by_text("Listen and read").click()
    # In turns, so that whatever else the machine does weighs on both.
    rates: dict[bool, list[float]] = {False: [], True: []}
    for turn in range(2 * SENSES):
        is_on = bool(turn % 2)
        for choice in ("Sound", "Hear the angle", "Describe"):
            page.get_by_label(choice, exact=True).set_checked(is_on)
        rates[is_on].append(page.evaluate(FRAMES, 500 * SECONDS))
    silent, heard = (statistics.median(rates[is_on]) for is_on in (False, True))
    measured = f"{silent:.1f}, {heard:.1f} with them"
    line("hand: pictures a second without sound and description", measured, "60")
    page.context.close()


def maps(browser: Any, address: str) -> None:
    """Print when the pictures of maps come."""
    page = new_page(browser)
    query = "?view=map&map.scenario=fig05_push&map.size={}&map.duration={}"
    page.goto(address + query.format(50, 300))
    page.wait_for_selector("[data-done]", timeout=PATIENCE)
    for size, turns, asked in (
        (50, COARSE_MAPS, ("0.3 s", "", "1.5 s")),
        (200, 1, ("", "0.5 s", "20 s")),
    ):
        found = []
        for turn in range(turns):
            times = page.evaluate(NEW_MAP, query.format(size, 300 + 0.01 * (turn + 1)))
            gaps = [b - a for a, b in zip([0.0, *times], times, strict=False)]
            found.append((times[0] / 1e3, max(gaps) / 1e3, times[-1] / 1e3))
        words = ("first picture", "longest time without a new picture", "done")
        for word, values, wish in zip(words, zip(*found, strict=True), asked, strict=True):
            line(f"map of {size} x {size}: {word}", f"{statistics.median(values):.2f} s", wish)
    page.context.close()


def size(browser: Any, address: str) -> None:
    """Print how much a visitor loads who opens Toy and holds it, and how much more with Map."""
    known: set[str] = set()
    toy = {"toy": "[data-runs]", "toy&toy.hand=1": "[data-ready]"}
    for name, ends, asked in (("Toy", toy, "0.6 MB"), ("Map in addition", {"map": "h1"}, "")):
        loaded: set[str] = set()
        for view, end in ends.items():
            page = new_page(browser)
            page.on("request", lambda request, loaded=loaded: loaded.add(request.url))
            page.goto(f"{address}?view={view}")
            page.wait_for_selector(end, state="attached", timeout=PATIENCE)
            page.wait_for_load_state("networkidle")
            page.context.close()
        added = {url.partition("?")[0] for url in loaded if url.startswith("http")} - known
        known |= added
        files = []
        for url in added:
            with urllib.request.urlopen(url) as answer:
                files.append(answer.read())
        whole, packed = (sum(map(len, each)) / 1e6 for each in (files, map(gzip.compress, files)))
        measured = f"{whole:.2f} MB, gzip {packed:.2f} MB"
        line(f"{name}, with kernels, {len(files)} files", measured, asked)


def server(browser: Any) -> None:
    """Print what open pages cost the server of the program."""
    command = [sys.executable, "-m", "latolato", "app", "--no-browser", "--port", "0"]
    with serving(command, r" at (\S+)") as (address, process):
        context = browser.new_context()
        for k in range(PAGES):
            page = context.new_page()
            page.goto(f"{address}?view={('toy', 'toy&toy.hand=1')[k % 2]}")
            page.wait_for_selector("[data-runs], [data-ready]", timeout=PATIENCE)
        time.sleep(1.0)
        before = cpu_time(process)
        time.sleep(SECONDS)
        used = (cpu_time(process) - before) / SECONDS
        line(f"processor time of the server, {PAGES} open pages", f"{100 * used:.1f} %", "0 %")
        context.close()


def cpu_time(process: int) -> float:
    """Return the processor time that a process has used [s]."""
    parts = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(parts[11]) + int(parts[12])) / os.sysconf("SC_CLK_TCK")


def main() -> None:
    """Measure what the command line names, or everything."""
    wanted = sys.argv[1:] or ["toy", "hand", "maps", "size", "server"]
    print(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}\n")
    line("", "measured", "asked at most")
    native()
    with tempfile.TemporaryDirectory() as folder, browsing() as browser:
        write_site(Path(folder))
        command = [sys.executable, "-m", "http.server", "--bind", "127.0.0.1", "-d", folder, "0"]
        with serving(command, r"\((http://[^)]+)\)") as (address, _):
            for measure in (toy, hand, maps, size):
                if measure.__name__ in wanted:
                    measure(browser, address)
        if "server" in wanted:
            server(browser)


if __name__ == "__main__":
    main()
