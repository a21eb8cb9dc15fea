"""Floquet multipliers of periodic motions, through impacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import numpy as np

from latolato.analysis.flow import Floats, checked_flow, drive_period, periodic_drive
from latolato.analysis.orbits import (
    CLOSED,
    GRAZING_SPEED,
    PERIODS,
    Orbit,
    checked_guess,
    distance_of,
    find_orbit,
    multipliers_of,
    run_elsewhere,
    scale_of,
)
from latolato.analysis.registry import analyses, labelled, note, warn
from latolato.analysis.rules import said
from latolato.core.errors import Sentence, Word, joined, quantity_gap
from latolato.core.quantities import Quantity
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED

if TYPE_CHECKING:
    import xarray as xr

QUANTITIES = {
    "monodromy": Quantity("1", "M", "monodromy matrix, SI units"),
    "determinant": Quantity("1", r"\det M", "determinant of the monodromy matrix"),
    "expected_determinant": Quantity("1", r"\det M", "determinant from the laws of motion"),
    "difference_residual": Quantity(
        "1", r"\Delta M", "largest relative difference from finite differences"
    ),
    "multiplier_error": Quantity("1", r"\Delta\mu", "change of the multipliers at half the step"),
    "turns": Quantity("1", "", "whole turns in one period of the orbit"),
    "slowest_impact": Quantity("rad/s", r"\dot\theta_{min}", "smallest closing speed of an impact"),
    "defect": Quantity("1", "", "what the orbit misses to be closed"),
    "response_period": Quantity("1", "p", "period of the orbit in drive periods"),
}
_NUMBERS = (
    "growth_rate", "determinant", "expected_determinant", "difference_residual",
    "multiplier_error", "impacts", "turns", "slowest_impact", "response_period", "guess_distance",
)  # fmt: skip
# A modulus this close to one is neither stable nor unstable.
_NEUTRAL = 1e-8
# Beyond this the determinant or the differences contradict the matrix.
_DETERMINANT_LIMIT, _DIFFERENCE_LIMIT = 1e-8, 1e-4
_NUDGE = 1e-6


@analyses.register("floquet", periodic_drive)
def floquet(
    system: System,
    drive: Drive | None = None,
    *,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    period: Annotated[int, PERIODS] = 1,
    contact: str | None = "exact",
    tolerance: float = 1e-12,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return the Floquet multipliers [1] of the periodic motion near a guess.

    Floquet (1883); through impacts with the saltation matrices of Aizerman & Gantmacher (1958).

    Parameters
    ----------
    system : System
        Any system.
    drive : PeriodicDrive or PlanarHarmonic
        A drive that repeats itself.
    initial_angle, initial_angular_velocity : float or pair of float
        Guess of the state at time zero [rad], [rad/s], (right, left) for a `BallPair`; refined by
        Newton's method on the map over the orbit's period. Without walls hanging at rest by
        default.
    initial_offset : float, optional
        Instead of the angle: above the low contact angle of a `LatoLato` [rad].
    period : int
        Drive periods after which the motion repeats itself, 1 to 16.
    contact, tolerance, rest_speed
        As for `latolato.simulate`; contact must not be clamped.

    Returns
    -------
    xarray.Dataset
        ``multipliers`` over ``multiplier`` (complex, largest modulus first, 2 or 4) and
        ``monodromy`` over ``row`` and ``column`` for the state (angle, angular velocity) of the
        right, then of the left ball; the orbit's ``initial_angle`` and
        ``initial_angular_velocity``; ``growth_rate``, the logarithm of the largest modulus over
        time [1/s], minus infinity if it is zero; ``determinant`` beside
        ``expected_determinant`` exp(-gamma T) e^(2n), ``difference_residual`` and
        ``multiplier_error``; ``impacts``, ``turns``, ``slowest_impact``, ``response_period`` (the
        smallest number of drive periods), ``guess_distance`` (how far the orbit is from the guess,
        angular velocities over the natural frequency), ``defect`` and ``status``: ``stable``,
        ``unstable``, ``neutral``, ``rest`` (balls rest on each other: a multiplier is exactly
        zero), ``grazing`` (an impact without speed: the matrix has no limit), ``contradicted`` (a
        check failed) or ``not found`` (everything else is NaN then).

    Raises
    ------
    InputError
        For a drive that does not repeat itself, a start inside a wall, no start where there are
        walls, clamped contact, and dry friction on strings.

    Notes
    -----
    The matrix is the exact derivative of the integrator's own steps. If Newton's method fails, the
    guess is followed for 40 and 400 periods first, which leads to attractors. Error of the
    multipliers: ``multiplier_error``, mostly below 1e-9. Of several orbits near the guess one is
    found, not always the nearest, nor that on which the run from the guess settles: where that is
    another one, the attribute ``message`` has the end of the run, to be given as guess. It may have
    a shorter period that fits into `period`: ``response_period`` and ``message`` show it, and the
    multipliers are still those over `period`. Strings may go slack on the way, but not at time
    zero; ``expected_determinant`` is NaN then, as the laws of motion do not tell it beforehand.

    Examples
    --------
    Hanging still in the first tongue is unstable, with a multiplier below -1:

    >>> import latolato as ll
    >>> system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> result = floquet(system, ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26))
    >>> print(f"{result.multipliers.values[0].real:.5f} {result.growth_rate.item():.5f}")
    -1.13373 0.12505
    """
    flow = checked_flow(
        system, drive, contact=contact, tolerance=tolerance, rest_speed=rest_speed,
        through_slack=True,
    )  # fmt: skip
    drive = flow.drive
    guess = checked_guess(flow, initial_angle, initial_angular_velocity, initial_offset)
    orbit = find_orbit(flow, guess, period)
    result = describe_orbit(orbit)
    doubts = []
    if orbit.defect <= CLOSED:
        result["guess_distance"] = distance_of(flow, orbit.start, guess)
        doubts = doubts_about(orbit, guess, period)
    if result["status"] == "not found":
        string = said("taut_start") if flow.is_string else ""
        warn("no_orbit", period=period, defect=float(orbit.defect), string=string)
    elif result["status"] in ("grazing", "contradicted"):
        warn("doubtful_multipliers", status=Word(result["status"]))
    return labelled(
        dimensioned(result, system),
        system=system,
        drive=drive,
        quantities=QUANTITIES,
        settings={
            "contact": "none" if not math.isfinite(flow.walls[0]) else "exact",
            "message": note(*doubts),
        },
    )


def doubts_about(orbit: Orbit, guess: Floats, period: int) -> list[Sentence]:
    """Return why an orbit may not be the one that was wanted: its period, or a run beside it."""
    result = []
    if (smallest := smallest_period(orbit)) < period:
        result.append(said("shorter_period", smallest=float(smallest), period=period))
    if elsewhere := run_elsewhere(orbit, guess):
        periods, end = elsewhere
        angle, velocity = (
            joined([quantity_gap(float(f"{number:.6g}"), unit) for number in numbers], ", ")
            for numbers, unit in ((end[0::2], "rad"), (end[1::2], "rad/s"))
        )
        result.append(said("run_elsewhere", periods=periods, angle=angle, velocity=velocity))
    return result


def describe_orbit(orbit: Orbit) -> dict[str, object]:
    """Return everything that `floquet` returns for an orbit, checks included."""
    size = orbit.flow.size
    result: dict[str, object] = {
        "multipliers": np.full(size, complex(math.nan, math.nan)),
        "monodromy": np.full((size, size), math.nan),
        "initial_angle": np.full(size // 2, math.nan),
        "initial_angular_velocity": np.full(size // 2, math.nan),
        **dict.fromkeys(_NUMBERS, math.nan),
        "defect": orbit.defect,
        "status": "not found",
    }
    if not orbit.defect <= CLOSED:
        return result
    matrix, multipliers = orbit.passage.matrix, orbit.multipliers
    largest, natural = abs(multipliers[0]), orbit.flow.system.natural_frequency
    expected = math.exp(orbit.passage.spread)
    determinant = float(np.linalg.det(matrix))
    difference = difference_residual(orbit)
    status = "neutral"
    if abs(largest - 1.0) > _NEUTRAL:
        status = "stable" if largest < 1.0 else "unstable"
    scale = max(float(np.max(np.abs(matrix))) ** 2, expected)
    if orbit.rests:
        status = "rest"
    elif orbit.passage.grazes or orbit.slowest_impact < GRAZING_SPEED * natural:
        status = "grazing"
    elif abs(determinant - expected) > _DETERMINANT_LIMIT * scale or (
        difference > _DIFFERENCE_LIMIT
    ):
        status = "contradicted"
    finer = replace(orbit.flow, tolerance=max(orbit.flow.tolerance / 64.0, 1e-15))
    refined = multipliers_of(finer.follow(orbit.start, orbit.duration).matrix)
    with np.errstate(divide="ignore"):
        rate = float(np.log(largest)) / orbit.duration
    return result | {
        "multipliers": multipliers,
        "monodromy": matrix,
        "initial_angle": orbit.start[0::2],
        "initial_angular_velocity": orbit.start[1::2],
        "growth_rate": rate,
        "determinant": determinant,
        "expected_determinant": expected,
        "difference_residual": difference,
        "multiplier_error": float(np.max(np.abs(refined - multipliers))),
        "impacts": float(orbit.passage.impacts),
        "turns": float(orbit.turns),
        "slowest_impact": orbit.slowest_impact,
        "response_period": float(smallest_period(orbit)),
        "status": status,
    }


def dimensioned(entries: dict[str, object], system: System) -> dict[str, object]:
    """Return the entries with their dimensions, a single ball's without one."""
    dims: dict[str, tuple[str, ...]] = {
        "multipliers": ("multiplier",),
        "monodromy": ("row", "column"),
    }
    variables: dict[str, object] = {}
    for name, value in entries.items():
        if name in ("initial_angle", "initial_angular_velocity"):
            values: Floats = np.asarray(value)
            variables[name] = (("ball",), values) if system.angles == 2 else float(values[0])
        else:
            variables[name] = (dims[name], value) if name in dims else value
    return variables


def difference_residual(orbit: Orbit) -> float:
    """Return how much the matrix differs from central differences, relative to its largest entry.

    Measured in radians and natural frequencies. NaN where a start on a wall cannot be moved.
    """
    flow, size = orbit.flow, orbit.flow.size
    unit = scale_of(flow.system)
    low, high = flow.walls
    place = orbit.start[0] if size == 2 else orbit.start[0] - orbit.start[2]
    if place - low < 2.0 * _NUDGE or high - place < 2.0 * _NUDGE:
        return math.nan
    # The larger the matrix, the smaller the nudge within which the motion is linear.
    matrix = orbit.passage.matrix * unit / unit[:, None]
    largest = float(np.max(np.abs(matrix)))
    nudge = _NUDGE / max(1.0, largest) ** 0.5
    columns = []
    for column in np.diag(unit * nudge):
        ahead, behind = (
            flow.follow(orbit.start + s * column, orbit.duration).end for s in (1.0, -1.0)
        )
        columns.append((ahead - behind) / (2.0 * nudge) / unit)
    return float(np.max(np.abs(np.array(columns).T - matrix))) / max(largest, 1.0)


def smallest_period(orbit: Orbit) -> int:
    """Return the smallest number of drive periods after which an orbit repeats itself."""
    period = drive_period(orbit.flow.drive)
    count = round(orbit.duration / period)
    for divisor in range(1, count):
        if count % divisor:
            continue
        end = orbit.flow.follow(orbit.start, divisor * period).end
        if distance_of(orbit.flow, end, orbit.start) < 1e-7:
            return divisor
    return count
