"""Map in a real browser."""

from __future__ import annotations

import itertools
import re
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

import latolato as ll
from app_pages import download, enter, new_context, open_view
from app_server import start_server, stop_server
from browser_checks import serious_faults

# Short runs, few points; a map whose boundary is known.
QUERY = "&map.scenario=fig05_push&map.duration=20&map.size=24&map.observable=largest_angle"


def open_map(page, query=QUERY):
    open_view(page, query, "map")


@contextmanager
def next_map(page):
    """Wait for the end of the map that something starts."""
    number = int(page.locator("[data-done]").get_attribute("data-done"))
    yield
    page.wait_for_selector(f"[data-done='{number + 1}']")


PIXELS = """() => {
  const { chart } = window.latolato.views.map;
  chart.lines = [];
  chart.cross = null;
  chart.draw();
  const context = chart.canvas.getContext("2d");
  const box = chart.canvas.getBoundingClientRect();
  const ratio = chart.canvas.width / box.width;
  const frame = chart.frame();
  const image = context.getImageData(frame.left, frame.top, frame.width, frame.height);
  return { frame, ratio, left: box.left, top: box.top, data: Array.from(image.data) };
}"""


def colours_of(values, low, high):
    """Return what matplotlib makes of values."""
    import matplotlib as mpl

    place = np.clip((values - low) / (high - low), 0.0, 1.0)
    return np.round(255 * mpl.colormaps["viridis"](place)[..., :3])


def check_colours(found):
    frame = found["frame"]
    pixels = np.array(found["data"]).reshape(frame["height"], frame["width"], 4)[..., :3]
    amplitudes, ratios = np.linspace(0.0, 0.5, 24), np.linspace(0.0, 5.0, 24)
    axes = {"drive_amplitude": amplitudes, "frequency_ratio": ratios}
    scenario = ll.load_scenario("fig05_push")
    angle = scenario.sweep(duration=20.0, axes=axes).largest_angle.values
    wanted = colours_of(angle, angle.min(), angle.max())
    # In chaos a change of gravity as small as rounding changes the colour too.
    moved = replace(scenario.system, gravity=9.8 * (1.0 + 1e-13))
    other = replace(scenario, system=moved).sweep(duration=20.0, axes=axes).largest_angle.values
    regular = np.abs(other - angle) < 1e-6
    assert regular.mean() > 0.9
    # Cells reach halfway to their neighbours, amounts not below zero.
    x_edges = np.concatenate([[0.0], 0.5 * (ratios[1:] + ratios[:-1]), [5.0 + 2.5 / 23]])
    y_edges = np.concatenate([[0.0], 0.5 * (amplitudes[1:] + amplitudes[:-1]), [0.5 + 0.25 / 23]])
    for i in range(24):
        for j in np.flatnonzero(regular[i]):
            middle_x = 0.5 * (x_edges[j] + x_edges[j + 1]) / x_edges[-1]
            middle_y = 0.5 * (y_edges[i] + y_edges[i + 1]) / y_edges[-1]
            column = int(middle_x * frame["width"])
            line = int((1.0 - middle_y) * frame["height"])  # the first line is the top
            # 64 colours are interpolated, and rounded twice.
            assert np.abs(pixels[line, column] - wanted[i, j]).max() <= 4, (i, j)
    # The border between two cells lies where the axis has it.
    row = int((1.0 - 0.5 * (y_edges[15] + y_edges[16]) / y_edges[-1]) * frame["height"])
    jump = int(np.argmax(np.abs(np.diff(wanted[15], axis=0)).max(axis=1)))
    border = x_edges[jump + 1] / x_edges[-1] * frame["width"]
    near = pixels[row, int(border) - 3 : int(border) + 4]
    place = int(border) - 3 + int(np.argmax(np.abs(np.diff(near, axis=0)).max(axis=1))) + 1
    assert abs(place - border) <= 1.0


def test_cells_have_their_colours_and_runs_where_the_axes_say(page):
    open_map(page)
    page.wait_for_selector("[data-runs='1']")
    found = page.evaluate(PIXELS)
    check_colours(found)
    # Keys move the cross, and show the run there.
    field = page.get_by_role("application")
    cross = "() => window.latolato.views.map.chart.cross"
    field.focus()
    page.evaluate("() => window.latolato.views.map.cursor.begin()")
    page.wait_for_selector("[data-runs='2']")
    before = page.evaluate(cross)
    for key in ("ArrowUp", "ArrowRight", "Enter"):
        field.press(key)
    page.wait_for_selector("[data-runs='3']")
    after = page.evaluate(cross)
    assert after[0] - before[0] == pytest.approx(5.0 / 23)
    assert after[1] - before[1] == pytest.approx(0.5 / 23)
    page.wait_for_function("() => location.search.includes('map.at=')")
    # A click on the cell in column 12 and row 18 from below.
    inner, ratio = found["frame"], found["ratio"]
    x = found["left"] + (inner["left"] + inner["width"] * 12.0 / 23.5) / ratio
    y = found["top"] + (inner["top"] + inner["height"] * (1.0 - 18.0 / 23.5)) / ratio
    page.mouse.click(x, y)
    page.wait_for_selector("[data-runs='4']")
    amplitude, number = 0.5 * 18 / 23, 5.0 * 12 / 23
    page.get_by_text(f"A₀ = {1e3 * amplitude:.4g} mm").first.wait_for()
    page.locator(".point").get_by_role("button", name="Pause").wait_for()
    assert page.get_by_role("img", name="angle [°]").count() == 1
    page.get_by_role("button", name="Open in Toy").click()
    page.wait_for_selector(".player [role=img]")
    page.wait_for_function("() => location.search.includes('view=toy')")
    page.get_by_text("More parameters", exact=True).click()
    # The computed value is in metres; nobody chose that unit.
    shown = page.get_by_label("driving amplitude A", exact=False).first
    assert float(shown.input_value()) == pytest.approx(1e3 * amplitude, rel=1e-5)
    frequency = page.get_by_label("angular driving frequency", exact=False).first.input_value()
    assert float(frequency) == pytest.approx(number * 9.8**0.5, rel=1e-5)


def test_a_box_is_computed_in_full_back_returns_and_an_axis_gets_logarithmic(page):
    open_map(page)
    frame = page.evaluate(PIXELS)
    inner, ratio = frame["frame"], frame["ratio"]

    def at(x, y):
        return (
            frame["left"] + (inner["left"] + x * inner["width"]) / ratio,
            frame["top"] + (inner["top"] + (1.0 - y) * inner["height"]) / ratio,
        )

    page.mouse.move(*at(0.25, 0.5))
    page.mouse.down()
    page.mouse.move(*at(0.4, 0.6))
    page.mouse.move(*at(0.75, 0.9))
    with next_map(page):
        page.mouse.up()
    grid = page.evaluate(
        """() => {
          const { grid } = window.latolato.views.map;
          return { x: Array.from(grid.x.values), y: Array.from(grid.y.values), done: grid.done };
        }"""
    )
    assert grid["done"] == 24 * 24
    assert len(grid["x"]) == 24
    x_end, y_end = 5.0 + 2.5 / 23, 0.5 + 0.25 / 23
    pixel = 1.5 / inner["width"]
    assert grid["x"][0] == pytest.approx(0.25 * x_end, abs=pixel * x_end)
    assert grid["x"][-1] == pytest.approx(0.75 * x_end, abs=pixel * x_end)
    assert grid["y"][0] == pytest.approx(0.5 * y_end, abs=2 * pixel * y_end)
    assert grid["y"][-1] == pytest.approx(0.9 * y_end, abs=2 * pixel * y_end)
    field = page.get_by_role("application")
    field.focus()
    # A move computes the new cells only.
    with next_map(page):
        field.press("Shift+ArrowRight")
    page.get_by_text(re.compile(rf"^576 points, {5 * 24} of them new")).wait_for()
    for _ in range(2):
        page.go_back()
    page.wait_for_function("() => window.latolato.views.map.grid.x.values[0] === 0")
    page.get_by_text("576 points", exact=True).wait_for()
    with next_map(page):
        page.get_by_label("logarithmic, upwards").check()
    found = page.evaluate(
        """() => {
          const { chart, grid } = window.latolato.views.map;
          const { top, height } = chart.frame();
          return { y: Array.from(grid.y.values), top, height, cross: chart.cross,
            places: Array.from(grid.y.values, y => chart.place(1, y)[1]),
            lift: window.latolato.views.map.over.lines.map(({ name }) => name) };
        }"""
    )
    np.testing.assert_allclose(found["y"], np.geomspace(0.005, 0.5, 24), rtol=1e-12)
    # Even on the screen, cells reach to the border.
    steps = -np.diff(found["places"])
    np.testing.assert_allclose(steps, found["height"] / 24, rtol=1e-9)
    assert found["lift"][:2] == ["tongue", "lift"]
    page.wait_for_function("() => location.search.includes('map.ylog=1')")
    # The arrow keys go by cells there too.
    field.focus()
    before = page.evaluate("() => window.latolato.views.map.chart.cross[1]")
    field.press("ArrowUp")
    after = page.evaluate("() => window.latolato.views.map.chart.cross[1]")
    assert after / before == pytest.approx(100 ** (1 / 23))
    page.get_by_text("Python and command line").click()
    assert "np.geomspace(0.005, 0.5, 24)" in page.locator("pre").first.inner_text()
    low = page.get_by_label("from", exact=True).nth(1)
    enter(low, "0")
    page.locator(".message").get_by_text("a logarithmic axis must begin above zero").wait_for()


def test_trials_and_contours_at_values_typed_by_hand_lie_where_they_belong(page, tmp_path):
    table = tmp_path / "trials.csv"
    table.write_text(
        "drive_amplitude,frequency_ratio,class\n"
        "100 mm,1.0,none\n200 mm,1.0,weak\n300 mm,1.0,strong\n"
    )
    open_map(page)
    page.get_by_text("Curves and trials").click()
    page.get_by_label("Trial table or curves").set_input_files(table)
    page.get_by_text("3 trials, 0 of them outside the map.").wait_for()
    found = page.evaluate(
        """() => {
          const { chart } = window.latolato.views.map;
          const { width, height } = chart.canvas;
          const context = new OffscreenCanvas(width, height).getContext("2d");
          context.drawImage(chart.canvas, 0, 0);
          const { data } = context.getImageData(0, 0, width, height);
          return [0.1, 0.2, 0.3].map(y => {
            const [px, py] = chart.place(1.0, y).map(Math.round);
            return Array.from(data.slice(4 * (py * width + px), 4 * (py * width + px) + 3));
          });
        }"""
    )
    assert found == [[0xF2, 0xA3, 0x1B], [0x0F, 0x96, 0x7C], [0x2B, 0x62, 0xC9]]
    bad = tmp_path / "bad.csv"
    bad.write_text("drive_amplitude,frequency_ratio,class\n100 mm,1.0,wild\n")
    page.get_by_label("Trial table or curves").set_input_files(bad)
    page.get_by_text("class must be 'none', 'weak' or 'strong', got 'wild'").wait_for()
    assert page.evaluate("() => window.latolato.views.map.chart.trials") is None
    # Contour lines run between the cells.
    page.get_by_label("Contour lines", exact=True).select_option("colours")
    levels = page.get_by_label("Contour lines at these values", exact=False)
    page.wait_for_function("() => window.latolato.views.map.chart.contours.length > 0")
    assert levels.get_attribute("placeholder") == "50, 100, 150"
    enter(levels, "45, 100 deg")
    page.wait_for_function("() => location.search.includes('map.levels=')")
    page.wait_for_function(
        "() => window.latolato.views.map.chart.contours.some(c => c.text === '100°')"
    )
    found = page.evaluate(
        """() => {
          const { chart, grid } = window.latolato.views.map;
          chart.lines = [];
          chart.draw();
          const context = chart.canvas.getContext("2d");
          const { width, height } = chart.canvas;
          const { data } = context.getImageData(0, 0, width, height);
          const longest = chart.contours.toSorted((a, b) => b.xs.length - a.xs.length)[0];
          const dark = Array.from(longest.xs, (x, i) => {
            const [px, py] = chart.place(x, longest.ys[i]).map(Math.floor);
            let least = 255;
            for (let r = py - 1; r <= py + 1; r += 1)
              for (let c = px - 1; c <= px + 1; c += 1)
                least = Math.min(least, Math.max(...data.slice(4 * (r * width + c),
                  4 * (r * width + c) + 3)));
            return least;
          });
          return { texts: [...new Set(chart.contours.map(c => c.text))], dark,
            level: longest.level, xs: Array.from(longest.xs), ys: Array.from(longest.ys),
            x: Array.from(grid.x.values), y: Array.from(grid.y.values),
            values: Array.from(grid.values[grid.variable("largest_angle")]) };
        }"""
    )
    assert sorted(found["texts"]) == ["100°", "45°"]
    # Its ink, beside its value, lies under every corner.
    assert np.mean(np.array(found["dark"]) < 60) > 0.8
    # Each corner is where the straight line between two points has the level.
    values = np.reshape(found["values"], (24, 24))
    column = np.interp(found["xs"], found["x"], np.arange(24.0))
    line = np.interp(found["ys"], found["y"], np.arange(24.0))
    left, low = np.minimum(column.astype(int), 22), np.minimum(line.astype(int), 22)
    a, b = column - left, line - low
    between = (1 - b) * ((1 - a) * values[low, left] + a * values[low, left + 1]) + b * (
        (1 - a) * values[low + 1, left] + a * values[low + 1, left + 1]
    )
    np.testing.assert_allclose(between, found["level"], rtol=1e-5)
    # The field explains levels that cannot be read, and the server is not asked.
    alert = page.get_by_role("alert")
    enter(levels, "45,,90")
    alert.get_by_text("“45,,90” is not a number in °.").wait_for()
    assert levels.get_attribute("aria-invalid") == "true"
    # The test fails where the console tells of a refusal.
    enter(levels, ",".join(map(str, range(10, 31))))
    page.get_by_text("At most 20 contour lines, got 21 levels").wait_for()
    enter(levels, "45, 90")
    page.wait_for_function("() => location.search.includes('map.levels=')")
    assert levels.get_attribute("aria-invalid") == "false"
    assert alert.filter(visible=True).count() == 0


def test_a_map_that_was_stopped_goes_on_and_is_stored_with_its_numbers(page, tmp_path):
    open_map(page, QUERY.replace("size=24", "size=8"))
    page.evaluate("() => window.latolato.views.map.controls.keep({ size: 64, duration: 60.5 })")
    page.wait_for_function(
        """() => {
          const { grid, run } = window.latolato.views.map;
          const isUnderWay = grid.width === 64 && run && grid.done > 500;
          const stop = [...document.querySelectorAll("button")].find(
            (button) => button.textContent === "Stop" && button.checkVisibility());
          if (isUnderWay) stop.click();  // at once: a fast machine would have ended before a mouse
          return isUnderWay;
        }"""
    )
    known = page.evaluate("() => window.latolato.views.map.grid.done")
    assert 500 < known < 4096
    page.get_by_text("Download", exact=True).click()
    path = download(page.get_by_role("button", name="CSV"), tmp_path)
    assert path.name == "latolato_map_fig05_push_64x64.unfinished.csv"
    part = ll.load(path)
    assert int((part.status == "missing").sum()) == 4096 - known
    with next_map(page):
        page.get_by_role("button", name="Go on").click()
    again = page.get_by_text(re.compile(r"^4096 points, \d+ of them new")).inner_text()
    assert int(again.split()[2]) <= 4096 - known
    shown = page.evaluate(
        """() => {
          const { grid } = window.latolato.views.map;
          return Array.from(grid.values[grid.variable("largest_angle")]);
        }"""
    )
    shown = np.array(shown).reshape(64, 64)
    whole = ll.load(download(page.get_by_role("button", name="CSV"), tmp_path))
    # Files hold degrees, whose last digit is rounded.
    np.testing.assert_allclose(whole.largest_angle.values, shown, rtol=1e-15)
    done = part.status.values != "missing"
    np.testing.assert_allclose(part.largest_angle.values[done], shown[done], rtol=1e-15)


def test_a_map_is_coarse_until_somebody_asks_for_all_points(page, tmp_path):
    open_map(page, "&map.scenario=fig05_push&map.duration=1&map.observable=largest_angle")
    done = "() => window.latolato.views.map.grid.done"
    assert page.evaluate(done) == 50 * 50
    page.get_by_text("Finer: 40000 points.").wait_for()
    page.get_by_text("Download", exact=True).click()
    csv, screen = (page.get_by_role("button", name=name) for name in ("CSV", "of the screen"))
    assert download(csv, tmp_path).name == "latolato_map_fig05_push_50x50.csv"
    assert download(screen, tmp_path).name == "latolato_map_fig05_push_screen.png"
    with next_map(page):
        page.get_by_role("button", name="Finer", exact=True).click()
    assert page.evaluate(done) == 200 * 200
    page.get_by_text("40000 points, 37500 of them new").wait_for()
    assert download(csv, tmp_path).name == "latolato_map_fig05_push_200x200.csv"
    # A link to this map names its points.
    page.wait_for_function("() => location.search.includes('map.size=200')")
    assert page.get_by_label("Points", exact=True).input_value() == "200"
    page.get_by_role("button", name="Compute again").wait_for()


def test_the_program_makes_files_with_progress_and_the_page_a_picture(page, tmp_path):
    open_map(page, f"{QUERY}&map.contours=colours&map.levels=1".replace("size=24", "size=8"))
    page.get_by_text("Download", exact=True).click()
    path = download(page.get_by_role("button", name="NetCDF"), tmp_path)
    axes = {"drive_amplitude": np.linspace(0.0, 0.5, 8), "frequency_ratio": np.linspace(0, 5, 8)}
    wanted = ll.load_scenario("fig05_push").sweep(duration=20.0, axes=axes)
    np.testing.assert_array_equal(ll.load(path).mean_energy, wanted.mean_energy)
    path = download(page.get_by_role("button", name="SVG"), tmp_path)
    assert "lift-off" in path.read_text()
    path = download(page.get_by_role("button", name="PNG of the screen"), tmp_path)
    import matplotlib.image

    image = matplotlib.image.imread(path)
    assert image.shape[0] > 300
    assert len(np.unique(image.reshape(-1, image.shape[2]), axis=0)) > 20


def test_the_picture_of_a_phone_cuts_no_text_off(page):
    page.set_viewport_size({"width": 390, "height": 844})
    open_map(page, "&map.scenario=fig05_push&map.duration=2&map.size=8&lang=id")
    texts = page.evaluate(
        """async () => {
          const texts = [];
          const { prototype } = CanvasRenderingContext2D;
          const { fillText } = prototype;
          prototype.fillText = function (text, x, y) {
            const { width, height } = this.canvas;
            const share = { center: 0.5, right: 0, end: 0 }[this.textAlign] ?? 1;
            texts.push([text, x + share * this.measureText(text).width, width, y, height]);
            fillText.call(this, text, x, y);
          };
          await window.latolato.views.map.picture();
          prototype.fillText = fillText;
          return texts;
        }"""
    )
    assert "dengan dorongan" in " ".join(text for text, *_ in texts)
    for text, right, width, y, height in texts:
        assert right <= width - 10, text
        assert y < height - 18, text


def test_a_new_question_pales_the_picture_until_it_has_its_own(page):
    open_map(page)
    page.wait_for_function("() => window.latolato.views.map.over.lines.length >= 2")
    place = """() => {
      const { chart, over } = window.latolato.views.map;
      const copy = new OffscreenCanvas(chart.canvas.width, chart.canvas.height);
      const context = copy.getContext("2d", { willReadFrequently: true });
      context.drawImage(chart.canvas, 0, 0);
      const [x, y] = chart.place(over.lines[0].xs[9], over.lines[0].ys[9]).map(Math.round);
      const pixel = (dx) => Array.from(context.getImageData(x + dx, y, 1, 1).data.slice(0, 3));
      return { line: pixel(0), cell: pixel(-12), isOld: chart.isOld,
        ys: Array.from(over.lines[1].ys), width: chart.grid.width };
    }"""
    before = page.evaluate(place)
    assert not before["isOld"]
    # Its points come when the test lets them.
    page.evaluate(
        """() => {
          const { controls, pool } = window.latolato.views.map;
          const begin = pool.begin.bind(pool);
          const held = new Promise((resolve) => { window.go = resolve; });
          pool.begin = async (job) => { await held; await begin(job); };
          controls.keep({ size: 400, duration: 3000, ylow: 0.2 });
        }"""
    )
    page.wait_for_function("() => window.latolato.views.map.pool.job")
    during = page.evaluate(place)
    assert during["isOld"]
    assert during["ys"] == before["ys"]
    assert during["width"] == 24
    for name in ("line", "cell"):
        # Towards the white of the card.
        assert sum(during[name]) > sum(before[name]) or sum(before[name]) > 700, name
    page.evaluate("() => window.go()")
    page.wait_for_function("() => window.latolato.views.map.grid.width === 400")
    after = page.evaluate(place)
    assert not after["isOld"]
    assert after["ys"] != before["ys"]
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("Stopped. The computed points stay.").wait_for()
    workers = "() => window.latolato.views.map.pool.members.filter((m) => m.batch).length"
    assert page.evaluate(workers) == 0


def test_energies_have_logarithmic_colours_and_the_picture_stays_below_the_longest_text(page):
    page.set_viewport_size({"width": 1366, "height": 768})
    open_map(page, QUERY.replace("largest_angle", "mean_energy").replace("size=24", "size=8"))
    look = "() => window.latolato.views.map.chart.look"
    assert page.evaluate(look)["log"]
    page.evaluate("() => window.latolato.views.map.controls.keep({ observable: 'crossings' })")
    assert page.evaluate(look)["scale"] == "viridis_r"
    page.get_by_label("logarithmic colours").evaluate("(e) => e.closest('details').open = true")
    darkest = page.get_by_role("textbox", name="darkest at")
    enter(darkest, "0")
    page.get_by_text("On a logarithmic scale this must be above 0.").wait_for()
    assert "map.low" not in page.evaluate("() => location.search")
    page.get_by_label("logarithmic colours").uncheck()
    assert not page.evaluate(look)["log"]
    page.wait_for_function("() => location.search.includes('map.log=0')")
    tops = page.evaluate(
        """() => ["", "25 %",
          "2500 runs in 8.1 s, 308 runs/s. Finer: 40000 in 2 min"].map((text) => {
          window.latolato.views.map.tools.showProgress(text);
          return document.querySelector(".map-field").getBoundingClientRect().top;
        })"""
    )
    assert tops[0] == tops[1] == tops[2]
    name = "Stability map of the colliding pair, with a push (Fig. 5)."
    assert page.locator(".source strong").inner_text() == name


def test_classes_have_a_legend_instead_of_a_bar(page):
    open_map(
        page,
        "&map.scenario=fig09&map.duration=30&map.transient=20&map.size=12"
        "&map.observable=motion_class",
    )
    for name in ("none", "weak", "strong"):
        page.get_by_role("listitem").get_by_text(name, exact=True).wait_for()
    assert page.get_by_role("img", name="Colour bar").count() == 0


# What does not vary over a map: the frequency does, as its ratio to the natural one.
FIXED = """() => {
  const { drive_frequency, ...fixed } = window.latolato.views.map.question.options;
  return fixed;
}"""


def test_a_fixed_parameter_changes_alone_and_the_address_says_of_which_map(page):
    open_map(page, "&map.duration=2&map.size=8")
    source = page.get_by_label("Map of")
    name, fixed = source.input_value(), page.evaluate(FIXED)
    page.get_by_text("Parameters that do not vary").click()
    changes = [("mass", "700", "mass", 0.7), ("coefficient of restitution", "0.8", "restitution",
               0.8), ("gravitational acceleration", "5", "gravity", 5.0)]  # fmt: skip
    for label, text, option, value in changes:
        field = page.locator(".form").get_by_label(label, exact=False).first
        with next_map(page):
            enter(field, text)
        fixed[option] = pytest.approx(value)
        assert (source.input_value(), page.evaluate(FIXED)) == (name, fixed)
        assert "map.scenario=fig05_push" in page.url
        assert field.evaluate("(input) => input === document.activeElement")
    # The link leads to the same map.
    page.goto(page.url)
    page.wait_for_selector("[data-done]")
    assert page.evaluate(FIXED) == fixed


REFUSED = [
    ("each run lasts", 0, "1e300", "“each run lasts” is too large to compute with, got 10³⁰⁰ s"),
    ("each run lasts", 0, "-3", "Each run must last longer than 0 s, got -3 s."),
    (
        "leave out",
        0,
        "300",
        "“leave out the first” must be shorter than “each run lasts” (2 s), got",
    ),
    ("leave out", 0, "-1", "“leave out the first” must be at least 0 s, got -1 s"),
    ("from", 1, "1e300", "the end must lie above the start, got 10³⁰⁰ mm"),
    ("to", 1, "-1", "the end must lie above the start, got 0 mm to -1 mm"),
]


def test_what_is_typed_is_read_or_refused_at_its_field_until_it_is_mended(page):
    open_map(page, "&map.scenario=fig05_push&map.duration=2&map.size=8")
    line = page.locator(".side").get_by_role("alert").filter(visible=True)
    for label, place, text, problem in REFUSED:
        field = page.get_by_label(label, exact=label != "leave out").nth(place)
        before = field.input_value()
        enter(field, text)
        line.get_by_text(problem).wait_for()
        assert line.count() == 1
        assert field.get_attribute("aria-invalid") == "true"
        assert field.get_attribute("aria-describedby") == line.get_attribute("id")
        page.locator(".message").get_by_text(problem).wait_for()
        with next_map(page):
            enter(field, before)
        assert line.count() == 0
        assert field.get_attribute("aria-invalid") == "false"
    low, high = (page.get_by_label(name, exact=True).nth(1) for name in ("from", "to"))
    # The line below a field explains what is no number, whatever else changes.
    border = "(e) => getComputedStyle(e).borderColor"
    usual = low.evaluate(border)
    low.fill("abc")
    low.press("Tab")
    line.get_by_text("“abc” is not a number").wait_for()
    assert low.evaluate(border) != usual
    box, told = low.bounding_box(), line.bounding_box()
    assert 0 <= told["y"] - (box["y"] + box["height"]) < 20
    with next_map(page):
        page.evaluate("() => window.latolato.views.map.controls.keep({ size: 9 })")
    assert line.is_visible()
    assert low.input_value() == "abc"
    ends = "() => [0, 8].map(i => window.latolato.views.map.grid.y.values[i])"
    # Both ends typed at once stay, and one just typed when the axis is made logarithmic.
    with next_map(page):
        low.fill("1 cm")
        enter(high, "20 cm")
    assert line.count() == 0
    assert page.evaluate(ends) == pytest.approx([0.01, 0.2])
    with next_map(page):
        low.fill("2 cm")
        page.get_by_label("logarithmic, upwards").click()
    values = page.evaluate("() => Array.from(window.latolato.views.map.grid.y.values)")
    np.testing.assert_allclose(values, np.geomspace(0.02, 0.2, 9), rtol=1e-12)
    page.wait_for_function("() => /map.ylog=1&map.ylow=0.02(&|$)/.test(location.search)")
    assert low.input_value() == "20"


def test_what_an_address_says_in_vain_is_told(page):
    small = QUERY.replace("size=24", "size=8")
    open_map(page, f"{small}&map.xlow=abc&map.levels=abc&map.ylow=0.1&map.xlog=1&map.sise=9")
    message = page.get_by_text("“map.levels=abc”, “map.sise=9”, “map.xlow=abc”.")
    message.wait_for()
    page.wait_for_function("() => !location.search.includes('abc')")
    # The others are about the axes on show.
    found = page.evaluate(
        """() => {
          const { grid } = window.latolato.views.map;
          return { log: grid.x.log, y: Array.from(grid.y.values) };
        }"""
    )
    assert found["log"]
    np.testing.assert_allclose(found["y"], np.linspace(0.1, 0.5, 8), rtol=1e-12)
    page.get_by_label("Scale").evaluate("(e) => { e.closest('details').open = true; }")
    page.get_by_label("Scale").select_option("magma")
    message.wait_for(state="hidden")
    page.goto(f"/?view=map{small.replace('size=8', 'size=501')}")
    alert = page.locator(".message")
    alert.get_by_text("a map has at most 250000 points, got 501 x 501").wait_for()
    points = page.get_by_label("Points", exact=True)
    assert points.input_value() == "501"
    assert "(251001)" in points.locator("option:checked").inner_text()
    points.select_option("25")
    page.wait_for_selector("[data-done]")
    assert alert.count() == 0
    assert points.locator("option").count() == 6  # the usual numbers, and a coarse map at first
    page.goto(f"/?view=map{QUERY}&map.xlow=5&map.xhigh=1")
    page.locator(".message").get_by_text("the end must lie above the start, got 5 to 1").wait_for()


def test_the_map_is_open_to_everybody(page):
    open_map(page)
    page.wait_for_selector("[data-runs]")
    for width, scheme in itertools.product((1280, 390), ("light", "dark")):
        page.set_viewport_size({"width": width, "height": 800})
        page.emulate_media(color_scheme=scheme)
        page.wait_for_timeout(300)
        assert page.evaluate("() => document.documentElement.scrollWidth") <= width
        assert serious_faults(page) == [], (width, scheme)


def test_a_map_of_the_command_line_is_shown(browser, tmp_path):
    axes = {"drive_amplitude": [0.1, 0.2, 0.4], "frequency_ratio": [1.0, 2.0, 4.0]}
    made = ll.load_scenario("fig05_push").sweep(
        axes=axes, duration=5.0, store=tmp_path / "own.zarr"
    )
    made.status[0, 1] = "missing"
    made.to_netcdf(tmp_path / "part.nc")
    files = [f"--open={tmp_path / name}" for name in ("own.zarr", "part.nc")]
    server = start_server(*files)
    context = new_context(browser, base_url=server.address)
    try:
        page = context.new_page()
        open_map(page, "&map.scenario=fig05_push&map.duration=5&map.size=8&map.contours=colours")
        with next_map(page):
            page.get_by_label("Map of").select_option("own.zarr")
        assert page.evaluate("() => Array.from(window.latolato.views.map.grid.y.values)") == [
            0.1,
            0.2,
            0.4,
        ]
        page.get_by_text("9 points", exact=True).wait_for()
        # Contour lines stay switched on.
        page.wait_for_function("() => window.latolato.views.map.chart.contours.length > 0")
        assert page.evaluate("() => window.latolato.views.map.controls.over.contours.select.value")
        assert "Drawn when" not in page.locator("body").inner_text()
        assert "map.contours=colours" in page.url
        # Those of what the next map does not have leave no word.
        page.evaluate("() => window.latolato.views.map.controls.keep({ contours: 'nothing' })")
        with next_map(page):
            page.get_by_label("Map of").select_option("part.nc")
        page.get_by_text("9 points, 1 of them not computed", exact=True).wait_for()
        over = "window.latolato.views.map.controls.over"
        assert page.evaluate(f"() => {over}.contourNote.textContent") == ""
        assert page.evaluate(f"() => {over}.levelBox.hidden")
    finally:
        context.close()
        stop_server(server)


def test_on_a_phone_what_a_file_is_stands_beside_its_button(page):
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto("/?view=map&map.scenario=fig05&map.size=4")
    page.get_by_text("Download", exact=True).click()
    entries = page.locator(".downloads li").all()
    assert len(entries) == 5
    for entry in entries:
        button, hint = (entry.locator(each).bounding_box() for each in ("button", "span"))
        assert hint["x"] >= button["x"] + button["width"]


# How many pixels names of axes need, beside the room for them and the arrow of the select.
NAMES = """() => [...document.querySelectorAll("details .preset select")].slice(0, 2).map(s => {
  const context = document.createElement("canvas").getContext("2d");
  const style = getComputedStyle(s);
  context.font = style.font;
  const room = s.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
  return [context.measureText(s.selectedOptions[0].text).width, room - 20];
})"""


@pytest.mark.parametrize("width, language", [(1366, "en"), (1366, "id"), (390, "id")])
def test_curves_and_names_fit_their_boxes(page, width, language):
    page.set_viewport_size({"width": width, "height": 768})
    open_map(page, f"&map.size=8&lang={language}")
    chart = page.locator(".preview .uplot")
    chart.wait_for()
    ends = "e => [e.getBoundingClientRect().right, e.parentElement.getBoundingClientRect().right]"
    chart_end, host_end = chart.evaluate(ends)
    assert chart_end <= host_end + 0.5
    names = page.evaluate(NAMES)
    assert len(names) == 2
    for needed, room in names:
        assert needed <= room
