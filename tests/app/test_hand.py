"""The toy in a hand, in a real browser."""

from __future__ import annotations

import math

import pytest

from app_pages import READY, enter, open_view, wait_for_options
from held_pages import of_toy, open_held, wait_for_toy

# Whether a ball has swung so far, in degrees.
SWINGS = """(degrees) => window.latolato.views.toy.hand.motion.values("angle")
  .some((angle) => angle > degrees * Math.PI / 180)"""


def test_a_toy_that_fails_starts_again_with_its_controls_and_says_so(page):
    open_held(page)
    page.get_by_role("application").press("ArrowUp")
    before = of_toy(page, "controls.drive_amplitude")
    page.evaluate(
        """() => {
          const { toy } = window.latolato.views.toy.hand;
          window.failed = toy;
          toy.advance = () => { throw new WebAssembly.RuntimeError("unreachable"); };
        }"""
    )
    page.get_by_text("The toy restarts: unreachable.").wait_for()
    wait_for_toy(page, "toy.kernels !== window.failed.kernels && toy.time > 0.05")
    assert of_toy(page, "controls.drive_amplitude") == pytest.approx(before, rel=1e-7)


def test_a_key_changes_the_motion_with_the_next_picture(page):
    open_held(page)
    before = of_toy(page, "controls.drive_amplitude")
    changed = page.evaluate(
        """async () => {
          const { toy, player } = window.latolato.views.toy.hand;
          await new Promise(requestAnimationFrame);
          player.scene.canvas.dispatchEvent(new KeyboardEvent("keydown",
            { key: "ArrowUp", bubbles: true, cancelable: true }));
          const { time } = toy;
          await new Promise(requestAnimationFrame);
          const change = toy.minute.changes.at(-1);
          return { delay: change.time - time, moved: toy.time - change.time };
        }"""
    )
    assert changed["delay"] == 0.0
    assert changed["moved"] > 0.0
    output = float(page.get_by_label("How far the hand moves A0").input_value())
    assert output / 1000 > before
    # The pivot soon reaches so high.
    wait_for_toy(page, f"toy.drive.isSteady && toy.pivot.height > 0.999 * {output / 1000}")
    page.wait_for_function("() => location.search.includes('drive_amplitude')")


def test_a_reload_keeps_what_was_set(page):
    open_held(page)
    page.keyboard.press("ArrowUp")
    page.keyboard.press("2")
    page.keyboard.press("e")
    page.wait_for_function("() => location.search.includes('restitution=0.91')")
    before = of_toy(page, "controls")
    page.reload()
    page.wait_for_selector("[data-ready]")
    assert of_toy(page, "controls") == pytest.approx(before)


@pytest.mark.parametrize(
    "query,ball,degrees",
    [
        ("&scenario=fig12", 0, 70),
        ("&scenario=fig12", 1, -70),
        ("&scenario=ballpair_asymmetric", 1, -60),
        ("&scenario=fig02", 0, 130),
    ],
)
def test_a_ball_follows_the_mouse_and_is_drawn_there(page, query, ball, degrees):
    # Without drive, so that nothing but the hand moves it.
    open_held(page, f"{query}&drive=harmonic&drive_amplitude=0%20m&drive_frequency=6%20rad/s")
    canvas = page.get_by_role("application")
    box = canvas.bounding_box()
    place = """([k, angle]) => {
      const { player: { scene }, motion } = window.latolato.views.toy.hand;
      const ratio = window.devicePixelRatio;
      const length = motion.balls[k].length;
      const to = angle === null ? [scene.drawn[k].x, scene.drawn[k].y]
        : scene.place(length * Math.sin(angle), -length * Math.cos(angle));
      return to.map(v => v / ratio);
    }"""
    x, y = page.evaluate(place, [ball, None])
    page.mouse.move(box["x"] + x, box["y"] + y)
    page.mouse.down()
    expected = math.radians(degrees)
    for step in range(1, 9):
        x, y = page.evaluate(place, [ball, expected * step / 8])
        page.mouse.move(box["x"] + x, box["y"] + y)
        page.wait_for_timeout(30)
    # The picture makes room as a ball rises: go on to where the place is now.
    for _ in range(3):
        page.wait_for_timeout(200)
        x, y = page.evaluate(place, [ball, expected])
        page.mouse.move(box["x"] + x, box["y"] + y)
    page.wait_for_function(
        """([k, angle]) => {
          const { motion } = window.latolato.views.toy.hand;
          return Math.abs(motion.angle(motion.balls[k]) - angle) < 0.03;
        }""",
        arg=[ball, expected],
        timeout=10_000,
    )
    page.wait_for_timeout(300)
    x, y = page.evaluate(place, [ball, expected])
    pixel, colour = page.evaluate(
        """([k, x, y]) => {
          const { player: { scene }, motion } = window.latolato.views.toy.hand;
          const ratio = window.devicePixelRatio;
          const context = scene.canvas.getContext("2d");
          const dot = document.createElement("canvas").getContext("2d");
          dot.fillStyle = scene.colours[motion.balls[k].name === "left" ? "left" : "right"];
          dot.fillRect(0, 0, 1, 1);
          return [[...context.getImageData(x * ratio, y * ratio, 1, 1).data],
            [...dot.getImageData(0, 0, 1, 1).data]];
        }""",
        [ball, x, y],
    )
    assert pixel == colour
    assert of_toy(page, "held") is not None
    page.mouse.up()
    assert of_toy(page, "held") is None


def test_the_trick_of_fig12_can_be_done_by_hand(page):
    open_held(page)
    page.get_by_role("button", name="High", exact=False).click()
    page.wait_for_function(SWINGS, arg=15, timeout=30_000)
    assert page.get_by_role("button", name="High").get_attribute("aria-pressed") == "true"
    page.keyboard.press("2")
    page.wait_for_function(SWINGS, arg=35, timeout=30_000)


def test_a_toy_that_is_not_seen_stands_still(page):
    open_held(page)
    page.get_by_role("link", name="Report").click()
    time = of_toy(page, "time")
    page.wait_for_timeout(200)
    assert of_toy(page, "time") == time
    page.get_by_role("link", name="Toy").click()
    page.wait_for_function("t => window.latolato.views.toy.hand.toy.time > t", arg=time)
    assert of_toy(page, "time") < time + 5


def test_a_tab_in_the_background_pauses_the_toy_and_says_so(page):
    open_held(page)
    show = """is => {
      Object.defineProperty(document, "hidden", { configurable: true, get: () => !is });
      document.dispatchEvent(new Event("visibilitychange"));
    }"""
    page.evaluate(show, False)
    page.evaluate(show, True)
    page.get_by_text("was paused while its tab was in the background").wait_for()


def test_a_toy_that_does_not_come_says_why(page, watch):
    page.route("**/one.wasm", lambda route: route.fulfill(status=404, body="gone"))
    page.goto("/?view=toy&toy.hand=1")
    page.locator(".message").get_by_text("one.wasm cannot be loaded").wait_for()
    page.unroute_all()
    page.get_by_role("link", name="Map").click()
    page.get_by_role("link", name="Toy").click()
    page.wait_for_selector("[data-ready]")
    watch.faults[:] = [fault for fault in watch.faults if "404" not in fault]


@pytest.mark.parametrize(
    "query,fault",
    [
        ("&scenario=fig12&drive=harmonic&drive_amplitude=1 m&drive_frequency=2 Hz", "amplitude"),
        ("&scenario=fig12&initial_angle=0 rad", "overlap"),
        ("&drive_amplitude=5 m", "“driving amplitude” must be at most 100 mm, got 5000 mm."),
    ],
)
def test_an_address_that_makes_no_toy_says_why(page, query, fault):
    page.goto(f"/?view=toy&toy.hand=1{query}")
    page.locator(".message").get_by_text(fault).wait_for()


def test_a_refused_control_is_mended_in_its_field(page):
    open_held(page)
    page.evaluate("() => window.latolato.views.toy.page.store.option('restitution', '2')")
    page.locator(".message").get_by_text("must be between 0 and 1").wait_for()
    knob = page.locator(".toy").get_by_label("Bounciness e")
    enter(knob, "0.5")
    wait_for_toy(page, "toy?.controls.restitution === 0.5")


def test_curves_of_a_toy_that_moves_are_described_as_it_goes_on(page):
    open_held(page, "&scenario=toy&initial_angle=1 rad&damping=0.1 kg*m/s")
    page.wait_for_function("() => document.querySelector('.chart[aria-label*=between]')")
    before = page.locator(".chart").first.get_attribute("aria-label")
    page.wait_for_function(
        "before => document.querySelector('.chart').getAttribute('aria-label') !== before",
        arg=before,
    )


# Ends when the worker that computes runs has asked for all that it loads: the list is the last.
LOADED = """async () => {
  const isAsked = () =>
    performance.getEntriesByType("resource").some((each) => each.name.endsWith("registry.json"));
  while (!isAsked()) await new Promise((resolve) => setTimeout(resolve, 20));
}"""


def test_a_toy_needs_no_server_once_it_is_there(page):
    open_held(page)
    for worker in page.workers:
        worker.evaluate(LOADED)
    requests = []
    page.on("request", lambda request: requests.append(request.url))
    page.keyboard.press("ArrowUp")
    page.keyboard.press("r")
    wait_for_toy(page, "toy.time > 0.5")
    page.get_by_role("button", name="Keep the last minute").click()
    page.get_by_text("Its parameters and its link reproduce it").wait_for()
    # Browsers ask for the icon again when the address changes.
    assert [url for url in requests if not url.endswith("icon.svg")] == []


# Whether the readout lies over the tools, and whether the tools are within the stage.
STAGE = """() => {
  const [readout, tools, stage] = [".readout", ".stage-tools", ".stage"]
    .map((each) => document.querySelector(`.toy ${each}`).getBoundingClientRect());
  return [readout.left < tools.right && tools.left < readout.right
      && readout.top < tools.bottom && tools.top < readout.bottom,
    [...document.querySelectorAll(".toy .stage-tools > *")].every((each) =>
      each.getBoundingClientRect().right <= stage.right)];
}"""


@pytest.mark.parametrize("language", ["en", "id"])
def test_nothing_on_the_stage_lies_over_something_else(page, language):
    open_held(page, f"&lang={language}")
    page.wait_for_function("() => document.querySelector('.readout').textContent")
    for width in (1366, 910, 600, 390):
        page.set_viewport_size({"width": width, "height": 844})
        page.wait_for_timeout(100)  # the stage is laid out again
        over, within = page.evaluate(STAGE)
        assert not over, width
        assert within, width


def test_who_wants_little_motion_finds_the_toy_at_rest(page):
    page.emulate_media(reduced_motion="reduce")
    open_view(page, view="held")
    page.wait_for_timeout(100)
    assert of_toy(page, "time") == 0.0
    page.get_by_role("button", name="Play", exact=True).click()
    wait_for_toy(page, "toy.time > 0.1")


def test_the_legends_say_what_the_toy_does(page):
    open_held(page)
    page.get_by_role("button", name="Push").click()
    wait_for_toy(page, "toy.time > 1")
    page.get_by_text("Energy and more curves", exact=True).click()
    page.get_by_role("button", name="Pause").click()
    page.wait_for_timeout(300)
    for figure, values in (
        (0, "motion.balls.map((ball) => motion.angle(ball) * 180 / Math.PI)"),
        (
            1,
            """["kinetic_energy", "potential_energy"].map((name) =>
            motion.balls.reduce((sum, ball) => sum + motion.at(name, 0, ball.row), 0))""",
        ),
    ):
        wanted = page.evaluate(
            f"() => {{ const {{ motion }} = window.latolato.views.toy.hand; return {values}; }}"
        )
        shown = page.locator("figure.panel").nth(figure).locator("output").all_inner_texts()[:2]
        assert [float(text) for text in shown] == pytest.approx(wanted, rel=1e-3, abs=1e-6)
    # On the move they would be behind the picture.
    page.get_by_role("button", name="Play", exact=True).click()
    page.wait_for_function(
        "() => document.querySelector('figure.panel .legend output').textContent === ''"
    )


def test_charts_in_a_closed_panel_are_not_drawn(page):
    open_held(page)
    summary = page.get_by_text("Energy and more curves", exact=True)
    summary.click()
    page.wait_for_function("() => window.latolato.views.toy.player.more")
    page.evaluate(
        """() => {
          window.draws = { open: 0, closed: 0 };
          const { curves, more } = window.latolato.views.toy.player;
          const count = (charts, name) => charts.forEach(({ plot }) =>
            (plot.hooks.draw ??= []).push(() => { window.draws[name] += 1; }));
          count(curves.charts, "open");
          count(more.curves.charts, "closed");
        }"""
    )
    page.wait_for_function("() => draws.closed > 2")
    summary.click()
    page.wait_for_timeout(100)  # what was under way
    page.evaluate("() => { draws.closed = draws.open = 0; }")
    page.wait_for_function("() => draws.open > 5")
    assert page.evaluate("() => draws.closed") == 0
    summary.click()
    page.wait_for_function("() => draws.closed > 2")


def test_the_curve_goes_along_with_the_toy(page):
    open_held(page)
    page.locator(".transport").get_by_label("Speed").select_option("10")
    wait_for_toy(page, "toy.time > 20", timeout=30_000)
    seen = page.evaluate(
        """() => {
          const { player: { curves }, toy } = window.latolato.views.toy;
          const { data, scales: { x } } = curves.charts[0].plot;
          return { count: data[0].length, last: data[0].at(-1), min: x.min, max: x.max };
        }"""
    )
    assert 850 < seen["count"] < 950
    assert seen["max"] - seen["min"] == pytest.approx(15, abs=1e-6)
    assert seen["max"] - seen["last"] < 0.1


def test_a_hand_takes_the_toy_where_the_run_has_it(page):
    open_view(page, "&scenario=toy")
    page.wait_for_function("() => window.latolato.views.toy.player.clock.time > 2")
    page.get_by_role("button", name="Pause").click()
    run = """() => {
      const { motion, clock: { time } } = window.latolato.views.toy.player;
      return [motion.angle(motion.balls[0], time), motion.at("pivot_height", time)];
    }"""
    before = page.evaluate(run)
    page.evaluate("() => { window.latolato.views.toy.player.clock.play = () => {}; }")
    page.get_by_role("button", name="Hold it yourself").click()
    page.wait_for_selector("[data-ready]")
    # At most a sample earlier.
    assert of_toy(page, "angles[0]") == pytest.approx(before[0], abs=0.25)
    assert of_toy(page, "pivot.height") == pytest.approx(before[1], abs=0.015)
    assert of_toy(page, "time") == 0.0


def test_a_toy_that_is_let_go_is_the_run_of_the_address_again(page):
    open_view(page, "&scenario=toy")
    page.get_by_role("button", name="Hold it yourself").click()
    page.wait_for_selector("[data-ready]")
    assert not page.get_by_role("checkbox", name="Loop").is_visible()
    page.get_by_role("application").press("e")
    page.wait_for_function("() => location.search.includes('restitution=0.91')")
    page.get_by_role("button", name="Hold it yourself").click()
    wait_for_options(page, "options.restitution === 0.91")
    assert page.get_by_role("checkbox", name="Loop").is_visible()
    assert not page.get_by_role("button", name="Push").is_visible()
    assert "toy.hand" not in page.url
    page.go_back()
    page.wait_for_selector(".held")


@pytest.mark.parametrize("view", ["live", "play"])
def test_addresses_of_older_versions_open_the_toy(page, view):
    page.goto(f"/?view={view}&scenario=fig12")
    page.wait_for_selector(READY[{"live": "held", "play": "toy"}[view]])
    assert page.get_by_role("link", name="Toy").get_attribute("aria-current") == "page"
    assert page.locator(".message").count() == 0


def test_the_stage_has_a_frame_only_for_who_uses_keys(page):
    open_held(page)
    stage = page.get_by_role("application")
    outline = "(element) => [element.matches(':focus'), getComputedStyle(element).outlineStyle]"
    assert stage.evaluate(outline) == [True, "none"]
    page.keyboard.press("ArrowUp")
    assert stage.evaluate(outline) == [True, "solid"]
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+Tab")
    assert stage.evaluate(outline) == [True, "solid"]
