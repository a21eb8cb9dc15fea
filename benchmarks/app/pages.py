"""A server of its own and a headless Chromium, as the benchmarks of the application use them."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


@dataclass
class Server:
    """A server: its address, its process and when it was started [s of the epoch]."""

    address: str
    pid: int
    begun: float


@contextlib.contextmanager
def serving() -> Iterator[Server]:
    """Yield a server that has just been started."""
    begun = time.time()
    command = [sys.executable, "-m", "latolato", "app", "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = process.stdout.readline().split(" at ")[1].strip()
        try:
            yield Server(address, process.pid, begun)
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
        browser = playwright.chromium.launch(executable_path=path, args=_ARGUMENTS)
        yield browser
        browser.close()
