"""Where the balls of a run begin, chosen with a pointer or with keys in a real browser."""

from __future__ import annotations

import math
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest

from app_pages import next_run, open_view
from latolato.app.run_request import RunRequest

PLAYER = (
    "const { player } = window.latolato.views.toy; const { motion, scene, clock, start } = player;"
)


def of_player(page, expression, argument=None):
    """What an expression of the player's parts and of `argument` says."""
    return page.evaluate(f"(argument) => {{ {PLAYER} return {expression}; }}", argument)


PLACE = """(() => {
  const [k, degrees] = argument;
  const pose = scene.pose();
  const { length } = motion.balls[k];
  const angle = (degrees * Math.PI) / 180;
  return degrees === null ? [scene.drawn[k].x, scene.drawn[k].y]
    : scene.place(length * Math.sin(angle), pose.height - length * Math.cos(angle));
})()"""


def lead(page, ball, degrees):
    """Press on a ball and lead it through angles; the pointer stays down.

    The ball stands still, so that it is still where it was when the pointer gets there.
    """
    of_player(page, "clock.pause()")
    box = page.locator("canvas.scene").bounding_box()
    for k, angle in enumerate([None, *degrees, degrees[-1]]):
        # The picture makes room as a ball rises: the pointer goes to where the place is now.
        x, y = of_player(page, PLACE, [ball, angle])
        page.mouse.move(box["x"] + x, box["y"] + y)
        if k == 0:
            page.mouse.down()


def release(page):
    """Let the ball go, and wait for its run."""
    with next_run(page):
        page.mouse.up()


def options_of(page):
    """The options that the address holds."""
    query = {name: values[0] for name, values in parse_qs(urlsplit(page.url).query).items()}
    query.pop("view")
    return query.pop("scenario", None), query


def degrees_of(text):
    """The angles of an option."""
    return [float(part.removesuffix(" deg")) for part in text.split(", ")]


@pytest.mark.parametrize(
    "scenario, ball, through, wanted",
    [
        ("toy", 0, [30, 60, 100], [100]),
        ("toy", 1, [-30, -60], [60]),
        ("fig04a_push", 0, [40], [40]),  # this one begins with a velocity
        ("zeno", 0, [50], [50]),
        ("fig02", 0, [-30, -70], [-70]),
        ("kapitza", 0, [140, 170, 190], [-170]),
        ("ballpair_asymmetric", 0, [50, 80], [80, None]),
        ("ballpair_asymmetric", 1, [-40, -60], [None, -60]),
    ],
)
def test_a_dragged_ball_is_where_the_run_begins(page, scenario, ball, through, wanted):
    open_view(page, f"&scenario={scenario}")
    of_player(page, "clock.seek(0.05 * clock.end)")
    # Slowly, so that the pointer finds the ball.
    of_player(page, "clock.speed = 1e-3")
    of_player(page, "clock.play()")
    page.wait_for_timeout(50)
    lead(page, ball, through)
    assert of_player(page, "clock.playing") is False
    assert of_player(page, "clock.time") == 0
    shown = of_player(page, "scene.held.balls.map(({ angle }) => angle)")
    text = of_player(page, "scene.held.text")
    release(page)
    page.wait_for_function(f"() => {{ {PLAYER} return clock.playing && clock.time < 5; }}")
    page.wait_for_function("() => location.search.includes('initial_angle')")
    _, options = options_of(page)
    chosen = degrees_of(options["initial_angle"])
    for angle, each in zip(chosen, wanted, strict=True):
        if each is not None:
            assert angle == pytest.approx(each, abs=0.5)  # a pixel of this picture
            assert f"{angle:g}°" == text
        assert angle == pytest.approx(round(angle, 1), abs=1e-9)
    assert "initial_offset" not in options
    # It begins where the pointer left it, and at rest.
    begun = of_player(page, "motion.pose(0).balls.map(({ angle }) => angle)")
    turns = (np.array(begun) - shown) / (2 * np.pi)
    assert turns == pytest.approx(np.round(turns), abs=1e-6)
    rates = of_player(page, "motion.balls.map(({ row }) => motion.at('angular_velocity', 0, row))")
    assert rates == pytest.approx([0.0] * len(rates), abs=1e-6)
    # The address asks Python for the same run.
    scenario, options = options_of(page)
    resolved = RunRequest(scenario, options).to_scenario()
    run = resolved.simulate(times=[0.0, 0.1])
    assert np.atleast_1d(run["angle"].isel(time=0).values) == pytest.approx(
        np.radians(chosen), abs=1e-9
    )


def test_curve_and_legend_show_where_a_ball_is_led(page):
    open_view(page, "&scenario=ballpair_asymmetric")
    lead(page, 0, [30, 75])
    held = of_player(page, "scene.held.balls.map(({ angle }) => angle)")
    legend = page.locator(".timeline .legend output").all_inner_texts()
    assert [float(text) for text in legend] == pytest.approx(np.degrees(held), abs=0.05)
    # Dots stand on the curve's axis, at the beginning.
    over = page.locator(".timeline .u-over").bounding_box()
    dots = [dot.bounding_box() for dot in page.locator(".timeline .led:visible").all()]
    assert [dot["x"] + dot["width"] / 2 - over["x"] for dot in dots] == pytest.approx(
        [0, 0], abs=1.5
    )
    places = of_player(
        page,
        "argument.map((angle) => player.curves.charts[0].plot.valToPos(angle, 'y'))",
        list(np.degrees(held)),
    )
    assert [dot["y"] + dot["height"] / 2 - over["y"] for dot in dots] == pytest.approx(
        np.clip(places, 0, over["height"]), abs=1.5
    )
    release(page)
    page.wait_for_function("() => !document.querySelector('.timeline .led:not([hidden])')")


def test_mirrored_balls_move_together_and_never_through_each_other(page):
    open_view(page, "&scenario=toy")
    low, high = of_player(page, "[motion.low, motion.high]")
    lead(page, 0, [40, 20, -20, -60])
    right, left = of_player(page, "scene.held.balls.map(({ angle }) => angle)")
    assert right == -left
    assert low <= right < low + math.radians(0.1)
    lead_on = of_player(page, PLACE, [0, 190])
    box = page.locator("canvas.scene").bounding_box()
    page.mouse.move(box["x"] + of_player(page, PLACE, [0, 120])[0], box["y"])
    page.mouse.move(box["x"] + lead_on[0], box["y"] + lead_on[1])
    right, left = of_player(page, "scene.held.balls.map(({ angle }) => angle)")
    assert right == -left
    assert high - math.radians(0.1) < right <= high
    release(page)
    assert page.get_by_role("alert").count() == 0


def test_arrow_keys_change_the_start_and_say_so(page):
    open_view(page, "&scenario=toy&initial_angle=20 deg")
    stage = page.get_by_role("application")
    stage.focus()
    stage.press("ArrowRight")
    page.get_by_text("The balls start at 25 degrees.").wait_for()
    stage.press("Shift+ArrowRight")
    stage.press("Shift+ArrowRight")
    stage.press("ArrowLeft")
    page.get_by_text("The balls start at 22 degrees.").wait_for()
    page.wait_for_function(
        f"() => {{ {PLAYER} const [{{ angle }}] = motion.pose(0).balls;"
        " return Math.abs(angle - 22 * Math.PI / 180) < 1e-6; }"
    )
    assert of_player(page, "[clock.playing, clock.time]") == [False, 0]
    page.wait_for_function("() => location.search.includes('initial_angle=22+deg')")
    stage.press("Space")
    page.wait_for_function(f"() => {{ {PLAYER} return clock.time > 0; }}")


def test_keys_move_each_of_two_balls(page):
    open_view(page, "&scenario=ballpair_asymmetric&initial_angle=40 deg, -30 deg")
    stage = page.get_by_role("application")
    stage.focus()
    stage.press("ArrowRight")
    page.get_by_text("The balls start at 45, -30 degrees.").wait_for()
    stage.press("a")
    stage.press("a")
    stage.press("d")
    stage.press("Shift+D")
    page.get_by_text("The balls start at 45, -34 degrees.").wait_for()
    page.wait_for_function("() => location.search.includes('initial_angle=45+deg%2C+-34+deg')")
    stage.press("?")
    keys = page.get_by_role("dialog")
    assert "where the left ball starts" in keys.inner_text()
    keys.get_by_role("button", name="Close").click()


def test_keys_of_a_left_ball_move_its_twin_and_are_not_listed_for_one(page):
    open_view(page, "&scenario=toy&initial_angle=20 deg")
    page.get_by_role("application").press("a")
    page.get_by_text("The balls start at 25 degrees.").wait_for()
    open_view(page, "&scenario=fig02")
    stage = page.get_by_role("application")
    stage.press("a")
    stage.press("?")
    keys = page.get_by_role("dialog").inner_text()
    assert "where the ball starts" in keys
    assert "left ball" not in keys
    assert "initial_angle" not in page.url


def test_who_wants_little_motion_starts_a_run_without_playing_it(page):
    page.emulate_media(reduced_motion="reduce")
    open_view(page, "&scenario=toy")
    lead(page, 0, [40])
    release(page)
    assert of_player(page, "[clock.playing, clock.time]") == [False, 0]


def test_a_click_on_a_ball_changes_nothing(page):
    open_view(page, "&scenario=toy")
    box = page.locator("canvas.scene").bounding_box()
    x, y = of_player(page, PLACE, [0, None])
    page.mouse.click(box["x"] + x, box["y"] + y)
    assert of_player(page, "scene.held") is None
    assert "initial_angle" not in page.url


def test_a_finger_drags_a_ball_and_scrolls_the_page_elsewhere(page):
    page.set_viewport_size({"width": 390, "height": 600})
    open_view(page, "&scenario=toy")
    page.locator("canvas.scene").scroll_into_view_if_needed()
    session = page.context.new_cdp_session(page)
    session.send("Emulation.setTouchEmulationEnabled", {"enabled": True})

    def drag(x, y, dx, dy):
        for kind, share in (("touchStart", 0), *(("touchMove", k / 6) for k in range(1, 7))):
            point = {"x": x + share * dx, "y": y + share * dy}
            session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
            page.wait_for_timeout(20)
        session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        page.wait_for_timeout(100)

    of_player(page, "clock.pause()")
    box = page.locator("canvas.scene").bounding_box()
    x, y = of_player(page, PLACE, [0, None])
    before = page.evaluate("scrollY")
    drag(box["x"] + x, box["y"] + y, 60, -60)
    page.wait_for_function("() => location.search.includes('initial_angle')")
    assert page.evaluate("scrollY") == before
    of_player(page, "clock.pause()")
    drag(box["x"] + 20, box["y"] + 0.6 * box["height"], 0, -120)
    page.wait_for_function("before => scrollY > before + 50", arg=before)
    session.detach()
