"""Where a motion has no derivatives with respect to parameters, or none that can be trusted.

At a graze a derivative grows like the inverse of the closing speed, and it is open whether the
impact happens at all; of two events at one instant a parameter may exchange the order; the last
bounces of a capture are not followed one by one. All derivatives are NaN from there on, with the
reason in ``run.doubt``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics.engine.balls import Balls
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import Run

# Why derivatives are not known any more; `simulation.sensitivity` has the sentences.
CERTAIN, GRAZING, TOGETHER, CAPTURED, START, JUMP_IN_SLACK = range(6)

# An impact is a graze if the balls would have turned round this close behind the wall [rad].
GRAZING_DEPTH = 1e-9
# A gap that changes less than this per unit of a parameter does not change [rad].
_NONE = 1e-12


class Doubts(NamedTuple):
    """The functions that mark derivatives as unknown; see `make_doubts`."""

    forget_delays: Callable[..., None]
    doubt: Callable[..., None]
    check_start: Callable[..., None]
    check_graze: Callable[..., None]
    check_slack_segment: Callable[..., None]


def make_doubts(
    balls: Balls, gap_change: Callable[..., float], count: int, part: Part = as_it_stands
) -> Doubts:
    """Make the functions that find out where a motion has no derivatives, and remember it."""
    size = 2 * count

    @part
    def forget_delays(run: Run) -> None:
        """Mark the delays of the present contact as unknown."""
        for p in range(run.parameters):
            run.delay[p] = math.nan

    @part
    def doubt(run: Run, reason: int) -> None:
        """Mark all derivatives as unknown from now on."""
        if run.parameters == 0 or run.doubt != CERTAIN:
            return
        run.doubt, run.doubted_since = reason, run.t
        forget_delays(run)
        for p in range(run.parameters):
            for row in range(size):
                run.sensitivity[row, p] = math.nan

    @part
    def check_start(run: Run, side: float) -> None:
        """Doubt derivatives that would lift the balls off a contact at time zero, or push in."""
        for p in range(run.parameters):
            if abs(gap_change(run, p, side)) > _NONE:
                doubt(run, START)

    @part
    def check_graze(run: Run, side: float, closing: float) -> None:
        """Doubt derivatives at an impact that a slightly larger gap would have spared.

        Balls that meet at `closing` [rad/s] while they are pulled apart would have turned round
        ``closing^2/(2 a)`` behind the contact; the derivative grows like the inverse of the speed.
        """
        pulled = balls.separation_acceleration(run, side, run.t, run.now)
        if pulled > 0.0 and closing * closing < 2.0 * pulled * GRAZING_DEPTH:
            doubt(run, GRAZING)

    @part
    def check_slack_segment(run: Run) -> None:
        """Doubt derivatives of where a segment begins, or of its jump, while a string is slack."""
        for p in range(run.parameters):
            if run.segment_changes[p].start != 0.0 or run.segment_changes[p].jump != 0.0:
                doubt(run, JUMP_IN_SLACK)

    return Doubts(forget_delays, doubt, check_start, check_graze, check_slack_segment)
