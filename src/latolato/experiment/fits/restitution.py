"""The coefficient of restitution, impact by impact, from the free flights before and after."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import joined
from latolato.core.quantities import NON_NEGATIVE, POSITIVE
from latolato.core.registry import checked_number
from latolato.experiment.fits.flights import (
    FEWEST,
    ROUGH,
    Flights,
    Pull,
    fit_flights,
    good_flights,
    pull_of,
    shared_changes,
    widening_of,
)
from latolato.experiment.fits.least_squares import Floats
from latolato.experiment.fits.pivots import pivot_for
from latolato.experiment.fits.registry import FitKind, fits
from latolato.experiment.fits.result import Adequacy, Estimate, Fit, make_fit
from latolato.experiment.fits.samples import filled, length_of, within
from latolato.experiment.rules import broken, said
from latolato.experiment.track_table import balls_of, checked_table, has_own_pivots
from latolato.physics.drives import Drive
from latolato.physics.pendulum import GRAVITY

if TYPE_CHECKING:
    import xarray as xr

# Time before and after an impact that its velocities are taken from [s].
_REACH = 0.25
# A jump of the velocity counts from so many of its standard deviations on, at this closing speed
# [rad/s], which must itself be this sure: turns are picked where noise looks like a jump.
_SURE, _SLOWEST, _SURE_SPEED = 6.0, 0.2, 12.0
# A gap at contact may differ from geometry by this share beside its own uncertainty.
_OFF = 0.15
# Impacts in a half of the record that another coefficient is seen from.
_HALF = 5
# Flights that swing faster or slower by this share than the length says are doubted.
_WRONG_PULL = 0.01


def fit_restitution(
    table: xr.Dataset,
    *,
    length: float | None = None,
    radius: float | None = None,
    gravity: float = GRAVITY,
    drive: Drive | None = None,
    start: Annotated[float | None, "s"] = None,
    end: Annotated[float | None, "s"] = None,
) -> Fit:
    """Return the coefficient of restitution of every visible impact, and of all impacts together.

    Paper eq11: for a table with two balls from their relative angular velocity, for one ball
    from its own at a wall.

    Parameters
    ----------
    table : xarray.Dataset
        A track table; samples flagged ok count.
    length : float, optional
        Pivot to ball centre [m]; by default the table's.
    radius : float, optional
        Radius of a ball [m], by default the table's: the gap at contact is then checked.
    gravity : float
        Gravitational acceleration [m/s^2].
    drive : Drive, optional
        How the pivot moves; by default as measured.
    start : float, optional
        First instant used [s].
    end : float, optional
        Last instant used [s].

    Returns
    -------
    Fit
        With `restitution`, pooled, and on ``impact`` the `contact_time`, the
        `angular_velocity_before` and `angular_velocity_after` (of the separation for two balls),
        `restitution_each` and its standard deviation.

    Raises
    ------
    InputError
        For bad input, or if no impact is seen well enough.

    Notes
    -----
    Before and after each reversal of the separation the pendulum equation is fitted to up to 0.25 s
    of each ball's samples, with the drag that all flights share as one more unknown; both are
    carried to the instant at which they meet. Impacts with fewer than 5 samples on a side (a rattle
    of short bounces), with closing speeds below 0.2 rad/s or 12 of their standard deviations are
    counted as unseen. If all flights together ask for another ``g/l`` than that of the length, by
    more than 1 % and 6 of its deviations, the fit is doubted. The pooled deviation grows with the
    scatter of the impacts, so that it holds if e varies; the verdict mentions a dependence on
    speed.
    """
    if has_own_pivots(checked_table(table)):
        raise broken("two_pivots")
    length = length_of(table, length)
    if length is None:
        raise broken("flights_length", parameter="restitution")
    radius = table.attrs.get("radius") if radius is None else radius
    radius = None if radius is None else checked_number("radius", radius, NON_NEGATIVE, "m")
    gravity = checked_number("gravity", gravity, POSITIVE, "m/s^2")
    record = _record(table, start, end)
    two = len(record.angles) == 2
    first, last = float(record.time[0]), float(record.time[-1])
    moving = pivot_for(drive, table, length, first, last)
    pull = pull_of(moving.drive, moving.origin, gravity, length, last)
    drag = _shared_drag(record, pull)
    contact = 2.0 * math.asin(min(radius / length, 1.0)) if radius and two else None

    def seen(pull: Pull, drag: _Drag) -> dict[float, _Impact]:
        candidates = ((turn.instant, _impact(record, turn, pull, drag)) for turn in record.turns)
        return {t: each for t, each in candidates if each and _is_at_contact(each, contact)}

    found = seen(pull, drag)
    impacts = list(found.values())
    unseen = len(record.turns) - len(impacts)
    if not impacts:
        raise broken("no_impact", {"count": unseen})
    each = np.array([i.restitution for i in impacts])
    deviations = np.array([i.sigma for i in impacts])
    speeds = np.array([abs(i.before) for i in impacts])
    pooled, scatter, speed = _pooled(each, deviations, speeds)
    # What all impacts share: the drag, and the pivot's motion.
    dragged = seen(pull, replace(drag, rate=drag.rate + drag.sigma))
    shared = _shift(found, dragged) ** 2
    deviations = np.hypot(deviations, [_shift({t: each}, dragged) for t, each in found.items()])
    for other, weight in moving.others:
        moved = pull_of(other, moving.origin, gravity, length, last)
        shared += weight * _shift(found, seen(moved, drag)) ** 2
    pooled = Estimate(pooled.value, math.sqrt(pooled.sigma**2 + shared), "1")
    curves = {
        "contact_time": ("impact", np.array([i.time for i in impacts])),
        "angular_velocity_before": ("impact", np.array([i.before for i in impacts])),
        "angular_velocity_after": ("impact", np.array([i.after for i in impacts])),
        "restitution_each": ("impact", each),
        "restitution_each_sigma": ("impact", deviations),
        "separation_at_contact": ("impact", np.array([i.gap for i in impacts])),
        "time": ("sample", record.time),
        "separation": ("sample", record.gap),
    }
    about = {
        "start": first, "end": last, "impacts": len(impacts), "unseen": unseen, "length": length,
        "radius": radius, "gravity": gravity, "damping_rate": drag.rate, "pivot": moving.words,
        "of": "two balls" if two else "one ball and a wall", "source": table.attrs.get("source"),
    }  # fmt: skip
    rule = "restitution_balls" if two else "restitution_wall"
    count = len(impacts)
    words = [said(rule, value=str(pooled), count=count, scatter=scatter, speed=speed)]
    if unseen:
        words.append(said("smooth_reversals", count=unseen))
    adequacy = _pull_doubt(drag.pull, length)
    if adequacy.describes and not speed:
        adequacy = _doubt(impacts)
    return make_fit(
        "restitution", {"restitution": pooled}, joined(words), curves, about, adequacy=adequacy
    )


fits.register("restitution")(FitKind(function=fit_restitution, title="Restitution", fewest_balls=2))


@dataclass(frozen=True)
class _Turn:
    """An instant at which the gap turns round, and the samples of the flights on both sides."""

    instant: float
    before: NDArray[np.int64]
    after: NDArray[np.int64]


@dataclass(frozen=True)
class _Record:
    """The samples of all balls (NaN where not ok), the gap between them and its turns."""

    time: Floats
    angles: list[Floats]
    sigmas: list[Floats]
    gap: Floats
    turns: list[_Turn]

    def flights(
        self, turn: _Turn, instant: float, pull: Pull, drag: float, widen: float = 1.0
    ) -> tuple[Flights | None, Flights | None]:
        """Return the flights before and after a turn, carried to an instant."""
        before, after = (
            fit_flights(self.time, self.angles, self.sigmas, side, instant, pull, drag, widen)
            for side in (turn.before, turn.after)
        )
        return before, after


@dataclass(frozen=True)
class _Drag:
    """The drag that all flights share [1/s], and how well they follow it.

    `spread` is the typical misfit of a flight, `widen` what correlated errors widen, and `pull` the
    factor of (g + y0'')/l that flights ask for, with its deviation.
    """

    rate: float
    sigma: float
    spread: float
    widen: float
    pull: tuple[float, float]


@dataclass(frozen=True)
class _Impact:
    """One impact: its instant, velocities of the gap, the gap, and what follows."""

    time: float
    before: float
    after: float
    gap: float
    gap_sigma: float
    sigma: float

    @property
    def restitution(self) -> float:
        """Speed after over speed before."""
        return -self.after / self.before


def _record(table: xr.Dataset, start: float | None, end: float | None) -> _Record:
    """Return the samples of a table and the turns of the gap.

    Raises
    ------
    InputError
        For too few samples, and without a turn.
    """
    chosen = within(table["time"].values, start, end)
    two = balls_of(table) == 2
    angles, sigmas = [], []
    for each in (1, 2) if two else (1,):
        angle = table[f"angle_{each}"].values[chosen].copy()
        angle[table[f"flag_{each}"].values[chosen] != "ok"] = np.nan
        if np.isfinite(angle).sum() < 2 * FEWEST:
            raise broken("few_ok", {"ball": each, "count": 2 * FEWEST})
        angles.append(angle)
        sigmas.append(filled(table[f"angle_sigma_{each}"].values[chosen]))
    time = table["time"].values[chosen]
    gap = angles[0] - angles[1] if two else angles[0]
    instants = _turns(time, gap)
    if not instants:
        raise broken("no_reversal")
    turns = [_Turn(instant, *_sides(time, gap, instants, k)) for k, instant in enumerate(instants)]
    return _Record(time, angles, sigmas, gap, turns)


def _shared_drag(record: _Record, pull: Pull) -> _Drag:
    """Return the drag that describes the flights before and after all turns best."""
    rate = 0.0
    for _ in range(3):
        pairs = [record.flights(turn, turn.instant, pull, rate) for turn in record.turns]
        good = good_flights([flights for pair in pairs for flights in pair])
        (change,), (sigma,) = shared_changes(good, 1)
        rate = min(max(rate + float(change), 0.0), 10.0)
    spread = float(np.median([flights.spread for flights in good])) if good else 1.0
    (_, faster), (_, error) = shared_changes(good, 2)
    return _Drag(rate, float(sigma), spread, widening_of(good), (1.0 + faster, error))


def _turns(time: Floats, gap: Floats) -> list[float]:
    """Return the instants at which a gap turns round, with or without an impact."""
    known = np.flatnonzero(np.isfinite(gap))
    slopes = np.diff(gap[known]) / np.diff(time[known])
    noise = 1.4826 * float(np.median(np.abs(np.diff(slopes)))) + 1e-12
    # Small slopes are of either sign by noise alone.
    clear = np.flatnonzero(np.abs(slopes) >= min(noise, _SLOWEST))
    turned = np.flatnonzero(np.diff(np.sign(slopes[clear])))
    before, after = time[known[clear[turned] + 1]], time[known[clear[turned + 1]]]
    turns: list[float] = (0.5 * (before + after)).tolist()
    return turns


def _sides(
    time: Floats, gap: Floats, turns: list[float], k: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the samples of the flights before and after a turn, clear of it and the next ones."""
    clear = 0.75 * float(np.median(np.diff(time)))
    before = max(turns[k] - _REACH, turns[k - 1] + clear if k else -math.inf)
    after = min(turns[k] + _REACH, turns[k + 1] - clear if k + 1 < len(turns) else math.inf)
    known = np.isfinite(gap)
    left = known & (time >= before) & (time < turns[k] - clear)
    right = known & (time <= after) & (time > turns[k] + clear)
    return np.flatnonzero(left), np.flatnonzero(right)


def _shift(impacts: Mapping[float, _Impact], others: Mapping[float, _Impact]) -> float:
    """Return by how much the mean of the same impacts differs; both are by their turns."""
    same = impacts.keys() & others.keys()
    if not same:
        return 0.0
    changes = [others[turn].restitution - impacts[turn].restitution for turn in same]
    return float(np.average(changes, weights=[impacts[turn].sigma ** -2 for turn in same]))


def _impact(record: _Record, turn: _Turn, pull: Pull, drag: _Drag) -> _Impact | None:
    """Return the impact at a turn, None if none is seen there."""
    instant = turn.instant
    for _ in range(3):
        before, after = record.flights(turn, instant, pull, drag.rate, drag.widen)
        if before is None or after is None:
            return None
        if max(before.spread, after.spread) > ROUGH * drag.spread:
            return None
        (gap, approach), (gap_sigma, approach_sigma) = before.separation, before.separation_sigma
        (later, recession), (later_sigma, sigma) = after.separation, after.separation_sigma
        if abs(recession - approach) < max(_SURE * math.hypot(approach_sigma, sigma), _SLOWEST):
            return None
        meets = _meets(before, after)
        shift = (gap - later) / (recession - approach)
        # Never beyond the samples on either side.
        low, high = float(record.time[turn.before[-1]]), float(record.time[turn.after[0]])
        instant = min(max(instant + shift, low), high)
    slowest = max(_SLOWEST, _SURE_SPEED * approach_sigma)
    if not (abs(approach) > slowest and approach * recession < 0.0):
        return None
    ratio = -recession / approach
    sigma = math.hypot(sigma, ratio * approach_sigma) / abs(approach)
    # Two impacts within one look: they gain speed, or the balls would have to jump.
    if ratio > 1.0 + _SURE * sigma or not meets:
        return None
    return _Impact(
        time=instant, before=approach, after=recession, gap=0.5 * (gap + later),
        gap_sigma=math.hypot(gap_sigma, later_sigma), sigma=sigma,
    )  # fmt: skip


def _meets(before: Flights, after: Flights) -> bool:
    """Return whether every ball is where it was, as its flights on both sides have it."""
    away = np.abs(before.states[:, 0] - after.states[:, 0])
    sigmas = np.sqrt(before.covariances[:, 0, 0] + after.covariances[:, 0, 0])
    return bool(np.all(away <= _SURE * sigmas))


def _is_at_contact(impact: _Impact, contact: float | None) -> bool:
    """Return whether an impact happens where balls of this radius touch, bottom or top."""
    if contact is None:
        return True
    gap = abs(impact.gap) % math.tau
    away = min(abs(gap - contact), abs(math.tau - gap - contact))
    return away < _OFF * contact + 5.0 * impact.gap_sigma


def _pull_doubt(pull: tuple[float, float], length: float) -> Adequacy:
    """Return whether the flights are those of a pendulum of this length."""
    factor, sigma = pull
    if abs(factor - 1.0) <= max(_WRONG_PULL, _SURE * sigma):
        return Adequacy()
    share = 100.0 * abs(math.sqrt(factor) - 1.0)
    rule = "balls_faster" if factor > 1.0 else "balls_slower"
    return Adequacy(said(rule, percent=share, length=length), "length")


def _doubt(impacts: Sequence[_Impact]) -> Adequacy:
    """Return whether one coefficient describes all impacts: that of both halves of the record."""
    half = len(impacts) // 2
    if half < _HALF:
        return Adequacy()
    values = np.array([impact.restitution for impact in impacts])
    sigmas = np.array([impact.sigma for impact in impacts])
    means, errors = [], []
    for part in (slice(None, half), slice(half, None)):
        mean, *_ = _pooled(values[part], sigmas[part], np.zeros(len(values[part])))
        means.append(mean.value)
        errors.append(max(mean.sigma, float(np.std(values[part])) / math.sqrt(half)))
    if abs(means[1] - means[0]) <= _SURE * math.hypot(*errors):
        return Adequacy()
    at = impacts[half].time
    before, after = (f"{mean:.3f}" for mean in means)
    return Adequacy(said("changed_restitution", before=before, time=at, after=after), "change", at)


def _chi_square(each: Floats, weights: Floats) -> float:
    """Return the weighted sum of squares about the weighted mean."""
    return float(np.sum(weights * (each - np.average(each, weights=weights)) ** 2))


def _excess(each: Floats, sigmas: Floats) -> float:
    """Return the variance beyond the sigmas that makes chi-square what it should be.

    Paule & Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377: more than 0 wherever the reduced
    chi-square is more than 1.
    """
    from scipy.optimize import brentq

    def surplus(extra: float) -> float:
        return _chi_square(each, 1.0 / (sigmas**2 + extra)) - (len(each) - 1)

    # All as far apart as the outermost two: more cannot be needed.
    return float(brentq(surplus, 0.0, float(np.ptp(each)) ** 2 * len(each)))


def _pooled(each: Floats, sigmas: Floats, speeds: Floats) -> tuple[Estimate, str, str]:
    """Return the pooled coefficient, and words on its scatter and on speed."""
    scatter = speed = ""
    count, weights = len(each), 1.0 / sigmas**2
    chi_square = _chi_square(each, weights) / max(count - 1, 1)
    wider = math.sqrt(max(chi_square, 1.0))
    if count > 3 and chi_square > 1.0 + 3.0 * math.sqrt(2.0 / (count - 1)):
        # Impacts differ by more than they are uncertain: all count nearly alike then.
        extra = _excess(each, sigmas)
        weights, wider = 1.0 / (sigmas**2 + extra), 1.0
        scatter = said("impacts_differ", extra=math.sqrt(extra))
    mean = float(np.average(each, weights=weights))
    own = wider / math.sqrt(float(np.sum(weights)))
    if count > 5 and np.ptp(speeds) > 0.0:
        late = speeds - np.average(speeds, weights=weights)
        slope = float(np.sum(weights * late * each) / np.sum(weights * late**2))
        spread = 1.0 / math.sqrt(float(np.sum(weights * late**2)))
        if abs(slope) > 4.0 * spread:
            rule = "restitution_falls" if slope < 0.0 else "restitution_grows"
            speed = said(rule, slope=abs(slope))
    return Estimate(mean, own, "1"), scatter, speed
