"""Damping, length and drag law from a free decay: by the full equation and by its envelope."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np

from latolato.core.errors import InputError, Sentence, Word, joined
from latolato.core.quantities import NON_NEGATIVE, POSITIVE
from latolato.core.registry import checked_choice, checked_number, suggest
from latolato.experiment.fits.adequacy import STRONG, solutions_of
from latolato.experiment.fits.free_swing import COEFFICIENTS, fit_best, fit_equation, guess_of
from latolato.experiment.fits.least_squares import (
    ConvergenceError,
    Data,
    Guess,
    Solution,
)
from latolato.experiment.fits.registry import Apparatus, FitKind, fits
from latolato.experiment.fits.result import (
    TWO_SIDED,
    Adequacy,
    Estimate,
    Fit,
    make_fit,
    named,
    quantity_of,
    shown,
    size_questions,
)
from latolato.experiment.fits.samples import (
    check_turns,
    is_driven,
    largest_jump,
    length_of,
    pivot_swing,
    samples_of,
    within,
    without_repeats,
)
from latolato.experiment.fits.sight import ABOVE, ASIDE, sight_guesses
from latolato.experiment.fits.swing_doubt import doubt_of
from latolato.experiment.fits.swings import (
    SPARSE,
    Swings,
    amplitude_of,
    are_turning_points,
    crossings,
    effective_amplitude,
    fit_envelope,
    free_start,
    period_factor,
    samples_per_swing,
    swings_of,
    swings_of_turning_points,
)
from latolato.experiment.fits.windows import START
from latolato.experiment.rules import broken, said
from latolato.experiment.track_table import checked_table, has_own_pivots, table_of_ball
from latolato.physics.pendulum import GRAVITY, Pendulum

if TYPE_CHECKING:
    import xarray as xr

# Drag laws and sums of them, by the terms that they have.
LAWS: dict[str, tuple[str, ...]] = {
    "+".join(terms): terms for count in (1, 2, 3) for terms in combinations(COEFFICIENTS, count)
}
_FULLEST_FIRST = sorted(LAWS, key=lambda name: -len(LAWS[name]))
METHODS = ("both", "equation", "envelope")
# Angle beyond which nothing swings (half a turn, off its middle).
_HALF_TURN = 1.2 * math.pi
# Differences of the criterion below this say nothing.
_WEAK = 2.0
# Samples in a swing below which a faster one may look the same.
_ALIASED = 4.0
# What eq13 is off where a swing loses much in a period, as a share.
_ROUGH = 1e-3
# Standard deviations from which drag is seen.
_SURE = 3.0
# Samples from which laws are compared, and trials that a start may take there.
_ENOUGH, _TRIES = 1500, 65


def fit_decay(
    table: xr.Dataset,
    *,
    length: float | None = None,
    mass: float | None = None,
    radius: float | None = None,
    method: Literal["both", "equation", "envelope"] = "both",
    law: str = "linear",
    gravity: float = GRAVITY,
    ball: int = 1,
    start: Annotated[float | None, "s"] = None,
    end: Annotated[float | None, "s"] = None,
    compare: bool = True,
    profile: bool = True,
) -> Fit:
    """Return damping, decay rate and length of a ball that swings freely on a pivot at rest.

    Paper eq7 in full, and the envelope of eq13.

    Parameters
    ----------
    table : xarray.Dataset
        A track table; samples that are not flagged ok are ignored.
    length : float, optional
        Pivot to ball centre [m]; by default the table's, else that from the dynamics.
    mass : float, optional
        Mass of the ball [kg]; without it the fit gives a decay rate but no C.
    radius : float, optional
        Radius of a solid ball [m]; `centre_length`, the distance to its centre, is then estimated
        too.
    method : {"both", "equation", "envelope"}
        Which models are fitted; the envelope is that of the turning points.
    law : str
        Drag of the equation: linear, quadratic, coulomb, sums with +, or best for the one with the
        least BIC.
    gravity : float
        Gravitational acceleration [m/s^2].
    ball : int
        Which ball of the table: 1 is the right one.
    start : float, optional
        First instant used [s], by default the release.
    end : float, optional
        Last instant used [s].
    compare : bool
        Whether to fit and compare all drag laws whose fits converge.
    profile : bool
        Whether to profile 95 percent intervals instead of taking them from the covariance.

    Returns
    -------
    Fit
        With `damping` [kg m/s], `decay_rate` [1/s], `natural_frequency`, `length` (from the
        dynamics, of the equivalent point pendulum), `angle_offset` (of the hanging ball in the
        table), and `damping_envelope` and `decay_rate_envelope`; of other drags
        `quadratic_damping` [kg m] and `coulomb_damping` [N]; of a table made from pictures
        `pivot_error_x` and `pivot_error_y` [m].

    Raises
    ------
    InputError
        For bad input, a pivot that moves, or angles without a free swing.
        If lmfit is missing.
    ConvergenceError
        If neither the law nor any part of it can be fitted.

    Notes
    -----
    With c = C/(m l), c2 = C2/(m l), c0 = C0/(m l) the angle obeys
    ``th'' = -(g/l) sin(th) - c th' - c2 th'|th'| - c0 sgn th'`` about `angle_offset`, from a free
    start. C is ``c m l`` with the given length, or the one from the dynamics. The true pivot may
    lie beside the table's, within the table's uncertainty (`latolato.experiment.fits.sight`).
    Correlated residuals are treated as in `latolato.experiment.fits.least_squares`. Laws are
    compared by BIC with the number of effective samples, all with the correlation and the samples
    of the fullest law that converges. If the terms of a law cannot be told apart, its fit may not
    converge: the numbers are then those of the best law with fewer terms, and the verdict says so.
    A drag that the three terms do not describe (a string that rubs, a draught) shows as correlation
    of the residuals only.
    """
    checked_table(table)
    checked_choice("method", method, METHODS)
    if law != "best" and law not in LAWS:
        raise InputError(f"unknown drag law '{law}'", way_out=suggest(law, ["best", *LAWS]))
    if method == "envelope" and law != "linear":
        raise InputError(
            "the envelope of eq13 assumes linear drag", way_out=f"use method 'equation' for {law}"
        )
    gravity = checked_number("gravity", gravity, POSITIVE, "m/s^2")
    mass = None if mass is None else checked_number("mass", mass, POSITIVE, "kg")
    radius = None if radius is None else checked_number("radius", radius, NON_NEGATIVE, "m")
    declared = length_of(table, length)
    number = ball
    if has_own_pivots(table):
        table, ball = table_of_ball(table, ball), 1
    data = samples_of(table, ball, start=start, end=end)
    check_turns(data)
    piece = table.isel(frame=within(table["time"].values, start, end))
    if declared is not None:  # before a driven swing is taken for one that somebody holds
        _check_rest(piece, declared)
    first = float(data.times[0])
    if start is None:
        data = data[data.times >= _release(data)]
    begin = float(data.times[0])
    _check_reach(data)
    data, repeats = without_repeats(data)
    seen = _seen(data)
    if declared is None:
        _check_rest(piece, gravity / seen.first["natural_frequency"] ** 2)
    body = Apparatus(length=declared, mass=mass, radius=radius, gravity=gravity)
    aside = sight_guesses(table, data)
    parts = []
    if method != "envelope" and seen.has_motion:
        compare = compare or law == "best"
        parts.append(
            _by_equation(data, seen.first, aside, body, law, compare=compare, profile=profile)
        )
    elif method == "equation":
        raise InputError(joined(seen.words), way_out="use method 'envelope'")
    if method != "equation" and seen.swings is not None:
        equation = parts[0].estimates if parts else None
        parts.append(_by_envelope(seen.swings, seen.first, aside, body, equation, profile=profile))
    elif method == "envelope":
        raise InputError(joined(seen.words), way_out="use method 'equation'")
    estimates = {name: each for part in parts for name, each in part.estimates.items()}
    curves = {name: curve for part in parts for name, curve in part.curves.items()}
    about: dict[str, Any] = {
        "start": begin, "end": float(data.times[-1]), "ball": number, "mass": mass,
        "radius": radius, "gravity": gravity, "method": method,
        "samples": len(data), "source": table.attrs.get("source"),
    }  # fmt: skip
    for part in parts:
        about |= part.attributes
    words = [sentence for part in parts for sentence in part.sentences]
    if method == "both":
        words += seen.words
    if start is None and begin > first:
        words.append(said("freed", time=begin))
    if repeats:
        words.append(said("repeated_samples", count=repeats))
    adequacy = parts[0].adequacy
    return make_fit(
        "decay",
        estimates,
        joined(words),
        curves,
        about,
        system=_system(body, estimates),
        adequacy=adequacy,
    )


def _swinging(fit: Fit, apparatus: Apparatus, table: xr.Dataset) -> Pendulum:
    """Return the pendulum of a fit with the length and the mass of the apparatus."""
    length = apparatus.length or fit["length"].value
    mass = apparatus.some_mass
    if "damping" in fit:
        damping = fit["damping"].value
    elif "decay_rate" in fit:
        damping = 2.0 * fit["decay_rate"].value * mass * length
    else:
        damping = 0.0
    return Pendulum(length=length, mass=mass, damping=max(damping, 0.0), gravity=apparatus.gravity)


fits.register("decay")(
    FitKind(
        function=fit_decay,
        title="Decay",
        headline=("period", "damping", "decay_rate", "length", "natural_frequency"),
        system=_swinging,
    )
)


@dataclass(frozen=True)
class _Part:
    """What one method contributes to a fit."""

    estimates: dict[str, Estimate]
    curves: dict[str, tuple[str, Any]]
    attributes: dict[str, Any]
    sentences: list[Sentence]
    adequacy: Adequacy = field(default_factory=Adequacy)


def _by_equation(
    data: Data,
    first: Mapping[str, float],
    aside: Mapping[str, Guess],
    body: Apparatus,
    law: str,
    *,
    compare: bool,
    profile: bool,
) -> _Part:
    """Estimates, curves and verdicts of the full equation with a law of drag."""
    laws = _compared(data, first, aside) if compare else {}
    if law == "best":
        law = min(laws, key=lambda name: laws[name].bayes, default="linear")
    chosen, solution, alone = _converged(data, first, laws, law, aside, profile=profile)
    adequacy, solution = doubt_of(data, solution, LAWS[chosen], aside, alone=alone)
    estimates = _estimates(body, solution, LAWS[chosen])
    sentences = _equation_verdict(body, estimates, solution, chosen)
    if compare:
        sentences += _law_verdict(laws, chosen)
    if chosen != law:
        sentences.append(said("lost_law", law=Word(law), chosen=Word(chosen)))
    curves = solution.curves(data, "angle")
    if laws:
        curves |= {
            "law": ("law", np.array(list(laws))),
            "law_bic": ("law", np.array([s.bayes for s in laws.values()])),
        }
    attributes = solution.quality | {"chi_square": solution.chi_square, "law": chosen}
    return _Part(estimates, curves, attributes, sentences, adequacy)


def _by_envelope(
    swings: Swings,
    first: Mapping[str, float],
    aside: Mapping[str, Guess],
    body: Apparatus,
    equation: Mapping[str, Estimate] | None,
    *,
    profile: bool,
) -> _Part:
    """Estimates, curves and verdict of the envelope, compared with the equation's if any.

    Raises
    ------
    ConvergenceError
        Without estimates of the equation.
    """
    profiles = ("decay_rate",) if profile else ()
    try:
        solution = fit_envelope(swings, first["angle_offset"], aside, profiles)
    except InputError as error:
        if equation is None:
            raise
        few = said("envelope_short", count=len(swings.times))
        lost = isinstance(error, ConvergenceError)
        return _Part({}, {}, {}, [said("envelope_lost") if lost else few])
    equation = equation or {}
    estimates = _envelope_estimates(body, solution, equation.get("length"), first)
    curves: dict[str, tuple[str, Any]] = {
        "swing_time": ("swing", swings.times),
        "swing_angle": ("swing", swings.angles),
        "swing_angle_fit": ("swing", solution.curve),
    }
    return _Part(estimates, curves, {}, [_envelope_verdict({**equation, **estimates})])


def _check_rest(piece: xr.Dataset, length: float) -> None:
    """Raise InputError if the pivot moves."""
    if is_driven(piece, length):
        raise broken("moving_pivot", {"size": 1e3 * pivot_swing(piece)})


@dataclass(frozen=True)
class _Seen:
    """What is seen of a swing before any fit.

    Attributes
    ----------
    first : dict
        A first guess of all parameters.
    swings : Swings or None
        Turning points, None where too few samples show them.
    has_motion : bool
        Whether there are samples between turning points.
    words : list of Sentence
        Why there are no turning points, or no motion; empty where there are both.
    """

    first: dict[str, float]
    swings: Swings | None
    has_motion: bool = True
    words: list[Sentence] = field(default_factory=list)


def _release(data: Data) -> float:
    """Return the instant from which a ball swings freely [s]; few samples show no hand."""
    if samples_per_swing(data.times, data.values) < SPARSE:
        return float(data.times[0])
    # Half-way between both sides: a hand that holds the ball for long moves the median.
    # A swing that dies soon is about its median.
    low, high = np.quantile(data.values, [0.01, 0.99])
    about = [data.values - middle for middle in (0.5 * (low + high), np.median(data.values))]
    try:
        return free_start(data.times, max(about, key=lambda v: len(crossings(data.times, v))))
    except InputError:
        _check_reach(data)
        jump = largest_jump(data)
        if jump is None:
            raise
        raise broken("jumping_angle", {"jump": abs(jump[1]), "time": jump[0]}) from None


def _check_reach(data: Data) -> None:
    """Raise InputError if an angle goes further than a swing does."""
    reach = float(np.max(np.abs(data.values - np.median(data.values))))
    if reach > _HALF_TURN:
        raise broken("beyond_half_turn", {"reach": reach})


def _seen(data: Data) -> _Seen:
    """Return turning points and first guesses.

    Raises
    ------
    InputError
        Without a swing.
    """
    middle = float(np.median(data.values))
    if are_turning_points(data.values - middle):
        swings = swings_of_turning_points(data.times, data.values)
        return _Seen(
            _first_guess(data, swings), swings, has_motion=False,
            words=[said("only_turning_points")],
        )  # fmt: skip
    count = samples_per_swing(data.times, data.values)
    if count < SPARSE:
        drags = {"linear": 0.02, "quadratic": 0.02, "coulomb": 0.02}
        first = guess_of(data[: 8 * SPARSE], drags)
        words = [said("few_in_swing", count=count)]
        if count < _ALIASED:
            pause = float(np.median(np.diff(data.times)))
            fast = pause / (1.0 - 1.0 / count)
            words.append(said("same_look", pause=pause, period=fast))
        return _Seen(first, None, words=words)
    swings = swings_of(data.times, data.values - middle)
    swings = Swings(swings.times, swings.angles + middle, swings.sigmas, swings.halves)
    return _Seen(_first_guess(data, swings), swings)


def _first_guess(data: Data, swings: Swings) -> dict[str, float]:
    """Return a guess of all parameters from the turning points and the first swing."""
    # Turning points either side lie the offset above and below the envelope.
    pairs = 0.5 * (swings.angles[1:-1] + 0.5 * (swings.angles[:-2] + swings.angles[2:]))
    offset = float(np.median(pairs)) if len(pairs) else 0.0
    sizes = np.abs(swings.angles - offset)
    factors = np.array([period_factor(size) for size in sizes])
    # Half periods across a gap are too long.
    frequency = math.pi / float(np.median(swings.halves / factors))
    effective = effective_amplitude(sizes)
    rate = 0.02
    if len(sizes) > 3:
        rate = -2.0 * float(np.polyfit(swings.times, np.log(effective), 1, w=effective)[0])
    drag = max(abs(rate), 1e-4)
    begin = float(data.times[0])
    swing = effective[0] * math.exp(0.5 * rate * (swings.times[0] - begin))
    amplitude = float(amplitude_of(np.array(min(swing, 3.0))))
    guess = {
        "natural_frequency": frequency,
        "linear": rate,
        "angle_offset": offset,
        "quadratic": drag / max(frequency * float(np.mean(sizes)), 1e-6),
        "coulomb": drag * frequency * float(np.mean(sizes)),
    }
    # The start: the first swing turned back by the phase from its turning point.
    phase = frequency / period_factor(amplitude) * (begin - swings.times[0])
    sign = float(np.sign(swings.angles[0] - offset))
    angle = sign * amplitude * math.cos(phase)
    lift = 2.0 * max(math.cos(angle) - math.cos(amplitude), 0.0)
    speed = -sign * math.copysign(frequency * math.sqrt(lift), math.sin(phase))
    return guess | {"initial_angle": angle, "initial_angular_velocity": speed}


def _compared(
    data: Data, first: Mapping[str, float], aside: Mapping[str, Guess]
) -> dict[str, Solution]:
    """Return the fit of every law that converges, in the order of `LAWS`.

    All have the samples and the correlation of the fullest one among them.
    """
    # A verdict needs no more samples than that.
    data = data[:: max(1, len(data) // _ENOUGH)]
    fullest: Solution | None = None
    solutions = {}

    def fit(terms: Sequence[str], like: Solution | None, start: Mapping[str, float]) -> Solution:
        return fit_equation(data, start, terms, aside, limit=_TRIES, like=like)

    for name in _FULLEST_FIRST:
        terms = LAWS[name]
        shared = _shared(first, terms)
        if fullest is None:
            # Friction that holds the ball at last makes false minima: the better of two starts.
            starts = [_shared(first, LAWS["linear"]), shared]
        else:
            starts = [{**fullest.values, **shared}]
            if len(terms) > 1:
                least = {t: max(fullest.values.get(t, 0.0), 1e-3 * first[t]) for t in terms}
                starts.append({**fullest.values, **least})
        tries = solutions_of(partial(fit, terms, fullest), starts)
        if tries:
            solutions[name] = min(tries, key=lambda each: each.chi_square)
            fullest = fullest or solutions[name]
    return {name: solutions[name] for name in LAWS if name in solutions}


def _converged(
    data: Data,
    first: Mapping[str, float],
    laws: Mapping[str, Solution],
    law: str,
    aside: Mapping[str, Guess],
    *,
    profile: bool,
) -> tuple[str, Solution, bool]:
    """Return a law and its fit, or those of the best part of it that converges.

    The third is whether no other solution is nearly as good. Parts are taken in the order of the
    comparison `laws`, without one the fullest first.
    """
    parts = [name for name in _FULLEST_FIRST if set(LAWS[name]) < set(LAWS[law])]
    parts.sort(key=lambda name: laws[name].bayes if name in laws else math.inf)
    for name in (law, *parts):
        terms = LAWS[name]
        start = _shared(first, terms) | (laws[name].values if name in laws else {})
        with suppress(ConvergenceError):
            best, alone = fit_best(data, start, terms, aside)
            if profile:
                profiles = [*terms, "natural_frequency"]
                best = fit_equation(data, best.values, terms, aside, profiles=profiles)
            return name, best, alone
    raise broken("lost_fit", {"law": Word(law)}, kind=ConvergenceError)


def _shared(first: Mapping[str, float], terms: Sequence[str]) -> dict[str, float]:
    """Return a first guess whose drag is shared by some terms."""
    shares = {term: first[term] * (1.0 / len(terms) if term in terms else 1e-3)
              for term in COEFFICIENTS}  # fmt: skip
    return {**first, **shares}


def _system(body: Apparatus, estimates: Mapping[str, Estimate]) -> Pendulum | None:
    """Return the pendulum that swings, None if its mass or its drag is unknown."""
    drags: dict[str, Any] = {
        name: estimates[name].value for name in COEFFICIENTS.values() if name in estimates
    }
    # A swing that grows is driven by something that no pendulum has.
    if body.mass is None or not drags or min(drags.values()) < 0.0:
        return None
    length = estimates["length"].value
    return Pendulum(length=length, mass=body.mass, gravity=body.gravity, **drags)


def _estimates(body: Apparatus, solution: Solution, terms: Sequence[str]) -> dict[str, Estimate]:
    """Return the estimates under their public names."""
    rate = solution.estimate("natural_frequency")
    length = rate.power(body.gravity, -2, "m")
    estimates: dict[str, Estimate] = {}
    lever = body.length or length.value
    for term in terms:
        raw, name = solution.estimate(term, "1/s"), COEFFICIENTS[term]
        if body.mass is not None:
            estimates[name] = raw.scaled(body.mass * lever, quantity_of(name).unit)
        if term == "linear":
            estimates["decay_rate"] = raw.scaled(0.5, "1/s")
    period = rate.power(math.tau, -1, "s")
    estimates = {"period": period, **estimates, "natural_frequency": rate, "length": length}
    if body.radius is not None:
        estimates["centre_length"] = _centre(body.radius, length)
    for name in ("angle_offset", *START):
        estimates[name] = solution.estimate(name)
    for name in (ASIDE, ABOVE):
        if name in solution.values:
            estimates[name] = solution.estimate(name, "1").scaled(lever, "m")
    return estimates


def _envelope_estimates(
    body: Apparatus, solution: Solution, length: Estimate | None, first: Mapping[str, float]
) -> dict[str, Estimate]:
    """Return the estimates of the envelope."""
    estimates = {"decay_rate_envelope": solution.estimate("decay_rate")}
    if body.mass is not None:
        dynamic = length.value if length else body.gravity / first["natural_frequency"] ** 2
        factor = 2.0 * body.mass * (body.length or dynamic)
        rate = estimates["decay_rate_envelope"]
        estimates["damping_envelope"] = rate.scaled(factor, "kg*m/s")
    return estimates


def _drag_words(estimates: Mapping[str, Estimate], law: str) -> list[Sentence]:
    """Return the drag in plain words: its numbers, a limit where none is seen, or a growth."""
    rate = estimates.get("decay_rate")
    if law != "linear" or rate is None:
        return [named(n, estimates[n]) for n in COEFFICIENTS.values() if n in estimates]
    if rate.value < -_SURE * rate.sigma:
        return [said("growing_swing", rate=str(rate.scaled(-1.0, "1/s")))]
    if rate.value < _SURE * rate.sigma:
        limit = max(rate.value, 0.0) + TWO_SIDED * rate.sigma
        if "damping" not in estimates:
            return [said("no_drag", rate=limit)]
        ratio = estimates["damping"].sigma / rate.sigma
        return [said("no_damping", rate=limit, damping=limit * ratio)]
    parts = [said("decay_rate_is", rate=str(rate))]
    if "damping" in estimates:
        parts.insert(0, joined([f"C = {estimates['damping']}"]))
    return parts


def _centre(radius: float, length: Estimate) -> Estimate:
    """Distance c to a solid ball's centre [m]; ``c + 2/5 r^2/c`` is the equivalent length."""
    bulk = 1.6 * radius**2
    if length.value**2 <= bulk:
        raise broken("large_radius", {"length": length.value}, parameter="radius", value=radius)
    centre = 0.5 * (length.value + math.sqrt(length.value**2 - bulk))
    return length.scaled(centre / length.value, "m")


def _equation_verdict(
    body: Apparatus, estimates: Mapping[str, Estimate], solution: Solution, law: str
) -> list[Sentence]:
    """Return the result of the equation in plain words."""
    length = estimates["length"]
    numbers = [
        said("small_period", period=str(estimates["period"])),
        *_drag_words(estimates, law),
        said("dynamic_length", length=str(shown("length", length)), gravity=body.gravity),
    ]
    words = size_questions({"length": length.value})
    words.append(said("equation_gives", law=Word(law), numbers=joined(numbers, ", ")))
    if body.length is not None:
        away = length.value / body.length - 1.0
        limit = max(3.0 * length.sigma / body.length, 0.003)
        if abs(away) > limit:
            share = said("percent_less" if away > 0 else "percent_more", percent=abs(100.0 * away))
            if not -0.5 < away < 1.0:
                share = said("times_what", ratio=1.0 / (1.0 + away))
            words.append(said("declared_length", length=body.length, share=share))
    if solution.outliers:
        words.append(said("outliers", count=solution.outliers))
    return words


def _law_verdict(laws: Mapping[str, Solution], chosen: str) -> list[Sentence]:
    """Return which drag law a comparison prefers, and whether the chosen one is doubtful."""
    if not laws:
        return [said("no_law", count=len(LAWS))]
    lost = [name for name in LAWS if name not in laws]
    order = sorted(laws, key=lambda name: laws[name].bayes)
    best = order[0]
    ahead = {name: laws[name].bayes - laws[best].bayes for name in order[1:]}
    near = [name for name, gap in ahead.items() if gap < _WEAK]
    clear = [name for name, gap in ahead.items() if gap >= STRONG]
    *others, last = [n for n in COEFFICIENTS if n in clear] or [""]
    excluded: str = said("excluded_law", law=Word(last)) if last else ""
    if others:
        excluded = said("excluded_laws", laws=_words(others), last=Word(last))
    if not ahead:
        words = [said("only_law", law=Word(best.capitalize()), excluded=excluded)]
    elif near:
        alike = _words([best.capitalize(), *near[:-1]])
        words = [said("alike_laws", laws=alike, last=Word(near[-1]), excluded=excluded)]
    else:
        rival = order[1]
        lead = {"ahead": ahead[rival], "rival": Word(rival)}
        words = [said("best_law", law=Word(best.capitalize()), **lead, excluded=excluded)]
    if chosen in clear:
        words.append(said("excluded_choice", law=Word(chosen)))
    if lost:
        rule = "law_not_compared" if len(lost) == 1 else "laws_not_compared"
        words.append(said(rule, count=len(LAWS), laws=_words(lost)))
    return words


def _words(laws: Iterable[str]) -> Sentence:
    """Return the names of drag laws as one text."""
    return joined(map(Word, laws), ", ")


def _envelope_verdict(estimates: Mapping[str, Estimate]) -> Sentence:
    """A sentence with the envelope's decay rate, and whether it agrees with the equation."""
    envelope = estimates["decay_rate_envelope"]
    damping = estimates.get("damping_envelope")
    comparison: str = ""
    if "decay_rate" in estimates and envelope.sigma > abs(envelope.value):
        comparison = said("envelope_unsure")
    elif "decay_rate" in estimates:
        gap = abs(envelope.value - estimates["decay_rate"].value)
        both = math.hypot(envelope.sigma, estimates["decay_rate"].sigma)
        agree = gap <= 3.0 * both + _ROUGH * abs(envelope.value)
        comparison = said("envelope_agrees" if agree else "envelope_differs")
    return said(
        "envelope_gives", rate=str(envelope), damping=f", C = {damping}" if damping else "",
        comparison=comparison,
    )  # fmt: skip
