"""Hysteresis: how the response depends on the direction in which the frequency is swept."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import (
    check_rods,
    checked_nonlinear,
    checked_vertical,
    increasing,
)
from latolato.analysis.registry import analyses, labelled, note
from latolato.analysis.rules import broken_analysis, said
from latolato.analysis.starts import start_columns, start_options
from latolato.analysis.stroboscopic import settled_cases
from latolato.core.errors import Sentence
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, Quantity
from latolato.observables.period import PERIODICITY, wrapped
from latolato.physics.drives import Drive, PeriodicDrive
from latolato.physics.pendulum import OneBall, System
from latolato.simulation.start import DEFAULT_REST_SPEED
from latolato.sweeps import sweep

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

LOOP, NO_LOOP, DELAY, UNKNOWN = "hysteresis", "no hysteresis", "not settled", "no answer"
# Drive periods that a difference between both ways must outlast.
_LASTING = 300.0
# Default range and number of frequencies [w/w0].
_DEFAULT_RATIOS = (1.6, 3.6, 81)

_ENDS = ("largest_angle_after_transient", "final_angle", "final_angular_velocity")

_QUANTITIES = {
    "direction": Quantity("1", "", "way along the frequencies"),
    "settled_angle": Quantity("rad", r"\theta_{max}", "largest angle once settled"),
    "jump_ratio": Quantity("1", r"\omega_j/\omega_0", "frequency ratio of the largest jump"),
    "jump_height": Quantity("rad", r"\Delta\theta_j", "change of the largest angle at the jump"),
    "loop_area": Quantity("rad", "S", "area between both ways, over the frequency ratio"),
    "bistable_low": Quantity("1", r"r_-", "lowest frequency ratio with two answers"),
    "bistable_high": Quantity("1", r"r_+", "highest frequency ratio with two answers"),
    "bistable_ranges": Quantity("1", "", "number of ranges with two answers"),
}


class _Sweep(NamedTuple):
    """What is swept, and with which options of `sweep`."""

    system: System
    drive: PeriodicDrive
    amplitudes: Floats
    ratios: Floats
    options: dict[str, Any]


@analyses.register("hysteresis", checked_nonlinear, check_rods, checked_vertical)
def hysteresis(
    system: System,
    drive: Drive | None = None,
    *,
    frequency_ratio: Annotated[Sequence[float] | None, NON_NEGATIVE] = None,
    drive_amplitude: Annotated[Sequence[float] | None, NON_NEGATIVE] = None,
    duration: float = 60.0,
    transient: Annotated[float | None, "s", NON_NEGATIVE] = None,
    least_jump: Annotated[float, "rad", POSITIVE] = 0.1,
    least_motion: Annotated[float, "rad", NON_NEGATIVE] = 1e-3,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    tolerance: float = 1e-6,
    contact: str | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return the largest angles [rad] of slow sweeps of the driving frequency, up and down.

    The experiment behind Paper Figs. 9 and 11, each step begun where the one before ended.

    Parameters
    ----------
    system : System
        What moves; of two balls the larger angle counts.
    drive : PeriodicDrive
        The drive; its frequency is swept.
    frequency_ratio : sequence of float, optional
        Driving over natural frequencies [1], increasing; by default 81 from 1.6 to 3.6.
    drive_amplitude : sequence of float, optional
        Amplitudes [m]; by default that of the drive.
    duration : float
        How long each frequency is held [s].
    transient : float, optional
        The beginning of that time whose angles do not count [s]; by default half of it.
    least_jump : float
        Change of the largest angle between neighbours, and difference between both ways, that
        counts as a jump [rad].
    least_motion : float
        A free pendulum whose motion has died down below this starts the next frequency with it
        [rad], as there is always some disturbance. Nothing is added where there are walls, for
        balls may stay at rest on them.
    initial_angle, initial_angular_velocity, initial_offset, tolerance, contact, rest_speed
        As for `latolato.sweep`; by default both ways start where the system hangs at rest.

    Returns
    -------
    xarray.Dataset
        Over ``drive_amplitude``: ``largest_angle`` and ``settled_angle`` (also over ``direction``,
        "up" and "down", and ``frequency_ratio``), ``jump_ratio`` and ``jump_height`` (also over
        ``direction``), ``loop_area``, ``bistable_low`` and ``bistable_high``, the lowest and the
        highest ratio with two answers, ``bistable_ranges``, the number of ranges between them, and
        ``status``: "hysteresis", "no hysteresis" (jumps may still exist; the bistable range is
        NaN), "not settled" (both ways differ, but only because the motion had too little time, or
        because it never settles; the bistable range is NaN) or "no answer". The attribute
        ``message`` mentions differences that do not last, and a range that the sweep cuts off.

    Raises
    ------
    InputError
        For a parameter outside its range, a drive without one frequency, or a linear system.

    Notes
    -----
    ``loop_area`` is the integral of ``|down - up|`` over the frequency ratio by trapezes; a jump's
    ratio is the middle of the two neighbours with the largest change, known to half their distance,
    and NaN where no change reaches `least_jump`. Where both ways differ by that, both are followed
    on for at least 300 drive periods, and ``settled_angle`` is NaN for one that has not settled
    then (see `response_period`); elsewhere it is that of the sweep. Ratios with two answers are
    those at which the settled angles still differ by `least_jump`. Two chaotic motions count as not
    settled. What it can miss: branches that neither sweep
    visits; a fold where the time per frequency is too short for the slow growth there, which
    widens the loop. A pendulum has to grow from `least_motion`: jumps come late unless half the
    duration is about ten growth times. A toy at rest in contact leaves it only where
    ``A0 w^2 > g``.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.0196, restitution=0.9)
    >>> drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.1)
    >>> result = hysteresis(toy, drive, frequency_ratio=[2.0, 2.4, 2.8, 3.2], duration=30.0)
    >>> result.status.values.tolist(), result.jump_ratio.sel(direction="up").values.tolist()
    (['hysteresis'], [3.0])
    """
    drive = checked_vertical(drive)
    ratios = increasing("frequency_ratio", frequency_ratio, np.linspace(*_DEFAULT_RATIOS))
    if len(ratios) < 2:
        raise broken_analysis("two_values", parameter="frequency_ratio", value=ratios)
    amplitudes = np.array([drive.drive_amplitude] if drive_amplitude is None else drive_amplitude)
    transient = 0.5 * duration if transient is None else transient
    start = start_options(system, initial_angle, initial_angular_velocity, initial_offset)
    options: dict[str, Any] = {
        "duration": duration,
        "transient": transient,
        "tolerance": tolerance,
        "contact": contact,
        "rest_speed": rest_speed,
    }
    swept = _Sweep(system, drive, amplitudes, ratios, options)
    if isinstance(system, OneBall) and not system.has_contacts:
        angles, *ends = _stirred(swept, start, least_motion)
    else:
        grid = sweep(
            system,
            drive,
            axes={"drive_amplitude": amplitudes, "frequency_ratio": ratios},
            observables=_ENDS,
            continuation="frequency_ratio",
            direction="both",
            **options,
            **start,
        )
        order = ("drive_amplitude", "direction", "frequency_ratio", "ball")
        grid = grid if "ball" in grid.dims else grid.expand_dims("ball")
        angles, *ends = (grid[name].transpose(*order).values for name in _ENDS)
        angles = angles.max(axis=-1)
    settled = _settled(swept, angles, ends, least_jump)
    two = _apart(settled, least_jump)
    rows = [
        _loop(ratios, up, down, least_jump, each)
        for (up, down), each in zip(angles, two, strict=True)
    ]
    along = ("drive_amplitude", "direction", "frequency_ratio")
    variables: dict[str, Any] = {
        "largest_angle": (along, angles),
        "settled_angle": (along, settled),
    }
    both = ("drive_amplitude", "direction")
    for name in rows[0]:
        dims = both if name.startswith("jump") else both[:1]
        variables[name] = (dims, np.array([row[name] for row in rows]))
    return labelled(
        variables,
        system=system,
        drive=drive,
        coordinates={
            "drive_amplitude": amplitudes,
            "direction": ["up", "down"],
            "frequency_ratio": ratios,
        },
        quantities=_QUANTITIES,
        settings={
            **start,
            "transient": transient,
            "message": note(*_doubts(ratios, _apart(angles, least_jump) & ~two, two)),
        },
    )


def _stirred(swept: _Sweep, start: dict[str, Any], least: float) -> Floats:
    """Return `_ENDS`, (name, amplitude, direction, ratio), of motions that never die away."""
    system, drive, amplitudes, ratios, options = swept
    count = len(amplitudes)
    result = np.full((len(_ENDS), count, 2, len(ratios)), math.nan)
    for way, order in enumerate((range(len(ratios)), reversed(range(len(ratios))))):
        angle = np.full(count, float(start["initial_angle"]))
        velocity = np.full(count, float(start["initial_angular_velocity"]))
        phase = np.full(count, drive.drive_phase)
        for place in order:
            frequency = ratios[place] * system.natural_frequency
            motion = np.hypot(angle, velocity / system.natural_frequency)
            angle = np.where(motion < least, np.copysign(least, angle), angle)
            grid = sweep(
                system,
                replace(drive, drive_frequency=frequency),
                axes={
                    "case": {
                        "drive_amplitude": amplitudes,
                        "drive_phase": phase,
                        **start_columns(system, [angle], [velocity]),
                    }
                },
                observables=_ENDS,
                **options,
            )
            result[:, :, way, place] = [grid[name].values for name in _ENDS]
            angle = np.nan_to_num(wrapped(grid.final_angle.values))
            velocity = np.nan_to_num(grid.final_angular_velocity.values)
            phase = np.remainder(phase + frequency * options["duration"], math.tau)
    return result


def _apart(angles: Floats, least: float) -> NDArray[np.bool_]:
    """Return the mask where both ways, along the second axis, differ by `least`."""
    return np.asarray(np.abs(angles[:, 1] - angles[:, 0]) >= least)


def _settled(swept: _Sweep, angles: Floats, ends: Sequence[Floats], least: float) -> Floats:
    """Return the largest angles once settled, NaN where they do not settle, shape as `angles`.

    Where both ways differ, each goes on from its end at the frequency it has reached. `ends` are
    the angles and angular velocities there, of shape (amplitude, way, ratio[, ball]).
    """
    system, drive, amplitudes, ratios, options = swept
    places = np.argwhere(_apart(angles, least))
    if not len(places):
        return angles
    row, column = np.tile(places, (2, 1)).T
    way = np.repeat([0, 1], len(places))
    frequencies = ratios * system.natural_frequency
    turned = frequencies * options["duration"]
    phases = np.array([np.cumsum(turned), np.cumsum(turned[::-1])[::-1]])
    angle, velocity = (each[row, way, column].reshape(len(row), -1) for each in ends)
    case = {
        "drive_amplitude": amplitudes[row],
        "frequency_ratio": ratios[column],
        "drive_phase": np.remainder(drive.drive_phase + phases[way, column], math.tau),
        **start_columns(system, angle.T, velocity.T),
    }
    motion = settled_cases(
        system,
        drive,
        case,
        frequencies[column],
        transient_periods=_LASTING,
        longest=4,
        angle_tolerance=1e-4,
        **{k: v for k, v in options.items() if k not in ("duration", "transient")},
    )
    status = motion["status"].reshape(2, -1)
    is_known = np.isin(status, PERIODICITY) & ~np.all(status == "aperiodic", axis=0)
    result = angles.copy()
    result[row, way, column] = np.where(is_known.ravel(), motion["largest_angle_watched"], math.nan)
    return result


def _doubts(
    ratios: Floats, passing: NDArray[np.bool_], two: NDArray[np.bool_]
) -> Iterator[Sentence]:
    """Yield which differences between both ways do not last, and at which ends others go on."""
    if passing.any():
        yield said("passing_difference", count=int(passing.sum()), of=passing.size)
    if two[:, 0].any():
        yield said("cut_off_below", ratio=float(ratios[0]))
    if two[:, -1].any():
        yield said("cut_off_above", ratio=float(ratios[-1]))


def _loop(
    ratios: Floats, up: Floats, down: Floats, least: float, is_two: NDArray[np.bool_]
) -> dict[str, Any]:
    """Return jumps, area and range of one loop, with two answers where `is_two`."""
    result: dict[str, Any] = {"jump_ratio": [], "jump_height": []}
    for angles, way in ((up, 1.0), (down, -1.0)):
        change = way * np.diff(angles)
        ratio = height = math.nan
        if np.all(np.isfinite(change)):
            i = int(np.argmax(np.abs(change)))
            if abs(change[i]) >= least:
                ratio, height = 0.5 * (ratios[i] + ratios[i + 1]), float(change[i])
        result["jump_ratio"].append(ratio)
        result["jump_height"].append(height)
    gap = np.abs(down - up)
    result["loop_area"] = float(np.trapezoid(gap, ratios))
    two = ratios[is_two]
    result["bistable_low"] = float(two[0]) if len(two) else math.nan
    result["bistable_high"] = float(two[-1]) if len(two) else math.nan
    result["bistable_ranges"] = int(np.count_nonzero(np.diff(is_two, prepend=False) & is_two))
    is_known = math.isfinite(result["loop_area"])
    result["status"] = LOOP if len(two) else (DELAY if np.any(gap >= least) else NO_LOOP)
    if not is_known:
        result["status"] = UNKNOWN
    return result
