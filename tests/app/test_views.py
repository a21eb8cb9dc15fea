"""What all views have in common, in a real browser."""

import pytest

from browser_checks import overlaps

# How long a view may take to show what it shows first [ms].
PATIENCE = 240_000

TITLES = {
    "play": "Play",
    "map": "Map",
    "live": "Live",
    "paper": "The paper\N{RIGHT SINGLE QUOTATION MARK}s claims, recalculated",
    "experiment": "Experiment",
    "analyse": "Analyse",
}


@pytest.mark.parametrize("first", ["play", "paper"])
def test_every_view_has_one_title(page, first):
    page.goto(f"/?view={first}")
    views = page.get_by_role("navigation", name="Views").get_by_role("link")
    views.first.wait_for()
    assert views.count() == len(TITLES)
    for name in [first, *TITLES]:
        views.nth(list(TITLES).index(name)).click()
        page.get_by_role("heading", level=1, name=TITLES[name]).wait_for()
        assert page.locator("h1").count() == 1


# What each view shows when it has what it asks the server for.
READY = {
    "play": "[data-runs] .ledger-row",
    "map": ".map-readout",
    "live": "[data-ready]",
    "paper": ".plate",
    "experiment": ".dropzone",
    "analyse": ".question",
}


@pytest.mark.parametrize("width", [390, 1366])
@pytest.mark.parametrize("view", TITLES)
def test_no_panel_covers_another(page, view, width):
    page.set_viewport_size({"width": width, "height": 768})
    page.goto(f"/?view={view}")
    page.wait_for_selector(READY[view], timeout=PATIENCE)
    assert overlaps(page) == []
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width
