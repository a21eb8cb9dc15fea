"""A fit that only these tests know: its function and its picture are all that it takes."""

import json
import sys
from types import SimpleNamespace
from typing import Annotated

import numpy as np
import pytest
from typer.testing import CliRunner

import latolato as ll
from latolato.app.experiment.description import apparatus_of, described, fit_kinds
from latolato.app.experiment.fits import fit_of, fits_of
from latolato.cli.main import app
from latolato.experiment.fits import fits
from latolato.experiment.fits.registry import FitKind
from latolato.experiment.fits.result import Estimate, make_fit
from latolato.experiment.fits.samples import samples_of
from latolato.experiment.track_table import write_table
from latolato.figures import style
from latolato.figures.fits import draw_curve
from page_blocks import unpack
from track_tables import decay_table


def fit_rest(
    table,
    *,
    mass: float | None = None,
    ball: int = 1,
    start: Annotated[float | None, "s"] = None,
):
    """Return where a ball hangs on average.

    The mean of all samples.

    Parameters
    ----------
    table : xarray.Dataset
        A track table.
    mass : float, optional
        Mass of the ball [kg].
    ball : int
        Which ball of the table.
    start : float, optional
        First instant used [s].
    """
    data = samples_of(table, ball, start=start)
    sigma = float(np.std(data.values)) / len(data) ** 0.5
    mean = Estimate(float(np.mean(data.values)), sigma, "rad")
    curves = {
        "time": ("sample", data.times),
        "angle": ("sample", data.values),
        "angle_fit": ("sample", np.full(len(data), mean.value)),
    }
    verdict = f"It hangs at {mean}."
    return make_fit("rest", {"angle_offset": mean}, verdict, curves, {"mass": mass})


def draw(dataset):
    """Return measured angles and their mean."""
    figure, axes = style.new_figure(1, 1, height=2.0)
    draw_curve(axes[0, 0], dataset, "angle", "angle_fit")
    return figure


@pytest.fixture(autouse=True)
def own_fit(monkeypatch):
    """The fit is registered for one test, and its picture is where those of others are."""
    monkeypatch.setitem(fits._entries, "rest", FitKind(function=fit_rest, title="Where it hangs"))
    monkeypatch.setitem(sys.modules, "latolato.figures.fits.rest", SimpleNamespace(draw=draw))


@pytest.fixture
def table():
    return decay_table(length=0.363, mass=0.1, damping=0.003, duration=6.0)


def run(*arguments):
    """Standard output of the command line in this process."""
    result = CliRunner().invoke(app, [str(each) for each in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_it_has_a_command_with_the_options_of_its_function(table, tmp_path):
    path = write_table(table, tmp_path / "decay.csv")
    assert "Where a ball hangs on average" in run("fit")
    options = run("fit", "rest", "--help")
    assert "first instant used" in options
    assert "--mass" in options
    picture, stored = tmp_path / "rest.png", tmp_path / "rest.nc"
    arguments = ["--start", "500 ms", "--mass", "100 g", "--plot", picture, "--output", stored]
    summary = json.loads(run("fit", "rest", path, *arguments, "--json"))
    mean = fit_rest(table, start=0.5)["angle_offset"].value
    # The file holds nine digits of an angle.
    assert summary["values"]["angle_offset"]["value"] == pytest.approx(mean, abs=1e-8)
    assert summary["attributes"]["mass"] == 0.1
    assert summary["files"] == [str(stored), str(picture)]
    assert len(ll.plot(ll.load(stored)).axes) == 1
    assert "It hangs at" in run("fit", "rest", path)


def test_a_page_offers_it_and_lays_its_curve_over_the_film(table):
    assert "Where it hangs" in [kind["title"] for kind in fit_kinds()]
    description = described({"mass": "100 g"})
    cards, _ = fits_of(table, description, (320, 240))
    assert cards["rest"]["verdict"].startswith("It hangs at")
    card, model = fit_of("rest", table, description, (320, 240))
    assert card["values"]["angle_offset"]["label"]
    assert "play" not in card  # it names no system
    about, motion = unpack(model["model"].tobytes())
    assert about["kind"] == "rest"
    assert np.nanstd(motion["angle"]) == 0.0


def test_it_is_handed_what_is_known_of_the_apparatus_and_no_more(table):
    apparatus = apparatus_of(described({"mass": "100 g", "length": "40 cm"}), table)
    fit = fits["rest"].fit(table, apparatus)
    assert fit.dataset.attrs["mass"] == 0.1
    assert fit.system is None
