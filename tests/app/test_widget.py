"""The player in a notebook is the player of the application."""

import base64
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import latolato as ll
from app_pages import enter
from latolato.app.widget import bundle, modules
from page_blocks import unpack

# What anywidget is to a widget: a model that holds its values.
PAGE = """async ({ source, block, language, texts }) => {
  const bytes = Uint8Array.from(atob(block), (c) => c.charCodeAt(0));
  const values = { block: new DataView(bytes.buffer), language, texts };
  const model = { get: (name) => values[name], on() {}, off() {} };
  const url = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
  const { default: widget } = await import(url);
  document.body.replaceChildren();
  const cell = document.createElement("div");
  document.body.append(cell);
  window.end = await widget.render({ model, el: cell });
  window.inside = cell.firstChild.shadowRoot;
  await new Promise((resolve) => setTimeout(resolve, 300));
}"""


@pytest.fixture(scope="module")
def run():
    toy = ll.LatoLato(length=0.2, mass=0.05, radius=0.02, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0)
    return ll.simulate(toy, drive, initial_angle=0.5, duration=3.0)


def show(page, widget):
    """Show a widget on a page as anywidget would."""
    block = base64.b64encode(widget.block).decode()
    given = {"block": block, "language": widget.language, "texts": widget.texts}
    page.evaluate(PAGE, {"source": bundle(), **given})


@pytest.fixture
def cell(browser):
    """A page that shows widgets; what goes wrong on it fails the test."""
    page = browser.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.set_content("<body></body>")
    yield page
    page.close()
    assert not faults


def test_the_widget_holds_the_run(run):
    widget = ll.play(run)
    about, arrays = unpack(widget.block)
    np.testing.assert_array_equal(arrays["time"], run["time"].values)
    np.testing.assert_array_equal(arrays["angle"][0], run["angle"].values.astype(np.float32))
    assert about["options"]["length"] == 0.2


def test_another_run_takes_the_place_of_the_first(run):
    widget = ll.play(run)
    other = ll.load_scenario("toy").simulate(duration=1.0)
    widget.run = other
    assert widget.run is other
    np.testing.assert_array_equal(unpack(widget.block)[1]["time"], other["time"].values)
    with pytest.raises(ValueError, match="play needs a run"):
        widget.run = run.drop_vars("angle")
    assert widget.run is other
    with pytest.raises(ValueError, match="play needs a run"):
        ll.play(run.drop_vars("angle"))


def test_the_page_on_notebooks_runs_as_printed():
    page = Path(__file__).parents[2] / "docs" / "how-to" / "notebooks.md"
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    names: dict[str, Any] = {}
    exec("".join(blocks), names)
    names["frequency"].value = 18.0
    assert names["player"].run.attrs["drive_frequency"] == 18.0


def test_places_without_widgets_get_a_picture_of_the_run_on_show(run):
    widget = ll.play(run)
    first, _ = widget._repr_mimebundle_()
    assert base64.b64decode(first["image/png"]).startswith(b"\x89PNG")
    assert first["application/vnd.jupyter.widget-view+json"]["model_id"] == widget.model_id
    widget.run = ll.load_scenario("toy").simulate(duration=1.0)
    second, _ = widget._repr_mimebundle_()
    assert first["image/png"] != second["image/png"]


def test_notebooks_need_no_package_of_the_application(tmp_path):
    code = """
import sys
import tomllib
from importlib.util import find_spec

extras = tomllib.load(open(sys.argv[1], "rb"))["project"]["optional-dependencies"]
needs = [need for need in extras["app"] if not need.startswith("latolato[")]
names = [need.partition(">=")[0].replace("-", "_") for need in needs]
assert all(map(find_spec, names)), names
sys.modules.update(dict.fromkeys(names))  # as if they were not installed
import latolato as ll

run = ll.simulate(ll.Pendulum(length=0.9, mass=0.5), initial_angle=0.5, duration=1.0)
assert ll.play(run).block
"""
    project = Path(__file__).parents[2] / "pyproject.toml"
    subprocess.run([sys.executable, "-c", code, str(project)], check=True)


def test_a_file_is_played_like_the_run_that_it_holds(run, tmp_path):
    path = tmp_path / "run.nc"
    ll.save(run, path)
    loaded = ll.play(ll.load(path))
    np.testing.assert_array_equal(
        unpack(loaded.block)[1]["angle"], unpack(ll.play(run).block)[1]["angle"]
    )


def test_every_module_of_the_program_comes_after_those_that_it_names():
    known: set[str] = set()
    for path, source in modules():
        assert set(re.findall(r'"latolato:(.+?)"', source)) <= known, path
        known.add(path)
    assert {"js/notebook.js", "js/model/run_worker.js", "js/kernels/run.js"} <= known


def test_the_program_holds_all_that_it_names():
    for path, source in modules():
        assert not re.search(r'(from |import\(|URL\()"\.', source), path
        assert "import.meta" not in source, path
    assert bundle().count("\nexport ") == 1


def test_a_cell_carries_less_than_a_megabyte():
    assert len(bundle()) < 300_000


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_cell_shows_balls_where_the_run_has_them(browser, run, scheme):
    widget = ll.play(run)
    context = browser.new_context(color_scheme=scheme, viewport={"width": 1000, "height": 800})
    page = context.new_page()
    faults: list[str] = []
    requests: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda m: faults.append(m.text) if m.type == "error" else None)
    page.on("request", lambda r: requests.append(r.url))
    page.set_content("<body></body>")
    show(page, widget)
    page.get_by_role("button", name="Play", exact=True).wait_for()
    found = page.evaluate(
        """() => {
          const canvas = window.inside.querySelector("canvas.scene");
          const pixels = canvas.getContext("2d")
            .getImageData(0, 0, canvas.width, canvas.height).data;
          const seen = { right: [0, 0, 0], left: [0, 0, 0] };
          const style = getComputedStyle(canvas);
          const wanted = {};
          for (const name of ["right", "left"]) {
            const hex = style.getPropertyValue(`--${name}`).trim();
            wanted[name] = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
          }
          for (let i = 0; i < pixels.length; i += 4)
            for (const name of ["right", "left"])
              if (pixels[i + 3] === 255
                && wanted[name].every((v, k) => Math.abs(v - pixels[i + k]) < 4)) {
                seen[name][0] += 1;
                seen[name][1] += (i / 4) % canvas.width;
                seen[name][2] += Math.floor(i / 4 / canvas.width);
              }
          return { seen, width: canvas.width };
        }"""
    )
    (n, x, y), (m, u, v) = found["seen"]["right"], found["seen"]["left"]
    assert n > 100
    assert m > 100
    middle = 0.5 * found["width"]
    assert math.isclose(x / n - middle, middle - u / m, abs_tol=2.0)
    assert math.isclose(y / n, v / m, abs_tol=2.0)
    assert x / n > middle
    assert not faults
    assert [url for url in requests if not url.startswith("blob:")] == []
    page.evaluate("() => window.end()")
    context.close()


def test_the_theme_is_that_of_the_page_around(browser, run):
    widget = ll.play(run)
    page = browser.new_page()
    page.set_content("<body></body>")
    show(page, widget)
    found = page.evaluate(
        """async () => {
          const { body } = document;
          const { host } = window.inside;
          const seen = async () => {
            await new Promise((resolve) => setTimeout(resolve));
            return host.dataset.theme;
          };
          const found = {};
          found.plain = await seen();
          // As in JupyterLab, as in VS Code, as in pages that only have light text.
          body.dataset.jpThemeLight = "false";
          found.jupyter = await seen();
          delete body.dataset.jpThemeLight;
          body.className = "vscode-light";
          found.light = await seen();
          body.className = "vscode-dark";
          found.dark = await seen();
          body.className = "vscode-high-contrast";
          body.style.color = "oklch(0.95 0.01 90)";
          found.contrast = await seen();
          body.style.color = "color(srgb 0.1 0.1 0.2)";
          found.text = await seen();
          return found;
        }"""
    )
    page.close()
    assert found == {
        "plain": "light",
        "jupyter": "dark",
        "light": "light",
        "dark": "dark",
        "contrast": "dark",
        "text": "light",
    }


def test_a_slider_computes_the_run_of_python_in_the_page(cell, run):
    show(cell, ll.play(run))
    slider = cell.get_by_label("Bounciness, slider")
    slider.focus()
    slider.press("ArrowLeft")
    cell.get_by_text("restitution=0.89").wait_for(state="attached")
    toy = ll.LatoLato(length=0.2, mass=0.05, radius=0.02, restitution=0.89)
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0)
    check_shown(cell, ll.simulate(toy, drive, initial_angle=0.5, duration=3.0))
    cell.get_by_role("button", name="Back to the run of this cell").click()
    check_shown(cell, run)


def test_keys_on_the_animation_of_a_cell_choose_where_its_run_starts(cell, run):
    show(cell, ll.play(run))
    stage = cell.get_by_role("application")
    stage.focus()
    stage.press("ArrowRight")
    cell.get_by_text("The balls start at 33.6 degrees.").wait_for(state="attached")
    toy = ll.LatoLato(length=0.2, mass=0.05, radius=0.02, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0)
    check_shown(cell, ll.simulate(toy, drive, initial_angle=math.radians(33.6), duration=3.0))
    cell.get_by_role("button", name="Back to the run of this cell").click()
    check_shown(cell, run)


def check_shown(cell, run):
    """Compare the table of contacts in a cell with a run."""
    cell.locator(".more-curves").evaluate("more => { more.open = true; }")
    rows = cell.locator("table tbody tr")
    # Two runs may have equally many contacts, and the table follows some pictures later.
    cell.wait_for_function(
        """({ count, last }) => {
          const rows = window.inside.querySelectorAll(".table-scroll tbody tr");
          const time = Number(rows[rows.length - 1]?.querySelector("td").textContent);
          return rows.length === count && Math.abs(time - last) < 1e-5 * last;
        }""",
        arg={"count": run.sizes["contact"], "last": float(run["contact_time"][-1])},
    )
    for k in range(run.sizes["contact"]):
        at, kind, before, after = rows.nth(k).locator("td").all_inner_texts()
        assert float(at) == pytest.approx(float(run["contact_time"][k]), rel=1e-5)
        assert kind == str(run["contact_kind"][k].values)
        assert float(before) == pytest.approx(float(run["angular_velocity_before"][k]), rel=1e-3)
        assert float(after) == pytest.approx(float(run["angular_velocity_after"][k]), rel=1e-3)


@pytest.mark.parametrize("name", ["fig12", "ballpair_asymmetric", "crank_slider", "fig02_mathieu"])
def test_every_kind_of_run_has_its_knobs(cell, name):
    run = ll.load_scenario(name).simulate(duration=2.0)
    show(cell, ll.play(run))
    knobs = cell.locator(".knobs .knob")
    assert knobs.count() == 3
    back = cell.get_by_role("button", name="Back to the run of this cell")
    assert back.is_disabled()
    knobs.first.locator("input[type=range]").press("ArrowRight")
    back.and_(cell.locator(":enabled")).wait_for()
    cell.get_by_role("application").press("ArrowRight")
    cell.get_by_text("initial_angle").first.wait_for(state="attached")
    cell.wait_for_timeout(500)
    assert cell.locator(".error:visible").all_inner_texts() == []


def test_a_bad_value_is_explained_next_to_its_knob(cell, run):
    show(cell, ll.play(run))
    field = cell.get_by_role("textbox", name="Bounciness")
    enter(field, "2")
    cell.locator(".knobs").get_by_text("must be between 0 and 1").wait_for()
    assert field.get_attribute("aria-invalid") == "true"
    # It stays while another knob is moved, until the cell's own run is asked for.
    cell.locator(".knobs input[type=range]").first.press("ArrowRight")
    cell.get_by_role("button", name="Back to the run of this cell").click()
    cell.locator(".knobs .error:visible").wait_for(state="detached")
    assert float(field.input_value()) == run.attrs["restitution"]


def test_a_run_that_ends_before_its_time_says_so(cell):
    toy = ll.LatoLato(length=0.2, mass=0.05, radius=0.02)
    run = ll.simulate(toy, initial_angle=0.5, duration=4, contact_limit=20)
    show(cell, ll.play(run))
    field = cell.get_by_role("textbox", name="Bounciness")
    assert cell.get_by_text("Note:").count() == 0
    enter(field, "0.5")
    cell.get_by_text("Note: the run stopped at t = ").wait_for()
    cell.get_by_role("button", name="Back to the run of this cell").click()
    assert cell.get_by_text("Note:").count() == 0


def test_a_run_that_pages_cannot_compute_has_no_knobs_and_says_why(cell):
    heights = 0.01 * np.sin(np.linspace(0.0, 12.0, 50)) ** 2
    drive = ll.MeasuredPivot(times=np.linspace(0.0, 2.0, 50), pivot_heights=heights)
    pendulum = ll.Pendulum(length=1.0, mass=0.5)
    show(cell, ll.play(ll.simulate(pendulum, drive, initial_angle=0.3, duration=2.0)))
    cell.get_by_text("pages do not have its law “measured_pivot”").wait_for()
    assert cell.locator(".knobs").count() == 0
    cell.get_by_role("button", name="Play", exact=True).wait_for()


@pytest.mark.parametrize("policy", ["worker-src 'none'", "worker-src blob:"])
def test_a_page_that_allows_no_workers_computes_by_itself(browser, run, policy):
    page = browser.new_page()
    workers: list[str] = []
    page.on("worker", lambda worker: workers.append(worker.url))
    page.set_content(f'<meta http-equiv="Content-Security-Policy" content="{policy}"><body></body>')
    show(page, ll.play(run))
    # A worker that is still loading stays when a newer run is wanted.
    for _ in range(4):
        page.get_by_label("How far the hand moves, slider").press("ArrowRight")
        page.wait_for_timeout(100)
    page.get_by_text("drive_amplitude=0.024").wait_for(state="attached")
    assert len(workers) == ("blob" in policy)
    page.close()


def test_a_cell_speaks_the_language_it_is_given(cell, run):
    show(cell, ll.play(run, language="id"))
    cell.get_by_role("button", name="Putar", exact=True).wait_for()
    cell.get_by_role("textbox", name="Daya pantul").wait_for(state="attached")
    with pytest.raises(ValueError, match=r"language must be one of en, id, got 'xx'"):
        ll.play(run, language="xx")
