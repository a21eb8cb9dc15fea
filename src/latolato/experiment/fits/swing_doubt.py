"""Whether the equation of a free swing describes a record, and what is the likely reason if not."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.fits.adequacy import (
    Cut,
    Kind,
    changes,
    deviance,
    first_cut,
    misfit_doubt,
    misfit_of,
    place_of_change,
)
from latolato.experiment.fits.free_swing import fit_best, part_fitter, portrait
from latolato.experiment.fits.least_squares import ConvergenceError, Data, Guess, Solution
from latolato.experiment.fits.result import Adequacy
from latolato.experiment.fits.samples import noise_of
from latolato.experiment.fits.sight import ABOVE, ASIDE
from latolato.experiment.fits.swings import period_factor

# Periods in the shortest part of a record.
_SHORTEST = 2.0
# By how much another explanation of the whole record must beat two parts.
_CLEAR = 10.0
# Periods that a cut may have taken out of a clock.
_MOST_PERIODS = 1000
# An offset within this of a turn is one, and a factor within this of that of degrees.
_NEAR = 0.02
# Factors to other units, and what is wrong if angles times that are those of a pendulum.
_UNITS = (
    (
        180.0 / math.pi,
        "its period changes with the size of the swing as if the angles were degrees: radians seem "
        "to have been taken for degrees",
    ),
    (
        math.pi / 180.0,
        "its period does not change with the size of the swing as a pendulum's does. Were degrees "
        "taken for radians, or is it no pendulum",
    ),
)
# Standard deviations from which a growth is seen.
_GROWS = 3.0
# Scatter over noise that is worth telling.
_FAR_OFF = 1.5
_FULLEST = ("linear", "quadratic", "coulomb")
_ALL = frozenset({"amplitude", "phase", "frequency", "offset", "drag"})
_KINDS = [
    Kind(
        "phase jump",
        frozenset({"phase"}),
        "the swing jumps ahead by {share:.2g} of a period there: a piece of {lost} seems to be "
        "missing from the clock",
    ),
    Kind(
        "change of pace",
        frozenset({"frequency"}),
        "from there on everything happens {pace}: slow motion, another frame rate, or another "
        "length",
    ),
    Kind(
        "change of drag",
        frozenset({"drag"}),
        "the decay rate changes there from {drag_before:.3g} to {drag_after:.3g} 1/s",
    ),
    Kind("shifted angle", frozenset({"offset"}), "the angle shifts there by {offset}"),
    Kind(
        "two films",
        frozenset({"amplitude", "phase"}),
        "the swing changes there at once, from {size_before:.3g} to {size_after:.3g} rad: two "
        "films were joined, or something touched the ball",
    ),
    Kind(
        "another motion",
        _ALL,
        "another motion begins there, with a period of {period_after:.4g} s instead of "
        "{period_before:.4g} s: two films were joined, the film's pace changes, or the pendulum "
        "was changed",
    ),
]


def doubt_of(
    data: Data,
    whole: Solution,
    terms: Sequence[str],
    aside: Mapping[str, Guess],
    *,
    alone: bool,
) -> Adequacy:
    """Return whether the equation describes a record.

    Parameters
    ----------
    data, whole : Data, Solution
        The samples and their fit.
    terms : sequence of str
        Drags of the equation.
    aside : mapping of str to Guess
        How the table sees angles.
    alone : bool
        Whether no other solution describes the samples nearly as well.
    """
    if not alone:
        at = float(data.times[int(np.argmax(np.diff(data.times)))])
        return Adequacy(
            "The record does not tell how many swings there were in its gap at "
            f"{at:.4g} s: several lengths describe it equally well.",
            "gap",
            at,
        )
    for name, place in ((ABOVE, "above"), (ASIDE, "beside")):
        if name in whole.beyond_priors:
            return Adequacy(
                f"The fit is not to be believed: it puts the pivot {abs(whole.values[name]):.2g} "
                f"of the arm {place} where the table has it, {abs(whole.beyond_priors[name]):.2g} "
                "times the uncertainty that the table states.",
                "pivot",
            )
    few = misfit_doubt(whole, data)
    fit_part = part_fitter(whole, terms, aside)
    period = math.tau / whole.values["natural_frequency"]
    ratio = whole.scatter / max(noise_of(data.values), 1e-300)
    size = f" (scatter {ratio:.2g} times the noise of the samples)" if ratio > _FAR_OFF else ""
    try:
        cut = first_cut(data, whole, fit_part, _SHORTEST * period)
    except ConvergenceError:
        return Adequacy(f"The equation does not describe this record{size}.", "unknown")
    if cut is None:
        return few or Adequacy()
    words = _of_whole(data, whole, cut, terms, aside)
    if words is not None:
        return Adequacy(f"The equation does not describe this record: {words[1]}.", words[0])
    kind, told = _of_cut(cut)
    return Adequacy(
        f"The equation does not describe this record{size}: it fails from {cut.instant:.4g} s on, "
        f"and it looks as if {told}.",
        kind,
        cut.instant,
    )


def _of_whole(
    data: Data,
    whole: Solution,
    cut: Cut,
    terms: Sequence[str],
    aside: Mapping[str, Guess],
) -> tuple[str, str] | None:
    """Return what explains the whole record better than two parts do: a kind, and words."""
    bar = deviance([whole]) - cut.gain
    found: list[tuple[float, str, str]] = []
    first = {**dict.fromkeys(_FULLEST, 1e-3), **whole.values}
    for factor, name in _UNITS:
        other = Data(data.times, factor * data.values, factor * data.sigmas, data.series)
        if np.ptp(other.values) > math.tau:
            continue
        scaled = {n: factor * first[n] for n in
                  ("initial_angle", "initial_angular_velocity", "angle_offset")}  # fmt: skip
        found += _tried(other, {**first, **scaled}, terms, aside, "unit", name)
    if set(terms) != set(_FULLEST):
        name = f"the drag is not {'+'.join(terms)}: compare the laws of drag, or use law 'best'"
        shared = {term: max(first[term], 1e-3) for term in _FULLEST}
        found += _tried(data, {**first, **shared}, _FULLEST, aside, "drag law", name)
    if not found:
        return None
    best, kind, words = min(found)
    return (kind, words) if best < bar + _CLEAR else None


def _tried(
    data: Data,
    first: Mapping[str, float],
    terms: Sequence[str],
    aside: Mapping[str, Guess],
    kind: str,
    words: str,
) -> list[tuple[float, str, str]]:
    """Return what another model of the whole record gives, nothing where that fails."""
    try:
        solution, _ = fit_best(data, first, terms, aside)
    except InputError:
        return []
    period = math.tau / solution.values["natural_frequency"]
    if place_of_change(data, solution, _SHORTEST * period) is not None:
        return []
    rate, sigma = 0.5 * solution.values.get("linear", 0.0), 0.0
    if rate < 0.0:
        sigma = 0.5 * solution.sigma("linear")
    if rate < -_GROWS * sigma:
        words += f"; the swing grows by {-rate:.3g} 1/s"
    return [(deviance([solution]), kind, words)]


def _pace_words(pace: float) -> str:
    """Return how much faster or slower things happen, in words."""
    quick, ratio = ("fast", pace) if pace > 1.0 else ("slowly", 1.0 / pace)
    if ratio > 1.2:
        return f"{ratio:.3g} times as {quick}"
    return f"{100.0 * (ratio - 1.0):.2g} % {'faster' if quick == 'fast' else 'more slowly'}"


def _of_cut(cut: Cut) -> tuple[str, str]:
    """Return the kind of break at a cut, and what it looks like."""
    before, after, names, covariance = changes(cut, portrait)
    off = {name: after[name] - before[name] for name in names}
    off["phase"] = math.remainder(off["phase"], math.tau)
    size = math.exp(before["amplitude"])
    period = math.tau * period_factor(size) / math.exp(before["frequency"])
    # What a break that explains one number leaves of the others.
    share = (off["phase"] / math.tau) % 1.0
    lost = period * (share + np.arange(_MOST_PERIODS))
    decayed = off["amplitude"] + before["drag"] * lost
    fewest = int(np.argmin(np.abs(decayed)))
    pace = math.exp(off["frequency"])
    left = {
        "phase jump": {**off, "amplitude": float(decayed[fewest])},
        "change of pace": {**off, "drag": after["drag"] - pace * before["drag"]},
    }
    kind = min(
        _KINDS, key=lambda each: misfit_of(each, left.get(each.name, off), names, covariance)
    )
    seconds = f"{float(lost[fewest]):.3g} s"
    turn = off["offset"]
    offset = f"{turn:.3g} rad"
    for one, name in ((math.tau, "a whole turn"), (math.pi, "half a turn")):
        if abs(abs(turn) - one) < _NEAR * one:
            offset = name
    numbers = {
        "share": share, "lost": seconds, "pace": _pace_words(pace), "offset": offset,
        "drag_before": before["drag"], "drag_after": after["drag"],
        "size_before": size, "size_after": math.exp(after["amplitude"]),
        "period_before": math.tau / math.exp(before["frequency"]),
        "period_after": math.tau / math.exp(after["frequency"]),
    }  # fmt: skip
    return kind.name, kind.words.format(**numbers)
