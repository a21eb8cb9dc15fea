"""A view that a user brings: its module, a line among the views and its title."""

from pathlib import Path
from urllib.parse import urlsplit

import pytest

import latolato.app
from app_pages import anchor, browser, page, server, watch

__all__ = ["anchor", "browser", "page", "server", "watch"]

STATIC = Path(latolato.app.__file__).parent / "static"
MODULE = """
import { el } from "../page/dom.js";

export class HelloView {
  constructor(page) {
    this.root = el("section", {}, `${Object.keys(page.registry.drives).length} drives`);
  }
  show() { this.shown = true; }
  hide() { this.shown = false; }
}
"""
LINES = {
    "js/main.js": (
        "const VIEWS = {\n",
        '  hello: async () => (await import("./hello/view.js")).HelloView,\n',
    ),
    "languages/en.json": ('    "view_toy": "Toy",\n', '    "view_hello": "Hello",\n'),
}


@pytest.fixture
def with_view(page):
    """A page whose server has the view's module and the two lines."""
    files = {"js/hello/view.js": MODULE}
    for name, (place, line) in LINES.items():
        text = (STATIC / name).read_text(encoding="utf-8")
        assert place in text
        files[name] = text.replace(place, place + line)

    def serve(route, request):
        path = urlsplit(request.url).path.removeprefix("/")
        if path in files:
            kind = "application/json" if path.endswith(".json") else "text/javascript"
            route.fulfill(body=files[path], content_type=kind)
        else:
            route.continue_()

    page.route("**/*", serve)
    return page


def test_it_is_linked_and_shown_and_left(with_view):
    with_view.goto("/?view=hello")
    with_view.get_by_role("heading", level=1, name="Hello").wait_for()
    assert with_view.locator("main section").inner_text().endswith(" drives")
    links = with_view.get_by_role("navigation", name="Views").get_by_role("link")
    assert "Hello" in links.all_inner_texts()
    assert with_view.title() == "Hello · latolato"
    links.filter(has_text="Toy").click()
    with_view.get_by_role("heading", level=1, name="Toy").wait_for()
    assert with_view.evaluate("() => window.latolato.views.hello.shown") is False
