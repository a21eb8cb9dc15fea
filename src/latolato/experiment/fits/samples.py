"""Which samples of a track table a fit uses, and what is seen of them beforehand."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, Sentence
from latolato.core.quantities import POSITIVE
from latolato.core.registry import checked_number
from latolato.experiment.fits.least_squares import Data, Floats, one_series
from latolato.experiment.rules import broken, said
from latolato.experiment.track_table import (
    CLEAN,
    balls_of,
    checked_table,
    has_own_pivots,
    table_of_ball,
)
from latolato.physics.drives import Drive, MeasuredPivot
from latolato.physics.pendulum import LatoLato, System

if TYPE_CHECKING:
    import xarray as xr

# A pivot that moves by less than this share of the length is at rest (its track is noisy).
_STILL = 0.004
# Share of samples that are distinct if angles are not rounded.
_DISTINCT = 0.95
# Periods from which a gap leaves the number of cycles in it open.
_GAP = 0.7
# A step so many times the usual ones is a jump.
_JUMP = 5.0
# The highest differences that noise is seen from, and by how much a scatter may exceed another one.
_HIGHEST, _SMALLER = 10, 1.3


def samples_of(
    table: xr.Dataset, ball: int, *, start: float | None = None, end: float | None = None
) -> Data:
    """Return the samples of a ball's angle flagged ok or manual, between `start` and `end` [s].

    Raises
    ------
    InputError
        If there is no such ball or nothing is left.
    """
    if isinstance(ball, bool) or ball not in range(1, balls_of(checked_table(table)) + 1):
        known = " or ".join(map(str, range(1, balls_of(table) + 1)))
        raise InputError(f"must be {known} in this table", parameter="ball", value=ball)
    checked_table(table, f"angle_{ball}")
    time, angle = table["time"].values, table[f"angle_{ball}"].values
    is_clean = np.isin(table[f"flag_{ball}"].values.astype(str), CLEAN)
    good = np.isfinite(angle) & is_clean & within(time, start, end)
    if good.sum() < 8:
        raise broken("few_clean", {"ball": ball, "count": good.sum()})
    sigma = table[f"angle_sigma_{ball}"].values[good]
    return one_series(time[good], angle[good], filled(sigma))


def of_own_pivot(
    table: xr.Dataset, system: System, ball: int | None
) -> tuple[xr.Dataset, int | None]:
    """Return the table and the ball that a system of one pivot is about.

    Of two balls that have pivots of their own, that is the table of one of them.

    Raises
    ------
    InputError
        For a system of two balls on one pivot if the balls of the table have pivots of their own.
    """
    if not has_own_pivots(checked_table(table)):
        return table, ball
    if system.angles == 2 or isinstance(system, LatoLato):
        raise broken("own_pivots", {"system": type(system).__name__})
    return table_of_ball(table, 1 if ball is None else ball), 1


def angles_of(
    table: xr.Dataset, system: System, ball: int | None, start: float | None, end: float | None
) -> Data:
    """Return the samples of the angles that a system has, flagged ok; see `samples_of`.

    Of a `LatoLato` with both balls in the table, half the difference of their angles.
    """
    if system.angles == 2:
        if balls_of(table) < 2:
            raise InputError(
                "a BallPair needs a table of two balls", way_out="use a Pendulum or a LatoLato"
            )
        parts = []
        for each in (1, 2):
            part = samples_of(table, each, start=start, end=end)
            parts.append(replace(part, series=np.full(len(part), each)))
        columns = {
            f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Data)
        }
        return Data(**columns)
    if is_mirrored(table, system, ball):
        one, two = (samples_of(table, each, start=start, end=end) for each in (1, 2))
        times, i, j = np.intersect1d(one.times, two.times, return_indices=True)
        sigmas = 0.5 * np.hypot(one.sigmas[i], two.sigmas[j])
        return one_series(times, 0.5 * (one.values[i] - two.values[j]), sigmas)
    data = samples_of(table, 1 if ball is None else ball, start=start, end=end)
    sign = -1.0 if isinstance(system, LatoLato) and ball == 2 else 1.0
    return replace(data, values=sign * data.values)


def is_mirrored(table: xr.Dataset, system: System, ball: int | None) -> bool:
    """Return whether a system's one angle is half the difference of a table's two."""
    return ball is None and isinstance(system, LatoLato) and balls_of(table) == 2


def within(time: Floats, start: float | None = None, end: float | None = None) -> NDArray[np.bool_]:
    """Return which instants lie between `start` and `end`, where given."""
    if start is not None and end is not None and start > end:
        raise broken("part_ends_first", {"end": end}, parameter="start", value=start)
    chosen = np.ones(len(time), dtype=bool)
    if start is not None:
        chosen &= time >= start
    if end is not None:
        chosen &= time <= end
    if not chosen.any():
        raise broken("empty_part", {"first": float(time[0]), "last": float(time[-1])})
    return chosen


def filled(sigma: Floats, otherwise: float = 1.0) -> Floats:
    """Return uncertainties with unknown ones replaced by the median, by `otherwise` without any."""
    known = np.isfinite(sigma) & (sigma > 0.0)
    typical = float(np.median(sigma[known])) if known.any() else otherwise
    return np.where(known, sigma, typical)


def length_of(table: xr.Dataset, length: Any) -> float | None:
    """Return the length that is given, else the table's, else None [m]."""
    if length is None:
        length = table.attrs.get("length")
    return None if length is None else checked_number("length", length, POSITIVE, "m")


def noise_of(values: Floats) -> float:
    """Return the scatter of neighbours about a smooth curve, from differences of high order.

    Of the orders 3 to 10, the first after which none gives a clearly smaller scatter: few samples
    in a swing need more than three, as lower differences still show the swing itself.
    """
    from scipy.stats import median_abs_deviation

    if len(values) < 8:
        return 0.0
    orders = range(3, min(_HIGHEST, len(values) - 4) + 1)
    scatters = [
        float(median_abs_deviation(np.diff(values, n), scale="normal"))
        / math.sqrt(math.comb(2 * n, n))
        for n in orders
    ]
    least = min(scatters)
    return next(each for each in scatters if each <= _SMALLER * least)


def without_repeats(data: Data) -> tuple[Data, int]:
    """Return samples without those that repeat the one before, and how many these are.

    A frame that a film shows twice gives the same angle to the last digit. Where other samples are
    equal as well, angles were rounded, and equal neighbours are no repeats.
    """
    same = np.append(False, np.diff(data.values) == 0.0)
    fresh = data.values[~same]
    if len(np.unique(fresh)) < _DISTINCT * len(fresh):
        return data, 0
    return data[~same], int(same.sum())


def steps_over_gap(times: Floats, rate: float, most: int) -> list[float]:
    """Return by how much a frequency [rad/s] may be off because of the longest gap [rad/s].

    A gap of more than 0.7 periods may hold another number of cycles than it seems to, up to `most`
    more or fewer; a shorter one none.
    """
    gap = float(np.max(np.diff(times), initial=0.0))
    if gap * abs(rate) <= _GAP * math.tau:
        return []
    return [math.tau * n / gap for n in range(-most, most + 1) if n]


def check_turns(data: Data) -> None:
    """Raise InputError if an angle jumps by a turn or half a turn between neighbouring samples."""
    jump = largest_jump(data)
    if jump is None:
        return
    instant, size, usual = jump
    turn = turn_words(size, min((3.0 * usual + 0.02) / math.tau, 0.08))
    if turn and usual < 0.2 * abs(size):
        raise broken("turned_angle", {"turn": turn, "time": instant})


def turn_words(size: float, near: float = 0.02) -> Sentence | None:
    """Return which turn an angle is within a share `near` of, in words; None if of none."""
    for turn, name in ((math.tau, "whole_turn"), (math.pi, "half_turn")):
        if abs(abs(size) - turn) < near * turn:
            return said(name)
    return None


def largest_jump(data: Data) -> tuple[float, float, float] | None:
    """Return the largest lasting jump between neighbouring samples, None without one.

    Its instant [s], its size [rad], and the steps that are usual [rad]. A sample or two elsewhere
    are no jump, and samples on either side of a gap no neighbours.
    """
    steps, pauses = np.diff(data.values), np.diff(data.times)
    usual = float(np.quantile(np.abs(steps), 0.9))
    best: tuple[float, float, float] | None = None
    near = (np.abs(steps) > _JUMP * usual) & (pauses < 2.5 * float(np.median(pauses)))
    for i in np.flatnonzero(near):
        before, after = data.values[max(i - 4, 0) : i + 1], data.values[i + 1 : i + 6]
        size = float(steps[i])
        lasts = abs(float(np.median(after) - np.median(before))) > 0.5 * abs(size)
        if lasts and (best is None or abs(size) > abs(best[1])):
            best = float(data.times[i + 1]), size, usual
    return best


def pivot_swing(table: xr.Dataset, column: str = "pivot_y") -> float:
    """Return half the way that the pivot goes up and down [m], 0 where it is unknown.

    `column` may be ``"pivot_x"``, for its horizontal swing.
    """
    places = table[column].values
    known = places[np.isfinite(places)]
    if len(known) < 8:
        return 0.0
    low, high = np.percentile(known, [2.0, 98.0])
    return 0.5 * float(high - low)


def is_driven(table: xr.Dataset, length: float, column: str = "pivot_y") -> bool:
    """Return whether the pivot moves by more than its track scatters."""
    places = table[column].values
    noise = noise_of(places[np.isfinite(places)])
    return pivot_swing(table, column) > max(_STILL * length, 4.0 * noise)


def check_end(drive: Drive, origin: float, last: float) -> None:
    """Raise InputError if the samples of a drive end before the `last` instant of a table [s].

    The drive's time zero is the instant `origin` of the table [s].
    """
    if isinstance(drive, MeasuredPivot) and drive.times[-1] < last - origin:
        raise broken("end_of_drive", {"latest": origin + drive.times[-1]}, parameter="end")
