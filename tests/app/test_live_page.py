"""Live in a real browser."""

from __future__ import annotations

import math

import pytest

from app_server import start_server, stop_server
from browser_checks import serious_faults

# How long a page may take to show its toy [ms].
PATIENCE = 240_000


def open_live(page, query=""):
    page.goto(f"/?view=live{query}")
    page.wait_for_selector("[data-ready]", timeout=PATIENCE)
    page.wait_for_function("() => window.latolato.views.live.motion.frame.number > 3")


def frame(page):
    return page.evaluate("() => ({ ...window.latolato.views.live.motion.frame })")


def test_a_key_changes_the_motion_and_the_field(page):
    open_live(page)
    before = frame(page)["drive_amplitude"]
    page.keyboard.press("ArrowUp")
    seq = page.evaluate("() => window.latolato.views.live.link.seq")
    page.wait_for_function(
        """([seq, before]) => {
          const { frame } = window.latolato.views.live.motion;
          return frame.seq >= seq && frame.drive_amplitude > before;
        }""",
        arg=[seq, before],
    )
    shown = float(page.get_by_label("driving amplitude", exact=False).first.input_value())
    page.wait_for_function(
        """mm => {
          const { frame } = window.latolato.views.live.motion;
          return Math.abs(frame.drive_amplitude - mm / 1000) < 1e-9;
        }""",
        arg=shown,
    )
    page.wait_for_function("() => location.search.includes('drive_amplitude')")


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
    open_live(page, f"{query}&drive=harmonic&drive_amplitude=0%20m&drive_frequency=6%20rad/s")
    canvas = page.get_by_role("application")
    box = canvas.bounding_box()
    place = """([k, angle]) => {
      const { scene, motion } = window.latolato.views.live;
      const ratio = window.devicePixelRatio;
      const length = motion.balls[k].length;
      const to = angle === null ? [scene.drawn[k].x, scene.drawn[k].y]
        : scene.place(length * Math.sin(angle), -length * Math.cos(angle));
      return to.map(v => v / ratio);
    }"""
    x, y = page.evaluate(place, [ball, None])
    page.mouse.move(box["x"] + x, box["y"] + y)
    page.mouse.down()
    wanted = math.radians(degrees)
    for step in range(1, 9):
        x, y = page.evaluate(place, [ball, wanted * step / 8])
        page.mouse.move(box["x"] + x, box["y"] + y)
        page.wait_for_timeout(30)
    # The picture makes room as a ball rises: go on to where the place is now.
    for _ in range(3):
        page.wait_for_timeout(200)
        x, y = page.evaluate(place, [ball, wanted])
        page.mouse.move(box["x"] + x, box["y"] + y)
    page.wait_for_function(
        """([k, angle]) => {
          const { motion } = window.latolato.views.live;
          return Math.abs(motion.angle(motion.balls[k]) - angle) < 0.03;
        }""",
        arg=[ball, wanted],
        timeout=10_000,
    )
    page.wait_for_timeout(300)
    x, y = page.evaluate(place, [ball, wanted])
    pixel, colour = page.evaluate(
        """([k, x, y]) => {
          const { scene, motion } = window.latolato.views.live;
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
    assert int(frame(page)["flags"]) & 2
    page.mouse.up()
    page.wait_for_function("() => !(window.latolato.views.live.motion.frame.flags & 2)")


def test_the_trick_of_fig12_can_be_done_by_hand(page):
    open_live(page)
    page.get_by_role("button", name="High", exact=False).click()
    page.wait_for_function(
        "() => window.latolato.views.live.watch.history.range(['right'])[1] > 15", timeout=30_000
    )
    assert page.get_by_role("button", name="High").get_attribute("aria-pressed") == "true"
    page.keyboard.press("2")
    page.wait_for_function(
        "() => window.latolato.views.live.watch.history.range(['right'])[1] > 35", timeout=30_000
    )


def test_a_recording_opens_in_play_as_a_run(page):
    open_live(page)
    page.get_by_role("button", name="Record").click()
    page.wait_for_function("() => window.latolato.views.live.motion.frame.recorded > 0.3")
    page.keyboard.press("2")
    page.wait_for_function("() => window.latolato.views.live.motion.frame.recorded > 0.8")
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("make the same motion again").wait_for()
    with page.expect_download() as caught:
        page.get_by_role("link", name="NetCDF").click()
    assert caught.value.suggested_filename == "live.nc"
    page.get_by_role("button", name="Open in Play").click()
    page.wait_for_selector("[data-runs]", timeout=PATIENCE)
    assert "drive=staged_harmonic" in page.url
    end = page.evaluate("() => window.latolato.views.play.player.clock.end")
    assert 0.8 <= end < 30.0


def test_a_recording_with_a_push_opens_as_it_was_kept(page):
    open_live(page)
    page.get_by_role("button", name="Record").click()
    page.wait_for_function("() => window.latolato.views.live.motion.frame.recorded > 0.2")
    page.keyboard.press("p")
    page.wait_for_function("() => window.latolato.views.live.motion.frame.recorded > 0.7")
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("A hand took part").wait_for()
    page.get_by_role("button", name="Open in Play").click()
    page.wait_for_selector("[data-runs]", timeout=PATIENCE)
    page.get_by_text("the hand", exact=True).wait_for()
    assert page.evaluate("() => window.latolato.views.play.player.motion.about.by_hand")
    slider = page.get_by_label("driving amplitude, slider")
    if slider.count():  # whoever changes a parameter gets a run of these parameters
        runs = page.locator("[data-runs]").get_attribute("data-runs")
        slider.focus()
        slider.press("ArrowRight")
        page.wait_for_function(
            "n => document.querySelector('[data-runs]').dataset.runs !== n", arg=runs
        )
        assert not page.evaluate("() => window.latolato.views.play.player.motion.about.by_hand")


def test_a_toy_that_is_not_seen_stands_still(page):
    open_live(page)
    page.get_by_role("link", name="Play").click()
    page.wait_for_function("() => window.latolato.views.live.motion.frame.flags & 1")
    time = frame(page)["time"]
    page.wait_for_timeout(200)
    assert frame(page)["time"] == time
    page.get_by_role("link", name="Live").click()
    page.wait_for_function("t => window.latolato.views.live.motion.frame.time > t", arg=time)


def test_a_toy_that_does_not_come_at_once_says_why(page):
    page.route_web_socket("**/ws/live", lambda socket: None)  # accepted, and nothing more
    page.route("**/api/compiling", lambda route: route.fulfill(json={"compiling": True}))
    page.goto("/?view=live")
    page.get_by_text("Preparing").wait_for()
    page.unroute_all()
    page.get_by_text("Computing").wait_for()


def test_a_value_out_of_range_is_told_beside_its_field(page):
    open_live(page)
    field = page.get_by_label("angular driving frequency", exact=False).first
    field.fill("1e8")
    field.press("Enter")
    page.get_by_text("It must lie between 0 and").wait_for()
    assert field.get_attribute("aria-invalid") == "true"
    assert frame(page)["drive_frequency"] < 100.0


def test_the_page_goes_on_when_its_server_was_killed_and_started_again(browser):
    server = start_server()
    port = str(server.port)
    context = browser.new_context(base_url=server.address)
    page = context.new_page()
    try:
        open_live(page)
        page.keyboard.press("ArrowUp")
        page.wait_for_function("() => window.latolato.views.live.motion.frame.time > 1")
        server.process.kill()
        page.get_by_text("The server does not answer").first.wait_for()
        before = frame(page)
        amplitude = page.evaluate("() => window.latolato.views.live.controls.drive_amplitude")
        assert amplitude > 0.034
        stop_server(server)
        server = start_server("--port", port)
        page.wait_for_function(
            "t => window.latolato.views.live.motion.frame.time > t + 0.1",
            arg=before["time"],
            timeout=PATIENCE,
        )
        after = frame(page)
        assert after["time"] < before["time"] + 60.0
        assert after["contacts"] <= before["contacts"] + 200
        assert abs(after["drive_amplitude"] - amplitude) < 1e-3
    finally:
        context.close()
        stop_server(server)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280])
def test_live_is_accessible_and_fits_the_screen(page, scheme, width):
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": 900})
    open_live(page)
    assert serious_faults(page) == []
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width


def test_who_wants_little_motion_finds_the_toy_at_rest(page):
    page.emulate_media(reduced_motion="reduce")
    open_live(page)
    page.wait_for_function("() => window.latolato.views.live.motion.frame.flags & 1")
    page.get_by_role("button", name="Play", exact=True).click()
    page.wait_for_function("() => !(window.latolato.views.live.motion.frame.flags & 1)")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_pressed_button_is_readable(page, scheme):
    page.emulate_media(color_scheme=scheme)
    open_live(page)
    pressed = page.locator(".trick button[aria-pressed=true]").first
    ground, ink = pressed.evaluate(
        "e => [getComputedStyle(e).backgroundColor, getComputedStyle(e).color]"
        ".map(c => c.match(/\\d+/g).slice(0, 3).reduce((a, b) => a + Number(b), 0))"
    )
    assert abs(ground - ink) > 250
