"""Whether the equation of a free swing describes a record, and what is the likely reason if not."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from latolato.core.errors import InputError, Sentence, Word
from latolato.experiment.fits.adequacy import (
    SHORTEST,
    SMALL,
    STRONG,
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
from latolato.experiment.fits.windows import START
from latolato.experiment.rules import said

# Samples that explanations of a whole record are fitted to, in so many trials, and what they must
# gain, as a share of what two parts do.
_ENOUGH, _TRIES, _MOST = 600, 40, 0.5
# How uncertain the instant of a cut is, in periods.
_UNSURE = 0.1
# Periods that a cut may have taken out of a clock.
_MOST_PERIODS = 1000
# Breaks that nothing which lasts can look like.
_SUDDEN = ("phase jump", "two films", "shifted angle", "another rest")
# Factors to other units, and what to ask if angles times that are those of a pendulum.
_UNITS = ((180.0 / math.pi, "seems_swing_in_radians"), (math.pi / 180.0, "seems_swing_in_degrees"))
# Standard deviations from which a growth is seen.
_GROWS = 3.0
# Scatter over noise that is worth telling.
_FAR_OFF = 1.5
# Laws of drag that may explain what another one does not.
_LAWS = (("linear",), ("quadratic",), ("coulomb",), ("linear", "quadratic"))
_ALL = frozenset({"amplitude", "phase", "frequency", "offset", "drag"})
_KINDS = [
    Kind("phase jump", frozenset({"phase"}), "missing_piece"),
    Kind("change of pace", frozenset({"frequency"}), "other_pace"),
    Kind("change of drag", frozenset({"drag"}), "changed_drag"),
    Kind("shifted angle", frozenset({"offset"}), "shifted_angle"),
    Kind("two films", frozenset({"amplitude", "phase"}), "two_films"),
    Kind("another rest", frozenset({"amplitude", "phase", "offset"}), "other_rest"),
    Kind("another motion", _ALL, "other_motion"),
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
        return Adequacy(said("open_gap", time=at), "gap", at), whole
    aside_doubt = pivot_doubt(whole)
    if aside_doubt is not None:
        return aside_doubt, whole
    few = misfit_doubt(whole, data)
    fit_part = part_fitter(whole, terms, aside)
    period = math.tau / whole.values["natural_frequency"]
    ratio = whole.scatter / max(noise_of(data.values), 1e-300)
    size = said("scatter_size", ratio=ratio) if ratio > _FAR_OFF else ""
    try:
        cut = first_cut(data, whole, fit_part, SHORTEST * period)
    except ConvergenceError:
        cut, few = None, Adequacy(said("not_described", scatter=size), "unknown")
    other_unit = _unit_doubt(data, whole, cut, terms, aside)
    if other_unit is not None:
        return other_unit, whole
    if cut is None:
        return few or Adequacy(), whole
    bend = cut.bend(whole, data)
    if few is None and bend < SMALL:
        note = said("nearly_described", time=cut.instant, percent=100.0 * bend)
        return Adequacy(note=note), widened(whole, cut, ("natural_frequency", *terms))
    kind, reason = _of_cut(cut)
    if kind not in _SUDDEN:
        drag = _of_drag(data, whole, cut, terms, aside)
        if drag is not None:
            return Adequacy(said("other_equation", reason=drag), "drag law"), whole
    broken = said("broken_record", scatter=size, time=cut.instant, reason=reason)
    return Adequacy(broken, kind, cut.instant), whole


def _unit_doubt(
    data: Data,
    whole: Solution,
    cut: Cut | None,
    terms: Sequence[str],
    aside: Mapping[str, Guess],
) -> Adequacy | None:
    """A question about the unit of angles, None where no other one explains a record.

    Period and shape of a swing depend on its size in radians, whatever a table calls it.
    """
    few, plain = _few(data, whole, terms, aside)
    p = whole.values
    size = amplitude_at(p["initial_angle"], p["initial_angular_velocity"], p["natural_frequency"])
    for factor, rule in _UNITS:
        other = replace(few, values=factor * few.values, sigmas=factor * few.sigmas)
        slower = period_factor(factor * size) / period_factor(size)
        if np.ptp(other.values) > math.tau or abs(slower - 1.0) < SMALL:
            continue
        scaled = {name: factor * p[name] for name in (*START, "angle_offset")}
        scaled["initial_angular_velocity"] *= slower
        scaled["natural_frequency"] = p["natural_frequency"] * slower
        try:
            solution = fit_equation(other, {**p, **scaled}, terms, aside, limit=_TRIES)
        except InputError:
            continue
        if plain - deviance([solution]) > max(STRONG, _least(cut, few, data)):
            stated = 0.5 * float(max(np.ptp(few.values), np.ptp(other.values)))
            return Adequacy(said(rule, size=stated), "unit", is_in_record=False)
    return None


def _of_drag(
    data: Data, whole: Solution, cut: Cut, terms: Sequence[str], aside: Mapping[str, Guess]
) -> Sentence | None:
    """An explanation of the record by another drag, whose numbers do not change within it."""
    few, plain = _few(data, whole, terms, aside)
    p = {**dict.fromkeys(COEFFICIENTS, 1e-3), **whole.values}
    size = amplitude_at(p["initial_angle"], p["initial_angular_velocity"], p["natural_frequency"])
    drag, rate = max(abs(p["linear"]), 1e-3), p["natural_frequency"]
    starts = {
        "linear": 0.5 * drag,
        "quadratic": drag / (rate * size),
        "coulomb": drag * rate * size,
    }
    found = []
    for laws in _LAWS:
        if laws == tuple(terms):
            continue
        try:
            solution = fit_equation(few, {**p, **starts}, laws, aside, limit=_TRIES)
        except InputError:
            continue
        shortest = SHORTEST * math.tau / solution.values["natural_frequency"]
        gain = plain - deviance([solution])
        if gain < _least(cut, few, data):
            continue
        if place_of_change(few, solution, shortest) is None:
            rate = 0.5 * solution.values.get("linear", 0.0)
            grows = rate < 0.0 and rate < -0.5 * _GROWS * solution.sigma("linear")
            growth = said("grows_at", rate=-rate) if grows else ""
            names = {"law": Word("+".join(terms)), "other": Word("+".join(laws))}
            found.append((gain, said("other_drag", **names, growth=growth)))
    return max(found)[1] if found else None


def _few(
    data: Data, whole: Solution, terms: Sequence[str], aside: Mapping[str, Guess]
) -> tuple[Data, float]:
    """Samples enough for an explanation of a whole record, and the deviance of its fit to them."""
    few = data[:: max(1, len(data) // _ENOUGH)]
    try:
        return few, deviance([fit_equation(few, whole.values, terms, aside, limit=_TRIES)])
    except InputError:
        return few, -math.inf


def _least(cut: Cut | None, few: Data, data: Data) -> float:
    """What an explanation of a whole record must gain: most of what two parts do."""
    return _MOST * cut.gain * len(few) / len(data) if cut is not None else 0.0


def _pace_words(pace: float) -> Sentence:
    """Return how much faster or slower things happen, in words."""
    ratio = max(pace, 1.0 / pace)
    if ratio > 1.2:
        return said("times_as_fast" if pace > 1.0 else "times_as_slowly", ratio=ratio)
    name = "percent_faster" if pace > 1.0 else "percent_slower"
    return said(name, percent=100.0 * (ratio - 1.0))


def _other_period(before: Mapping[str, float], after: Mapping[str, float]) -> str:
    """Return the periods before and after a cut in words, nothing where they are alike."""
    one, other = (math.tau / math.exp(each["frequency"]) for each in (before, after))
    return "" if abs(other - one) < 1e-3 * one else said("other_period", before=one, after=other)


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


def _of_cut(cut: Cut) -> tuple[str, Sentence]:
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
    turn = off["offset"]
    offset = turn_words(turn) or said("angle_rad", angle=turn)
    numbers = {
        "share": share, "lost": seconds, "pace": _pace_words(pace), "offset": offset,
        "drag_before": before["drag"], "drag_after": after["drag"],
        "size_before": size, "size_after": math.exp(after["amplitude"]),
        "other": _other_period(before, after),
    }  # fmt: skip
    return kind.name, said(kind.rule, **numbers)
