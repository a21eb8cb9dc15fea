"""Whether the equation of a free swing describes a record, and what is the likely reason if not."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.fits.adequacy import (
    SMALL,
    Cut,
    Kind,
    changes,
    deviance,
    first_cut,
    misfit_doubt,
    misfit_of,
    place_of_change,
    widened,
)
from latolato.experiment.fits.free_swing import (
    COEFFICIENTS,
    amplitude_at,
    fit_equation,
    part_fitter,
    portrait,
)
from latolato.experiment.fits.least_squares import ConvergenceError, Data, Floats, Guess, Solution
from latolato.experiment.fits.result import Adequacy
from latolato.experiment.fits.samples import noise_of, turn_words
from latolato.experiment.fits.sight import pivot_doubt
from latolato.experiment.fits.swings import period_factor

# Periods in the shortest part of a record.
_SHORTEST = 2.0
# Samples that explanations of a whole record are fitted to, in so many trials, and what they must
# gain, as a share of what two parts do.
_ENOUGH, _TRIES, _MOST = 600, 40, 0.5
# How uncertain the instant of a cut is, in periods.
_UNSURE = 0.1
# Periods that a cut may have taken out of a clock.
_MOST_PERIODS = 1000
# Breaks that nothing which lasts can look like.
_SUDDEN = ("phase jump", "two films", "shifted angle", "another rest")
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
        "taken for radians, or is this no pendulum?",
    ),
)
# Standard deviations from which a growth is seen.
_GROWS = 3.0
# Scatter over noise that is worth telling.
_FAR_OFF = 1.5
# Laws of drag that may explain what another one does not.
_LAWS = (("linear",), ("quadratic",), ("coulomb",), ("linear", "quadratic"))
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
        "the swing changes there at once, by {share:.2g} of a period and from {size_before:.3g} to "
        "{size_after:.3g} rad: two films were joined, something touched the ball, or another ball "
        "is followed",
    ),
    Kind(
        "another rest",
        frozenset({"amplitude", "phase", "offset"}),
        "the ball hangs elsewhere from there on, by {offset}: a wind, or a pivot that slipped",
    ),
    Kind(
        "another motion",
        _ALL,
        "another motion begins there{other}: two films were joined, the film's pace changes, or "
        "the pendulum was changed",
    ),
]


def doubt_of(
    data: Data,
    whole: Solution,
    terms: Sequence[str],
    aside: Mapping[str, Guess],
    *,
    alone: bool,
) -> tuple[Adequacy, Solution]:
    """Return whether the equation describes a record, and the fit.

    The deviations of the fit include what apparatus does to a swing that it describes nearly.

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
        words = (
            f"The record does not tell how many swings there were in its gap at {at:.4g} s: "
            "several lengths describe it equally well."
        )
        return Adequacy(words, "gap", at), whole
    aside_doubt = pivot_doubt(whole)
    if aside_doubt is not None:
        return aside_doubt, whole
    few = misfit_doubt(whole, data)
    fit_part = part_fitter(whole, terms, aside)
    period = math.tau / whole.values["natural_frequency"]
    ratio = whole.scatter / max(noise_of(data.values), 1e-300)
    size = f" (scatter {ratio:.2g} times the noise of the samples)" if ratio > _FAR_OFF else ""
    try:
        cut = first_cut(data, whole, fit_part, _SHORTEST * period)
    except ConvergenceError:
        return Adequacy(f"The equation does not describe this record{size}.", "unknown"), whole
    if cut is None:
        return few or Adequacy(), whole
    bend = cut.bend(whole, data)
    if few is None and bend < SMALL:
        note = (
            f"Before and after {cut.instant:.4g} s the numbers differ by more than noise: the "
            f"equation is {100.0 * bend:.1g} % of the swing off. Their deviations include that."
        )
        return Adequacy(note=note), widened(whole, cut, ("natural_frequency", *terms))
    kind, told = _of_cut(cut)
    if kind not in _SUDDEN:
        other = _of_whole(data, whole, cut, terms, aside)
        if other is not None:
            end = "" if other[1].endswith("?") else "."
            words = f"The equation does not describe this record: {other[1]}{end}"
            return Adequacy(words, other[0]), whole
    words = (
        f"The equation does not describe this record{size}: it fails from {cut.instant:.4g} s on, "
        f"and it looks as if {told}."
    )
    return Adequacy(words, kind, cut.instant), whole


def _of_whole(
    data: Data, whole: Solution, cut: Cut, terms: Sequence[str], aside: Mapping[str, Guess]
) -> tuple[str, str] | None:
    """An explanation of the whole record by other units or another drag: a kind, and words.

    It must gain most of what two parts do, and its numbers may not change within the record.
    """
    few = data[:: max(1, len(data) // _ENOUGH)]
    p = {**dict.fromkeys(COEFFICIENTS, 1e-3), **whole.values}
    size = amplitude_at(p["initial_angle"], p["initial_angular_velocity"], p["natural_frequency"])
    tries: list[tuple[Data, Mapping[str, float], Sequence[str], str, str]] = []
    for factor, words in _UNITS:
        other = replace(few, values=factor * few.values, sigmas=factor * few.sigmas)
        if np.ptp(other.values) < math.tau:
            slower = period_factor(factor * size) / period_factor(size)
            scaled = {n: factor * p[n] for n in ("initial_angle", "angle_offset")}
            scaled["initial_angular_velocity"] = factor * p["initial_angular_velocity"] * slower
            scaled["natural_frequency"] = p["natural_frequency"] * slower
            tries.append((other, {**p, **scaled}, terms, "unit", words))
    drag, rate = max(abs(p["linear"]), 1e-3), p["natural_frequency"]
    starts = {
        "linear": 0.5 * drag,
        "quadratic": drag / (rate * size),
        "coulomb": drag * rate * size,
    }
    for laws in _LAWS:
        if laws != tuple(terms):
            words = f"its drag is not {'+'.join(terms)} but rather {'+'.join(laws)}: use law 'best'"
            tries.append((few, {**p, **starts}, laws, "drag law", words))
    try:
        plain = deviance([fit_equation(few, whole.values, terms, aside, limit=_TRIES)])
    except InputError:
        return None
    found = []
    for samples, start, drags, kind, words in tries:
        try:
            solution = fit_equation(samples, start, drags, aside, limit=_TRIES)
        except InputError:
            continue
        shortest = _SHORTEST * math.tau / solution.values["natural_frequency"]
        gain = plain - deviance([solution])
        if gain < _MOST * cut.gain * len(few) / len(data):
            continue
        if place_of_change(samples, solution, shortest) is None:
            rate = 0.5 * solution.values.get("linear", 0.0)
            if rate < 0.0 and rate < -0.5 * _GROWS * solution.sigma("linear"):
                words = f"{words}; the swing grows by {-rate:.3g} 1/s"
            found.append((gain, kind, words))
    return max(found)[1:] if found else None


def _pace_words(pace: float) -> str:
    """Return how much faster or slower things happen, in words."""
    quick, ratio = ("fast", pace) if pace > 1.0 else ("slowly", 1.0 / pace)
    if ratio > 1.2:
        return f"{ratio:.3g} times as {quick}"
    return f"{100.0 * (ratio - 1.0):.2g} % {'faster' if quick == 'fast' else 'more slowly'}"


def _other_period(before: Mapping[str, float], after: Mapping[str, float]) -> str:
    """Return the periods before and after a cut in words, nothing where they are alike."""
    one, other = (math.tau / math.exp(each["frequency"]) for each in (before, after))
    if abs(other - one) < 1e-3 * one:
        return ""
    return f", with a period of {other:.4g} s instead of {one:.4g} s"


def _by_instant(before: Mapping[str, float], after: Mapping[str, float]) -> Floats:
    """Return the covariance of differences because the instant of a cut is uncertain."""
    rates = [
        {"phase": math.exp(each["frequency"]) / period_factor(math.exp(each["amplitude"])),
         "amplitude": -each["drag"]}
        for each in (before, after)
    ]  # fmt: skip
    period = math.tau / min(rate["phase"] for rate in rates)
    moved = [rates[1].get(name, 0.0) - rates[0].get(name, 0.0) for name in before]
    return (_UNSURE * period) ** 2 * np.outer(moved, moved)


def _of_cut(cut: Cut) -> tuple[str, str]:
    """Return the kind of break at a cut, and what it looks like."""
    usual = 0.5 * cut.before.values.get("linear", 0.0)
    before, after, off, covariance = changes(cut, partial(portrait, usual=usual))
    covariance = covariance + _by_instant(before, after)
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
    kind = min(_KINDS, key=lambda each: misfit_of(each, left.get(each.name, off), covariance))
    seconds = f"{float(lost[fewest]):.3g} s"
    offset = turn_words(off["offset"]) or f"{off['offset']:.3g} rad"
    numbers = {
        "share": share, "lost": seconds, "pace": _pace_words(pace), "offset": offset,
        "drag_before": before["drag"], "drag_after": after["drag"],
        "size_before": size, "size_after": math.exp(after["amplitude"]),
        "other": _other_period(before, after),
    }  # fmt: skip
    return kind.name, kind.words.format(**numbers)
