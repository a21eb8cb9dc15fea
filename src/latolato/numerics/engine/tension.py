"""Locates the instant within a step at which a rod is first compressed, or a string goes slack."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics.contact_time import MOST_TRIALS
from latolato.numerics.engine.taut_step import TautStep, acceleration_with_drag
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import ANY_LENGTH, Run
from latolato.observables.hermite import quintic_terms

# How well a root is located by what is seen, and by the steps then, whose last one leaves an error
# of higher order; and where the slope is taken. Shares of the step.
_SEEN, _NEARBY = 1e-8, 1e-3


class Tension(NamedTuple):
    """The functions of the tension within a step; see `make_tension`."""

    seen: Callable[..., float]
    zero: Callable[..., float]
    margin: Callable[..., float]


def make_tension(swing: TautStep, part: Part = as_it_stands) -> Tension:
    """Make the functions of the tension within the step of a ball."""

    @part
    def after(run: Run, i: int, length: float) -> float:
        """Tension over mass and length, `length` seconds into the step [1/s^2]."""
        swing.step_by(run, i, ANY_LENGTH + i, length, run.now[i], run.inside[i])
        return swing.tension(run, i, run.inside[i])

    @part
    def seen(run: Run, i: int, s: float) -> float:
        """Nearly the same without a step, from the quintic through both ends of the whole step."""
        b, begin, end, point = run.bodies[i], run.now[i], run.end[i], run.inside[i]
        h, x0, v0, a0 = run.length, begin.angle, begin.velocity, acceleration_with_drag(begin, b)
        b1, c, p3, p4, p5 = quintic_terms(
            h, x0, v0, a0, end.angle, end.velocity, acceleration_with_drag(end, b)
        )
        u = s / h if h > 0.0 else 0.0
        point.angle = x0 + u * (b1 + u * (c + u * (p3 + u * (p4 + u * p5))))
        rate = u * (2.0 * c + u * (3.0 * p3 + u * (4.0 * p4 + u * 5.0 * p5)))
        point.velocity = v0 + (rate / h if h > 0.0 else 0.0)
        swing.write_pivot_motion(run, run.t + s, point)
        return swing.tension(run, i, point)

    @part
    def zero(run: Run, i: int, low: float, high: float, left: float, right: float) -> float:
        """Time into the step at which the tension changes its sign [s].

        Regula falsi with kept ends halved (Illinois) on what is `seen`; then Newton on the step
        with its slope.
        """
        begins_compression, kept, root, first, last = left < 0.0, 0, high, low, high
        for _ in range(MOST_TRIALS):
            s = (low * right - high * left) / (right - left)
            if not low < s < high:
                break
            now = seen(run, i, s)
            moved, root = abs(s - root), s
            if (now < 0.0) == begins_compression:
                low, left = s, now
                right, kept = (0.5 * right if kept == 1 else right), 1
            else:
                high, right = s, now
                left, kept = (0.5 * left if kept == 2 else left), 2
            if moved < _SEEN * run.length or now == 0.0:
                break
        nearby = _NEARBY * run.length
        slope = (seen(run, i, root + nearby) - seen(run, i, root - nearby)) / (2.0 * nearby)
        moved = nearby
        while slope != 0.0 and moved > _SEEN * run.length:
            move = -after(run, i, root) / slope
            if abs(move) > 0.5 * moved or not first < root + move < last:
                break
            moved, root = abs(move), root + move
        return root

    @part
    def margin(run: Run, i: int) -> float:
        """Bound of the dip of the tension below its values at both ends of the step [1/s^2]."""
        begin, end = run.now[i], run.end[i]
        strongest = (run.settings.gravity + run.settings.pivot_bound) * run.bodies[i].inverse_length
        speeds = begin.velocity * begin.velocity + end.velocity * end.velocity
        result: float = (speeds + strongest) * run.settings.tension_dip
        return result

    return Tension(
        seen=seen,
        zero=zero,
        margin=margin,
    )
