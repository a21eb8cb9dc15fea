"""What all views have in common, in a real browser."""

TITLES = {
    "toy": "Toy",
    "map": "Map",
    "measure": "Measure",
    "analyse": "Analyse",
    "report": "Report",
}


def test_every_view_has_one_title(page):
    page.goto("/?view=map")
    views = page.get_by_role("navigation", name="Views").get_by_role("link")
    views.first.wait_for()
    assert views.count() == len(TITLES)
    for name in TITLES:
        views.nth(list(TITLES).index(name)).click()
        page.get_by_role("heading", level=1, name=TITLES[name]).wait_for()
        assert page.locator("h1").count() == 1


def test_every_view_has_the_same_tools_at_its_top_right(page):
    page.add_init_script("delete Navigator.prototype.share;")
    page.goto("/?view=measure&unknown=1")
    views = page.get_by_role("navigation", name="Views").get_by_role("link")
    views.first.wait_for()
    for name, title in TITLES.items():
        views.nth(list(TITLES).index(name)).click()
        page.get_by_role("heading", level=1, name=title).wait_for()
        place = page.locator(".stage-tools")
        place.get_by_role("button", name="Share").click()
        assert place.get_by_label("Link to this view").input_value() == page.url
        # Only a stage and a map can be saved as a picture.
        has_picture = name in ("toy", "map")
        picture = place.get_by_role("button", name="Save the picture")
        picture.wait_for(state="visible" if has_picture else "hidden")
        page.keyboard.press("Escape")
    page.go_back()
    page.get_by_role("heading", level=1, name=TITLES["analyse"]).wait_for()


def test_messages_leave_the_columns_of_a_view_as_they_are(page):
    page.goto("/?view=analyse&unknown=1")
    message = page.locator(".message")
    message.wait_for()
    side = page.locator(".side").bounding_box()
    assert message.bounding_box()["x"] > side["x"] + side["width"]
