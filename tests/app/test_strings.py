"""Balls on strings in a run and in a hand, in a real browser."""

from __future__ import annotations

import json
import re

import pytest

from app_pages import enter, open_view
from latolato.app.site import write_site

LOOP = (
    "&system=pendulum&length=0.5 m&mass=0.2 kg&initial_angle=20 deg"
    "&initial_angular_velocity=8 rad/s&duration=3 s"
)
# Where the ball is at all times, and what is written of it.
SEEN = """async () => {
  const { slackText } = await import("/js/player/hang.js");
  const { player } = window.latolato.views.toy;
  const seen = [];
  for (let time = 0; time < player.motion.end; time += 0.01) {
    const { across, height, balls: [{ x, y }] } = player.motion.pose(time);
    seen.push([Math.hypot(x - across, y - height), slackText(player.motion, time), across]);
  }
  return seen;
}"""


def opened(page, query, view="toy"):
    """Return the compiled modules that a view loads until it shows its first motion."""
    loaded = []
    page.on("request", lambda request: loaded.append(request.url.rpartition("/")[2]))
    page.emulate_media(reduced_motion="reduce")
    open_view(page, query, view)
    return {name for name in loaded if name.endswith(".wasm")}


@pytest.mark.parametrize("view", ["toy", "held"])
def test_only_strings_load_the_modules_of_the_plane(page, view):
    assert opened(page, "&scenario=toy", view) == {"one.wasm"}
    assert "plane_one.wasm" in opened(page, "&scenario=toy&suspension=string", view)


def test_a_ball_on_a_slack_string_leaves_its_circle_and_its_distance_is_written(page):
    opened(page, f"{LOOP}&suspension=string")
    seen = page.evaluate(SEEN)
    assert min(distance for distance, _, _ in seen) < 0.4
    for distance, text, _ in seen:
        assert distance <= 0.5 * (1 + 1e-9)
        assert (text == "") == (distance > 0.5 * (1 - 1e-6))
        assert not text or text.startswith(", slack at ")


# At how many places controls are while a run is played, and what is written of its times.
PLACES = """() => {
  const { player } = window.latolato.views.toy;
  const below = [...document.querySelectorAll(".transport button, .knobs input")];
  const [places, texts] = [new Set(), new Set()];
  for (let time = 0; time < player.motion.end; time += 0.02) {
    player.clock.seek(time);
    const boxes = below.map((each) => each.getBoundingClientRect());
    places.add(JSON.stringify(boxes.map(({ x, y }) => [x, y])));
    texts.add(player.timeText.textContent);
  }
  return { places: places.size, texts: [...texts] };
}"""


@pytest.mark.parametrize("query", [LOOP, "&scenario=toy"])
def test_nothing_moves_on_a_phone_when_a_string_is_slack(page, query):
    page.set_viewport_size({"width": 390, "height": 844})
    opened(page, f"{query}&suspension=string&lang=id")
    found = page.evaluate(PLACES)
    # The text of a slack string comes and goes.
    assert {"kendur" in text for text in found["texts"]} == {True, False}
    assert found["places"] == 1


def test_a_pivot_that_moves_sideways_is_drawn_there(page):
    drive = "&drive=planar_harmonic&vertical_amplitude=0 m&horizontal_amplitude=5 cm"
    opened(page, f"{LOOP}{drive}&drive_frequency=2 Hz")
    ways = [across for _, _, across in page.evaluate(SEEN)]
    assert (min(ways), max(ways)) == (pytest.approx(-0.05, 0.01), pytest.approx(0.05, 0.01))


def test_strings_and_rods_are_chosen_in_the_form_and_take_their_fields_along(page):
    opened(page, "&scenario=toy&string_restitution=0.5&suspension=string")
    page.get_by_text("More parameters", exact=True).click()
    bounce = page.get_by_label("coefficient of restitution of a string", exact=False)
    bounce.first.wait_for()
    page.get_by_label("suspension").select_option("rod")
    page.wait_for_function("() => location.search.includes('suspension=rod')")
    page.wait_for_function("() => !window.latolato.views.toy.player.motion.isString")
    assert not bounce.count()
    assert "string_restitution" not in page.url
    page.get_by_label("suspension").select_option("string")
    page.wait_for_function("() => window.latolato.views.toy.player.motion.isString")


def test_a_hand_hangs_its_toy_on_strings(page):
    opened(page, "&scenario=toy", "held")
    page.get_by_label("Hung on a").select_option("string")
    page.wait_for_function(
        "() => window.latolato.views.toy.hand.toy?.system.suspension === 'string'"
    )
    assert "suspension=string" in page.url


def test_a_toy_in_a_hand_says_how_far_slack_balls_are(page):
    page.goto("/?view=toy&toy.hand=1&scenario=toy_strings")
    page.get_by_text(re.compile(r"contacts, slack at [\d.]+ cm")).wait_for()


def test_a_map_of_strings_has_a_field_for_the_distance(page):
    shape = "&map.scenario=page&map.size=5&map.duration=1&map.observable=slack_fraction"
    page.goto(f"/?view=map&scenario=toy_strings{shape}")
    page.wait_for_selector("[data-done='1']")
    page.get_by_text("Parameters that do not vary").click()
    distance = page.get_by_label("distance from the pivot at the start", exact=False).first
    enter(distance, "12 cm")
    page.wait_for_selector("[data-done='2']")
    # Each ball falls for a while before its string is taut.
    assert page.evaluate("() => Math.min(...window.latolato.views.map.grid.values[0])") > 0.0


def test_cells_of_notebooks_leave_strings_to_python(ask_node, tmp_path):
    write_site(tmp_path / "site")
    path = tmp_path / "site" / "registry.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "upright": True}))
    requests = [
        {"scenario": "toy", "options": options}
        for options in ({"duration": "1 s"}, {"suspension": "string"}, {"drag_frame": "lab"})
    ]
    rod, *others = ask_node("latolato_in_node.mjs", requests, tmp_path / "site")
    assert rod["status"] == "complete"
    assert [(each["error"], each["parameter"]) for each in others] == [
        (
            f"players in notebooks leave out the code for {name} {value}, to stay small; "
            "compute the run in Python and show it with ll.play",
            name,
        )
        for name, value in (("suspension", "string"), ("drag_frame", "lab"))
    ]
