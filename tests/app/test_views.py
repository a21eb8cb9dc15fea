"""What all views have in common, in a real browser."""

TITLES = {
    "play": "Play",
    "map": "Map",
    "live": "Live",
    "story": "Stories",
    "paper": "The paper\N{RIGHT SINGLE QUOTATION MARK}s claims, recalculated",
    "experiment": "Experiment",
    "analyse": "Analyse",
}


def test_every_view_has_one_title(page):
    page.goto("/?view=paper")
    views = page.get_by_role("navigation", name="Views").get_by_role("link")
    views.first.wait_for()
    assert views.count() == len(TITLES)
    for name in TITLES:
        views.nth(list(TITLES).index(name)).click()
        page.get_by_role("heading", level=1, name=TITLES[name]).wait_for()
        assert page.locator("h1").count() == 1
