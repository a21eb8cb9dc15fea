"""Play in a real browser."""

from __future__ import annotations

import itertools
import math
import re
from urllib.parse import urlencode

import numpy as np
import pytest

import latolato as ll
from app_pages import (
    OPTIONS,
    enter,
    new_context,
    next_run,
    open_form,
    open_view,
    stored_run,
    wait_for_options,
)
from app_server import start_server, stop_server
from latolato.app.run_request import RunRequest


def open_play(page, query=""):
    """Open Play with a run at rest."""
    page.emulate_media(reduced_motion="reduce")
    open_view(page, query)


def test_a_slider_changes_the_curve_and_the_address(page):
    open_form(page, "&scenario=fig04b_push&duration=10%20s")
    assert page.get_by_label("duration", exact=False).first.input_value() == "10"
    slider = page.get_by_label("driving amplitude, slider")
    slider.focus()
    with next_run(page):
        slider.press("ArrowRight")
    page.wait_for_function("() => location.search.includes('drive_amplitude')")


def test_a_run_has_few_samples_while_a_slider_moves_and_all_when_it_is_let_go(page):
    open_play(page, "&scenario=fig04b_push&duration=300%20s&samples=30000")
    samples = """() => {
      const { player: { motion: { time, contacts }, curves: { span: [from, to] } } } =
        window.latolato.views.toy;
      return [time.length, time.filter((each) => each >= from && each <= to).length, time.at(-1),
        contacts.length];
    }"""
    runs = "n => Number(document.querySelector('[data-runs]').dataset.runs) >= n"
    whole = page.evaluate(samples)
    assert whole[0] == 30_000
    slider = page.get_by_label("How far the hand moves, slider").bounding_box()
    middle = slider["y"] + slider["height"] / 2
    page.mouse.move(slider["x"] + 0.3 * slider["width"], middle)
    page.mouse.down()
    page.wait_for_function(runs, arg=2)
    count, on_show, end, _ = page.evaluate(samples)
    assert count < 6000
    # Every second one: there are still some fifty in a swing.
    assert on_show >= whole[1] // 2
    assert end == whole[2]
    page.mouse.up()
    page.wait_for_function(runs, arg=3)
    let_go = page.evaluate(samples)
    assert let_go[:3] == whole[:3]
    # Contacts do not depend on the samples.
    page.evaluate("""() => window.latolato.views.toy.root.querySelector(".knob input[type=range]")
      .dispatchEvent(new Event("input", { bubbles: true }))""")
    page.wait_for_function(runs, arg=4)
    few = page.evaluate(samples)
    assert few[0] < 6000
    assert few[3] == let_go[3] > 100


def test_numbers_that_would_lag_behind_the_picture_are_not_shown(page):
    open_view(page, "&scenario=toy")
    page.wait_for_timeout(1500)  # the first clacks
    fast, slow, paused = page.evaluate(
        """async () => {
          const { player } = window.latolato.views.toy;
          const { clock, motion } = player;
          const read = (time) => [document.querySelector(".transport .time").textContent,
            [...document.querySelectorAll(".timeline .legend output")]
              .map((output) => output.textContent),
            time, motion.balls.map((ball) => (motion.angle(ball, time) * 180) / Math.PI)];
          const watch = async (speed) => {
            const written = [];
            clock.speed = speed;
            // The last to hear of an instant.
            const end = clock.subscribe((time) => { if (clock.isRead) written.push(read(time)); });
            await new Promise((done) => setTimeout(done, 800));
            end();
            return written;
          };
          const found = [await watch(1), await watch(0.01)];
          clock.pause();
          return [...found, read(clock.time)];
        }"""
    )
    # No faster than a person reads them.
    assert 2 <= len(fast) <= 9
    assert all(legend == ["", ""] for _, legend, *_ in fast)
    for text, legend, time, angles in [*slow, paused]:
        assert text == f"t = {time:.{2 if text == paused[0] else 1}f} s"
        assert [float(each) for each in legend] == pytest.approx(angles, abs=0.06)  # four digits


# Reads the canvas of a curve: for some columns the rows in which a colour is seen.
READ_CURVE = """({ chart, series }) => {
  const { plot, curves } = window.latolato.views.toy.player.curves.charts[chart];
  const { canvas } = plot.ctx;
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const paint = getComputedStyle(document.documentElement)
    .getPropertyValue(`--${curves[series].paint}`).trim();
  const wanted = [1, 3, 5].map((k) => parseInt(paint.slice(k, k + 2), 16));
  const found = [];
  for (const share of [0.13, 0.29, 0.41, 0.58, 0.71, 0.9]) {
    const { min, max } = plot.scales.x;
    const time = min + share * (max - min);
    const column = Math.round(plot.valToPos(time, "x", true));
    const rows = [];
    for (let y = 0; y < canvas.height; y += 1) {
      const i = 4 * (y * canvas.width + column);
      if (wanted.every((v, k) => Math.abs(v - data[i + k]) < 40)) rows.push(y);
    }
    const at = plot.data[0].findIndex((t) => t >= time);
    const value = plot.data[series + 1][at];
    found.push({ rows, wanted: plot.valToPos(value, "y", true), ratio: devicePixelRatio });
  }
  return found;
}"""


def test_curves_go_through_the_data_in_both_themes(page):
    open_play(page, "&scenario=fig02&initial_angle=10%20deg&duration=4%20s")
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        page.wait_for_timeout(300)
        for found in page.evaluate(READ_CURVE, {"chart": 0, "series": 0}):
            assert found["rows"], "no pixel of the curve's colour in this column"
            assert min(abs(row - found["wanted"]) for row in found["rows"]) <= 3.0 * found["ratio"]


# Where the marks of the phase portrait stand at an instant, in units of its axes and of one pixel
# there, and whether its canvas has the colour of the ball at that place.
PHASE = """(time) => {
  const { clock, more: { plots: { phase } } } = window.latolato.views.toy.player;
  clock.seek(time);
  const { bbox, ctx, scales: { x, y } } = phase.plot;
  const { left, top } = ctx.canvas.getBoundingClientRect();
  const pixels = [(x.max - x.min) / bbox.width, (y.max - y.min) / bbox.height];
  return Object.fromEntries(phase.paints.map((name, k) => {
    const box = phase.dots[k].getBoundingClientRect();
    const across = (box.left + 0.5 * box.width - left) * devicePixelRatio;
    const down = (box.top + 0.5 * box.height - top) * devicePixelRatio;
    const paint = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    const wanted = [1, 3, 5].map((i) => parseInt(paint.slice(i, i + 2), 16));
    const copy = document.createElement("canvas").getContext("2d");
    copy.drawImage(ctx.canvas, 1 - Math.floor(across), 1 - Math.floor(down));
    const { data } = copy.getImageData(0, 0, 3, 3);
    const isDrawn = Array.from({ length: 9 }, (_, i) => 4 * i).some((i) =>
      wanted.every((value, c) => Math.abs(value - data[i + c]) < 60));
    return [name, { isDrawn, pixels,
      place: [x.min + (across - bbox.left) * pixels[0], y.max - (down - bbox.top) * pixels[1]] }];
  }));
}"""


def test_the_phase_portrait_goes_through_its_marks_in_both_themes(page):
    open_play(page, "&scenario=ballpair_asymmetric&duration=2%20s")
    page.get_by_text("Energy and more curves", exact=True).click()
    page.locator(".more-curves tbody tr").first.wait_for()
    run = ll.load_scenario("ballpair_asymmetric").simulate(duration=2.0)
    for width, scheme in itertools.product((1280, 390), ("light", "dark")):
        page.set_viewport_size({"width": width, "height": 900})
        page.emulate_media(color_scheme=scheme)
        page.wait_for_timeout(200)  # size and theme are applied, and drawn
        for time in (0.1, 0.45, 1.8):  # not near a contact
            found = page.evaluate(PHASE, time)
            for ball in ("right", "left"):
                assert found[ball]["isDrawn"], (width, scheme, time, ball)
                near = run.sel(ball=ball)
                wanted = [
                    np.interp(time, run["time"], values)
                    for values in (np.degrees(near["angle"]), near["angular_velocity"])
                ]
                off = np.subtract(found[ball]["place"], wanted) / found[ball]["pixels"]
                assert np.abs(off).max() < 1.5, (width, scheme, time, ball)


CURSOR = """(share) => {
  const { clock, curves } = window.latolato.views.toy.player;
  clock.seek(share * clock.end);
  return curves.charts.map(({ plot, playhead }) => {
    const box = plot.over.getBoundingClientRect();
    const { min, max } = plot.scales.x;
    const line = playhead.line.getBoundingClientRect();
    return {
      drawn: 0.5 * (line.left + line.right),
      wanted: box.left + ((clock.time - min) / (max - min)) * box.width,
    };
  });
}"""


def test_the_cursor_stands_at_the_instant_also_after_a_change_of_size(page):
    open_play(page, "&scenario=fig04b_push&duration=20%20s")
    for width in (1280, 700, 1100):
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_timeout(200)
        for share in (0.0, 0.37, 0.9):
            for head in page.evaluate(CURSOR, share):
                assert abs(head["drawn"] - head["wanted"]) <= 1.0
    # Fast and slow playback show the same motion.
    shown = page.evaluate(
        """() => {
          const { clock, scene } = window.latolato.views.toy.player;
          const at = (speed, steps) => {
            clock.speed = speed;
            clock.seek(0);
            for (let i = 0; i < steps; i += 1) clock.advance(0.05);
            return [clock.time, ...scene.drawn.flatMap(({ x, y }) => [x, y])];
          };
          return [at(10, 25), at(1, 250)];
        }"""
    )
    assert shown[0] == pytest.approx(shown[1], abs=1e-6)


def test_the_address_brings_the_same_run_back(page):
    open_form(page, "&scenario=fig12&duration=8%20s")
    field = page.get_by_label("driving amplitude", exact=False).first
    enter(field, "28")
    page.wait_for_function("() => location.search.includes('28')")
    wait_for_options(page, "Math.abs(options.drive_amplitude - 0.028) < 1e-12")
    before, address = page.evaluate(OPTIONS), page.url
    page.goto("about:blank")
    page.goto(address)
    page.wait_for_selector("[data-runs]")
    assert page.evaluate(OPTIONS) == before


def test_a_run_that_pages_cannot_compute_comes_from_the_program(page, tmp_path):
    times, heights = [0.25 * k for k in range(9)], [0, 10, 20, 15, 5, 0, -5, 0, 10]
    query = {
        "system": "latolato", "length": "0.2 m", "mass": "50 g", "radius": "20 mm",
        "drive": "measured_pivot", "drive_times": ", ".join(f"{time} s" for time in times),
        "pivot_heights": ", ".join(f"{height} mm" for height in heights),
        "initial_angle": "0.5 rad", "duration": "2 s",
    }  # fmt: skip
    open_play(page, f"&{urlencode(query)}")
    page.get_by_text("Python and command line", exact=True).click()
    page.get_by_text("ll.MeasuredPivot(").wait_for()
    wanted = RunRequest(None, query).to_scenario().simulate()
    found = stored_run(page, tmp_path)
    assert set(found.variables) == set(wanted.variables)
    for name in ("time", "angle", "tension", "contact_time"):
        # Files hold degrees, whose last digit is rounded.
        np.testing.assert_allclose(found[name], wanted[name], rtol=1e-15)
    assert list(found["contact_kind"].values) == list(wanted["contact_kind"].values)
    assert found.attrs["scenario"] == wanted.attrs["scenario"]


def test_a_row_can_be_added_before_the_run_has_come(page):
    open_form(page, "&scenario=fig02&duration=5%20s")
    page.route("**/api/run", lambda route: None)  # it never comes
    page.get_by_label("Drive", exact=True).select_option("frequency_schedule")
    page.get_by_role("button", name="Add a row").click()
    page.wait_for_function(
        """() => new URLSearchParams(location.search).get("drive_times")?.split(",").length === 3"""
    )
    page.unroute_all(behavior="ignoreErrors")


def test_stages_begin_with_as_many_rows_as_the_schedule_had(page):
    open_form(page)
    lengths = """() => ["times", "frequencies", "amplitudes"].map((name) =>
      new URLSearchParams(location.search).get(`drive_${name}`)?.split(",").length ?? 0)"""
    page.get_by_label("Drive", exact=True).select_option("frequency_schedule")
    for rows in (3, 4):
        page.get_by_role("button", name="Add a row").click()
        page.wait_for_function(f"() => ({lengths})()[0] === {rows}")
    page.get_by_label("angular frequency of each stage 4").wait_for()  # else it is drawn again
    page.get_by_label("angular frequency of each stage 3").fill("12")
    page.get_by_label("angular frequency of each stage 3").press("Enter")
    wait_for_options(page, "options.drive_frequencies[2] === 12")
    page.get_by_label("Drive", exact=True).select_option("staged_harmonic")
    wait_for_options(page, "options.drive === 'staged_harmonic'")
    # The address follows a moment later.
    page.wait_for_function(f"() => ({lengths})().join() === '4,4,4'")
    page.get_by_role("button", name="Add a row").click()
    wait_for_options(page, "options.drive_amplitudes?.length === 5")


def test_another_system_keeps_what_it_knows_and_gets_what_it_needs(page):
    open_form(page, "&scenario=fig02&duration=5%20s")
    for system in ("latolato", "ballpair", "mathieu", "pendulum"):
        page.get_by_label("System", exact=True).select_option(system)
        wait_for_options(page, f"options.system === '{system}'")
    page.get_by_label("Drive", exact=True).select_option("frequency_schedule")
    page.get_by_role("button", name="Add a row").click()
    wait_for_options(page, "options.drive_times?.length === 3")
    for drive in ("chirp", "crank_slider", "fixed_pivot", "harmonic"):
        page.get_by_label("Drive", exact=True).select_option(drive)
        wait_for_options(page, f"options.drive === '{drive}'")


@pytest.mark.parametrize("scenario", [None, "fig02"])
def test_another_drive_leaves_toy_and_start_as_they_are(page, scenario):
    open_form(page, f"&scenario={scenario}" if scenario else "")
    before = page.evaluate(OPTIONS)
    page.get_by_label("Drive", exact=True).select_option("chirp")
    wait_for_options(page, "options.drive === 'chirp'")
    after = page.evaluate(OPTIONS)
    for name in ("length", "mass", "damping", "radius", "initial_angle", "duration"):
        assert after.get(name) == (pytest.approx(before[name]) if name in before else None), name


def test_what_is_typed_stays_when_the_run_before_it_comes(page):
    open_play(page, "&scenario=fig04b_push&duration=20%20s")
    length = page.locator(".knobs .field").first.get_by_role("textbox")
    enter(length, "31")
    length.press_sequentially("7")
    page.wait_for_function("() => Number(document.querySelector('[data-runs]').dataset.runs) > 1")
    page.evaluate("() => window.latolato.views.toy.knobs.all.drive_amplitude.show(0.02)")
    assert length.input_value() == "317"


def test_a_cell_of_a_schedule_keeps_what_is_typed_when_the_run_comes(page):
    open_form(page, "&scenario=fig12")
    first, second = (page.locator(".field.list input").nth(i) for i in (1, 3))
    first.fill("3.2")
    second.click()
    second.press_sequentially("9")
    typed = second.input_value()
    page.wait_for_function("() => Number(document.querySelector('[data-runs]').dataset.runs) > 1")
    assert second.input_value() == typed
    assert second.evaluate("input => input === document.activeElement")


def test_a_refusal_of_a_hidden_field_is_seen(page, watch):
    open_form(page)
    field = page.get_by_label("duration", exact=False).first
    enter(field, "1e9")
    page.locator(".form").get_by_text("shorten it, loosen “tolerance”").wait_for()


def test_a_value_that_is_offered_is_written_as_people_read_it(page):
    open_form(page)
    page.locator(".form summary").last.click()
    enter(page.get_by_role("textbox", name="tolerance"), "-1")
    page.get_by_role("button", name="Take 10⁻¹⁴ rad").click()
    page.wait_for_url("**tolerance=1e-14**")


def test_a_default_is_offered_where_there_is_no_limit_that_anybody_means(page):
    open_form(page)
    form = page.locator(".form")
    form.locator("summary").last.click()
    for name, offered in (("gravitational", "9.8 m/s²"), ("tolerance", "10⁻¹⁰ rad")):
        field = form.get_by_role("textbox", name=name)
        enter(field, "1e300")
        form.get_by_role("button", name=f"Take {offered}", exact=True).click()
        assert field.get_attribute("aria-invalid") == "false"


def test_a_run_of_minutes_says_so_and_stops_at_once(page):
    open_form(page, "&scenario=toy")
    field = page.get_by_label("duration", exact=False).first
    enter(field, "5e6")
    page.get_by_role("status").filter(has_text="Computing").wait_for()
    page.get_by_role("button", name="Stop").press("Enter")
    page.get_by_text("The run was stopped").wait_for()
    assert page.evaluate("() => window.latolato.views.toy.runner.worker") is None
    enter(field, "5")
    page.wait_for_function("() => window.latolato.views.toy.player.motion.end === 5")
    assert page.locator(".message").count() == 0
    assert page.get_by_text("Computing").count() == 0


def test_a_first_run_that_is_stopped_leaves_a_way_back_and_no_gap(page):
    page.goto("/?view=toy&duration=4e6")
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("The run was stopped").wait_for()
    hanging, drawers = (page.locator(each).bounding_box() for each in (".hanging", ".drawers"))
    assert drawers["y"] - hanging["y"] - hanging["height"] < 50
    page.get_by_role("button", name="Reset to the preset").click()
    page.wait_for_selector("[data-runs]")
    page.locator(".knobs .knob").first.wait_for()


def test_a_worker_that_fails_says_so_and_the_next_run_has_another_one(page):
    open_play(page)
    page.evaluate(
        """() => {
          const view = window.latolato.views.toy;
          view.simulate();
          view.runner.receive({ number: view.runner.number, fault: { message: "" } });
        }"""
    )
    page.locator(".message").get_by_text("The computation failed").wait_for()
    page.get_by_label("Begin with").select_option("fig04a_push")
    page.wait_for_function("() => document.querySelector('[data-runs]').dataset.runs === '2'")


def test_a_page_whose_worker_does_not_load_computes_by_itself(page, watch):
    page.route("**/model/run_worker.js", lambda route: route.abort())
    open_play(page)
    assert page.locator(".message").count() == 0
    watch.faults[:] = [fault for fault in watch.faults if "ERR_FAILED" not in fault]


@pytest.mark.parametrize("query", ["?view=toy", "?view=toy&toy.hand=1"])
def test_compiled_code_is_loaded_while_the_registry_is_awaited(page, query):
    awaited, given = [], []

    def hold(route):
        if given:
            route.continue_()
        else:
            awaited.append(route)

    page.route("**/registry.json", hold)
    with page.expect_request(re.compile("kernels/one")):
        page.goto(f"/{query}", wait_until="commit")
    assert page.locator("nav a").count() == 0
    given.append(True)
    for route in awaited:
        route.continue_()
    page.wait_for_selector("[data-runs], [data-ready]", state="attached")


def test_a_moving_slider_shows_the_run_under_way_and_the_newest_one(page):
    open_play(page, "&scenario=fig04b_push&duration=20%20s")
    asked, statuses, amplitude = page.evaluate(
        """async () => {
          const { runner } = window.latolato.views.toy;
          const { worker } = runner;
          const post = worker.postMessage.bind(worker);
          let asked = 0;
          worker.postMessage = (question) => { asked += 1; post(question); };
          const ends = await Promise.allSettled(Array.from({ length: 10 }, (_, k) =>
            runner.compute({ scenario: "fig04b_push", options: { drive_amplitude: `${k} mm` } })));
          return [asked, ends.map(({ status }) => status),
            ends[9].value.about.options.drive_amplitude];
        }"""
    )
    assert asked == 2
    assert statuses == ["fulfilled"] + ["rejected"] * 8 + ["fulfilled"]
    assert amplitude == pytest.approx(9e-3, rel=1e-15)


PLAYING = "() => window.latolato.views.toy.player.clock.playing"


def test_the_keyboard_plays_steps_and_zooms(page):
    open_play(page, "&scenario=fig04b_push&duration=20%20s")
    chart = page.get_by_role("img", name="angle [°]", exact=False).first
    chart.focus()
    chart.press(".")
    chart.press(".")
    step = page.evaluate("() => 20 / (window.latolato.views.toy.player.motion.time.length - 1)")
    assert page.evaluate("() => window.latolato.views.toy.player.clock.time") == pytest.approx(
        2 * step
    )
    chart.press("+")
    span = page.evaluate("() => window.latolato.views.toy.player.curves.span")
    assert span[1] - span[0] == pytest.approx(10.0, rel=0.5)
    chart.press("0")
    assert page.evaluate("() => window.latolato.views.toy.player.curves.span") == [0, 20]
    chart.press(" ")
    page.wait_for_function("() => window.latolato.views.toy.player.clock.time > 0.2")
    chart.press(" ")
    assert not page.evaluate(PLAYING)


@pytest.mark.parametrize("hand", ["", "&toy.hand=1"])
def test_space_plays_and_pauses_wherever_no_field_has_the_focus(page, hand):
    page.goto(f"/?view=toy&scenario=toy{hand}")
    page.wait_for_selector("[data-runs], [data-ready]")
    for focus in ("body", "canvas, main", "a.brand", ".scrub", "#views a"):
        before = page.locator(".transport .play").inner_text()
        page.evaluate(
            """(focus) => {
              document.activeElement.blur();
              document.querySelector(focus).focus({ preventScroll: true });
            }""",
            focus,
        )
        page.keyboard.press("Space")
        after = "Pause" if before == "Play" else "Play"
        page.get_by_role("button", name=after, exact=True).wait_for()
    assert page.evaluate("() => scrollY") == 0


def test_the_space_bar_is_left_to_those_that_need_it(page):
    open_form(page, "&scenario=fig04b_push&duration=20%20s")
    loop = page.get_by_label("Loop", exact=True)
    loop.focus()
    was = loop.is_checked()
    page.keyboard.press("Space")
    assert loop.is_checked() != was
    page.get_by_role("button", name="Pin this run to compare").focus()
    page.keyboard.press("Space")
    page.get_by_role("button", name="Unpin this run").wait_for()
    field = page.get_by_label("pivot to ball centre l", exact=True)
    field.focus()
    page.keyboard.press("End")
    page.keyboard.press("Space")
    assert field.input_value().endswith(" ")
    assert not page.evaluate(PLAYING)
    # A view that was left takes no keys.
    page.get_by_role("link", name="Report", exact=True).click()
    page.get_by_role("heading", level=1).wait_for()
    page.keyboard.press("Space")
    assert not page.evaluate(PLAYING)


def test_a_pinned_run_stays_behind_the_next(page):
    open_form(page, "&scenario=fig04b_push&duration=10%20s")
    page.get_by_role("button", name="Pin this run to compare").click()
    field = page.get_by_label("driving amplitude", exact=False).first
    enter(field, "30")
    page.get_by_text("right ball, pinned").wait_for()
    series = page.evaluate("() => window.latolato.views.toy.player.curves.charts[0].plot.data")
    assert len(series) == 5  # time, two pinned angles, two angles
    page.get_by_role("button", name="Unpin this run").click()
    page.get_by_text("right ball, pinned").wait_for(state="detached")


def test_a_mark_beyond_the_axes_of_a_portrait_is_not_shown(page):
    page.goto("/")
    hidden = page.evaluate(
        """async () => {
          const { XYPlot } = await import("/js/player/xy_plot.js");
          const plot = new XYPlot(document.body, { x: "x", y: "y" }, ["right"]);
          plot.show({ right: { xs: [0, 1], ys: [0, 1] } });
          await new Promise((drawn) => setTimeout(drawn, 100));
          return [0.5, 100].map((x) => {
            plot.mark({ right: { x, y: 0.5 } });
            return plot.dots[0].hidden;
          });
        }"""
    )
    assert hidden == [False, True]


def test_the_ledger_makes_a_hundred_percent_on_each_side(page):
    open_play(page, "&scenario=fig12")
    page.get_by_text("Energy and more curves", exact=True).click()
    page.get_by_text("Out, and left").wait_for()
    sides = page.evaluate(
        """async () => {
          const { ledgerRows } = await import("/js/player/more_curves.js");
          const rows = ledgerRows(window.latolato.views.toy.player.motion);
          const sum = (sign) => rows.filter((r) => r.energy * sign > 0)
            .reduce((total, r) => total + r.share, 0);
          return [sum(1), sum(-1)];
        }"""
    )
    assert sides == pytest.approx([1.0, 1.0], abs=1e-5)


def test_a_view_chosen_while_the_server_is_away_comes_with_it(browser):
    first = start_server()
    context = new_context(browser, viewport={"width": 1280, "height": 900})
    page = context.new_page()
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(first.address)
    page.wait_for_selector("[data-runs]")
    stop_server(first)
    page.get_by_role("link", name="Map", exact=True).click()
    page.get_by_text("The server does not answer").wait_for()
    second = start_server("--port", str(first.port))
    try:
        page.locator(".map-bar").first.wait_for()
        page.get_by_role("link", name="Toy", exact=True).click()
        page.get_by_label("Begin with").wait_for()
        assert errors == []
    finally:
        stop_server(second)
        context.close()


def test_the_hint_on_frequencies_and_a_refused_stage_are_of_the_toy_on_show(page):
    open_form(page)
    hint = page.get_by_text("ω₀ is how often a ball swings by itself:")
    assert "1.11 times per second. After a push, this toy flies at" in hint.inner_text()
    page.evaluate("window.latolato.views.toy.page.store.option('length', '80 cm')")
    page.get_by_text("0.557 times per second.").wait_for()
    assert "this toy flies" not in hint.inner_text()
    page.get_by_label("Begin with").select_option("fig12")
    cell = page.get_by_label("angular frequency of each stage 2")
    enter(cell, "slow")
    page.get_by_text("“slow” is not a number").wait_for()
    assert "drive_frequencies" not in page.url


def test_each_field_says_what_is_wrong_with_it_whatever_others_hold(page):
    open_play(page)
    fields = [page.get_by_role("textbox", name=name) for name in ("How far", "Bounciness")]
    for text, problem in {"abc": "is not a number", "": "A number belongs here, such as"}.items():
        for field in fields:
            field.fill(text)
            field.press("Tab")
        assert page.locator(".knobs").get_by_text(problem).filter(visible=True).count() == 2
        assert [field.get_attribute("aria-invalid") for field in fields] == ["true", "true"]
    # Another run leaves them as they are; nothing of them is in the address.
    frequency = page.get_by_role("textbox", name="How often")
    enter(frequency, "slow")
    page.get_by_text("A number “per second” belongs here; “slow” is not one.").wait_for()
    enter(frequency, "3 hz")
    page.get_by_text("“3 hz” is not one. Did you mean 'Hz'?").wait_for()
    enter(frequency, "2,5")
    page.wait_for_function("() => location.search.includes('drive_frequency=2.5+Hz')")
    page.wait_for_function("() => Number(document.querySelector('[data-runs]').dataset.runs) > 1")
    assert [field.get_attribute("aria-invalid") for field in fields] == ["true", "true"]
    assert "restitution" not in page.url
    enter(fields[1], "0.5")
    page.wait_for_function("() => location.search.includes('restitution=0.5')")
    assert fields[1].get_attribute("aria-invalid") == "false"


def test_a_start_in_the_wall_is_refused_in_the_unit_of_its_field(page):
    open_form(page)
    field = page.locator(".form").get_by_label("initial angle", exact=False).first
    page.get_by_label("unit of initial angle").select_option("deg")
    enter(field, "0.5")
    beyond = re.compile(
        "must lie between the contact angles, 5.16.*° and 174.8.*°, got 0.5°; give one"
    )
    page.locator(".form .error").filter(has_text=beyond).wait_for()
    page.locator(".stage-messages").filter(has_text=beyond).wait_for()
    page.get_by_label("unit of initial angle").select_option("rad")
    enter(field, "0.01")
    beyond = re.compile(
        "must lie between the contact angles, 0.0901.* rad and 3.05.* rad, got 0.01 rad; give one"
    )
    page.locator(".form .error").filter(has_text=beyond).wait_for()
    page.locator(".stage-messages").filter(has_text=beyond).wait_for()


def test_a_chosen_unit_is_kept_but_the_address_goes_before_it(page):
    open_form(page, "&scenario=fig02&duration=2%20s")
    page.get_by_label("unit of angular driving frequency").select_option("Hz")
    field = page.get_by_label("angular driving frequency ω", exact=True)
    in_hertz = float(field.input_value())
    page.reload()
    page.get_by_text("More parameters", exact=True).click()
    assert float(field.input_value()) == in_hertz
    open_form(page, "&scenario=fig02&duration=2%20s&drive_frequency=60%20rpm")
    assert float(field.input_value()) == 60.0


def test_a_field_keeps_its_unit_when_another_knob_changes_its_value(page):
    open_form(page)
    unit = page.get_by_label("unit of angular driving frequency")
    field = page.get_by_label("angular driving frequency ω", exact=True)
    assert unit.input_value() == "rad/s"
    often = page.get_by_role("textbox", name="How often")
    enter(often, "2.5")
    page.wait_for_function("() => Number(document.querySelector('[data-runs]').dataset.runs) > 1")
    assert unit.input_value() == "rad/s"
    assert float(field.input_value()) == pytest.approx(5.0 * math.pi, rel=1e-5)
    # Neither other fields nor fields made anew for another drive change it.
    page.get_by_label("Drive", exact=True).select_option("crank_slider")
    page.wait_for_function("() => Number(document.querySelector('[data-runs]').dataset.runs) > 2")
    assert unit.input_value() == "rad/s"
    enter(field, "16")
    page.wait_for_function("() => location.search.includes('drive_frequency=16+rad%2Fs')")
    # A unit that is typed is chosen.
    enter(field, "60 rpm")
    page.wait_for_function("() => location.search.includes('drive_frequency=60+rpm')")
    assert unit.input_value() == "rpm"
    enter(field, "90")
    page.wait_for_function("() => location.search.includes('drive_frequency=90+rpm')")


def test_a_kept_unit_that_there_is_not_is_left_aside(page):
    page.add_init_script("localStorage.setItem('latolato.unit.drive_frequency', 'parsec')")
    open_form(page, "&scenario=fig02&duration=2%20s")
    unit = page.get_by_label("unit of angular driving frequency")
    assert unit.input_value() == "rad/s"
