"""Bifurcation diagrams by brute force: the motion is followed up and down a parameter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import (
    AngleTolerance,
    LongestPeriod,
    TransientPeriods,
    check_rods,
    check_span,
    checked_periodic,
)
from latolato.analysis.flow import varied
from latolato.analysis.registry import analyses, labelled
from latolato.analysis.starts import single_start, start_columns
from latolato.analysis.stroboscopic import QUANTITIES_HERE, settled_motion
from latolato.core.parameters import Parameter, UnitOf
from latolato.core.quantities import POSITIVE, Quantity, Range
from latolato.core.registry import checked_number, suggest
from latolato.core.rules import broken_rule
from latolato.numerics.integrate import Start
from latolato.observables.period import PERIODICITY, wrapped
from latolato.physics.drives import Drive, PeriodicDrive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED, between_walls, checked_contact, walls_of
from latolato.simulation.vary import parameters_of

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

# Parameters that set the frequency of the drive.
_FREQUENCIES = ("drive_frequency", "frequency_ratio")
_KEPT = ("response_period", "rotation_number", "mirror_residual", "largest_angle_watched")


@analyses.register("bifurcation_diagram", checked_periodic, check_rods)
def bifurcation_diagram(
    system: System,
    drive: Drive | None = None,
    *,
    parameter: str,
    low: Annotated[float, UnitOf("parameter")],
    high: Annotated[float, UnitOf("parameter")],
    points: Annotated[int, Range(2, 100_000)] = 201,
    direction: Literal["both", "up", "down"] = "both",
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    transient_periods: TransientPeriods = 200.0,
    longest: LongestPeriod = 16,
    angle_tolerance: AngleTolerance = 1e-4,
    tolerance: float = 1e-6,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return stroboscopic angles [rad] while a parameter is followed up and down.

    Orbit diagram (``orbitdiagram``) of DynamicalSystems.jl (Datseris, 2018), with continuation.

    Parameters
    ----------
    system, drive
        The laws; the drive must have one period (harmonic or crank slider).
    parameter : str
        What is varied: any number of the system or the drive, such as drive_amplitude,
        frequency_ratio, restitution.
    low, high : float
        Its lowest and highest value, in the parameter's SI unit.
    points : int
        Values from low to high, 2 to 100000.
    direction : {"both", "up", "down"}
        Which way the motion is followed.
    transient_periods : float
        Drive periods at each value before the motion is watched, at least 0.
    longest : int
        Longest response period that is recognised, 1 to 64; three times as many samples are kept.
    angle_tolerance : float
        Distance below which two samples agree [rad], in (0, 1].
    initial_angle, initial_angular_velocity, initial_offset, tolerance, rest_speed
        As for `latolato.simulate`; the start is that at the first value.

    Returns
    -------
    xarray.Dataset
        ``section_angle``, modulo 2 pi in [-pi, pi), and ``section_angular_velocity`` over
        (direction, the parameter, [ball,] sample); ``response_period``, ``rotation_number``,
        ``mirror_residual``, ``largest_angle_watched`` and ``status`` as in `response_period` over
        (direction, the parameter). ``is_hysteretic`` [1] over the parameter, if followed both
        ways: 1 where both ways reach motions of different period or largest angle, NaN where
        that is unknown: both aperiodic, one not settled or without an answer.

    Raises
    ------
    InputError
        For bad input, an unknown parameter, a drive without a period, the linearised pendulum.

    Notes
    -----
    Each value starts from the last sample of the one before, at the same drive phase, so that
    the motion stays on its branch as far as that is stable, and all samples are at the drive phase
    of time zero, ``drive_phase``. With walls the state is moved inside them where they moved.
    ``is_hysteretic`` compares the largest angles with a threshold of a hundred times
    `angle_tolerance`. Two aperiodic motions may be one chaos seen at different times, which comes
    in bursts, or two: compare their samples, or look at `basins`.

    What it can miss: unstable orbits, and every branch that neither way leads to (see `basins`).
    A motion near a bifurcation settles slowly and is followed with a delay, so that hysteresis
    narrower than a few steps of the parameter may be the delay: compare with more
    `transient_periods`. Motion at rest stays at rest until lift-off, also where other motions
    exist.

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=0.245, mass=0.106, radius=0.02, damping=0.005, restitution=0.9)
    >>> drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0)
    >>> result = bifurcation_diagram(
    ...     toy, drive, parameter="frequency_ratio", low=2.2, high=3.4, points=13,
    ...     initial_offset=0.0,
    ... )
    >>> result.status.sel(frequency_ratio=2.4, method="nearest").values
    array(['rest', 'periodic'], dtype='<U12')
    """
    drive = checked_periodic(system, drive)
    known = {n: p for n, p in parameters_of(system, drive).items() if p.owner != "run"}
    known.pop("drive_phase", None)
    if parameter not in known:
        hint = suggest(str(parameter), list(known))
        raise broken_rule("unknown", {"kind": "parameter", "name": parameter, "hint": hint})
    about = known[parameter]
    # A drive at rest has no period at which to look.
    allowed = POSITIVE if parameter in _FREQUENCIES else about.allowed
    for name, value in (("low", low), ("high", high)):
        checked_number(name, value, allowed, about.unit)
    check_span(low, high)
    values = np.linspace(low, high, points)
    start = single_start(system, initial_angle, initial_angular_velocity, initial_offset)
    ways: list[str] = ["up", "down"] if direction == "both" else [direction]
    result = _follow(
        system,
        drive,
        about,
        values,
        ways,
        start,
        {
            "longest": longest,
            "angle_tolerance": angle_tolerance,
            "transient_periods": transient_periods,
            "tolerance": tolerance,
            "rest_speed": rest_speed,
        },
    )
    kept = {n: result[n] for n in (*_KEPT, "status")}
    dims = ("direction", parameter)
    ball = ("ball",) if system.angles == 2 else ()
    variables: dict[str, Any] = {name: (dims, each) for name, each in kept.items()}
    for name in ("section_angle", "section_angular_velocity"):
        variables[name] = ((*dims, *ball, "sample"), result[name])
    if len(ways) == 2:
        variables["is_hysteretic"] = ((parameter,), _differ(kept, 100.0 * angle_tolerance))
    return labelled(
        variables,
        system=system,
        drive=drive,
        coordinates={"direction": ways, parameter: values},
        quantities=QUANTITIES_HERE
        | {
            parameter: about.quantity,
            "direction": Quantity("1", "", "way along the parameter"),
            "is_hysteretic": Quantity("1", "", "whether both ways differ"),
        },
    )


def _frequencies(system: System, law: PeriodicDrive, parameter: str, values: Floats) -> Floats:
    """Return the drive's frequency at each value of the parameter [rad/s]."""
    if parameter == "drive_frequency":
        return values
    if parameter == "frequency_ratio":
        return values * system.natural_frequency
    return np.full(len(values), law.drive_frequency)


def _follow(
    system: System,
    law: PeriodicDrive,
    parameter: Parameter,
    values: Floats,
    ways: list[str],
    start: Start,
    options: dict[str, Any],
) -> dict[str, NDArray[Any]]:
    """Return the results of `motion_of`, of shape (way, value, ...).

    All ways run at once. Each value starts from the last sample of the one before, which lies a
    whole number of drive periods after its start: so all samples are at one drive phase.
    """
    count = len(values)
    frequency = _frequencies(system, law, parameter.name, values)
    states = [(np.array(start.angles), np.array(start.velocities)) for _ in ways]
    result: dict[str, NDArray[Any]] = {}
    for step in range(count):
        places = [step if way == "up" else count - 1 - step for way in ways]
        cases = []
        for number, (place, state) in enumerate(zip(places, states, strict=True)):
            moved = system
            if parameter.owner == "system":
                moved, _ = varied(system, law, parameter.name, float(values[place]))
            angles = between_walls(state[0], walls_of(moved, checked_contact("exact", moved)))
            states[number] = (angles, state[1])
            cases.append((float(values[place]), *angles, *state[1]))
        distinct = list(dict.fromkeys(cases))  # both ways may meet in one motion
        first, *columns = np.array(distinct).T
        starts = start_columns(system, columns[: system.angles], columns[system.angles :])
        at = frequency[[places[cases.index(case)] for case in distinct]]
        motion = settled_motion(
            system,
            law,
            {"case": {parameter.name: first, **starts}},
            at,
            slowest_frequency=float(frequency[places].min()),
            **options,
        )
        of = [distinct.index(case) for case in cases]
        for number, (place, case) in enumerate(zip(places, of, strict=True)):
            angles = np.atleast_1d(motion["section_angle"][case, ..., -1])
            velocities = np.atleast_1d(motion["section_angular_velocity"][case, ..., -1])
            if np.isfinite(angles).all():  # a run that failed passes its start on
                states[number] = (angles, velocities)
            for name, each in motion.items():
                shape = (len(ways), count, *each.shape[1:])
                result.setdefault(name, np.empty(shape, dtype=each.dtype))[number, place] = each[
                    case
                ]
    result["section_angle"] = wrapped(result["section_angle"])
    return result


def _differ(kept: dict[str, NDArray[Any]], threshold: float) -> Floats:
    """Return a mask of where the ways up and down reach different motions, NaN where unknown."""
    up, down = kept["status"]
    largest = kept["largest_angle_watched"]
    orders = np.nan_to_num(kept["response_period"], nan=math.inf)
    chaotic = (up == "aperiodic") & (down == "aperiodic")
    unknown = chaotic | ~np.isin([up, down], PERIODICITY).all(axis=0)
    apart = abs(largest[0] - largest[1]) > threshold
    differ = (up != down) | (orders[0] != orders[1]) | apart
    return np.where(unknown, math.nan, differ.astype(np.float64))
