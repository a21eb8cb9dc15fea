"""Makes the pictures of README and the first tutorial again: the moving toy, and pages.

`make pictures` runs it; it needs Chromium.
"""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
sys.path.insert(0, str(ROOT / "tests" / "shared"))

# What each page shows, by its address, and what is in it once it is ready.
PAGES = {
    "toy": ("?scenario=toy", "[data-runs]"),
    "map": ("?view=map&map.scenario=fig05_push&map.duration=60&map.size=120", "[data-done]"),
    "measure": ("?view=measure&measure.example=decay", ".measure[data-state=result]"),
    "report": ("report/index.html", ".claims"),
}
SIZE = {"width": 1366, "height": 860}
SET = "([name, text]) => window.latolato.views.toy.page.store.option(name, text)"
SETTLED = 3000  # ms: the toy is on its way
# Those of the tutorial, with buttons to press, sliders to put to their end, and options to set.
SMALLER = {"width": 1180, "height": 720}
Steps = Sequence[tuple[str, str]]
TUTORIAL: dict[str, tuple[str, str, Steps]] = {
    "play-toy": ("?scenario=toy", "[data-runs]", []),
    "play-push": (
        "?scenario=first_push&initial_offset=7 deg", "[data-runs]",
        [("press", "Pin this run to compare"), ("initial_offset", "5 deg"), ("press", "Whole run")],
    ),
    "play-chaos": (
        "?scenario=toy&restitution=0.5&drive_amplitude=91.5 mm&duration=60 s", "[data-runs]",
        [("press", "Pause"), ("end", "Instant")],
    ),
    "map-toy": ("?view=map&scenario=toy&map.size=200", "[data-done]", []),
}  # fmt: skip


def main() -> None:
    """Write the moving picture and the screenshots."""
    from playwright.sync_api import sync_playwright

    from app_pages import launch
    from app_server import start_server, stop_server

    moving = ["simulate", "toy", "--duration", "8", "--fps", "20", "--animate"]
    subprocess.run([sys.executable, "-m", "latolato", *moving, IMAGES / "toy.gif"], check=True)
    report = ROOT / "build" / "report"
    quickly = ["reproduce", "--quick", "--output", report]
    subprocess.run([sys.executable, "-m", "latolato", *quickly], check=True)
    server: Any = start_server("--report", str(report))
    try:
        with sync_playwright() as playwright:
            page = launch(playwright.chromium).new_page(viewport=SIZE, color_scheme="light")
            for name, (query, ready) in PAGES.items():
                shot = picture(page, f"{server.address}{query}", ready)
                shot.quantize(128).save(IMAGES / f"{name}.png", optimize=True)
            page.set_viewport_size(SMALLER)
            for name, (query, ready, steps) in TUTORIAL.items():
                shot = picture(page, f"{server.address}{query}", ready, steps)
                shot.save(IMAGES / f"{name}.webp", quality=80)
    finally:
        stop_server(server)


def picture(page: Any, address: str, ready: str, steps: Steps = ()) -> Image.Image:
    """Return a screenshot of a page after some steps."""
    page.goto(address)
    page.wait_for_selector(ready, timeout=300_000)
    for what, text in steps:
        if what == "press":
            page.get_by_role("button", name=text).click()
        elif what == "end":
            page.get_by_role("slider", name=text).press("End")
        else:
            page.evaluate(SET, [what, text])
    page.wait_for_load_state("networkidle")
    page.wait_for_timeout(SETTLED)
    return Image.open(io.BytesIO(page.screenshot())).convert("RGB")


if __name__ == "__main__":
    main()
