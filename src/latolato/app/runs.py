"""Runs that pages leave to the program: those with laws of your own or a measured pivot.

A page computes all others itself, in `static/js/model`. That code also describes the balls and the
drive's periods: `tests/app/test_runs.py` compares both.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from latolato.app.blocks import pack
from latolato.app.run_request import RunRequest, check_size, options_of
from latolato.core.errors import InputError
from latolato.physics.contacts import CONTACT_KINDS
from latolato.physics.drives import Drive
from latolato.physics.drives.segment import POLYNOMIAL, STILL
from latolato.scenario.scenario import Scenario
from latolato.simulation.plan import SAMPLES_PER_PERIOD
from latolato.simulation.record import LEDGER

if TYPE_CHECKING:
    import xarray as xr

    from latolato.simulation.record import Record

# Samples of a run that is shown: by default as many as files have, up to this number.
USUAL_SAMPLES = 30_000
MOST_STROBES = 20_000
# What is known of contacts beside time and kind; the last three on strings only.
CONTACT_COLUMNS = (
    "angular_velocity_before", "angular_velocity_after", "radial_velocity_before",
    "radial_velocity_after", "contact_ball",
)  # fmt: skip


def compute(request: RunRequest, most_samples: int = USUAL_SAMPLES) -> bytes:
    """Return the columns of a run, its contacts and its description, as one block.

    Raises
    ------
    InputError
        For bad input, and for a run that is too large, before any work.
    """
    return block_of(scenario_of(request), most_samples)


def scenario_of(request: RunRequest) -> Scenario:
    """Return the scenario of one run that is neither a map nor too large."""
    scenario = request.to_scenario()
    if scenario.varied:
        raise InputError(f"{scenario.name or 'this scenario'} is a map, not one run: open it there")
    check_size(scenario)
    return scenario


def block_of(scenario: Scenario, most_samples: int = USUAL_SAMPLES) -> bytes:
    """Return the run of a scenario as `compute` does."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = scenario.record(**sampled(scenario, most_samples))
    columns = [name for name, (shape, _) in run.variables.items() if shape[-1] == "time"]
    description = {**about(scenario, run), "warnings": [str(w.message) for w in caught]}
    return pack(description, arrays_of(scenario, run, columns))


def sampled(scenario: Scenario, most_samples: int) -> dict[str, Any]:
    """Return the argument `times` of a run that would have more samples than `most_samples`."""
    end = float(scenario.run.get("duration") or 0.0)
    fastest = max(scenario.system.natural_frequency, scenario.drive.fastest_frequency)
    usual = math.ceil(SAMPLES_PER_PERIOD * end * fastest / (2.0 * math.pi)) + 1
    if scenario.run.get("times") is not None or usual <= most_samples:
        return {}
    return {"times": np.linspace(0.0, end, max(most_samples, 2))}


def about(scenario: Scenario, run: Record | xr.Dataset) -> dict[str, Any]:
    """Return the description of a run: all but its columns."""
    return {
        "options": options_of(scenario),
        "is_sinusoidal": scenario.drive.is_sinusoidal,
        "attributes": dict(run.attrs),
        "contact_kinds": CONTACT_KINDS,
        "balls": balls_of(scenario),
        "duration": float(run["time"][-1]),
        "ledger": {name: _last(np.asarray(run[name])) for name in LEDGER if name in run},
    }


def _last(values: NDArray[np.float64]) -> float:
    """Return the last number of a run, also of one that stopped early; NaN if there is none."""
    numbers = values[np.isfinite(values)]
    return float(numbers[-1]) if numbers.size else math.nan


def balls_of(scenario: Scenario) -> list[dict[str, Any]]:
    """Return name, length, radius, mass and the sign of the angle of every ball on show."""
    names = ["right", "left"] if scenario.system.has_contacts else ["ball"]
    shown = scenario.system.balls
    mirrored = len(shown) < len(names)
    return [
        {
            "name": name,
            "row": 0 if mirrored else i,
            "sign": -1 if mirrored and name == "left" else 1,
            "length": shown[0 if mirrored else i].length,
            "radius": shown[0 if mirrored else i].radius,
            "mass": shown[0 if mirrored else i].mass,
        }
        for i, name in enumerate(names)
    ]


def strobes_of(drive: Drive, end: float) -> NDArray[np.float64]:
    """Return the instants up to `end` at which the drive's phase is a multiple of 2 pi [s].

    Empty for a drive that has no phase, or that turns too often to be shown.
    """
    result, segments = [], drive.segments(end)
    ends = [*(segment.start for segment in segments[1:]), end]
    for segment, last in zip(segments, ends, strict=True):
        if getattr(segment, "form", STILL) in (STILL, POLYNOMIAL):
            continue
        start, phase, w, rate = segment.start, segment.phase, segment.frequency, segment.rate
        span = last - start
        reached = phase + span * (w + 0.5 * rate * span)
        if not abs(reached - phase) < math.tau * MOST_STROBES:
            return np.empty(0)
        first = math.ceil(phase / math.tau - 1e-9)
        turned = math.tau * np.arange(first, math.floor(reached / math.tau + 1e-9) + 1) - phase
        # The root of w s + rate s^2/2 = turned, without loss of digits at small rates.
        if w > 0.0 or rate > 0.0:
            speed = np.sqrt(np.maximum(w * w + 2.0 * rate * turned, 0.0))
            result.append(start + 2.0 * turned / (w + speed))
    return np.unique(np.concatenate(result)) if result else np.empty(0)


def arrays_of(
    scenario: Scenario,
    run: Record | xr.Dataset,
    columns: Iterable[str],
    dtype: DTypeLike = np.float64,
) -> dict[str, Any]:
    """Return instants, columns as rows of balls, the drive's periods and the contacts."""
    result: dict[str, Any] = {"time": np.asarray(run["time"], dtype=np.float64)}
    result["strobe"] = strobes_of(scenario.drive, float(run["time"][-1]))
    with np.errstate(over="ignore"):  # what is beyond all pictures becomes infinite
        for name in columns:
            if name in run:
                result[name] = np.atleast_2d(np.asarray(run[name], dtype=dtype))
    kinds = np.asarray(run["contact_kind"])
    result["contact_time"] = np.asarray(run["contact_time"], dtype=np.float64)
    result["contact_kind"] = np.array([CONTACT_KINDS.index(str(k)) for k in kinds], dtype=np.uint8)
    for name in CONTACT_COLUMNS:
        if name in run:
            result[name] = np.atleast_2d(np.asarray(run[name], dtype=dtype))
    return result
