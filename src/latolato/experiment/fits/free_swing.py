"""A ball that swings freely, fitted by the full equation: to a whole record, or to parts of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.quantities import ANY, quantity_field
from latolato.experiment.fits.adequacy import cost, solutions_of
from latolato.experiment.fits.least_squares import MOST_TRIALS, Data, Guess, Solution
from latolato.experiment.fits.samples import noise_of, steps_over_gap
from latolato.experiment.fits.sight import ABOVE
from latolato.experiment.fits.swings import period_factor
from latolato.experiment.fits.windows import START, WindowedModel, motion_at, step_of
from latolato.experiment.quality import fitted_harmonic
from latolato.numerics.integrate import Start
from latolato.physics.drives import FixedPivot
from latolato.physics.pendulum import Ball, Pendulum

# The coefficient of each term of the drag as a parameter of `Pendulum`.
COEFFICIENTS = {
    "linear": "damping",
    "quadratic": "quadratic_damping",
    "coulomb": "coulomb_damping",
}
# Residuals so many times the noise ask for other starts.
_POOR = 4.0
# Trials that a start may take, and one beside a solution.
_TRIES, _SOON = 50, 12
# Swings that a search from nothing begins with, and by how much it grows each time.
_FIRST_SWINGS, _GROWTH = 4.0, 2.0
# Swings more or fewer that a gap may hold than the part before it says.
_LOST_SWINGS = 3
# A pivot whose place is known to less than this share of the arm leaves the scale of angles open.
_OPEN_SCALE = 0.02
# The stiffness of a start from nothing, where the drag is unknown [1/s].
_SOME_DRAG = 0.02


@dataclass(frozen=True, kw_only=True)
class _FreeBall(Ball):
    """A ball whose swing may also grow."""

    damping: float = quantity_field("damping", ANY, default=0.0)


@dataclass(frozen=True, kw_only=True)
class _FreeSwing(Pendulum):
    """A pendulum whose swing may also grow: the damping has no bound."""

    damping: float = quantity_field("damping", ANY, default=0.0)

    @cached_property
    def balls(self) -> tuple[Ball, ...]:
        """The ball."""
        return (
            _FreeBall(
                **{f.name: getattr(self, f.name) for f in fields(Ball) if hasattr(self, f.name)}
            ),
        )


def fit_equation(
    data: Data,
    first: Mapping[str, float],
    terms: Sequence[str],
    aside: Mapping[str, Guess],
    *,
    profiles: Sequence[str] = (),
    like: Solution | None = None,
    limit: int = MOST_TRIALS,
) -> Solution:
    """Return the least-squares solution of the equation with these drags.

    Parameters
    ----------
    data : Data
        Angles [rad].
    first : mapping of str to float
        First guesses: ``natural_frequency``, ``angle_offset``, ``initial_angle`` and
        ``initial_angular_velocity`` at the first sample, and the drags by name.
    terms : sequence of str
        Which drags there are. Linear drag alone has no bound: a swing may grow.
    aside : mapping of str to Guess
        How the table sees angles (`latolato.experiment.fits.sight`).
    profiles, like, limit
        Those of `solve`.
    """
    guesses = {
        "natural_frequency": Guess(first["natural_frequency"], 1e-3),
        "angle_offset": Guess(first["angle_offset"]),
    }
    for term in terms:
        if tuple(terms) == ("linear",):
            guesses[term] = Guess(first[term])
        else:
            guesses[term] = Guess(max(first[term], 1e-6), 0.0)
    guesses |= {name: replace(each, value=first.get(name, 0.0)) for name, each in aside.items()}

    def laws(p: Mapping[str, float]) -> tuple[Pendulum, FixedPivot]:
        return _pendulum(p["natural_frequency"], {term: p[term] for term in terms}), FixedPivot()

    model = WindowedModel(data, laws, guesses, data.times[:1], 0.0)
    state = np.array([[[first[name] for name in START]]])
    return model.solved(model.guesses(state), profiles=profiles, like=like, limit=limit)


def _pendulum(frequency: float, drags: Mapping[str, float]) -> Pendulum:
    """Return the pendulum of length 1 m and mass 1 kg with this frequency and these drags."""
    coefficients: dict[str, Any] = {COEFFICIENTS[term]: value for term, value in drags.items()}
    return _FreeSwing(length=1.0, mass=1.0, gravity=frequency**2, **coefficients)


def state_at(p: Mapping[str, float], late: float) -> tuple[float, float]:
    """Return angle [rad] and angular velocity [rad/s] some seconds after a solution's start."""
    begin = p["initial_angle"], p["initial_angular_velocity"]
    if late <= 0.0:
        return begin
    drags = {term: p[term] for term in COEFFICIENTS if term in p}
    system = _pendulum(p["natural_frequency"], drags)
    largest = amplitude_at(*begin, p["natural_frequency"])
    step = step_of(system, FixedPivot(), 2.0 * p["natural_frequency"] * math.sin(0.5 * largest))
    start = Start(begin[:1], begin[1:])
    angles, velocities, _ = motion_at(system, FixedPivot(), start, np.array([late]), step=step)
    return float(angles[0, 0]), float(velocities[0, 0])


def amplitude_at(angle: float, velocity: float, frequency: float) -> float:
    """Return the angle at which a ball with this state would turn [rad], pi if it would not."""
    rise = math.sin(0.5 * angle) ** 2 + 0.25 * (velocity / frequency) ** 2
    return 2.0 * math.asin(math.sqrt(min(rise, 1.0)))


def phase_at(angle: float, velocity: float, frequency: float) -> float:
    """Return the share of the swing since its turn to the right, in radians: 2 pi a period."""
    from scipy.special import ellipk, ellipkinc

    k = math.sin(0.5 * amplitude_at(angle, velocity, frequency))
    if k <= 0.0:
        return 0.0
    part = math.asin(min(max(math.sin(0.5 * angle) / k, -1.0), 1.0))
    swing = 0.5 * math.pi * float(ellipkinc(part, k * k)) / float(ellipk(k * k))
    # `swing` goes from 0 at the bottom to pi/2 at the turn; backwards it counts on from there.
    return swing - 0.5 * math.pi if velocity >= 0.0 else 0.5 * math.pi - swing


def portrait(
    solution: Solution, p: Mapping[str, float], instant: float, usual: float = 0.0
) -> dict[str, float]:
    """Return the numbers of a swing at an instant, as `adequacy.changes` compares them.

    Its logarithmic amplitude and frequency, phase [rad], offset [rad] and decay rate [1/s]. `usual`
    is a decay rate that motions which are compared have in common [1/s].
    """
    late = instant - solution.origin
    angle, velocity = state_at(p, late)
    frequency, drag = p["natural_frequency"], 0.5 * p.get("linear", 0.0)
    # Drag takes energy where the ball is fast; with this velocity the size falls evenly.
    velocity += usual * angle
    size = amplitude_at(angle, velocity, frequency)
    # A part that begins shortly after the instant is followed back at an even pace.
    back = min(late, 0.0)
    return {
        "amplitude": math.log(max(size, 1e-12)) - drag * back,
        "phase": phase_at(angle, velocity, frequency) + frequency / period_factor(size) * back,
        "frequency": math.log(frequency),
        "offset": p["angle_offset"],
        "drag": drag,
    }


def guess_of(data: Data, drags: Mapping[str, float]) -> dict[str, float]:
    """Return a first guess of a swing from the best sine, for a few periods of any samples."""
    late = data.times - data.times[0]
    rate, weights, _ = fitted_harmonic(late, data.values)
    offset, cosine, sine = map(float, weights)
    size = min(math.hypot(cosine, sine), 3.0)
    frequency = rate * period_factor(size)
    return {
        **drags,
        "natural_frequency": frequency,
        "angle_offset": offset,
        "initial_angle": cosine,
        "initial_angular_velocity": rate * sine,
    }


def fit_best(
    data: Data, first: Mapping[str, float], terms: Sequence[str], aside: Mapping[str, Guess]
) -> tuple[Solution, bool]:
    """Return the best solution of several starts, and whether it is the only one.

    Parameters are those of `fit_equation`. Starts are taken over what the samples leave open: the
    whole swings in a gap, and the scale of the angles where the pivot's place is uncertain.
    """
    steps = steps_over_gap(data.times, first["natural_frequency"], _LOST_SWINGS)
    starts: list[Mapping[str, float]] = [first]
    scale = aside.get(ABOVE)
    if scale is not None and scale.prior > _OPEN_SCALE:
        starts += [{**first, ABOVE: sign * scale.prior} for sign in (-1.0, 1.0)]

    def fit(start: Mapping[str, float]) -> Solution:
        return fit_equation(data, start, terms, aside, limit=_TRIES)

    tries = solutions_of(fit, starts)
    if steps or not tries or _is_poor(tries[0], data):
        grown = _grown(data, first, terms, aside)
        if grown is not None:
            tries.append(grown)
    if not tries:
        return fit_equation(data, first, terms, aside), True
    best = min(tries, key=cost)
    # Frequencies that differ by a whole swing in the longest gap.
    about = best.values["natural_frequency"]
    slower = math.sqrt(period_factor(float(np.ptp(data.values)) / 2.0))
    others = [about + slower * step for step in steps]
    more = [{**best.values, "natural_frequency": w} for w in others if w > 0.3 * about]
    tries += solutions_of(fit, more)
    best = min(tries, key=cost)
    apart = [
        each
        for each in tries
        if abs(each.values["natural_frequency"] - best.values["natural_frequency"])
        > 5.0 * best.sigma("natural_frequency") + 1e-4 * best.values["natural_frequency"]
    ]
    alone = all(cost(each) > cost(best) + 10.0 for each in apart)
    return best, alone


def _is_poor(solution: Solution, data: Data) -> bool:
    """Return whether residuals are larger than the noise of the samples alone."""
    return solution.scatter > _POOR * noise_of(data.values) or not solution.kept.mean() > 0.95


def _grown(
    data: Data, first: Mapping[str, float], terms: Sequence[str], aside: Mapping[str, Guess]
) -> Solution | None:
    """Return the solution of a search that begins with the first swings and takes on more."""
    drags = {term: first[term] for term in COEFFICIENTS}
    period = math.tau / first["natural_frequency"]
    begin, end = float(data.times[0]), float(data.times[-1])
    span = _FIRST_SWINGS * period
    start: Mapping[str, float] | None = None
    solution: Solution | None = None
    while True:
        part = data[data.times <= begin + span]
        is_all = len(part) == len(data)
        if len(part) >= 3 * (4 + len(terms)):
            try:
                solution = fit_equation(
                    part, start or guess_of(part, drags), terms, aside, limit=_TRIES
                )
            except InputError:
                if start is not None or is_all:
                    return None
            else:
                start = solution.values
        if is_all:
            return solution
        span *= _GROWTH
        if begin + span >= end:
            span = end - begin + 1.0


def part_fitter(whole: Solution, terms: Sequence[str], aside: Mapping[str, Guess]) -> Any:
    """A function that fits the same equation to a part of the samples, from the whole's motion."""
    drags = dict.fromkeys(COEFFICIENTS, _SOME_DRAG) | {t: whole.values[t] for t in terms}

    def fit_part(part: Data, about: Solution | None = None) -> Solution:
        known = about or whole
        begin = state_at(known.values, float(part.times[0]) - known.origin)
        near = {**drags, **known.values, **dict(zip(START, begin, strict=True))}
        if about is not None:
            return fit_equation(part, near, terms, aside, limit=_SOON)
        return fit_best(part, near, terms, aside)[0]

    return fit_part
