"""Whether a run of JavaScript is Python's run, as far as rounding lets it be."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from latolato.app.run_request import RunRequest

# See `tests/numerics/test_wasm.py`: what rounding does is judged by shifts of gravity. One as small
# as rounding moves the instants at which a ball comes to rest, which a larger one may leave alone.
SHIFTS, FACTOR, CLOSE, REGULAR = (1e-13, 4e-16, -4e-16), 4.0, 1e-12, 1e-11


def in_python(name: str | None, options: dict[str, Any], gravity: float = 1.0) -> Any:
    """The run in Python, or its refusal; gravity is changed by a factor."""
    scenario = RunRequest(name, options).to_scenario()
    if gravity != 1.0:
        known = scenario.to_dict()["system"]["gravity"]
        scenario = RunRequest(name, {**options, "gravity": known * gravity}).to_scenario()
    return scenario.record()


def check_same(run: Any, answer: Any, name: str | None, options: dict[str, Any]) -> None:
    """Check that columns agree as far as rounding lets them, and contacts while it is regular."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        others = [in_python(name, options, 1.0 + shift) for shift in SHIFTS]
    about = (name, options)
    columns = [
        each
        for each in run.variables
        if not each.startswith(("contact", "angular_velocity_", "radial_velocity_"))
    ]
    assert set(answer["units"]) >= {*columns, "contact_time"}, about
    time = run["time"]
    assert np.array_equal(answer["time"], time), about
    regular = _moved(run, others, "angle").max(axis=0) < REGULAR
    assert regular[0]
    for each in columns:
        here, there = np.atleast_2d(run[each]), np.atleast_2d(np.array(answer[each], dtype=float))
        size = max(1.0, float(np.nanmax(np.abs(here[:, regular]), initial=0.0)))
        allowed = CLOSE * size + FACTOR * _moved(run, others, each)
        assert np.all((np.abs(here - there) <= allowed)[:, regular]), (about, each)
    count = int(np.sum(run["contact_time"] < time[regular][-1]))
    kinds = [str(kind) for kind in run["contact_kind"][:count]]
    assert answer["contact_kind"][:count] == kinds, about


def _moved(run: Any, others: list[Any], name: str) -> Any:
    """How far shifts of gravity have moved a column so far."""
    here = np.atleast_2d(run[name])
    distance = np.max([np.abs(here - np.atleast_2d(other[name])) for other in others], axis=0)
    return np.maximum.accumulate(np.nan_to_num(distance, nan=np.inf), axis=1)
