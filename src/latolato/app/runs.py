"""Runs for the pages: simulated, sampled for the screen, sent as one block."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.app.blocks import pack
from latolato.app.given import (
    MOST_SAMPLES,
    RunRequest,
    TooLargeError,
    check_size,
    option_value,
    options_of,
)
from latolato.app.lines import command_line, python_line
from latolato.core.errors import InputError
from latolato.core.registry import checked_count, suggest
from latolato.physics.contacts import CONTACT_KINDS
from latolato.physics.drives import Drive
from latolato.physics.drives.stretch import POLYNOMIAL, STILL
from latolato.scenario.options import law_options
from latolato.scenario.scenario import Scenario
from latolato.simulation.run import SAMPLES_PER_PERIOD
from latolato.simulation.summary import summarise

if TYPE_CHECKING:
    import xarray as xr

    from latolato.simulation.record import Record

# Samples of a run that is shown: by default as many as files have, up to this number.
USUAL_SAMPLES = 30_000
MOST_STROBES = 20_000
# Always sent, as the animation needs them.
_MOTION = ("angle", "angular_velocity", "pivot_height")
# What pages ask for beside them if they do not say.
USUAL_COLUMNS = (
    "kinetic_energy",
    "potential_energy",
    "total_energy",
    "drive_power",
    "damping_power",
    "tension",
)
# The ledger, of which the end is sent always.
_LEDGER = ("drive_work", "damping_loss", "impact_loss", "capture_loss", "noise_work")
# What a page may ask for.
COLUMNS = (
    *_MOTION,
    "pivot_velocity",
    "pivot_acceleration",
    "kinetic_energy",
    "potential_energy",
    "total_energy",
    "drive_power",
    "damping_power",
    "tension",
    *_LEDGER,
)
_ATTRIBUTES = (
    "system",
    "drive",
    "natural_frequency",
    "contact_angle_low",
    "contact_angle_high",
    "contact_separation",
    "latolato_version",
)


def simulate_request(request: RunRequest, samples: int | None = None) -> tuple[Scenario, Record]:
    """Return the scenario that a page asks for and its run, sampled evenly for the screen.

    Parameters
    ----------
    samples : int, optional
        Number of samples; by default 100 in the shorter period, 30000 at most.

    Raises
    ------
    InputError
        For bad input, and for a run that is too large, before any work.
    """
    wanted = dict(request.options or {})
    if "samples" in wanted:
        samples = option_value(law_options()["samples"], wanted.pop("samples"))
    if samples is not None and checked_count("samples", samples) > MOST_SAMPLES:
        raise TooLargeError(f"must not exceed {MOST_SAMPLES}, got {samples}", parameter="samples")
    scenario = RunRequest(request.scenario, wanted).to_scenario()
    return scenario, simulate_shown(scenario, samples)


def simulate_shown(scenario: Scenario, samples: int | None = None) -> Record:
    """Return the run of a scenario as `simulate_request` does."""
    if scenario.varied:
        raise InputError(f"{scenario.name or 'this scenario'} is a map, not one run: open it there")
    check_size(scenario)
    times = scenario.run.get("times")
    if times is None:
        end = float(scenario.run.get("duration") or 0.0)
        fastest = max(scenario.system.natural_frequency, scenario.drive.fastest_frequency)
        usual = math.ceil(SAMPLES_PER_PERIOD * end * fastest / (2.0 * math.pi)) + 1
        count = max(samples or min(usual, USUAL_SAMPLES), 2)
        if end > 0.0:
            times = np.linspace(0.0, end, count)
    return scenario.record(**({} if times is None else {"times": times}))


def run_block(
    request: RunRequest, columns: Sequence[str] = USUAL_COLUMNS, samples: int | None = None
) -> bytes:
    """Return a run as a block: motion, the `columns` asked for, contacts and all about it."""
    return _block(lambda: simulate_request(request, samples), columns)


def block_of(scenario: Scenario, columns: Sequence[str] = USUAL_COLUMNS) -> bytes:
    """Return the run of a scenario as `run_block` does."""
    return _block(lambda: (scenario, simulate_shown(scenario)), columns)


def _block(run_it: Callable[[], tuple[Scenario, Record]], columns: Sequence[str]) -> bytes:
    for name in columns:
        if name not in COLUMNS:
            raise InputError(f"unknown column '{name}': {suggest(name, list(COLUMNS))}")
    begun = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scenario, run = run_it()
    told = {
        "warnings": [str(w.message) for w in caught],
        "wall_time": time.perf_counter() - begun,
    }
    return pack({**about(scenario, run), **told}, arrays_of(scenario, run, columns))


def about(scenario: Scenario, run: Record | xr.Dataset) -> dict[str, Any]:
    """Return all that the pages tell of a run beside its numbers."""
    return {
        "summary": summarise(run),
        "options": options_of(scenario),
        "attributes": {name: run.attrs[name] for name in _ATTRIBUTES if name in run.attrs},
        "balls": balls_of(scenario),
        "duration": float(run["time"][-1]),
        "ledger": {name: float(run[name][-1]) for name in _LEDGER if name in run},
        "title": scenario.title,
        "python": python_line(scenario),
        "command": command_line(scenario),
    }


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
    result, stretches = [], drive.stretches(end)
    ends = [*(stretch.start for stretch in stretches[1:]), end]
    for stretch, last in zip(stretches, ends, strict=True):
        if getattr(stretch, "form", STILL) in (STILL, POLYNOMIAL):
            continue
        start, phase, w, rate = stretch.start, stretch.phase, stretch.frequency, stretch.rate
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
    scenario: Scenario, run: Record | xr.Dataset, columns: Sequence[str]
) -> dict[str, Any]:
    """Return instants, motion, columns as rows of balls, the drive's periods and the contacts."""
    result: dict[str, Any] = {"time": np.asarray(run["time"], dtype=np.float64)}
    result["strobe"] = strobes_of(scenario.drive, float(run["time"][-1]))
    with np.errstate(over="ignore"):  # what is beyond all pictures becomes infinite
        for name in dict.fromkeys((*_MOTION, *columns)):
            if name in run:
                result[name] = np.atleast_2d(np.asarray(run[name], dtype=np.float32))
    kinds = np.asarray(run["contact_kind"])
    result["contact_time"] = np.asarray(run["contact_time"], dtype=np.float64)
    result["contact_kind"] = np.array([CONTACT_KINDS.index(str(k)) for k in kinds], dtype=np.uint8)
    for name in ("angular_velocity_before", "angular_velocity_after"):
        result[name] = np.atleast_2d(np.asarray(run[name], dtype=np.float32))
    return result
