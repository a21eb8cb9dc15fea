"""Searches for the instant within a step at which something happens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from latolato.core.scalar import formula
from latolato.numerics.parts import Part
from latolato.numerics.run_record import Run
from latolato.observables.hermite import quintic_terms

# What a search looks for.
GAP, RATE = 0, 1
# More halvings than a double has bits below a step: a search that needs them has no root.
MOST_TRIALS = 120
# A search ends when no more than this share of a step is missing: a glide takes that to rounding.
EXTENDABLE = 1e-5
# Trials of a guess by a polynomial; a few more only save steps.
MOST_GUESSES = 12


@formula
def next_trial(
    s: float, value: float, slope: float, low: float, high: float, last_move: float
) -> tuple[float, bool]:
    """Return the next trial of a search for value(s) = 0 in a bracket, and whether it is Newton's.

    Newton's step, or the middle of the bracket where Newton would leave it or halves the last
    move too slowly (Numerical Recipes' safeguard).
    """
    if slope != 0.0:
        move = value / slope
        trial = s - move
        if low < trial < high and abs(2.0 * move) < abs(last_move):
            return trial, True
    return 0.5 * (low + high), False


@formula
def is_located(move: float, slope: float, curvature: float, step: float) -> bool:
    """Return whether the Newton step just made leaves an error below rounding.

    The error after a Newton step is ``curvature/(2 slope) move^2``.
    """
    if abs(move) <= 4e-16 * step:
        return True
    return abs(curvature) * move * move <= 2e-16 * step * abs(slope) and abs(move) < 1e-3 * step


@formula
def crossing(
    what: int, low: float, high: float, far: float, h: float,
    x0: float, v0: float, a0: float, x1: float, v1: float, a1: float,
) -> float:  # fmt: skip
    """Return the zero in (low, high) of the quintic of a step, or of its rate.

    It does so about where the motion does: a search on the step itself begins there.

    Parameters
    ----------
    what : int
        `GAP` or `RATE`.
    far : float
        Sign of what is looked at, at `high`.
    """
    b, c, p3, p4, p5 = quintic_terms(h, x0, v0, a0, x1, v1, a1)
    span, s = high - low, 0.5 * (low + high)
    move = span
    for _ in range(MOST_GUESSES):
        u = s / h
        rate = (b + u * (2.0 * c + u * (3.0 * p3 + u * (4.0 * p4 + u * 5.0 * p5)))) / h
        if what == RATE:
            value = rate
            slope = (2.0 * c + u * (6.0 * p3 + u * (12.0 * p4 + u * 20.0 * p5))) / (h * h)
        else:
            value = x0 + u * (b + u * (c + u * (p3 + u * (p4 + u * p5))))
            slope = rate
        if value * far > 0.0:
            high = s
        else:
            low = s
        trial, _ = next_trial(s, value, slope, low, high, move)
        move, s = trial - s, trial
        if abs(move) <= 1e-9 * span:
            break
    return s


def make_root(function: Callable[..., Any], part: Part) -> Callable[..., Any]:
    """Return the search for where the value of ``function(run, s, *rest)`` is zero, to rounding.

    The function returns a value, its slope and its curvature; the value changes its sign between
    the ends. Called as ``root(run, guess, low, high, far, *rest)``, `far` the sign at `high`. The
    result is the last trial and what is missing from there, a `EXTENDABLE` of the bracket at most.
    """

    @part
    def root(
        run: Run, s: float, low: float, high: float, far: float, *rest: Any
    ) -> tuple[float, float]:
        span = move = high - low
        for _ in range(MOST_TRIALS):
            value, slope, curvature = function(run, s, *rest)
            if value == 0.0:
                break
            if value * far > 0.0:
                high = s
            else:
                low = s
            trial, newton = next_trial(s, value, slope, low, high, move)
            move = trial - s
            if (
                newton
                and abs(move) <= EXTENDABLE * span
                and abs(curvature * move) <= EXTENDABLE * abs(slope)
            ):
                return s, move - 0.5 * curvature / slope * move * move
            if high - low <= 4e-16 * span:
                break
            s = trial
        return s, 0.0

    return root


def make_lowest(function: Callable[..., float], part: Part) -> Callable[..., float]:
    """Return the search for where ``function(run, s, *rest)`` is smallest, by golden section.

    Called as ``lowest(run, begin, end, *rest)``.
    """

    @part
    def lowest(run: Run, begin: float, end: float, *rest: Any) -> float:
        for _ in range(80):
            left, right = begin + 0.382 * (end - begin), begin + 0.618 * (end - begin)
            if function(run, left, *rest) < function(run, right, *rest):
                end = right
            else:
                begin = left
        return 0.5 * (begin + end)

    return lowest
