"""Searches for the instant within a step at which something happens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from latolato.core.scalar import formula
from latolato.numerics.engine.compiling import Part

# More halvings than a double has bits below a step: a search that needs them has no root.
MOST_TRIALS = 120


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


def make_root(function: Callable[..., Any], part: Part) -> Callable[..., float]:
    """Return the search for where the value of ``function(run, s, *rest)`` is zero, to rounding.

    The function returns a value and its slope (0: unknown); the value changes its sign between the
    ends. Called as ``root(run, low, high, *rest)``.
    """

    @part
    def root(run: Any, low: float, high: float, *rest: Any) -> float:
        value, slope = function(run, high, *rest)
        is_positive, span, move, s = value > 0.0, high - low, high - low, high
        for _ in range(MOST_TRIALS):
            trial, newton = next_trial(s, value, slope, low, high, move)
            move, s = trial - s, trial
            if s <= low or s >= high:
                break
            value, slope = function(run, s, *rest)
            if value == 0.0:
                break
            if (value > 0.0) == is_positive:
                high = s
            else:
                low = s
            if high - low <= 4e-16 * span or (newton and abs(move) <= 4e-16 * span):
                break
        return s

    return root


def make_lowest(function: Callable[..., float], part: Part) -> Callable[..., float]:
    """Return the search for where ``function(run, s, *rest)`` is smallest, by golden section.

    Called as ``lowest(run, begin, end, *rest)``.
    """

    @part
    def lowest(run: Any, begin: float, end: float, *rest: Any) -> float:
        for _ in range(80):
            left, right = begin + 0.382 * (end - begin), begin + 0.618 * (end - begin)
            if function(run, left, *rest) < function(run, right, *rest):
                end = right
            else:
                begin = left
        return 0.5 * (begin + end)

    return lowest
