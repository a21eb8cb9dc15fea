"""The composition of Toy: a large stage, few knobs, the rest when asked for."""

from __future__ import annotations

import numpy as np
import pytest

import latolato as ll
from app_pages import OPTIONS, PLAYER, enter, new_context, open_view, wait_for_options
from latolato.core.quantities import QUANTITIES
from latolato.io.shown_units import SIZES

LAPTOP = {"width": 1366, "height": 768}
PHONE = {"width": 390, "height": 844}


def open_at(page, query="", view="toy", size=LAPTOP, motion="reduce"):
    page.emulate_media(reduced_motion=motion)
    page.set_viewport_size(size)
    open_view(page, query, view)


def test_the_first_run_moves_where_that_is_welcome(page):
    open_at(page, motion="no-preference")
    page.wait_for_function(f"() => {PLAYER}.clock.time > 0.1")
    page.get_by_role("button", name="Pause").wait_for()


def test_what_was_paused_stays_so_when_the_address_comes_back(page):
    open_at(page, "&scenario=fig12", motion="no-preference")
    page.get_by_role("button", name="Pause").click()
    for scenario in ("zeno", "fig02"):
        page.get_by_label("Begin with").select_option(scenario)
    wait_for_options(page, "options.system === 'pendulum'")
    page.go_back()
    wait_for_options(page, "options.restitution === 0.6")
    assert not page.evaluate(f"() => {PLAYER}.clock.playing")


def test_a_run_that_played_goes_on_when_its_view_comes_back(page):
    open_at(page, motion="no-preference")
    page.get_by_role("link", name="Map", exact=True).click()
    assert not page.evaluate(f"() => {PLAYER}.clock.playing")
    page.get_by_role("link", name="Toy", exact=True).click()
    page.get_by_role("button", name="Pause").wait_for()


def test_the_headline_asks_what_the_preset_asks(page):
    open_at(page)
    headline = page.get_by_role("heading", level=2).first
    assert headline.inner_text() == ll.load_scenario("toy").question
    page.get_by_label("Begin with").select_option("kapitza")
    page.get_by_role("heading", name=ll.load_scenario("kapitza").question).wait_for()


@pytest.mark.parametrize("language", ["en", "id"])
@pytest.mark.parametrize("view", ["toy", "held"])
def test_the_stage_is_large_and_all_that_matters_is_seen_at_once(page, view, language):
    open_at(page, f"&lang={language}", view)
    seen = [".headline", ".stage", ".bench .panel", ".transport", ".side select", ".chart"]
    seen += {"toy": [".scrub", ".drawers", ".more-curves"], "held": [".trick"]}[view]
    knobs = page.locator(".knobs .knob")
    assert knobs.count() >= 3
    parts = [*(page.locator(each).first for each in seen), *(knobs.nth(k) for k in range(3))]
    for size in (LAPTOP, {"width": 1920, "height": 1080}):
        page.set_viewport_size(size)
        page.wait_for_timeout(200)
        stage = page.locator(".stage").bounding_box()
        assert 0.57 < stage["width"] / size["width"] < 0.63
        assert page.locator("canvas.scene").bounding_box()["height"] > 0.45 * size["height"]
        for part in parts:
            box = part.bounding_box()
            assert box["y"] >= 0, (size, part)
            assert box["y"] + box["height"] <= size["height"], (size, part)


# The knobs of presets, and of those whose pivot is fixed.
KNOBS = {
    ("toy", ""): ["drive_amplitude", "drive_frequency", "restitution"],
    ("fig12", ""): ["drive_amplitude", "restitution", "initial_offset"],
    ("zeno", ""): ["restitution", "initial_angle", "damping"],
    ("ballpair_asymmetric", ""): ["drive_amplitude", "drive_frequency", "restitution"],
    ("ballpair_asymmetric", "fixed_pivot"): ["restitution", "right_length", "left_length"],
    ("fig02", ""): ["drive_amplitude", "drive_frequency", "damping"],
    ("fig02", "fixed_pivot"): ["initial_angle", "damping", "length"],
}


def test_every_toy_has_three_telling_knobs(page):
    open_at(page)
    for (scenario, drive), knobs in KNOBS.items():
        page.evaluate(
            """([scenario, drive]) => window.latolato.views.toy.page.store.set(
              { scenario, options: { duration: "3 s", ...(drive && { drive }) } })""",
            [scenario, drive],
        )
        shown = "Object.keys(window.latolato.views.toy.knobs.all)"
        page.wait_for_function(
            f"(knobs) => {shown}.filter((name) => name !== 'frequency_ratio').join() === knobs",
            arg=",".join(knobs),
        )
        assert page.locator(".knobs .knob").count() == 3


def test_shakes_per_second_and_the_frequency_ratio_follow_each_other(page):
    open_at(page, "&scenario=toy&duration=3 s")
    often = page.get_by_role("textbox", name="How often")
    ratio = page.locator(".knobs").get_by_role("textbox", name="driving over natural frequency")
    natural = 7.0
    assert float(ratio.input_value()) == pytest.approx(6 * np.pi / natural, rel=1e-3)
    enter(ratio, "2")
    wait_for_options(page, f"Math.abs(options.drive_frequency - {2 * natural}) < 1e-9")
    assert float(often.input_value()) == pytest.approx(natural / np.pi, rel=1e-3)
    page.wait_for_function("() => location.search.includes('frequency_ratio=2')")
    enter(often, "2.5")
    wait_for_options(page, f"Math.abs(options.drive_frequency - {5 * np.pi}) < 1e-9")
    assert float(ratio.input_value()) == pytest.approx(5 * np.pi / natural, rel=1e-3)
    page.wait_for_function("() => !location.search.includes('frequency_ratio')")
    slider = page.get_by_role("slider", name="How often, slider")
    slider.focus()
    slider.press("ArrowRight")
    wait_for_options(page, f"options.drive_frequency > {5 * np.pi}")
    now = page.evaluate(f"() => {OPTIONS}.drive_frequency")
    assert float(often.input_value()) == pytest.approx(now / (2 * np.pi), rel=1e-3)
    assert float(ratio.input_value()) == pytest.approx(now / natural, rel=1e-3)


def test_the_form_takes_the_frequency_ratio_too(page):
    open_at(page, "&scenario=fig02&duration=3 s&drive_frequency=5 rad/s")
    page.get_by_text("More parameters", exact=True).click()
    form = page.locator(".drawers .form")
    slider = form.get_by_label("driving over natural frequency, slider")
    slider.focus()
    slider.press("ArrowRight")
    page.wait_for_function("() => location.search.includes('frequency_ratio')")
    assert "drive_frequency" not in page.url
    ratio = float(form.get_by_role("textbox", name="driving over natural").input_value())
    wait_for_options(
        page, f"Math.abs(options.drive_frequency - {ratio} * Math.sqrt(9.8)) < 1e-4 * {ratio}"
    )


def test_energies_are_computed_when_they_are_asked_for(page):
    open_at(page, "&scenario=fig04a_push&duration=10 s")
    page.wait_for_timeout(300)
    assert page.evaluate(f"() => {PLAYER}.more") is None
    assert page.locator(".more-curves canvas").count() == 0
    page.get_by_text("Energy and more curves", exact=True).click()
    page.locator(".more-curves .ledger-row").first.wait_for()
    assert page.evaluate(f"() => {PLAYER}.more.curves.charts.length") == 2


@pytest.mark.parametrize(
    "scenario,whose", [("toy", "both balls"), ("ballpair_asymmetric", "both balls"),
                       ("fig02", "per ball")],
)  # fmt: skip
def test_energies_say_of_how_many_balls_they_are(page, scenario, whose):
    open_at(page, f"&scenario={scenario}&duration=3 s")
    page.get_by_text("Energy and more curves", exact=True).click()
    page.get_by_text(f"energy, {whose} [J]").wait_for()
    page.get_by_text(f"power, {whose} [W]").wait_for()
    page.get_by_text(f"Where the energy goes, {whose}").wait_for()
    total = page.evaluate(f"() => Array.from({PLAYER}.more.curves.charts[0].curves[2].values)")
    run = ll.load_scenario(scenario).simulate(duration=3.0)
    energy = run["total_energy"]
    wanted = energy.sum("ball") if "ball" in energy.dims else energy
    times = 2 if scenario == "toy" else 1  # one row of a mirror-symmetric toy stands for both
    assert total == pytest.approx(times * wanted.values, rel=1e-5, abs=1e-7)


def curve(page, k):
    """The values of a curve of the strip, and what is drawn of them."""
    return page.evaluate(
        f"""k => {{
          const {{ curves, plot }} = {PLAYER}.curves.charts[0];
          return [Array.from(curves[k].values), Array.from(plot.data[k + 1])];
        }}""",
        k,
    )


def test_angles_can_be_wrapped_and_no_line_is_drawn_through_a_turn(page):
    open_at(page, "&scenario=chaos&duration=20 s")
    plain, _ = map(np.array, curve(page, 0))
    page.get_by_role("button", name="±180°").click()
    wrapped, drawn = curve(page, 0)
    assert max(wrapped) <= 180.0
    assert min(wrapped) > -180.0
    turns = (plain - np.array(wrapped)) / 360.0
    assert turns == pytest.approx(np.round(turns), abs=1e-9)
    missing = [k for k, value in enumerate(drawn) if value is None]
    assert missing == list(np.flatnonzero(np.abs(np.diff(wrapped)) > 180.0) + 1)
    assert missing


def test_angles_that_never_turn_over_are_not_wrapped(page):
    open_at(page, "&scenario=fig02&duration=5 s")
    assert page.get_by_role("button", name="±180°").is_hidden()


@pytest.mark.parametrize("scenario", ["toy", "fig04a_push"])
def test_the_curve_of_the_pivot_is_its_height(page, scenario):
    unit = QUANTITIES["pivot_height"].shown_unit  # as in pictures and in CSV
    size = float(SIZES[unit])
    open_at(page, f"&scenario={scenario}&duration=3 s")
    page.get_by_role("button", name="Pivot", exact=True).click()
    page.get_by_text(f"pivot [{unit}]").wait_for()
    heights, _ = curve(page, 2)
    run = ll.load_scenario(scenario).simulate(duration=3.0)
    largest = float(abs(run["pivot_height"]).max())
    assert np.array(heights) * size == pytest.approx(run["pivot_height"].values, abs=1e-6 * largest)
    page.get_by_role("button", name="Pivot", exact=True).click()
    page.get_by_text(f"pivot [{unit}]").wait_for(state="detached")


def test_a_reset_goes_back_to_the_preset(page):
    open_at(page, "&scenario=toy&duration=3 s")
    reset = page.get_by_role("button", name="Reset")
    reset.click()
    wait_for_options(page, "options.duration === 20")
    assert reset.is_hidden()
    slider = page.get_by_role("slider", name="Bounciness, slider")
    slider.focus()
    slider.press("ArrowLeft")
    wait_for_options(page, "options.restitution === 0.89")
    reset.click()
    wait_for_options(page, "options.restitution === 0.9")
    page.wait_for_function("() => !location.search.includes('restitution')")


# Where the slider's thumb and the line in the curve stand, in pixels of the window.
PLACES = f"""() => {{
  const {{ timeline, curves }} = {PLAYER};
  const {{ scrub }} = timeline;
  const box = scrub.getBoundingClientRect();
  const thumb = parseFloat(getComputedStyle(scrub).getPropertyValue("--thumb"));
  const line = curves.charts[0].playhead.line.getBoundingClientRect();
  return [box.left + 0.5 * thumb + (scrub.value / scrub.max) * (box.width - thumb),
    0.5 * (line.left + line.right)];
}}"""


def test_the_slider_stands_below_the_instant_of_the_curve(page):
    open_at(page, "&scenario=fig02&duration=60 s")
    for size, pivot in ((PHONE, False), (LAPTOP, False), (LAPTOP, True), (PHONE, True)):
        page.set_viewport_size(size)
        button = page.get_by_role("button", name="Pivot", exact=True)
        if pivot != (button.get_attribute("aria-pressed") == "true"):
            button.click()
        page.wait_for_timeout(200)  # the curve is laid out again
        for time in (0.0, 5.3, 17.0):
            page.evaluate(f"t => {PLAYER}.clock.seek(t)", time)
            page.wait_for_timeout(50)
            thumb, line = page.evaluate(PLACES)
            assert thumb == pytest.approx(line, abs=1.5)


def test_a_pointer_on_the_curve_moves_the_clock(page):
    open_at(page, "&scenario=fig02&duration=60 s")
    box = page.locator(".timeline .u-over").bounding_box()
    span = page.evaluate(f"() => {PLAYER}.curves.span")
    for begin, end in ((0.2, 0.6), (0.9, 0.3)):
        y = box["y"] + 0.5 * box["height"]
        page.mouse.move(box["x"] + begin * box["width"], y)
        page.mouse.down()
        page.mouse.move(box["x"] + end * box["width"], y, steps=5)
        page.mouse.up()
        time = page.evaluate(f"() => {PLAYER}.clock.time")
        assert time == pytest.approx(span[0] + end * (span[1] - span[0]), abs=0.1)
    assert page.evaluate(f"() => {PLAYER}.curves.span") == span
    # With Shift it chooses what is shown.
    page.keyboard.down("Shift")
    page.mouse.move(box["x"] + 0.25 * box["width"], y)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.75 * box["width"], y, steps=5)
    page.mouse.up()
    page.keyboard.up("Shift")
    low, high = page.evaluate(f"() => {PLAYER}.curves.span")
    assert high - low == pytest.approx(0.5 * (span[1] - span[0]), rel=0.05)
    assert page.evaluate(f"() => {PLAYER}.clock.time") == time


def test_the_curve_shows_some_swings_and_follows_the_clock(page):
    open_at(page, "&scenario=fig02")
    low, high = page.evaluate(f"() => {PLAYER}.curves.span")
    assert (low, high) == (0.0, pytest.approx(12 * 2 * np.pi / np.sqrt(9.8)))
    page.evaluate(f"() => {PLAYER}.clock.seek(100)")
    page.wait_for_timeout(50)
    begin, end = page.evaluate(f"() => {PLAYER}.curves.span")
    assert begin < 100 < end
    assert end - begin == pytest.approx(high - low)
    whole = page.get_by_role("button", name="Whole run")
    whole.click()
    assert page.evaluate(f"() => {PLAYER}.curves.span") == [0, 300]
    assert whole.get_attribute("aria-pressed") == "true"
    whole.click()
    low, high = page.evaluate(f"() => {PLAYER}.curves.span")
    assert low < 100 < high < 200


def test_the_curve_follows_a_clock_that_goes_on(page):
    open_at(page, "&scenario=fig02")
    page.locator(".transport").get_by_label("Speed").select_option("20")
    page.get_by_role("button", name="Play", exact=True).click()
    for time in (30, 60):
        page.wait_for_function(f"time => {PLAYER}.clock.time > time", arg=time)
        begin, now, end = page.evaluate(
            f"() => [{PLAYER}.curves.span[0], {PLAYER}.clock.time, {PLAYER}.curves.span[1]]"
        )
        assert begin < now < end
        assert end - begin == pytest.approx(12 * 2 * np.pi / np.sqrt(9.8))


# Lets the clock leave the stretch on show, and returns how often each chart is drawn in each of the
# next frames.
COUNT_DRAWS = f"""async () => {{
  const {{ clock, curves, more }} = {PLAYER};
  let frame = [];
  const frames = [];
  [curves, more.curves].flatMap(({{ charts }}) => charts).forEach(({{ plot }}, k) => {{
    frame[k] = 0;
    (plot.hooks.draw ??= []).push(() => {{ frame[k] += 1; }});
  }});
  clock.seek(curves.span[1] - 0.05);
  clock.play();
  for (let k = 0; k < 30; k += 1) {{
    await new Promise(requestAnimationFrame);
    frames.push(frame);
    frame = frame.map(() => 0);
  }}
  return frames;
}}"""


def test_a_run_that_plays_draws_no_chart_twice_in_a_frame(page):
    open_at(page, "&scenario=fig02")
    page.locator(".more-curves > summary").click()
    page.wait_for_function(f"() => {PLAYER}.more?.curves.charts.length === 2")
    page.wait_for_timeout(300)
    frames = np.array(page.evaluate(COUNT_DRAWS))
    assert page.evaluate(f"() => {PLAYER}.curves.span[0]") > 0
    assert frames.shape[1] == 3
    assert frames.max() == 1
    # The curves stand still until the clock leaves them.
    assert frames.sum() < 3 * len(frames) / 2


def test_a_refusal_stands_on_the_stage_and_beside_its_knob(page):
    open_at(page, "&scenario=toy&duration=3 s")
    page.get_by_label("Begin with").focus()
    messages = page.locator(".stage-messages")
    option = "([name, text]) => window.latolato.views.toy.page.store.option(name, text)"
    page.evaluate(option, ["radius", "9 m"])
    messages.get_by_text("“radius of one ball” must be at least 0 m and").wait_for()
    page.evaluate(option, ["restitution", "2"])
    page.evaluate(option, ["radius", None])
    page.locator(".knobs").get_by_text("must be between 0 and 1").wait_for()
    messages.get_by_text("“Bounciness” must be between 0 and 1, got 2.").wait_for()
    assert messages.locator(".message").count() == 1
    page.evaluate(option, ["restitution", None])
    messages.locator(".message").wait_for(state="detached")


def test_the_first_run_finds_its_place(page):
    held = []
    page.route("**/one.wasm", lambda route: held.append(route))
    page.set_viewport_size(LAPTOP)
    page.goto("/?view=toy")
    parts = (".stage", ".scrub", ".transport", ".drawers", ".more-curves")
    page.locator(".more-curves").wait_for()
    before = [page.locator(each).bounding_box() for each in parts]
    page.wait_for_timeout(500)
    for route in held:
        route.continue_()
    page.wait_for_selector("[data-runs]")
    after = [page.locator(each).bounding_box() for each in parts]
    for one, other in zip(before, after, strict=True):
        assert one["y"] == pytest.approx(other["y"], abs=3)
        assert one["x"] == pytest.approx(other["x"], abs=3)


def test_messages_and_curves_move_nothing(page):
    open_at(page, "&scenario=toy&duration=3 s")
    parts = (".stage", ".transport", ".knobs", ".drawers")
    places = [page.locator(each).bounding_box() for each in parts]
    page.evaluate(
        "() => window.latolato.views.toy.note('This run takes long.', "
        "[{ label: 'Stop', act: () => {} }])"
    )
    page.get_by_role("button", name="Pivot", exact=True).click()
    page.get_by_role("slider", name="Bounciness, slider").press("ArrowLeft")
    page.get_by_role("button", name="Reset").wait_for()
    assert [page.locator(each).bounding_box() for each in parts] == places


# What a finger presses that is lower than 44 pixels, boxes to tick than 22.
SMALL = """() => [
  ["button:not(td button), select, summary, .check, input:not([type=checkbox], [type=radio])", 44],
  ["nav a, li > a, dt > a, .stories-link a, td > select", 44],
  ["[type=checkbox], [type=radio]", 22],
].flatMap(([selector, least]) => [...document.querySelectorAll(selector)]
  .filter((each) => each.checkVisibility({ visibilityProperty: true })
    && each.getBoundingClientRect().height < least)
  .map((each) => `${each.getBoundingClientRect().height}: ${each.outerHTML.slice(0, 80)}`))"""
# The views, stories and tables with what is ready there.
TOUCHED = {
    "view=map&map.scenario=fig05&map.size=4": "[data-done]",
    "view=measure": ".dropzone",
    "view=analyse": "dt > a",
    "view=analyse&analyse.what=self_start": ".settings .field",
    "view=toy&story.name=why_twice&story.step=3": ".story input",
    "view=toy": "[data-runs]",
}


@pytest.mark.parametrize("query", TOUCHED)
def test_fingers_can_press_all_that_a_phone_shows(browser, server, query):
    context = new_context(
        browser, base_url=server.address, viewport=PHONE, has_touch=True, is_mobile=True
    )
    page = context.new_page()
    page.goto(f"/?{query}")
    page.locator(TOUCHED[query]).first.wait_for()
    page.evaluate(
        "() => { for (const each of document.querySelectorAll('details')) each.open = true; }"
    )
    page.wait_for_timeout(300)
    assert page.evaluate(SMALL) == []
    assert page.evaluate("() => document.documentElement.scrollWidth") <= PHONE["width"]
    context.close()


@pytest.mark.parametrize("view", ["toy", "held"])
def test_a_phone_keeps_the_stage_above_what_a_thumb_reaches(browser, server, view):
    context = new_context(
        browser, base_url=server.address, viewport=PHONE, has_touch=True, is_mobile=True
    )
    page = context.new_page()
    open_at(page, "", view, PHONE)
    stage = page.locator(".stage").bounding_box()
    assert stage["height"] == pytest.approx(0.45 * PHONE["height"], abs=12)
    assert page.evaluate(SMALL) == []
    page.mouse.wheel(0, 600)
    page.wait_for_function("() => scrollY > 200")
    assert page.locator(".stage").bounding_box()["y"] == pytest.approx(0, abs=1)
    assert page.evaluate("() => document.documentElement.scrollWidth") <= PHONE["width"]
    context.close()


@pytest.mark.parametrize("view", ["toy", "held"])
def test_small_windows_show_the_stage_and_cut_nothing_off(page, view):
    open_at(page, "", view)
    # A phone on its side, a laptop and a phone at 200 %.
    for width, height in ((844, 390), (683, 384), (195, 422)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(200)
        stage = page.locator(".stage").bounding_box()
        assert min(stage["y"] + stage["height"], height) - stage["y"] > 100, width
        wide = page.evaluate(
            """() => [...document.querySelectorAll(".desk *")].filter((each) =>
              each.checkVisibility()
              && !each.closest(".stage-tools")  // they scroll by themselves
              && each.getBoundingClientRect().right > innerWidth + 1)
              .map((each) => each.outerHTML)"""
        )
        assert wide == [], width


def test_nothing_lies_over_the_picture_or_moves_what_stands_below_it(page):
    open_at(page, "&unknown=1")
    page.locator(".stage-messages .message").wait_for()
    page.get_by_label("Arrows").check()
    for size in (PHONE, {"width": 683, "height": 384}, LAPTOP):
        page.set_viewport_size(size)
        page.wait_for_timeout(200)
        picture = page.locator("canvas.scene").bounding_box()
        assert picture["height"] >= 100
        for each in (".stage-tools > *", ".stage-messages", ".of-arrows"):
            for part in page.locator(each).all():
                box = part.bounding_box()
                assert (
                    box["y"] >= picture["y"] + picture["height"] - 0.5
                    or box["x"] >= picture["x"] + picture["width"] - 0.5
                ), (size, each)
    curve = page.locator(".timeline").bounding_box()
    page.get_by_role("button", name="Dismiss this message").click()
    page.get_by_label("Arrows").uncheck()
    assert page.locator(".timeline").bounding_box() == curve


@pytest.mark.parametrize("view", ["toy", "held"])
def test_paper_shows_the_stage_the_curve_the_values_and_the_address(page, view):
    page.emulate_media(color_scheme="dark")
    open_at(page, "", view, motion="no-preference")
    page.emulate_media(media="print")
    paint = "() => getComputedStyle(document.documentElement).getPropertyValue('--ink').trim()"
    on_screen = page.evaluate(paint)
    page.evaluate("() => dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate(paint) != on_screen == "#e8eaef"
    curve = ".chart canvas"
    for seen in ("canvas.scene", curve, ".headline", ".legend output", ".knobs input[type=text]"):
        assert page.locator(seen).first.is_visible()
    # Pictures keep their shape.
    for each in ("canvas.scene", curve):
        box = page.locator(each).first.bounding_box()
        width, height = page.locator(each).first.evaluate("(c) => [c.width, c.height]")
        assert box["width"] / box["height"] == pytest.approx(width / height, rel=0.02)
    assert page.locator(".address").inner_text() == page.url
    assert page.locator(".legend output").first.inner_text()  # all is at rest
    for left_out in (".top", ".transport button", ".stage-tools", ".knobs input[type=range]"):
        assert page.locator(left_out).first.is_hidden()
    page.evaluate("() => dispatchEvent(new Event('afterprint'))")
    assert page.evaluate(paint) == on_screen


def test_an_angle_that_stays_small_can_be_read_off_its_axis(page):
    open_at(page, "&scenario=fig02_mathieu")
    marks = page.evaluate(
        """() => {
          const { plot } = window.latolato.views.toy.player.curves.charts[0];
          return plot.axes[1]._values.map(Number);
        }"""
    )
    assert len(marks) >= 3
    assert min(marks) < 0 < max(marks)


@pytest.mark.parametrize("language", ["en", "id"])
def test_a_phone_s_header_is_low_and_shows_the_whole_name_of_its_language(page, language):
    page.set_viewport_size(PHONE)
    open_view(page, f"&lang={language}")
    select = page.locator("#language")
    width = select.bounding_box()["width"]
    select.evaluate("(element) => { element.style.width = 'max-content'; }")
    assert select.bounding_box()["width"] <= width
    tops = [page.locator(name).bounding_box()["y"] for name in ("#language", "#theme")]
    assert tops[0] == pytest.approx(tops[1], abs=3)
    select.evaluate("(element) => { element.style.width = ''; }")
    for width in (390, 360):
        page.set_viewport_size({"width": width, "height": 844})
        assert page.locator("header.top").bounding_box()["height"] < 100
        for link in page.locator("#views a").all():
            box = link.bounding_box()
            assert 0 <= box["x"] <= width - box["width"]


@pytest.mark.parametrize("language", ["en", "id"])
def test_toy_needs_no_scrolling_and_its_bar_has_one_line_in_every_language(page, language):
    open_at(page, f"&lang={language}", motion="no-preference")
    page.locator(".headline p").get_by_text("°").wait_for()
    for size in (LAPTOP, {"width": 1280, "height": 800}):
        page.set_viewport_size(size)
        page.wait_for_timeout(200)
        bar, play = (page.locator(name).bounding_box() for name in (".transport", ".play"))
        assert bar["height"] < 1.5 * play["height"]
        assert page.evaluate("() => document.documentElement.scrollHeight") <= size["height"]


def test_a_phone_shows_a_map_before_its_explanation(page):
    page.set_viewport_size(PHONE)
    open_view(page, "&map.scenario=fig05_push&map.duration=20&map.size=12", "map")
    assert page.locator("canvas").first.bounding_box()["y"] < 0.5 * PHONE["height"]
    text = page.get_by_text("Every point of the picture is a separate run.")
    assert not text.is_visible()
    page.get_by_text("What is this?", exact=True).click()
    assert text.is_visible()


def test_how_often_has_one_limit_in_both_ways_to_say_it(page):
    # Of this length the limit of the ratio, 50.556, must not be rounded upwards.
    open_at(page, "&scenario=toy&duration=2 s&length=23 cm")
    knobs = page.locator(".knobs")
    for label, text in (("How often", "66.9"), ("driving over natural frequency", "66")):
        field = knobs.get_by_label(label, exact=False).first
        enter(field, text)
        line = knobs.get_by_text("must be between 0").first
        line.wait_for()
        # The limit that it names is the value that it offers.
        offered = line.get_by_role("button").inner_text().removeprefix("Take ")
        assert f"and {offered}. " in line.inner_text()
        assert "frequency" not in page.url
        page.reload()
        page.wait_for_selector("[data-runs]")
