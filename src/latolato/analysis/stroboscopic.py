"""Runs sampled once per drive period, and what follows from their samples."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.core.quantities import Quantity
from latolato.observables.period import (
    LONGEST,
    PERIODICITY,
    ResponseSamples,
    Samples,
    find_mirror,
    find_period,
)
from latolato.observables.strings import SlackFraction
from latolato.physics.drives import Drive
from latolato.physics.pendulum import LatoLato, System
from latolato.sweeps import sweep
from latolato.sweeps.statuses import has_answer

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

# Variables of `motion_of` that latolato.core.quantities does not know.
QUANTITIES_HERE: dict[str, Quantity] = {
    **ResponseSamples.variables,
    "rotation_number": Quantity("1", r"\rho", "full turns, swings or impacts per drive period"),
}
# Of a normal distribution, within which 95 % lie.
_Z95 = 1.959963984540054
# What becomes smaller while a motion settles; by which factor: twice, or once. Set by trial on a
# few slow decays and toys that are chaotic in bursts.
_DECAYING = ("largest_angle_watched", "fastest_speed", "recurrence_residual")
_SLOWED, _FALLEN = 0.8, 0.5
# Motion that recurs so closely is nearly periodic [rad].
_NEARLY = 0.05


def run_samples(
    system: System,
    drive: Drive,
    axes: Mapping[str, Any],
    *,
    longest: int,
    angle_tolerance: float,
    transient_periods: float,
    slowest_frequency: float | None = None,
    **options: Any,
) -> xr.Dataset:
    """Return a sweep with the samples of the last drive periods after a transient.

    `slowest_frequency` [rad/s] is that of the drive where it varies; `options` are those of
    `latolato.sweep`.
    """
    watched = ResponseSamples(longest=longest, angle_tolerance=angle_tolerance)
    slowest = slowest_frequency or drive.drive_frequency  # type: ignore[attr-defined]
    # A little longer, so that the last mark is inside for every rounding.
    duration = math.tau / slowest * (transient_periods + watched.marks - 1) * (1.0 + 1e-12)
    strings = [SlackFraction()] if system.suspension == "string" else []
    wanted = [watched, *strings]
    return sweep(system, drive, axes=axes, duration=duration, observables=wanted, **options)


def settled_motion(
    system: System,
    drive: Drive,
    axes: Mapping[str, Any],
    frequency: Any,
    *,
    transient_periods: float,
    longest: int,
    angle_tolerance: float,
    **options: Any,
) -> dict[str, NDArray[Any]]:
    """Return period, rotation number, symmetry, samples and status of motions, settled or not.

    Arrays as those of `motion_of`, for the points of `axes` in C order.

    Motion without a period is run again with two and four times the transient, and where it seems
    to settle with eight times, watched for longer. It is "not settled" where it has a period then,
    and where it goes on to settle. `frequency` is as in `motion_of`. The limits above are a rule of
    thumb from a few motions; for what it gets wrong see `latolato.analysis.response_period`.
    """

    def look(
        which: Mapping[str, Any], periods: float, at: Any, most: int
    ) -> dict[str, NDArray[Any]]:
        limits: dict[str, Any] = {"longest": most, "angle_tolerance": angle_tolerance}
        grid = run_samples(system, drive, which, transient_periods=periods, **limits, **options)
        return motion_of(grid, system, at, **limits)

    motion = look(axes, transient_periods, frequency, longest)
    status = motion["status"]
    each = np.broadcast_to(np.asarray(frequency, dtype=np.float64).ravel(), status.shape)
    left = np.flatnonzero(status == "aperiodic")
    looks = [{name: motion[name][left] for name in _DECAYING}]
    waited = max(transient_periods, ResponseSamples(longest=longest).marks - 1.0)
    for times, most in ((1.0, longest), (3.0, longest), (7.0, LONGEST)):
        if not left.size:
            break
        periods = transient_periods + times * waited
        now = look(_chosen(axes, left), periods, each[left], most)
        result = np.isin(now["status"], PERIODICITY[:-1]) & (now["response_period"] <= longest)
        keep = np.isin(now["status"], PERIODICITY) & ~result
        looks.append(now)
        if len(looks) == 3:
            keep &= _seems_to_settle(*looks)
        elif len(looks) == 4:
            result |= keep & _goes_on_to_settle(looks)
        status[left[result]] = "not settled"
        left = left[keep]
        looks = [{name: row[name][keep] for name in _DECAYING} for row in looks]
    return motion


def settled_cases(
    system: System, drive: Drive, case: Mapping[str, Floats], frequency: Floats, **options: Any
) -> dict[str, NDArray[Any]]:
    """Return `settled_motion` of points along one axis, run by octaves of frequency.

    Every point has at least the transient, the faster ones up to twice that.
    """
    result: dict[str, NDArray[Any]] = {}
    for part in octaves(frequency):
        motion = settled_motion(
            system,
            drive,
            {"case": {name: values[part] for name, values in case.items()}},
            frequency[part],
            slowest_frequency=float(frequency[part].min()),
            **options,
        )
        for name, values in motion.items():
            shape = (len(frequency), *values.shape[1:])
            result.setdefault(name, np.empty(shape, values.dtype))[part] = values
    return result


def _seems_to_settle(
    first: Mapping[str, Floats], second: Mapping[str, Floats], third: Mapping[str, Floats]
) -> NDArray[np.bool_]:
    """Return which aperiodic motions die down over three looks, as chaos in bursts may do too."""
    result = np.zeros(len(third["largest_angle_watched"]), dtype=bool)
    for name in _DECAYING:
        a, b, c = first[name], second[name], third[name]
        result |= ((b < _SLOWED * a) & (c < _SLOWED * b)) | (c < _FALLEN * b)
    return result


def _goes_on_to_settle(looks: Sequence[Mapping[str, Floats]]) -> NDArray[np.bool_]:
    """Return which motions are less than ever at the last look, or ever nearer to a period."""
    angle, speed, residual = (
        row[-1] < _SLOWED * row[:-1].min(axis=0)
        for row in (np.array([each[name] for each in looks]) for name in _DECAYING)
    )
    nearly = np.array([each["recurrence_residual"] for each in looks]).max(axis=0) < _NEARLY
    return np.asarray((angle & speed) | (residual & nearly))


def _chosen(axes: Mapping[str, Any], places: NDArray[np.int64]) -> dict[str, Any]:
    """Return one axis with some of the points that axes span, counted in C order."""
    columns = [
        {name: np.asarray(each) for name, each in values.items()}
        if isinstance(values, Mapping)
        else {axis: np.asarray(values)}
        for axis, values in axes.items()
    ]
    indices = np.unravel_index(places, [len(next(iter(c.values()))) for c in columns])
    return {
        "case": {
            name: values[index]
            for column, index in zip(columns, indices, strict=True)
            for name, values in column.items()
        }
    }


def motion_of(
    grid: xr.Dataset,
    system: System,
    frequency: Any,
    *,
    longest: int,
    angle_tolerance: float,
) -> dict[str, NDArray[Any]]:
    """Return period, rotation number, symmetry, samples and status of the points of `run_samples`.

    Arrays of shape (point,), of samples (point, [ball,] sample), points in C order; `frequency`
    is that of the drive [rad/s], of the same shape or one number. A ball that hangs on its string
    and hops straight up and down has the status "slackens" instead of "rest".
    """
    two = system.angles == 2
    words = grid["status"].values.ravel()
    failed = ~has_answer(words)
    count = len(words)
    each = np.broadcast_to(np.asarray(frequency, dtype=np.float64).ravel(), (count,))

    def of(name: str) -> Floats:
        shape = (count, 2) if two else (count,)
        return np.asarray(grid[name].values, dtype=np.float64).reshape(shape)

    def either(name: str) -> Floats:
        """Return the larger value of both balls."""
        return of(name).max(axis=1) if two else of(name)

    balls = 2 if two else 1
    angle, velocity = (
        np.asarray(grid[f"section_{name}"].values).reshape(count, balls, -1)
        for name in ("angle", "angular_velocity")
    )
    period, residual, kind = (
        of(n) for n in ("response_period", "recurrence_residual", "periodicity")
    )
    numbers = np.stack([angle, velocity], axis=2)  # (point, ball, 2, sample)
    marks = numbers.shape[-1]
    samples = Samples(0, marks, 1, 2 * marks, marks, balls)
    if two:
        kinds = kind
        period, residual = np.full((2, count), math.nan)
        for k in np.flatnonzero(np.isfinite(kinds).all(axis=1)):
            period[k], residual[k] = find_period(
                numbers[k].ravel().tolist(), samples, each[k], longest, angle_tolerance
            )
        kind = np.where(np.isfinite(period), 1.0, 3.0)
        kind = np.where((kind == 1.0) & (kinds == 2.0).any(axis=1), 2.0, kind)
        rests = (kinds == 0.0).all(axis=1)
        kind, period = np.where(rests, 0.0, kind), np.where(rests, 1.0, period)
        kind = np.where(np.isnan(kinds).any(axis=1), math.nan, kind)
    period = np.where(np.isnan(kind), math.nan, period)
    if isinstance(system, LatoLato):  # its left ball is the mirror image at every instant
        mirror = shift = np.where(np.isfinite(period), 0.0, math.nan)
    elif two:
        mirror, shift = np.full((2, count), math.nan)
        for k in np.flatnonzero(np.isfinite(period)):
            mirror[k], shift[k] = find_mirror(
                numbers[k].ravel().tolist(), samples, each[k], period[k]
            )
    else:
        mirror, shift = of("mirror_residual"), of("mirror_shift")
    turns = of("turns_per_period")
    if two:  # of the one that turns more
        turns = np.take_along_axis(turns, abs(turns).argmax(axis=1)[:, None], axis=1)[:, 0]
    windings, impacts = either("windings"), either("impacts_per_period")
    rotation = np.where(turns != 0.0, turns, windings)
    rotation = np.where(np.isfinite(period), rotation, math.nan)
    if system.has_contacts:
        rotation = impacts
    status = np.array(["failed"] * count, dtype="<U12")
    for number, name in enumerate(PERIODICITY):
        status[kind == number] = name
    if "slack_fraction" in grid:  # a ball that hops straight up and down, which angles do not show
        hops = (status == PERIODICITY[0]) & (either("slack_fraction") > 0.0)
        status[hops], period[hops], rotation[hops] = "slackens", math.nan, math.nan
    status[failed] = words[failed]
    return {
        "response_period": period,
        "rotation_number": rotation,
        "windings": windings,
        "turns_per_period": turns,
        "impacts_per_period": impacts,
        "mirror_residual": mirror,
        "mirror_shift": shift,
        "recurrence_residual": residual,
        "largest_angle_watched": either("largest_angle_watched"),
        "fastest_speed": either("fastest_speed"),
        "status": status,
        "section_angle": angle if two else angle[:, 0],
        "section_angular_velocity": velocity if two else velocity[:, 0],
    }


def wilson_interval(count: Any, total: Any) -> tuple[Floats, Floats, Floats]:
    """Return a share and the ends of its 95 % interval [1] (Wilson, 1927).

    Parameters
    ----------
    count, total : array_like of int
        How many of how many; NaN for a total of zero.

    Raises
    ------
    InputError
        For counts that are not within their totals.

    Examples
    --------
    >>> share, low, high = wilson_interval(0, 10)
    >>> print(f"{share:.3f} in [{low:.3f}, {high:.3f}]")
    0.000 in [0.000, 0.278]
    """
    for name, value in (("count", count), ("total", total)):
        if np.asarray(value).dtype.kind not in "iu":
            raise InputError("must hold whole numbers", parameter=name, value=value)
    k, n = np.asarray(count, dtype=np.float64), np.asarray(total, dtype=np.float64)
    if not np.all((k >= 0.0) & (k <= n)):
        raise InputError("must lie between 0 and total", parameter="count", value=count)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = k / n
        square = _Z95**2 / n
        middle = (share + 0.5 * square) / (1.0 + square)
        half = np.sqrt(square * (share * (1.0 - share) + 0.25 * square)) / (1.0 + square)
    low, high = np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
    return share, np.minimum(low, share), np.maximum(high, share)


def octaves(frequencies: Floats) -> list[NDArray[np.int64]]:
    """Return the places of frequencies within a factor of two of each other, slowest first.

    Runs of equal duration then spend at most twice the periods they must.
    """
    order = np.argsort(frequencies, kind="stable")
    parts: list[list[int]] = []
    for place in order:
        if not parts or frequencies[place] > 2.0 * frequencies[parts[-1][0]]:
            parts.append([])
        parts[-1].append(int(place))
    return [np.array(sorted(part)) for part in parts]
