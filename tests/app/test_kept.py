"""Pages in a browser that keeps nothing: with blocked storage, and with a full one."""

from __future__ import annotations

import pytest

from app_pages import open_view

DENIED = """Object.defineProperty(window, "localStorage", { get() {
  throw new DOMException("The request was denied.", "SecurityError"); } });"""
FULL = """Storage.prototype.setItem = () => {
  throw new DOMException("The quota has been exceeded.", "QuotaExceededError"); };"""


@pytest.mark.parametrize("script", [DENIED, FULL], ids=["denied", "full"])
def test_a_page_works_where_the_browser_keeps_nothing(page, script):
    page.add_init_script(script)
    open_view(page)
    theme = page.locator("#theme")
    theme.click()
    assert theme.inner_text() == "Light"
    page.get_by_text("This browser keeps nothing for this page").wait_for()
    page.evaluate("() => { document.getElementById('status').textContent = ''; }")
    theme.click()
    assert page.locator("#status").text_content() == ""  # it is said once
    assert page.locator("html").get_attribute("data-theme") == "dark"

    page.locator("#language").select_option("id")
    page.wait_for_function("() => document.documentElement.lang === 'id'")
