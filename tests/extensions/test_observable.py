"""An observable that a user brings: the example of `latolato/observables/base.py`."""

import json
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from typer.testing import CliRunner

import latolato as ll
from latolato.app.forms import registry
from latolato.cli.main import app as command_line
from latolato.core.quantities import Quantity, Range, quantity_field
from latolato.core.scalar import formula
from latolato.io.files import load
from latolato.observables import Observable, observables
from map_in_node import views_in_node


@formula
def _step(acc, i, n, segment):
    acc[i + n] += max(segment.t1 - segment.t0, 0.0) if segment.x1 > acc[i] else 0.0


@dataclass(frozen=True, kw_only=True)
class TimeAbove(Observable):
    """Time above an angle."""

    variables: ClassVar = {"time_above": Quantity("s", "t_a", "time above an angle")}
    step: ClassVar = staticmethod(_step)

    angle: float = quantity_field("initial_angle", Range(), default=0.1)


PENDULUM = ll.Pendulum(length=1.0, mass=0.8)
ANGLES = [0.2, 0.3]
OPTIONS = {"axes": {"initial_angle": ANGLES}, "duration": 60.0, "tolerance": 1e-9}


@pytest.fixture(autouse=True)
def known(monkeypatch, forget):
    """Only these tests know the observable."""
    monkeypatch.setattr(observables, "_entries", dict(observables))
    observables.register("time_above")(TimeAbove)
    forget()


def expected(angle):
    """Return how long a small swing from an angle is above 0.1 rad in a minute [s]."""
    return 60.0 * np.arccos(0.1 / angle) / np.pi


@pytest.mark.parametrize("executor", ["threads", "reference"])
def test_a_sweep_gathers_it_by_name(executor):
    grid = ll.sweep(PENDULUM, observables=["time_above"], executor=executor, **OPTIONS)
    assert grid.time_above.attrs["units"] == "s"
    for angle, time in zip(ANGLES, grid.time_above.values, strict=True):
        # It counts whole steps, some 2 % of a swing, in 30 swings whose last is cut.
        assert time == pytest.approx(expected(angle), abs=1.0)
    higher = ll.sweep(PENDULUM, observables=[TimeAbove(angle=0.25)], executor=executor, **OPTIONS)
    assert higher.time_above.values[0] == 0.0 < higher.time_above.values[1]


def test_the_command_line_gathers_it_and_draws_its_map(tmp_path):
    words = "--system pendulum --length 1 --mass 0.8 --duration 60 --axis initial_angle=0.2:0.3:2"
    targets = ["--output", str(tmp_path / "a.nc"), "--plot", str(tmp_path / "a.png")]
    own = ["--observable", "time_above(angle = 0.25 rad)", "--json"]
    result = CliRunner().invoke(command_line, ["sweep", *words.split(), *own, *targets])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)
    assert load(tmp_path / "a.nc").time_above.values[0] == 0.0
    assert (tmp_path / "a.png").exists()


def test_the_app_says_which_command_computes_its_map():
    assert registry()["observables"]["time_above"]["description"] == "Time above an angle."
    request = {"scenario": "fig02", "observable": "time_above"}
    (page,) = views_in_node([{"planned": True, "request": request}])
    assert page["error"] == (
        "a map with the observable time_above is computed by the installed program: run "
        "`latolato sweep` and open its file with `latolato app --open`"
    )
