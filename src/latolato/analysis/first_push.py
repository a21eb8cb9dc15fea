"""The smallest push that starts lasting motion, against frequency and phase of the drive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import TransientPeriods, check_no_repeat, checked_periodic
from latolato.analysis.registry import analyses, labelled
from latolato.analysis.starts import hanging_angles, start_columns
from latolato.analysis.stroboscopic import octaves, run_samples
from latolato.core.parameters import UnitOf
from latolato.core.quantities import POSITIVE, QUANTITIES, Quantity, Range
from latolato.physics.drives import Drive, PeriodicDrive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED
from latolato.sweeps.statuses import has_answer

if TYPE_CHECKING:
    import xarray as xr

    Floats = NDArray[np.float64]

# Periods watched after the transient: three times this.
_LONGEST = 4
# Points that a bracket is cut into at each refinement.
_CUTS = 8
# Default largest push, in natural frequencies [rad/s] or as an angle [rad].
_FASTEST, _WIDEST = 3.0, 1.0


@analyses.register("first_push", checked_periodic)
def first_push(
    system: System,
    drive: Drive | None = None,
    *,
    frequency_ratio: Annotated[Sequence[float], POSITIVE],
    drive_phase: Sequence[float] = (0.0,),
    push: Literal["initial_angular_velocity", "initial_offset"] = "initial_angular_velocity",
    largest_push: Annotated[float | None, UnitOf("push"), POSITIVE] = None,
    scan_points: int = 100,
    refinements: Annotated[int, Range(0, 12)] = 3,
    sustained_angle: Annotated[float, "rad", Range(0.0, math.pi, open_low=True)] = 0.1,
    transient_periods: TransientPeriods = 300.0,
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
        Driving over natural frequency, w/w0 [1], positive.
    drive_phase : sequence of float
        Drive phases at the push [rad]; at 0 a harmonic pivot is at its top.
    push : {"initial_angular_velocity", "initial_offset"}
        What the push gives: an angular velocity, of two balls opposite ones [rad/s]; or an angle
        away from rest at zero speed, of two balls half as far each way [rad].
    largest_push : float, optional
        Where the search ends, in the unit of the push; by default 3 w0 or one radian.
    scan_points : int
        Pushes tried between none and the largest, at equal distances.
    refinements : int
        How often the first bracket is cut into eight, 0 to 12.
    sustained_angle : float
        Motion lasts if, after the transient, it still goes this far beyond its angle at rest
        [rad], in (0, pi].
    transient_periods : float
        Drive periods before that is checked, at least 0; twelve are watched.
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
    pushes) below the first push. Motion that grows or dies more slowly than the transient
    lasts is judged by how far it goes at its end; small pushes of an unstable pendulum need
    ``ln(sustained_angle/push)/growth_rate`` seconds. Lift-off alone is not lasting motion: visible
    motion from rest needs ``drive_acceleration_ratio`` of about 1.04 (e = 1) to 1.9 (e = 0.5).

    Examples
    --------
    >>> import latolato as ll
    >>> toy = ll.LatoLato(length=0.245, mass=0.106, radius=0.02, damping=0.005, restitution=0.9)
    >>> drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0)
    >>> result = first_push(toy, drive, frequency_ratio=[2.4, 3.2], scan_points=40)
    >>> result.status.values.ravel(), result.first_push.values.ravel().round(1)
    (array(['push', 'self-start'], dtype='<U10'), array([0.6, 0. ]))
    """
    drive = checked_periodic(system, drive)
    ratios, phases = np.array(frequency_ratio), np.array(drive_phase)
    check_no_repeat("frequency_ratio", ratios)
    check_no_repeat("drive_phase", phases)
    unit, w0 = QUANTITIES[push].unit, system.natural_frequency
    usual = {"initial_angular_velocity": _FASTEST * w0, "initial_offset": _WIDEST}[push]
    largest_push = usual if largest_push is None else largest_push
    trials = _Trials(
        system,
        drive,
        push,
        {
            "transient_periods": transient_periods,
            "tolerance": tolerance,
            "rest_speed": rest_speed,
        },
    )
    cells = np.array([(r, p) for r in ratios for p in phases])
    pushes = np.linspace(0.0, largest_push, scan_points + 1)
    scan = trials.reach(cells, np.tile(pushes, (len(cells), 1)))
    lasts = scan > sustained_angle
    first, some = np.argmax(lasts, axis=1), lasts.any(axis=1)
    high = np.where(some, pushes[first], math.nan)
    low = np.where(some, pushes[np.maximum(first - 1, 0)], math.nan)
    pushed = np.flatnonzero(some & (first > 0))
    for _ in range(refinements if pushed.size else 0):
        ends = np.linspace(low[pushed], high[pushed], _CUTS + 1, axis=1)
        last = trials.reach(cells[pushed], ends[:, 1:-1]) > sustained_angle
        place = np.where(last.any(axis=1), np.argmax(last, axis=1), _CUTS - 1)
        rows = np.arange(len(pushed))
        low[pushed], high[pushed] = ends[rows, place], ends[rows, place + 1]
    is_any = some & (first > 0) & (low == 0.0) & (refinements > 0)
    bad = np.isnan(scan).any(axis=1)
    status = np.select(
        [bad, ~some, first == 0, is_any], ["failed", "none", "self-start", "any push"], "push"
    )
    value = np.where(is_any, 0.0, high)
    shape = (len(ratios), len(phases))
    dims = ("frequency_ratio", "drive_phase")
    accelerations = [
        replace(drive, drive_frequency=float(ratio * w0)).largest_acceleration for ratio in ratios
    ]
    return labelled(
        {
            "first_push": (dims, np.where(bad, math.nan, value).reshape(shape)),
            "push_error": (dims, np.where(bad, math.nan, high - low).reshape(shape)),
            "sustained_share": (dims, lasts.mean(axis=1).reshape(shape)),
            "angle_without_push": (dims, scan[:, 0].reshape(shape)),
            "status": (dims, status.reshape(shape)),
            "drive_acceleration_ratio": (
                "frequency_ratio",
                np.array(accelerations) / system.gravity,
            ),
        },
        system=system,
        drive=drive,
        coordinates={"frequency_ratio": ratios, "drive_phase": phases},
        quantities={
            "first_push": Quantity(unit, QUANTITIES[push].symbol, f"first push ({_WORDS[push]})"),
            "push_error": Quantity(unit, "", "width of the bracket of the first push"),
            "sustained_share": Quantity("1", "", "share of pushes after which motion lasts"),
            "angle_without_push": Quantity("rad", "", "angle beyond rest without a push"),
        },
        settings={"largest_push": largest_push, "scan_resolution": largest_push / scan_points},
    )


_WORDS = {"initial_angular_velocity": "angular velocity", "initial_offset": "angle"}


class _Trials(NamedTuple):
    """Pushes of a system at rest under a drive whose frequency and phase vary."""

    system: System
    drive: PeriodicDrive
    push: str
    options: dict[str, Any]

    def reach(self, cells: Floats, pushes: Floats) -> Floats:
        """Return how far beyond rest motions go at last [rad], NaN where a run failed.

        Shape (cell, push), as that of `pushes`; `cells` holds frequency ratios and phases.
        """
        system, rest = self.system, np.array(hanging_angles(self.system))
        ratio, phase = np.repeat(cells, pushes.shape[1], axis=0).T
        case = {"frequency_ratio": ratio, "drive_phase": phase, **self.starts(rest, pushes.ravel())}
        result = np.full(pushes.size, math.nan)
        for part in octaves(ratio):
            grid = run_samples(
                system,
                self.drive,
                {"case": {name: values[part] for name, values in case.items()}},
                longest=_LONGEST,
                angle_tolerance=1e-4,
                slowest_frequency=float(ratio[part].min() * system.natural_frequency),
                **self.options,
            )
            reached = np.asarray(grid["largest_angle_watched"].values).reshape(len(part), -1)
            beyond = (reached - np.abs(rest)).max(axis=1)
            result[part] = np.where(has_answer(grid["status"]), beyond, math.nan)
        return result.reshape(pushes.shape)

    def starts(self, rest: Floats, sizes: Floats) -> dict[str, Floats]:
        """Return the starts after pushes of these sizes as columns of a sweep."""
        away = np.array([1.0, -1.0])[: len(rest), None] * sizes
        still = np.zeros_like(away)
        if self.push == "initial_offset":  # which two balls share
            return start_columns(self.system, rest[:, None] + away / len(rest), still)
        return start_columns(self.system, rest[:, None] + still, away)
