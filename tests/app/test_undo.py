"""What is changed is an entry of the browser's history: Back and Forward undo and redo it."""

from __future__ import annotations

import pytest

from app_pages import enter, open_view, wait_for_options


def open_play(page, query="&scenario=toy&duration=4%20s&map.size=20"):
    open_view(page, query)
    page.get_by_text("More parameters", exact=True).click()


def type_into(page, label, text):
    field = page.get_by_label(label, exact=False).first
    enter(field, text)
    return field


def wait_for_step(page, step):
    page.wait_for_function(f"() => history.state?.step === {step}")


def options(page):
    return page.evaluate("() => Object.fromEntries(new URLSearchParams(location.search))")


def wait_for_address(page, **wanted):
    page.wait_for_function(
        """(wanted) => Object.entries(wanted).every(([name, value]) =>
          new URLSearchParams(location.search).get(name) === value)""",
        arg=wanted,
    )


def test_steps_of_all_views_are_undone_and_redone_one_by_one(page):
    open_play(page)
    start = page.url
    type_into(page, "driving amplitude", "28")
    type_into(page, "coefficient of restitution", "0.8")
    page.get_by_role("link", name="Map").click()
    page.wait_for_selector("[data-done]")
    page.get_by_role("button", name="Zoom in on the cross").click()
    wait_for_step(page, 4)
    page.get_by_role("link", name="Toy").click()
    page.get_by_role("button", name="Hold it yourself").click()
    page.wait_for_selector("[data-ready]")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowUp")
    wait_for_step(page, 7)
    wait_for_address(page, drive_amplitude="29 mm")
    views = ["toy", "toy", "toy", "map", "map", "toy", "toy", "toy"]
    end = page.url
    for step in (6, 5, 4, 3, 2, 1, 0):
        page.go_back()
        wait_for_step(page, step)
        assert options(page)["view"] == views[step]
    assert page.url == start
    wait_for_options(page, "options.restitution !== 0.8")
    for step in (1, 2, 3, 4, 5, 6, 7):
        page.go_forward()
        wait_for_step(page, step)
        assert options(page)["view"] == views[step]
    assert page.url == end


def test_each_typed_value_is_a_step_and_its_field_shows_what_is_undone(page):
    open_play(page)
    for step, text in enumerate(("0.8", "0.7", "0.6"), 1):
        type_into(page, "coefficient of restitution", text)
        wait_for_step(page, step)
    page.go_back()
    wait_for_step(page, 2)
    wait_for_address(page, restitution="0.7")
    page.wait_for_function("() => document.activeElement.value === '0.7'")


def test_back_is_undo_also_right_after_a_change(page):
    open_play(page)
    type_into(page, "driving amplitude", "28")
    page.go_back()
    wait_for_step(page, 0)
    assert "drive_amplitude" not in options(page)
    page.go_forward()
    wait_for_address(page, drive_amplitude="28 mm")
    wait_for_options(page, "options.drive_amplitude === 0.028")


def test_a_drag_of_a_slider_is_one_step_however_slow(page):
    open_play(page)
    slider = page.get_by_label("driving amplitude, slider")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    x, y = box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(12):
        page.mouse.move(x + 5 * k, y)
    page.wait_for_timeout(1200)  # longer than the pauses within a gesture
    for k in range(12, 20):
        page.mouse.move(x + 5 * k, y)
    page.mouse.up()
    wait_for_step(page, 1)
    page.wait_for_function("() => location.search.includes('drive_amplitude')")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.up()
    wait_for_step(page, 2)
    for step in (1, 0):
        page.go_back()
        wait_for_step(page, step)
    assert "drive_amplitude" not in options(page)


def test_a_refused_run_offers_the_way_back(page):
    open_play(page)
    page.evaluate("() => window.latolato.views.toy.page.store.option('radius', '40 cm')")
    page.locator(".message").get_by_role("button", name="Undo").click()
    wait_for_step(page, 0)
    page.locator(".message").wait_for(state="detached")


def test_a_toy_in_a_hand_goes_on_where_a_control_is_undone(page):
    open_view(page, "&scenario=toy", view="held")
    page.evaluate("() => { window.first = window.latolato.views.toy.hand.toy; }")
    usual = page.evaluate("() => window.first.controls.restitution")
    type_into(page, "Bounciness", "0.5")
    wait_for_step(page, 1)
    page.go_back()
    page.wait_for_function(
        "(usual) => window.latolato.views.toy.hand.toy?.controls.restitution === usual", arg=usual
    )
    # The first number of a sample after its time and a mark is the angle of the right ball.
    begun = page.evaluate("() => window.latolato.views.toy.hand.toy.minute.samples[0][2]")
    assert begun == pytest.approx(page.evaluate("() => window.first.angles[0]"), abs=1e-6)
    knob = page.get_by_role("textbox", name="Bounciness")
    page.wait_for_function("(e) => e.value !== '0.5'", arg=knob.element_handle())


def test_many_quick_changes_stay_within_what_browsers_allow(page):
    open_play(page)
    calls, last = page.evaluate(
        """async () => {
          let calls = 0;
          for (const name of ["pushState", "replaceState"]) {
            const own = history[name].bind(history);
            history[name] = (...given) => { calls += 1; own(...given); };
          }
          const { store } = window.latolato.views.toy.page;
          for (let k = 0; k < 150; k += 1) {
            store.option("restitution", `${k / 1000}`);
            store.option("duration", `${k + 1} s`);
          }
          return [calls, store.state.options.duration];
        }"""
    )
    assert calls <= 100  # Safari allows 100 in 30 s
    assert last == "150 s"
