"""Every preset, map, example, question and drive on the pages; opened by links, like a user's."""

import math

import pytest

import latolato as ll
from browser_checks import assert_panels_have_room
from latolato.analysis import analyses
from latolato.app.experiment.description import EXAMPLES
from latolato.physics.drives import drives

# How long a page may take to its end [ms].
PATIENCE = 300_000
# What is refused says so in one of these.
FAULTS = [".error", ".notice", ".message.bad"]
SWEEPS = [name for name, scenario in ll.scenarios().items() if scenario.varied]
RUNS = [name for name in ll.scenarios() if name not in SWEEPS]
# Mirrored balls and balls that differ; `tests/app/test_analyses.py` analyses a pendulum.
TOYS = ("toy", "ballpair_asymmetric")
# Of the 10,000 starts that pages offer, a few show as much.
FEWER = {"basins": "&analyse.angle_points=20&analyse.velocity_points=20"}
# What each example is there to show.
FITS = {"decay": "decay", "driven": "drive", "toy": "restitution"}
# Measured heights come with a table, not with a form.
TYPED_DRIVES = [name for name in drives if name != "measured_pivot"]


@pytest.fixture
def page(page):
    """A page as wide as a small laptop."""
    page.set_viewport_size({"width": 1366, "height": 768})
    return page


def faults(page):
    """Return the errors that are on show."""
    return [e.inner_text() for e in page.locator(", ".join(FAULTS)).all() if e.is_visible()]


def wait_for(page, end):
    """Wait for a page's end, or for what it says instead, which is a fault."""
    ends = [end, *(f"{fault}:visible" for fault in FAULTS)]
    page.wait_for_selector(", ".join(ends), timeout=PATIENCE)
    page.wait_for_load_state("networkidle")
    assert not faults(page)


# The ends of the axes of all pictures in Play.
ENDS = """() => {
  const { curves, more } = window.latolato.views.toy.player;
  return [more.plots.phase, more.plots.section, ...curves.charts, ...more.curves.charts]
    .flatMap(({ plot }) => [plot.scales.x, plot.scales.y]).map(({ min, max }) => [min, max]);
}"""


@pytest.mark.parametrize("scenario", RUNS)
def test_play(page, answer, scenario):
    page.goto(f"/?view=toy&scenario={scenario}")
    wait_for(page, "[data-runs]")
    page.get_by_text("Energy and more curves", exact=True).click()
    # Pictures come one after the other, the table of contacts last.
    page.wait_for_function("() => document.querySelector('.player .table-scroll')?.children.length")
    ends = page.evaluate(ENDS)
    assert len(ends) >= 10
    for low, high in ends:
        assert math.isfinite(high - low)
        assert high - low > 1e-6 * max(abs(low), abs(high))
    answer(f"{page.locator('main canvas:visible').count()} pictures")
    assert_panels_have_room(page)


@pytest.mark.parametrize("drive", TYPED_DRIVES)
def test_drive(page, answer, drive):
    registry = page.request.get("/registry.json").json()
    # A pivot that moves sideways breaks the mirror symmetry of a toy of one angle.
    scenario = "ballpair_asymmetric" if drive == "planar_harmonic" else "toy"
    link = f"/?view=toy&scenario={scenario}&drive={drive}&duration=10 s"
    for name in registry["drives"][drive]["options"]:
        option = registry["options"][name]
        if option["default"] is None:  # the form would begin with this
            usual = option["usual"] or option["low"] or 0.0
            link += f"&{name}={', '.join(map(str, usual)) if option['several'] else usual}"
    page.goto(link)
    wait_for(page, "[data-runs]")
    answer(f"{page.locator('main canvas:visible').count()} pictures")
    assert_panels_have_room(page)


@pytest.mark.parametrize("scenario", SWEEPS)
def test_map(page, answer, scenario):
    page.goto(f"/?view=map&map.scenario={scenario}&map.size=12")
    wait_for(page, "[data-done]")
    wait_for(page, "[data-runs]")
    answer(page.locator(".bar-title").inner_text())
    box = page.locator("canvas.map").bounding_box()
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.3 * box["height"])
    wait_for(page, "[data-runs='2']")
    assert page.locator(".message:visible").count() == 0
    assert page.get_by_role("button", name="Open in Toy").is_enabled()
    assert_panels_have_room(page)


@pytest.mark.parametrize("example", EXAMPLES)
def test_experiment(page, answer, example):
    page.goto(f"/?view=measure&measure.example={example}")
    fit = f"[data-fit={FITS[example]}]"
    page.wait_for_selector(f"{fit}, .error:visible", timeout=PATIENCE)
    page.wait_for_selector("[data-state=result]", timeout=PATIENCE)
    assert not faults(page)
    answer(page.locator(f"{fit} .hint").first.inner_text())
    assert_panels_have_room(page)


@pytest.mark.parametrize("scenario", TOYS)
@pytest.mark.parametrize("name", list(analyses))
def test_analysis(page, answer, name, scenario):
    fewer = FEWER.get(name, "")
    page.goto(f"/?view=analyse&scenario={scenario}&analyse.what={name}&analyse.ask=1{fewer}")
    page.wait_for_selector("[data-answers], .choice .error:visible", timeout=PATIENCE)
    # What does not suit the system is refused in a sentence.
    refused = page.locator(".choice .error:visible")
    if refused.count():
        answer(refused.inner_text())
    else:
        assert not faults(page)
        answer(page.locator(".numbers").inner_text())
    assert_panels_have_room(page)


# What each view shows when it has what it asks the server for; the others are opened above.
VIEWS = {"toy&toy.hand=1": "[data-ready]", "report": "h1", "measure": ".dropzone"}


@pytest.mark.parametrize("view", VIEWS)
def test_view(page, answer, view):
    page.goto(f"/?view={view}")
    wait_for(page, VIEWS[view])
    answer(page.locator("h1").first.inner_text())
    assert_panels_have_room(page)
