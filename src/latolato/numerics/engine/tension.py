"""Looks for the instant within a step at which a rod is pushed first, or a string goes slack."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.contact_time import MOST_TRIALS
from latolato.numerics.engine.compiling import Part, as_it_stands
from latolato.numerics.engine.swing import ANY_LENGTH, Swing


class Tension(NamedTuple):
    """The functions of the tension within a step; see `make_tension`."""

    after: Callable[..., float]
    zero: Callable[..., float]
    margin: Callable[..., float]


def make_tension(swing: Swing, part: Part = as_it_stands) -> Tension:
    """Return the functions of the tension within the step of a ball."""

    @part
    def after(run: Any, i: int, length: float) -> float:
        """Return the tension over mass and length that far into the step [1/s^2]."""
        swing.step_by(run, i, ANY_LENGTH + i, length, run.now[i], run.inside[i])
        return swing.tension(run, i, run.inside[i])

    @part
    def zero(run: Any, i: int, low: float, high: float, left: float, right: float) -> float:
        """Return where the tension changes its sign; regula falsi, kept ends halved (Illinois)."""
        begins_compression, kept, root = left < 0.0, 0, high
        for _ in range(MOST_TRIALS):
            s = (low * right - high * left) / (right - left)
            if not low < s < high:
                break
            now = after(run, i, s)
            moved, root = abs(s - root), s
            if (now < 0.0) == begins_compression:
                low, left = s, now
                right, kept = (0.5 * right if kept == 1 else right), 1
            else:
                high, right = s, now
                left, kept = (0.5 * left if kept == 2 else left), 2
            if moved < 1e-14 * run.length or now == 0.0:
                break
        return root

    @part
    def margin(run: Any, i: int) -> float:
        """Return how far the tension may dip below its values at both ends of the step [1/s^2]."""
        begin, end = run.now[i], run.end[i]
        strongest = (run.settings.gravity + run.settings.pivot_bound) * run.bodies[i].coupling
        speeds = begin.velocity * begin.velocity + end.velocity * end.velocity
        result: float = (speeds + strongest) * run.settings.sag
        return result

    return Tension(after, zero, margin)
