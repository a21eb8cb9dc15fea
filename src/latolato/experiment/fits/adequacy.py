"""Goodness of fit: whether one model describes a whole record, and what breaks it if not.

A model that describes a record gives the same numbers for each part of it. So its parameters may
change at an instant, at each of many in turn. If that describes the samples so much better that
noise cannot be the reason, the model does not describe the record. How the motions before and after
differ where they meet tells what happened there: a jump of the phase alone is a piece cut out of
the clock, another frequency is a change of pace, and so on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.fits.least_squares import (
    OUTLIER,
    ConvergenceError,
    Data,
    Floats,
    Solution,
    correlation_of,
    whitened,
)
from latolato.experiment.fits.result import Adequacy
from latolato.experiment.fits.samples import noise_of, turn_words
from latolato.experiment.rules import said

# By how much minus twice the log likelihood must fall for a change to count, for each of the
# parameters that may change and for its instant; see benchmarks/fit_doubt.py for what chance does.
_GAIN = 6.0
# A misfit below this share of the scatter of the values is what trackers bend angles by.
_BENT = 3e-4
# Instants at which a change is looked for, and those about the best one, twice as fine each time.
_PLACES, _FINER = 24, 5
# Fewest samples in a part for each parameter, and periods that it lasts at least.
_FEWEST, SHORTEST = 3, 2.0
# What is left out on either side of a change, as a share of the shortest part.
_CLEAR = 0.1
# Outliers beyond this share are not mistakes of a tracker: the model does not follow.
MOST_OUTLIERS = 0.05
# A richer model must lower the criterion (BIC) by so much; differences beyond are strong.
STRONG = 10.0
# What apparatus does to a swing, as a share of its scatter: angles to a per cent, smoothed samples,
# a length that changes by a thousandth. The deviations of the numbers include that much.
SMALL = 1e-2
# Residuals beyond so many times the noise of the samples are no correlated noise: with neighbours
# correlated by 0.95 it scatters by six times what differences show.
_MOST_SCATTER = 10.0
# Deviations of a part's numbers, as a share of those stated, which follow from the scatter only.
_MORE = 2.0
# What one more change must gain to be part of an explanation.
_PENALTY = 9.0
# Stretches that the noise is looked at in, of so many samples or more, and by what factor it must
# differ to count.
_STRETCHES, _STRETCH, _UNEVEN = 12, 40, 2.0
# The instant of a cut is moved by these shares of the shortest part, with so many samples.
_MOVES, _MOVING = (0.125, 0.06, 0.03, 0.015), 2000

Portrait = Callable[[Solution, Mapping[str, float], float], dict[str, float]]
FitPart = Callable[..., Solution]


@dataclass(frozen=True)
class Cut:
    """An instant between two parts [s], with the samples and the fits of both."""

    instant: float
    early: Data
    late: Data
    before: Solution
    after: Solution
    gain: float

    def bend(self, whole: Solution, data: Data) -> float:
        """Return how far one model is from those of both parts, over the scatter of the values."""
        off = []
        for part, own in ((self.early, self.before), (self.late, self.after)):
            inside = np.isin(data.times, part.times)
            off.append((whole.curve[inside] - own.curve)[own.kept])
        size = float(np.sqrt(np.mean(np.concatenate(off) ** 2)))
        return size / max(float(np.std(data.values)), 1e-300)


@dataclass(frozen=True)
class Kind:
    """A kind of break: which numbers of the motion it changes, and the rule that says it."""

    name: str
    changed: frozenset[str]
    rule: str


def deviance(solutions: Sequence[Solution]) -> float:
    """Return minus twice the log likelihood of samples in parts, up to a constant.

    All parts have one scatter, so that a change of the noise is no break.

    Notes
    -----
    The likelihood is that of a first-order autoregression, whose fresh errors have the variance
    ``s^2 (1 - rho^2)``. A sample that was left out counts as one at the limit.
    """
    total = lost = 0
    fresh = 0.0
    for each in solutions:
        count = int(each.kept.sum())
        fresh += count * each.chi_square * (1.0 - each.correlation**2)
        total += len(each.kept)
        lost += len(each.kept) - count
    variance = fresh / max(total - lost, 1)
    return total * math.log(max(variance, 1e-300)) + lost * OUTLIER**2


def cost(solution: Solution) -> float:
    """Return minus twice the log likelihood, with what is known beforehand."""
    return deviance([solution]) + solution.prior_misfit


def solutions_of(fit: Callable[[Any], Solution], starts: Iterable[Any]) -> list[Solution]:
    """Return the solutions of the starts from which a fit converges, the best one first."""
    found = []
    for start in starts:
        with suppress(ConvergenceError):
            found.append(fit(start))
    return sorted(found, key=cost)


def place_of_change(data: Data, whole: Solution, shortest: float, bent: float = 0.0) -> int | None:
    """Return the sample from which on the parameters of a model are others, None if they are not.

    Parameters
    ----------
    data, whole : Data, Solution
        The samples of one series, and their fit.
    shortest : float
        Duration on either side [s].
    bent : float
        What a track may bend the values by, besides 0.03 % of their scatter.

    Notes
    -----
    A score test (Chow, Econometrica 28 (1960) 591, with an unknown instant): about the solution the
    model is linear, so a change is the residuals' regression on its derivatives after the instant,
    besides those of all samples.
    """
    kept = np.flatnonzero(whole.kept)
    samples = data[kept]
    times, sigmas = samples.times, samples.sigmas
    errors = whole.residuals[kept] / sigmas
    slopes = whole.slopes[kept] / sigmas[:, None]
    slopes = slopes / np.maximum(np.sqrt(np.sum(slopes**2, axis=0)), 1e-300)
    # Where samples scatter more they say less: another noise is no break.
    scale = _noise_in_time(errors)
    errors, slopes = errors / scale, slopes / scale[:, None]
    count, free = slopes.shape
    fewest = _FEWEST * free
    bent = math.hypot(bent, _BENT * float(np.std(data.values)), _rounding_of(data.values))
    floor = (bent / float(np.median(data.sigmas))) ** 2
    together = _likelihood(samples, errors, slopes, floor)

    def gain(place: int) -> float:
        if min(place, count - place) < fewest:
            return -math.inf
        if min(times[place - 1] - times[0], times[-1] - times[place]) < shortest:
            return -math.inf
        late = np.where(np.arange(count)[:, None] < place, 0.0, slopes)
        return together - _likelihood(samples, errors, np.hstack([slopes, late]), floor)

    places = {round(k * count / _PLACES) for k in range(1, _PLACES)}
    places.add(int(np.argmax(np.diff(times))) + 1)
    gains = {place: gain(place) for place in sorted(places)}
    best = max(gains, key=lambda place: gains[place])
    if not gains[best] > _GAIN * (free + 1):
        return None
    step = count / (2 * _PLACES)
    for _ in range(_FINER):
        for place in (round(best - step), round(best + step)):
            if 0 < place < count:
                gains.setdefault(place, gain(place))
        best = max(gains, key=lambda place: gains[place])
        step *= 0.5
    return int(kept[best])


def _noise_in_time(errors: Floats) -> Floats:
    """Return the noise of each error over the typical one, 1 where it hardly changes."""
    stretches = min(_STRETCHES, len(errors) // _STRETCH)
    if stretches < 2:
        return np.ones(len(errors))
    parts = np.array_split(np.arange(len(errors)), stretches)
    sizes = np.array([noise_of(errors[part]) for part in parts])
    typical = float(np.median(sizes))
    if not 0.0 < np.max(sizes) < math.inf or np.max(sizes) < _UNEVEN * np.min(sizes):
        return np.ones(len(errors))
    middles = [float(np.mean(part)) for part in parts]
    ratios = np.maximum(sizes / max(typical, 1e-300), 1.0 / _MOST_SCATTER)
    out: Floats = np.interp(np.arange(len(errors)), middles, ratios)
    return out


def _rounding_of(values: Floats) -> float:
    """Return the deviation that rounding gives values of which most occur several times."""
    distinct = np.unique(values)
    if len(distinct) < 2 or 2 * len(distinct) > len(values):
        return 0.0
    return float(np.min(np.diff(distinct))) / math.sqrt(12.0)


def _likelihood(samples: Data, errors: Floats, slopes: Floats, floor: float) -> float:
    """Return minus twice the log likelihood of errors after regression, up to a constant.

    The errors of the samples are a first-order autoregression.
    """
    everything = np.ones(len(samples), dtype=bool)

    def rest(e: Floats, s: Floats) -> Floats:
        values, *_ = np.linalg.lstsq(s, e, rcond=1e-10)
        out: Floats = e - s @ values
        return out

    rho = correlation_of(samples, rest(errors, slopes))
    white = whitened(samples, everything, rho)
    left = rest(white(errors), white(slopes))
    fresh = float(left @ left) / len(samples) * (1.0 - rho**2) + floor
    return len(samples) * math.log(max(fresh, 1e-300))


def cut_of(data: Data, whole: Solution, fit_part: FitPart, shortest: float) -> Cut | None:
    """The cut between two parts of a record with the fits of both, None where it is one.

    `fit_part` fits the same model to some of the samples, at once where a fit of nearly the same
    samples is given too; other arguments are those of `place_of_change`.

    Raises
    ------
    ConvergenceError
        If there is a change, but no fit of a part converges.
    """
    place = place_of_change(data, whole, shortest)
    return None if place is None else cut_at(data, whole, place, fit_part, shortest)


def cut_at(data: Data, whole: Solution, place: int, fit_part: FitPart, shortest: float) -> Cut:
    """The cut near a sample that divides a record best, with the fits of both parts."""
    at = float(data.times[place])
    # The instant is not sure to a sample, and a part must not hold any of the other one.
    clear = _CLEAR * shortest

    def parts(instant: float) -> tuple[Data, Data]:
        return data[data.times < instant - clear], data[data.times > instant + clear]

    before, after = (fit_part(part) for part in parts(at))
    moved = _moved(data, at, fit_part, (before, after), shortest)
    if moved != at:
        at = moved
        before, after = (fit_part(part) for part in parts(at))
    early, late = parts(at)
    same = replace(whole, kept=whole.kept[np.abs(data.times - at) > clear])
    gain = deviance([same]) - deviance([before, after])
    return Cut(at, early, late, before, after, gain)


def _moved(
    data: Data, at: float, fit_part: FitPart, about: tuple[Solution, Solution], shortest: float
) -> float:
    """Return the instant near `at` where two parts describe the samples best [s].

    The score test takes changes for small ones, which displaces large ones. `about` are the fits of
    both parts there.
    """
    few = data[:: max(1, len(data) // _MOVING)]

    def misfit(instant: float) -> float:
        early = few.times < instant
        try:
            return deviance(
                [fit_part(few[own], near) for own, near in zip((early, ~early), about, strict=True)]
            )
        except InputError:
            return math.inf

    best = (misfit(at), at)
    for share in _MOVES:
        trials = [best[1] + sign * share * shortest for sign in (-1.0, 1.0)]
        best = min(best, *((misfit(each), each) for each in trials))
    return best[1]


def first_cut(data: Data, whole: Solution, fit_part: FitPart, shortest: float) -> Cut | None:
    """Return the earliest cut of a record, with the fits of the parts on either side of it.

    One that bends the curve by no more than apparatus does only where there is no other.
    """
    cut = cut_of(data, whole, fit_part, shortest)
    if cut is None:
        return None
    while True:
        earlier = cut_of(cut.early, cut.before, fit_part, shortest)
        if earlier is None or earlier.bend(cut.before, cut.early) < SMALL:
            break
        cut = earlier
    later = cut_of(cut.late, cut.after, fit_part, shortest)
    if later is None or later.bend(cut.after, cut.late) < SMALL:
        return cut
    return replace(cut, late=later.early, after=later.before)


def widened(whole: Solution, cut: Cut, names: Sequence[str]) -> Solution:
    """Return a solution whose deviations include by how much parameters differ in both parts."""
    factors, intervals = np.ones(len(whole.names)), dict(whole.intervals)
    for i, name in enumerate(whole.names):
        if name in names:
            off = max(abs(p.values[name] - whole.values[name]) for p in (cut.before, cut.after))
            own = whole.estimate(name, "")
            factors[i] = max(1.0, off / max(own.sigma, 1e-300))
            if name in intervals:
                wider = own.widened(factors[i] * own.sigma)
                intervals[name] = (wider.low, wider.high)
    return replace(
        whole, covariance=whole.covariance * np.outer(factors, factors), intervals=intervals
    )


def changes(
    cut: Cut, portrait: Portrait
) -> tuple[dict[str, float], dict[str, float], dict[str, float], Floats]:
    """Return how the motion before a cut differs from the one after it, and how surely.

    Returns
    -------
    before, after, differences : dict
        The numbers of the motion at the cut, and the second less the first.
    covariance : ndarray
        Of the differences, in their order.
    """
    sides, covariances = [], []
    for solution in (cut.before, cut.after):

        def away(p: Mapping[str, float], own: Solution = solution) -> Floats:
            return _less(portrait(own, p, cut.instant), portrait(own, own.values, cut.instant))

        sides.append(portrait(solution, solution.values, cut.instant))
        covariances.append(solution.covariance_of(away))
    before, after = sides
    differences = dict(zip(before, _less(after, before).tolist(), strict=True))
    return before, after, differences, _MORE**2 * (covariances[0] + covariances[1])


def _less(one: Mapping[str, float], other: Mapping[str, float]) -> Floats:
    """Return the differences of the numbers of two motions, of phases within half a turn."""
    away = {name: one[name] - other[name] for name in other}
    if "phase" in away:
        away["phase"] = math.remainder(away["phase"], math.tau)
    return np.array(list(away.values()))


def misfit_of(kind: Kind, differences: Mapping[str, float], covariance: Floats) -> float:
    """Return how badly a kind of break explains differences.

    What it does not change must agree: these differences over their deviations, squared, and a
    penalty for each change.
    """
    same = [i for i, name in enumerate(differences) if name not in kind.changed]
    if not same:
        return _PENALTY * len(kind.changed)
    off = np.array(list(differences.values()))[same]
    inverse = np.linalg.pinv(covariance[np.ix_(same, same)], hermitian=True)
    return float(off @ inverse @ off) + _PENALTY * len(kind.changed)


def misfit_doubt(whole: Solution, data: Data) -> Adequacy | None:
    """Return the doubt if samples scatter too much about a model or too many lie far from it."""
    bent = _BENT * float(np.std(data.values))
    # Samples without noise leave the errors of the computation, of which some are far from others.
    lost = ~whole.kept & (np.abs(whole.residuals) > OUTLIER * bent)
    share = float(np.mean(lost))
    if share <= MOST_OUTLIERS:
        noise = max(noise_of(data.values), bent, 1e-12)
        if whole.scatter <= max(_MOST_SCATTER * noise, SMALL * float(np.std(data.values))):
            return None
        return Adequacy(said("scatters", ratio=whole.scatter / noise), "scatter")
    at = float(data.times[np.flatnonzero(lost)[0]])
    off = float(np.median(np.abs(whole.residuals[lost])))
    numbers = {"share": 100.0 * share, "time": at}
    turn = turn_words(off)
    if turn:
        return Adequacy(said("turned_samples", **numbers, turn=turn), "outliers", at)
    return Adequacy(said("far_samples", **numbers), "outliers", at)
