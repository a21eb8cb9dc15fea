"""The toy in a hand, in a browser."""

from __future__ import annotations

from typing import Any

from app_pages import open_view

# The toy of Fig. 12 at rest, shaken as in its slow second stage, too gently to lift the balls off.
AT_REST = "&scenario=fig12&drive=harmonic&drive_amplitude=34 mm&frequency_ratio=2.389"


def open_held(page: Any, query: str = AT_REST) -> None:
    """Open the toy in a hand and wait until it moves."""
    open_view(page, query, view="held")
    page.wait_for_function("() => window.latolato.views.toy.hand.toy.time > 0.05")


def of_toy(page: Any, what: str) -> Any:
    """Return a number of the toy."""
    return page.evaluate(f"() => window.latolato.views.toy.hand.toy.{what}")


def wait_for_toy(page: Any, condition: str, **options: Any) -> None:
    """Wait until a condition of the toy holds."""
    page.wait_for_function(f"() => {{ const {{ toy }} = window.latolato.views.toy.hand; "
                           f"return {condition}; }}", **options)  # fmt: skip
