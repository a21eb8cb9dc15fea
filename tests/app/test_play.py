"""Play in a real browser."""

from __future__ import annotations

import math

import pytest

# How long a page may take to show its first run [ms].
PATIENCE = 60_000


def open_play(page, query=""):
    page.goto(f"/?view=play{query}")
    page.wait_for_selector("[data-runs]", timeout=PATIENCE)


def test_a_scenario_is_drawn_and_its_fields_are_filled(page):
    open_play(page, "&scenario=fig02&duration=20%20s")
    assert page.get_by_label("pivot to ball centre l", exact=True).input_value() == "100"
    page.get_by_role("button", name="Play", exact=True).click()
    page.get_by_role("button", name="Pause").click()


def test_a_slider_changes_the_curve_and_the_address(page):
    open_play(page, "&scenario=fig04b_push&duration=10%20s")
    before = page.locator("[data-runs]").get_attribute("data-runs")
    slider = page.get_by_label("driving amplitude, slider")
    slider.focus()
    slider.press("ArrowRight")
    page.wait_for_function(
        "n => document.querySelector('[data-runs]').dataset.runs !== n", arg=before
    )
    page.wait_for_function("() => location.search.includes('drive_amplitude')")


def test_a_bad_value_is_told_beside_its_field(page, watch):
    open_play(page)
    field = page.get_by_label("radius of one ball", exact=False).first
    field.fill("2000")
    field.press("Enter")
    page.get_by_text("radius must lie in [0, length)").wait_for()
    assert field.get_attribute("aria-invalid") == "true"
    # The browser itself notes the refusal.
    watch.faults[:] = [f for f in watch.faults if "422" not in f]


@pytest.mark.parametrize("scenario", ["fig04a_push", "ballpair_asymmetric", "fig02"])
def test_balls_are_drawn_where_the_run_has_them(page, scenario):
    open_play(page, f"&scenario={scenario}&duration=6%20s")
    for share in (0.0, 0.31, 0.77):
        found = page.evaluate(
            """async share => {
              const player = window.latolato.views.play.player;
              player.clock.seek(share * player.clock.end);
              const { motion, scene } = player;
              const time = player.clock.time;
              const drawn = scene.drawn;
              const wanted = motion.balls.map(ball => ({
                angle: ball.sign * motion.at("angle", time, ball.row), length: ball.length }));
              const height = motion.at("pivot_height", time);
              return { drawn, wanted, height, scale: scene.scale() };
            }""",
            share,
        )
        scale = found["scale"]
        for drawn, ball in zip(found["drawn"], found["wanted"], strict=True):
            length, angle = ball["length"], ball["angle"]
            x = scale["x"] + scale["size"] * length * math.sin(angle)
            y = scale["y"] - scale["size"] * (found["height"] - length * math.cos(angle))
            assert math.hypot(drawn["x"] - x, drawn["y"] - y) < 2.0
