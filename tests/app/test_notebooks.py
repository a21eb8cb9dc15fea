"""The player in a real JupyterLab and in a real marimo, without a network."""

from __future__ import annotations

import base64
import math

import pytest

import latolato as ll
from latolato.app.widget import bundle, modules
from notebooks import (
    RUN,
    balls,
    expected_balls,
    in_player,
    jupyter,
    jupyter_export,
    marimo,
    marimo_export,
    offline_page,
    shown_time,
)

# Keys that delete, add, cut, select and run cells in the notebooks' command modes.
DANGEROUS = ("a", "x", "d", "d", "m", "ArrowDown", "Enter")
PLACES = ("canvas.scene", "button.play", "select", ".scrub", ".chart", ".knobs input[type=text]")


def run_from(**start):
    toy = ll.LatoLato(length=0.2, mass=0.05, radius=0.02, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0)
    return ll.simulate(toy, drive, **start)


@pytest.fixture(scope="module")
def run():
    return run_from(initial_angle=0.5, duration=3.0)


def player(page, which=0):
    """Wait for a player and its curves."""
    page.get_by_role("button", name="Play", exact=True).nth(which).wait_for()
    more = page.locator(".inset .more-curves").nth(which)
    more.evaluate("more => { more.open = true; }")
    more.locator(".ledger-row").first.wait_for()
    return page.locator(".inset").nth(which)


def check_balls(page, run, which=0):
    """Compare the pixels of the balls with the run at instants that the slider reaches exactly."""
    scrub = page.locator(".inset .scrub").nth(which)
    scrub.focus()
    for key, share in (("Home", 0.0), ("PageUp", 0.1), ("PageUp", 0.2), ("End", 1.0)):
        scrub.press(key)
        time = share * float(run.time[-1])
        assert shown_time(page, which) == pytest.approx(time, abs=0.0051)
        seen = balls(page, which)
        wanted = expected_balls(run, time, seen["width"], seen["height"])
        for name, (x, y) in wanted.items():
            u, v = seen[name]
            assert math.hypot(u - x, v - y) < 2.0, (name, time, seen, wanted)


def check_play(page):
    """Play and pause by the keyboard after a click on the picture."""
    page.locator(".inset canvas.scene").first.click()
    page.keyboard.press("Home")
    before = shown_time(page)
    page.keyboard.press(" ")
    page.get_by_role("button", name="Pause").first.wait_for()
    page.wait_for_timeout(400)
    page.keyboard.press(" ")
    page.get_by_role("button", name="Play", exact=True).first.wait_for()
    assert shown_time(page) != before


def check_keys(page, cells):
    """Press keys in all parts of the player: the notebook must keep its cells."""
    count = page.locator(cells).count()
    for place in PLACES:
        page.locator(f".inset {place}").first.click()
        for key in DANGEROUS:
            page.keyboard.press(key)
        assert page.locator(cells).count() == count, place
        inside = in_player(page, 0, "root.activeElement !== null")
        assert inside, f"the focus left {place}"
    page.keyboard.press("Escape")
    # Letters are no value of a field.
    page.locator(".inset .error:visible").wait_for()
    page.get_by_role("button", name="Back to the run of this cell").click()
    page.locator(".inset .error:visible").wait_for(state="detached")


def theme(page, which=0):
    return in_player(page, which, "root.host.dataset.theme")


def command(page, name, **options):
    """Do what a menu entry of JupyterLab does."""
    page.evaluate(
        "async ([name, options]) => { await jupyterapp.commands.execute(name, options); }",
        [name, options],
    )


@pytest.mark.slow
def test_jupyterlab_shows_a_player_that_plays(browser, run, tmp_path):
    first = f"import latolato as ll\n{RUN}\nwidget = ll.play(run)\nwidget"
    second = "widget.run = ll.simulate(toy, drive, initial_angle=1.0, duration=7.0)"
    with (
        jupyter(tmp_path, [first, second, "1 + 1"]) as address,
        offline_page(browser, color_scheme="light") as page,
    ):
        page.goto(address)
        page.locator(".jp-Notebook .jp-Cell").first.click()
        page.locator(".jp-Notebook-ExecutionIndicator[data-status=idle]").wait_for()
        command(page, "notebook:run-cell")
        player(page)
        check_balls(page, run)
        check_play(page)
        check_keys(page, ".jp-Notebook .jp-Cell")

        assert theme(page) == "light"
        command(page, "apputils:change-theme", theme="JupyterLab Dark")
        page.locator("body[data-jp-theme-light=false]").wait_for(state="attached")
        assert theme(page) == "dark"
        check_balls(page, run)

        check_fields(page)

        # Another run in the same place.
        page.locator(".jp-InputArea-editor").nth(1).click()
        command(page, "notebook:run-cell")
        other = run_from(initial_angle=1.0, duration=7.0)
        page.locator(".inset tbody tr").nth(other.sizes["contact"] - 1).wait_for()
        check_balls(page, other)

        # The view that a second run of the cell replaces leaves nothing behind.
        page.locator(".inset canvas.scene").click()
        page.keyboard.press(" ")
        page.get_by_role("button", name="Pause").wait_for()
        before = page.evaluate("() => counted.listeners")
        page.locator(".jp-InputArea-editor").first.click()
        command(page, "notebook:run-cell")
        page.get_by_role("button", name="Pause").wait_for(state="detached")
        player(page)
        page.wait_for_timeout(300)
        frames = page.evaluate("() => counted.frames")
        page.wait_for_timeout(500)
        assert page.evaluate("() => counted.frames") - frames < 10
        assert page.evaluate("() => counted.listeners") <= before


@pytest.mark.slow
def test_marimo_shows_a_player_that_plays(browser, run, tmp_path):
    with (
        marimo(tmp_path, "edit", ["ll.play(run)", "1 + 1"]) as address,
        offline_page(browser, color_scheme="dark") as page,
    ):
        page.goto(address)
        player(page)
        check_balls(page, run)
        check_play(page)
        check_keys(page, ".marimo-cell")
        assert theme(page) == "dark"
        page.emulate_media(color_scheme="light")
        page.locator("body.light").wait_for(state="attached")
        assert theme(page) == "light"
        check_balls(page, run)
        check_fields(page)


@pytest.mark.slow
def test_a_marimo_application_shows_a_player_that_was_hidden_at_first(browser, run, tmp_path):
    cells = ['mo.ui.tabs({"text": mo.md("first"), "player": ll.play(run)})', "ll.play(run)"]
    with (
        marimo(tmp_path, "run", cells) as address,
        offline_page(browser, color_scheme="light") as page,
    ):
        page.goto(address)
        page.get_by_role("tab", name="player").click()
        player(page, 1)
        for which in (0, 1):
            check_balls(page, run, which)


def check_fields(page):
    """Move a slider: the page computes the run that Python would, without a kernel."""
    slider = page.get_by_label("Bounciness, slider")
    slider.focus()
    slider.press("ArrowLeft")
    page.get_by_text("restitution=0.89").wait_for(state="attached")
    toy = ll.LatoLato(length=0.2, mass=0.05, radius=0.02, restitution=0.89)
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0)
    wanted = ll.simulate(toy, drive, initial_angle=0.5, duration=3.0)
    check_balls(page, wanted)
    times = page.locator(".inset tbody tr td:first-child").all_inner_texts()
    assert [float(time) for time in times] == pytest.approx(wanted["contact_time"].values, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("tool", ["jupyter", "marimo"])
def test_fields_of_an_exported_page_need_no_kernel(browser, run, tmp_path, tool):
    if tool == "jupyter":
        file = jupyter_export(tmp_path, f"import latolato as ll\n{RUN}\nll.play(run)")
    else:
        file = marimo_export(tmp_path, ["ll.play(run)"])
    with offline_page(browser, color_scheme="light") as page:
        page.goto(file.as_uri())
        player(page)
        check_balls(page, run)
        check_fields(page)


@pytest.mark.slow
def test_an_export_without_widgets_shows_the_picture(run):
    import nbconvert
    import nbformat

    data, _ = ll.play(run)._repr_mimebundle_()
    node = nbformat.v4.new_notebook()
    output = nbformat.v4.new_output("execute_result", data=data, execution_count=1)
    node.cells = [nbformat.v4.new_code_cell("ll.play(run)", outputs=[output])]
    html, _ = nbconvert.HTMLExporter().from_notebook_node(node)
    assert f'src="data:image/png;base64,{data["image/png"][:40]}' in html


def test_the_modules_of_many_widgets_run_once_in_a_page(browser, run):
    page = browser.new_page()
    page.set_content("<body></body>")
    made = page.evaluate(
        """async ([source, block]) => {
          let made = 0;
          const make = URL.createObjectURL;
          URL.createObjectURL = (blob) => { made += 1; return make(blob); };
          const bytes = Uint8Array.from(atob(block), (c) => c.charCodeAt(0));
          const values = { block: new DataView(bytes.buffer), language: "", texts: "" };
          const model = { get: (name) => values[name], on() {}, off() {} };
          const counts = [];
          for (let i = 0; i < 2; i += 1) {
            const url = make(new Blob([source], { type: "text/javascript" }));
            const { default: widget } = await import(url);
            await widget.render({ model, el: document.body });
            counts.push(made);
          }
          return counts;
        }""",
        [bundle(), base64.b64encode(ll.play(run).block).decode()],
    )
    page.close()
    assert made == [len(modules())] * 2
