"""After how many drive periods the motion repeats, and how symmetric it is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from latolato.analysis.checks import (
    AngleTolerance,
    LongestPeriod,
    TransientPeriods,
    checked_periodic,
)
from latolato.analysis.registry import analyses, labelled, note
from latolato.analysis.rules import said
from latolato.analysis.starts import single_start, start_columns
from latolato.analysis.stroboscopic import QUANTITIES_HERE, settled_motion
from latolato.core.errors import Sentence, Word
from latolato.observables.period import wrapped
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED

if TYPE_CHECKING:
    import xarray as xr


@analyses.register("response_period", checked_periodic)
def response_period(
    system: System,
    drive: Drive | None = None,
    *,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    transient_periods: TransientPeriods = 500.0,
    longest: LongestPeriod = 16,
    angle_tolerance: AngleTolerance = 1e-4,
    tolerance: float = 1e-8,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return after how many drive periods the motion repeats [1], with rotation and symmetry.

    Stroboscopic map; rotation number as in DynamicalSystems.jl (Datseris, 2018).

    Parameters
    ----------
    system, drive
        The laws; the drive must have one period (harmonic or crank slider).
    transient_periods : float
        Drive periods before the motion is watched, at least 0.
    longest : int
        Longest response period that is recognised, 1 to 64 drive periods; three times as many
        drive periods are watched.
    angle_tolerance : float
        Distance below which two samples agree [rad], in (0, 1].
    initial_angle, initial_angular_velocity, initial_offset, tolerance, rest_speed
        As for `latolato.simulate`.

    Returns
    -------
    xarray.Dataset
        ``status`` is "periodic", "rest" (period 1), "grazing" (periodic without rest, with an
        impact slower than `angle_tolerance` times the drive frequency: the period may change
        with the smallest change of a parameter), "aperiodic" (no period up to `longest`), "not
        settled" (the motion still changes after the transient), "slackens" (a ball hangs still, but
        hops up and down on its string), or that of a run without an answer ("event_limit",
        "failed", "invalid", "outside_model").
        ``response_period`` [1] is NaN where there is none; ``recurrence_residual`` [rad] is the
        distance left after one period, or of the closest recurrence.
        ``rotation_number`` [1] is, with walls, the impacts per drive period. Without, it is the
        turns per drive period of a rotating pendulum, negative where the mean angular velocity is
        (the mirror image of a motion rotates the other way), and otherwise the swings per drive
        period, which have no sign. Of two balls it is that of the one that turns more.
        ``mirror_residual`` [rad] is the distance from the mirror image ``mirror_shift`` drive
        periods later. ``section_angle`` [rad], modulo 2 pi, and
        ``section_angular_velocity`` [rad/s] are the samples, over ([ball,] sample).

    Raises
    ------
    InputError
        For bad input, a drive without a period, and the linearised pendulum.

    Notes
    -----
    With samples ``x_n = (angle, angular velocity/w)`` at ``t = n T`` the period is the smallest p
    with ``|x_{n+p} - x_n| <= angle_tolerance`` for all n watched, angles modulo 2 pi, the
    distance being the larger of both. Swings are windings of (angle, angular velocity) about the
    hanging position: half the passages through it. They are not defined for motion that swings
    about another position, where they are 0. Rates are over a whole number of response periods;
    of a chaotic motion they are means over the periods watched, and the rotation number of a
    chaotic free pendulum, which swings and tumbles, is NaN.

    The mirror image ``-angle`` of a free pendulum's motion is a motion too, under the same drive.
    So a periodic motion is its own mirror image some k drive periods later (``mirror_residual``
    about 0), or one of a pair. As going twice must lead back, k is 0 (rest only) or half the
    response period, which then is even: the swing of period 2 in the tongue has k = 1. Two balls
    are mirrored by exchanging them, and the residual with k = 0 is ``|angle_right + angle_left|``.
    A `LatoLato` is symmetric by construction.

    Motion without a period is run again with twice and four times the transient. It is "not
    settled" if it has a period then. If its largest angle, its fastest speed or the distance left
    has fallen below 0.8 times its value twice, or below half once, it is watched for 192 drive
    periods after eight times the transient, and is "not settled" if angle and speed are below 0.8
    times all values before, or the distance left, which never exceeded 0.05 rad, is.

    This is a rule of thumb whose limits were set on a few motions. Chaos in bursts can be taken for
    "not settled": of one such toy (l = 1 m, m = 0.8 kg, r = 0.1 m, C = 0.02 kg m/s, e = 0.9,
    A0 = 0.374 m, w/w0 = 1.733) none to 11 of 64 starts are, depending on transient and tolerance.

    What it can miss: motion that settles more slowly than that, and chaos that ends later, count
    as aperiodic, so repeat with a longer transient; a period above `longest`; a pulsation below
    `angle_tolerance`; an impact that falls on the end of a drive period, where the angular velocity
    jumps, so that recurrence is found late. Other starts may lead to other motions: see `basins`.

    Examples
    --------
    >>> import latolato as ll
    >>> system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
    >>> result = response_period(system, drive, initial_angle=0.1)
    >>> result.response_period.item(), result.status.item(), result.mirror_residual.item() < 1e-4
    (2.0, 'periodic', True)
    """
    drive = checked_periodic(system, drive)
    start = single_start(system, initial_angle, initial_angular_velocity, initial_offset)
    result = settled_motion(
        system,
        drive,
        {"case": start_columns(system, start.angles, start.velocities)},
        drive.drive_frequency,
        longest=longest,
        angle_tolerance=angle_tolerance,
        transient_periods=transient_periods,
        tolerance=tolerance,
        rest_speed=rest_speed,
    )
    variables: dict[str, Any] = {name: values[0] for name, values in result.items()}
    dims = ("ball", "sample") if system.angles == 2 else ("sample",)
    variables["section_angle"] = (dims, wrapped(variables["section_angle"]))
    variables["section_angular_velocity"] = (dims, variables["section_angular_velocity"])
    return labelled(
        variables,
        system=system,
        drive=drive,
        quantities=QUANTITIES_HERE,
        settings={"message": note(_message(variables, longest, transient_periods))},
    )


def _message(values: dict[str, Any], longest: int, transient_periods: float) -> Sentence | None:
    """Return why there is no answer, or a doubtful one, and what to try."""
    status, left = str(values["status"]), float(values["recurrence_residual"])
    if status == "aperiodic":
        return said("aperiodic_run", longest=longest, left=left, periods=transient_periods)
    if status == "not settled":
        longer = 4.0 * max(transient_periods, 3.0 * longest)
        return said("still_changing", periods=transient_periods, longer=longer)
    if status == "grazing":
        return said("grazing_period")
    if not math.isfinite(float(values["response_period"])):
        return said("ended_run", status=Word(status))
    return None
