"""A running server, a browser, and pages that fail on whatever a user would call broken."""

from __future__ import annotations

import atexit
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

import latolato as ll
from app_server import Server, start_server, stop_server

# The first of them needs a quarter less of a processor than the others.
_BROWSERS = (
    "chromium-headless-shell",
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
)
_ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
# How long a page may take to show its first run, map or result [ms].
PATIENCE = 120_000
# How addresses name the views, and a toy held by hand; and the attributes of pages that are ready.
ADDRESS = {"toy": "toy", "held": "toy&toy.hand=1", "map": "map"}
READY = {"toy": "[data-runs]", "held": "[data-ready]", "map": "[data-done]"}


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """One server for all tests of a worker."""
    server = start_server()
    yield server
    stop_server(server)


@pytest.fixture(scope="session")
def browser() -> Any:
    """The system's Chromium, without a window."""
    return _chromium()


@lru_cache(maxsize=1)
def _chromium() -> Any:
    """Return the one browser of this process; folders of tests have fixtures of their own."""
    from playwright.sync_api import sync_playwright

    playwright = sync_playwright().start()
    atexit.register(playwright.stop)
    return launch(playwright.chromium)


def launch(kind: Any, *arguments: str) -> Any:
    """Return a Chromium that is started with these arguments beside the usual ones."""
    path = next(filter(None, map(shutil.which, _BROWSERS)), None)
    assert path is not None, "these tests need Chromium: apt-get install chromium"
    return kind.launch(executable_path=path, args=[*_ARGUMENTS, *arguments])


def new_context(browser: Any, **options: Any) -> Any:
    """Return a context of a browser whose pages have the time that they may need."""
    context = browser.new_context(**options)
    context.set_default_timeout(PATIENCE)
    return context


def open_view(page: Any, query: str = "", view: str = "toy") -> None:
    """Open a view, and wait until it shows its first run, toy or map."""
    page.goto(f"/?view={ADDRESS[view]}{query}")
    page.wait_for_selector(READY[view])


def enter(field: Any, text: str) -> None:
    """Type a text into a field, and take it."""
    field.fill(text)
    field.press("Enter")


def download(button: Any, folder: Path) -> Path:
    """Press a button or a link that stores a file, and return the file in a folder."""
    with button.page.expect_download() as caught:
        button.click()
    path = folder / caught.value.suggested_filename
    caught.value.save_as(path)
    return path


def open_form(page: Any, query: str = "") -> None:
    """Open a toy at rest with all its parameters."""
    page.emulate_media(reduced_motion="reduce")
    open_view(page, query)
    page.get_by_text("More parameters", exact=True).click()


# The run on show, and its options.
PLAYER = "window.latolato.views.toy.player"
OPTIONS = f"{PLAYER}.motion.about.options"


def wait_for_options(page: Any, condition: str) -> None:
    """Wait until a condition of the `options` of the run on show holds."""
    page.wait_for_function(
        f"() => {{ const options = {PLAYER}.motion?.about.options;"
        f" return options && ({condition}); }}"
    )


@contextmanager
def next_run(page: Any) -> Iterator[None]:
    """Wait for the run that something makes."""
    before = page.locator("[data-runs]").get_attribute("data-runs")
    yield
    page.wait_for_function(
        "n => document.querySelector('[data-runs]').dataset.runs !== n", arg=before
    )


def stored_run(page: Any, folder: Path) -> Any:
    """Store the run on show from the menu, and read it."""
    page.get_by_text("Download", exact=True).click()
    menu = page.locator(".downloads")
    path, _ = (
        download(menu.get_by_role("button", name=name, exact=True), folder)
        for name in ("CSV", "CSV of contacts")
    )
    return ll.load(path)


@dataclass
class Watch:
    """What went wrong on a page."""

    port: int
    faults: list[str] = field(default_factory=list)

    def attach(self, page: Any) -> None:
        """Collect errors, failed requests and requests to elsewhere."""
        page.on("pageerror", lambda error: self.faults.append(f"page error: {error}"))
        page.on("console", self._console)
        page.on("response", self._response)
        page.on("request", self._request)

    def _console(self, message: Any) -> None:
        if message.type in ("error", "warning"):
            self.faults.append(f"console {message.type}: {message.text}")

    def _response(self, response: Any) -> None:
        if response.status >= 400:
            self.faults.append(f"{response.status} {response.url}")

    def _request(self, request: Any) -> None:
        parts = urlsplit(request.url)
        if parts.scheme in ("data", "blob"):
            return
        if (parts.hostname, parts.port) != ("127.0.0.1", self.port):
            self.faults.append(f"request to elsewhere: {request.url}")


@pytest.fixture
def watch(server: Server) -> Iterator[Watch]:
    """Faults of all pages of a test; those that are expected must be taken out."""
    watch = Watch(server.port)
    yield watch
    assert not watch.faults, "\n".join(watch.faults)


@pytest.fixture(scope="session")
def anchor(browser: Any, server: Server) -> Iterator[Any]:
    """A page without scripts that stays open: pages beside it open in half the time."""
    context = new_context(browser, base_url=server.address)
    anchor = context.new_page()
    anchor.goto("/icon.svg")
    yield anchor
    context.close()


@pytest.fixture
def page(anchor: Any, watch: Watch) -> Iterator[Any]:
    """A page of the server, 1280 pixels wide, that knows nothing of earlier ones."""
    page = anchor.context.new_page()
    page.set_viewport_size({"width": 1280, "height": 900})
    watch.attach(page)
    yield page
    for other in anchor.context.pages[1:]:
        other.close()
    anchor.context.clear_cookies()
    anchor.evaluate("() => localStorage.clear()")
