"""Sharing what is on show: a link and a picture, in a real browser."""

from __future__ import annotations

import pytest
from PIL import Image

from app_pages import download, enter, open_view

# A system that can share, and what it was given.
SHARES = """() => {
  navigator.canShare = () => true;
  navigator.share = async ({ url, files }) => {
    window.given = { url, name: files[0].name, size: files[0].size };
  };
}"""


@pytest.fixture(autouse=True)
def of_linux(page):
    """Chromium shares by the system on some systems only."""
    page.add_init_script("delete Navigator.prototype.share;")


def open_menu(page, query="", view="toy"):
    open_view(page, f"{query}&map.size=8", view)
    page.get_by_role("button", name="Share").click()


@pytest.mark.parametrize("view", ["toy", "held", "map"])
def test_the_picture_of_a_view_is_saved(page, view, tmp_path):
    open_menu(page, view=view)
    path = download(page.get_by_role("button", name="Save the picture"), tmp_path)
    with Image.open(path) as picture:
        assert min(picture.size) > 200
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 10


def test_the_link_is_copied(page):
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    open_menu(page, "&scenario=toy")
    field = page.get_by_role("textbox", name="Bounciness")
    enter(field, "0.8")
    link = page.get_by_role("textbox", name="Link")
    assert link.input_value().endswith("/?view=toy&scenario=toy&restitution=0.8&map.size=8")
    page.get_by_role("button", name="Copy the link").click()
    page.get_by_text("Copied.").wait_for()
    assert page.evaluate("() => navigator.clipboard.readText()") == link.input_value()
    page.context.clear_permissions()


def test_the_menu_closes_when_something_else_is_pressed(page):
    open_menu(page, "&scenario=toy")
    copy = page.get_by_role("button", name="Copy the link")
    page.get_by_role("textbox", name="Link").click()
    assert copy.is_visible()
    page.get_by_role("heading", level=2).first.click()
    copy.wait_for(state="hidden")
    assert page.get_by_role("button", name="Share").get_attribute("aria-expanded") == "false"


def test_without_the_clipboard_the_link_is_selected(page):
    page.add_init_script("Object.defineProperty(navigator, 'clipboard', { value: undefined });")
    open_menu(page, "&scenario=toy")
    page.get_by_role("button", name="Copy the link").click()
    page.get_by_text("The link is selected").wait_for()
    assert page.evaluate("() => getSelection().toString()").endswith("scenario=toy&map.size=8")
    page.keyboard.press("Escape")
    assert not page.get_by_role("button", name="Copy the link").is_visible()
    assert page.evaluate("() => document.activeElement.textContent") == "Share"


def test_a_system_that_shares_gets_the_link_and_the_picture(page):
    open_view(page, "&scenario=toy")
    page.evaluate(SHARES)
    page.get_by_role("button", name="Share").click()
    page.wait_for_function("() => window.given")
    given = page.evaluate("() => window.given")
    assert given["url"].endswith("/?view=toy&scenario=toy")
    assert given["name"] == "latolato_toy.png"
    assert given["size"] > 1000
    refuse = "(name) => { navigator.share = async () => { throw new DOMException('', name); }; }"
    page.evaluate(refuse, "AbortError")
    page.get_by_role("button", name="Share").click()
    page.wait_for_timeout(300)
    assert not page.get_by_role("button", name="Copy the link").is_visible()
    page.evaluate(refuse, "NotAllowedError")
    page.get_by_role("button", name="Share").click()
    page.get_by_role("button", name="Copy the link").wait_for()


@pytest.mark.parametrize("size", [(1366, 768), (844, 390), (683, 384), (390, 844)])
def test_the_menu_opens_within_the_stage_and_moves_nothing(page, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    open_view(page, "&scenario=toy")
    button, stage = page.get_by_role("button", name="Share"), page.locator(".stage")
    places = [button.bounding_box(), stage.bounding_box()]
    button.click()
    menu = page.locator(".share-menu").bounding_box()
    assert [button.bounding_box(), stage.bounding_box()] == places
    for start, length in (("x", "width"), ("y", "height")):
        assert menu[start] >= places[1][start]
        assert menu[start] + menu[length] <= places[1][start] + places[1][length]
