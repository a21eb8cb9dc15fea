"""Makes the README's pictures again: the moving toy, and pages of the application.

`make pictures` runs it; it needs Chromium.
"""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
sys.path.insert(0, str(ROOT / "tests" / "shared"))

# What each page shows, by its address, and what is in it once it is ready.
PAGES = {
    "play": ("?scenario=toy", "[data-runs]"),
    "map": ("?view=map&map.scenario=fig05_push&map.duration=60&map.size=120", "[data-done]"),
    "experiment": ("?view=experiment&experiment.example=decay", ".experiment[data-state=result]"),
    "paper": ("?view=paper&paper.figure=fig04", "#paper-fig04 .picture img"),
}
SIZE = {"width": 1366, "height": 860}


def main() -> None:
    """Write the moving picture and the screenshots."""
    from PIL import Image
    from playwright.sync_api import sync_playwright

    from app_pages import launch
    from app_server import start_server, stop_server

    moving = ["simulate", "toy", "--duration", "8", "--fps", "20", "--animate"]
    subprocess.run([sys.executable, "-m", "latolato", *moving, IMAGES / "toy.gif"], check=True)
    server: Any = start_server()
    try:
        with sync_playwright() as playwright:
            page = launch(playwright.chromium).new_page(viewport=SIZE, color_scheme="light")
            for name, (query, ready) in PAGES.items():
                page.goto(f"{server.address}{query}")
                page.wait_for_selector(ready, timeout=300_000)
                page.wait_for_load_state("networkidle")
                shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
                shot.quantize(128).save(IMAGES / f"{name}.png", optimize=True)
    finally:
        stop_server(server)


if __name__ == "__main__":
    main()
