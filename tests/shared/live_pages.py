"""The view Live in a browser."""

from __future__ import annotations

from typing import Any

# How long a page may take to show its toy [ms].
PATIENCE = 240_000


def open_live(page: Any, query: str = "") -> None:
    """Open Live and wait until its toy moves."""
    page.goto(f"/?view=live{query}")
    page.wait_for_selector("[data-ready]", timeout=PATIENCE)
    page.wait_for_function("() => window.latolato.views.live.toy.time > 0.05")


def of_toy(page: Any, what: str) -> Any:
    """Return a number of the toy."""
    return page.evaluate(f"() => window.latolato.views.live.toy.{what}")


def wait_for_toy(page: Any, condition: str, **options: Any) -> None:
    """Wait until a condition of the toy holds."""
    page.wait_for_function(f"() => {{ const {{ toy }} = window.latolato.views.live; "
                           f"return {condition}; }}", **options)  # fmt: skip
