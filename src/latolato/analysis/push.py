"""The smallest push that starts lasting motion, against frequency and phase of the drive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import checked_periodic, checked_transient, checked_values
from latolato.analysis.registry import analyses, labelled
from latolato.analysis.starts import hanging_angles, start_columns
from latolato.analysis.stroboscopic import octaves, run_samples
from latolato.core.quantities import ANY, POSITIVE, QUANTITIES, Quantity, Range
from latolato.core.registry import checked_choice, checked_count, checked_number
from latolato.numerics.records import EVENT_LIMIT
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED

if TYPE_CHECKING:
    import xarray as xr

    Floats = NDArray[np.float64]

PUSHES = ("initial_angular_velocity", "initial_offset")
# Periods watched after the transient: three times this.
_LONGEST = 4
# Points that a bracket is cut into at each refinement.
_CUTS = 8
# Default largest push in natural frequencies [rad/s] or as an angle [rad].
_LARGEST = {"initial_angular_velocity": 3.0, "initial_offset": 1.0}


@analyses.register("first_push")
def first_push(
    system: System,
    drive: Drive | None = None,
    *,
    frequency_ratio: Sequence[float],
    drive_phase: Sequence[float] = (0.0,),
    push: Literal["initial_angular_velocity", "initial_offset"] = "initial_angular_velocity",
    largest_push: float | None = None,
    scan_points: int = 100,
    refinements: int = 3,
    sustained_angle: float = 0.1,
    transient_periods: float = 300.0,
    tolerance: float = 1e-6,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return the smallest push from rest that starts lasting motion [rad/s or rad].

    Basin boundary on a line of starts; answers why the paper's toy needs a push at moderate
    frequencies and none at high ones.

    Parameters
    ----------
    system, drive
        The laws; frequency and phase of the drive are replaced, its amplitude stays.
    frequency_ratio : sequence of float
        w/w0 [1], positive.
    drive_phase : sequence of float
        Drive phases at the push [rad]; at 0 a harmonic pivot is at its top.
    push : {"initial_angular_velocity", "initial_offset"}
        What the push gives: an angular velocity, of two balls opposite ones [rad/s]; or an angle
        away from rest at zero speed, of two balls half as far each way [rad].
    largest_push : float, optional
        Where the search ends, in the unit of the push; by default 3 w0 or 1 rad.
    scan_points : int
        Pushes tried between none and the largest, at equal distances.
    refinements : int
        How often the first bracket found is cut into eight, 0 to 12.
    sustained_angle : float
        Motion lasts if, after the transient, it still goes this far beyond its angle at rest
        [rad], in (0, pi].
    transient_periods : float
        Drive periods after which that is asked, at least 0; twelve are watched.
    tolerance, rest_speed
        As for `latolato.simulate`.

    Returns
    -------
    xarray.Dataset
        Over (frequency_ratio, drive_phase): ``first_push``, in the unit of the push, with
        ``push_error``, the width of the bracket that it is the upper end of, and ``status``:
        "self-start" (0: motion lasts without a push), "any push" (0: the smallest of the refined
        pushes lasts, the hanging position is unstable), "push", "none" (NaN: no push up to the
        largest one lasts), "failed". ``sustained_share`` [1], the share of the pushes scanned
        that last, and ``angle_without_push`` [rad], how far beyond rest the motion goes at last
        without one: small hops after lift-off need not be lasting motion. Over frequency_ratio:
        ``drive_acceleration_ratio``, above 1 a ball at rest lifts off.

    Raises
    ------
    InputError
        For bad input, a drive without a period, the linearised pendulum.

    Notes
    -----
    Balls start in contact at rest, one pendulum hanging; the push comes at time zero, at the drive
    phase given. Basins are striped: above the first push there may be pushes after which the
    motion dies again, as ``sustained_share`` shows.

    What it can miss: a stripe narrower than ``scan_resolution`` (attribute, the distance of scanned
    pushes) below the first push found. Motion that grows or dies more slowly than the transient
    lasts is judged by how far it goes at its end; small pushes of an unstable pendulum need
    ``ln(sustained_angle/push)/growth_rate`` seconds. Lift-off alone is not lasting motion: visible
    motion from rest needs ``drive_acceleration_ratio`` of about 1.04 (e = 1) to 1.9 (e = 0.5).

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=0.245, mass=0.106, radius=0.02, damping=0.005, restitution=0.9)
    >>> drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0)
    >>> found = first_push(toy, drive, frequency_ratio=[2.4, 3.2], scan_points=40)
    >>> found.status.values.ravel(), found.first_push.values.ravel().round(1)
    (array(['push', 'self-start'], dtype='<U10'), array([0.6, 0. ]))
    """
    law = checked_periodic(system, drive)
    transient_periods = checked_transient(transient_periods)
    ratios = checked_values("frequency_ratio", frequency_ratio, "1", POSITIVE)
    phases = checked_values("drive_phase", drive_phase, "rad", ANY)
    checked_choice("push", push, PUSHES)
    unit = QUANTITIES[push].unit
    largest = checked_number("largest_push", _default(system, push, largest_push), POSITIVE, unit)
    scan_points = checked_count("scan_points", scan_points)
    refinements = int(checked_number("refinements", refinements, Range(0.0, 12.0), "1"))
    sustained_angle = checked_number(
        "sustained_angle", sustained_angle, Range(0.0, math.pi, open_low=True), "rad"
    )
    rest = np.array(hanging_angles(system))
    cells = [(float(r), float(p)) for r in ratios for p in phases]
    options = {"tolerance": tolerance, "rest_speed": rest_speed}

    def reach(cases: Floats) -> Floats:
        """Return how far beyond rest the motion goes at last [rad], NaN where a run failed."""
        result = np.full(len(cases), math.nan)
        for part in octaves(cases[:, 0]):
            some = cases[part]
            grid = run_samples(
                system,
                law,
                {"case": _case(system, some, push, rest)},
                longest=_LONGEST,
                angle_tolerance=1e-4,
                transient_periods=transient_periods,
                slowest_frequency=float(some[:, 0].min() * system.natural_frequency),
                **options,
            )
            reached = np.asarray(grid["largest_angle_watched"].values).reshape(len(part), -1)
            beyond = (reached - np.abs(rest)).max(axis=1)
            failed = grid["status"].values >= EVENT_LIMIT
            result[part] = np.where(failed, math.nan, beyond)
        return result

    pushes = np.linspace(0.0, largest, scan_points + 1)
    scan = reach(np.array([(*cell, p) for cell in cells for p in pushes]))
    scan = scan.reshape(len(cells), scan_points + 1)
    lasts = scan > sustained_angle
    first, some = np.argmax(lasts, axis=1), lasts.any(axis=1)
    high = np.where(some, pushes[first], math.nan)
    low = np.where(some, pushes[np.maximum(first - 1, 0)], math.nan)
    for _ in range(refinements):
        open_cells = np.flatnonzero(some & (first > 0))
        if not open_cells.size:
            break
        inner = np.linspace(low[open_cells], high[open_cells], _CUTS + 1, axis=1)[:, 1:-1]
        cases = np.array(
            [(*cells[c], p) for c, row in zip(open_cells, inner, strict=True) for p in row]
        )
        result = reach(cases).reshape(inner.shape) > sustained_angle
        for c, row, seen in zip(open_cells, inner, result, strict=True):
            ends = np.concatenate([[low[c]], row, [high[c]]])
            place = int(np.argmax(np.append(seen, True))) + 1
            low[c], high[c] = ends[place - 1], ends[place]
    status = np.array(["push"] * len(cells), dtype="<U10")
    status[~some] = "none"
    status[some & (first == 0)] = "self-start"
    anything = some & (first > 0) & (low == 0.0) & (refinements > 0)
    status[anything] = "any push"
    status[np.isnan(scan).any(axis=1)] = "failed"
    bad = status == "failed"
    value = np.where(anything, 0.0, high)
    shape = (len(ratios), len(phases))
    dims = ("frequency_ratio", "drive_phase")
    frequency = ratios * system.natural_frequency
    lift = _accelerations(law, frequency) / system.gravity
    return labelled(
        "first_push",
        {
            "first_push": (dims, np.where(bad, math.nan, value).reshape(shape)),
            "push_error": (dims, np.where(bad, math.nan, high - low).reshape(shape)),
            "sustained_share": (dims, lasts.mean(axis=1).reshape(shape)),
            "angle_without_push": (dims, scan[:, 0].reshape(shape)),
            "status": (dims, status.reshape(shape)),
            "drive_acceleration_ratio": (("frequency_ratio",), lift),
        },
        coordinates={"frequency_ratio": ratios, "drive_phase": phases},
        quantities={
            "first_push": Quantity(unit, QUANTITIES[push].symbol, f"first push ({_WORDS[push]})"),
            "push_error": Quantity(unit, "", "width of the bracket of the first push"),
            "sustained_share": Quantity("1", "", "share of pushes after which motion lasts"),
            "angle_without_push": Quantity("rad", "", "angle beyond rest without a push"),
        },
        system=system,
        drive=law,
        arguments=locals(),
        settings={"largest_push": largest, "scan_resolution": largest / scan_points},
    )


_WORDS = {"initial_angular_velocity": "angular velocity", "initial_offset": "angle"}


def _default(system: System, push: str, largest: float | None) -> float:
    """Return where the search ends."""
    if largest is not None:
        return largest
    scale = system.natural_frequency if push == "initial_angular_velocity" else 1.0
    return _LARGEST[push] * scale


def _accelerations(law: Any, frequency: Floats) -> Floats:
    """Return the pivot's largest downward-directed acceleration at each frequency [m/s^2]."""
    from dataclasses import replace

    return np.array(
        [replace(law, drive_frequency=float(w)).largest_acceleration for w in frequency]
    )


def _case(system: System, cases: Floats, push: str, rest: Floats) -> dict[str, Floats]:
    """Return the parameters of cases (ratio, phase, push) along one axis of a sweep."""
    ratio, phase, size = cases.T
    away = np.array([1.0, -1.0])[: system.angles, None] * size
    still = np.zeros_like(away)
    if push == "initial_offset":  # which two balls share
        starts = rest[:, None] + away / system.angles, still
    else:
        starts = rest[:, None] + still, away
    columns = start_columns(system, *starts)
    return {"frequency_ratio": ratio, "drive_phase": phase, **columns}
