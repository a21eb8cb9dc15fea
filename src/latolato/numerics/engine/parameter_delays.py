"""By how much parameters delay events: ``dt = -(q_x s + q_p)/(dq/dt)`` for a guard ``q(x, t, p)``.

The guard of an impact is the gap above the contact, which moves itself. That of the end of rest or
sticking contact is the acceleration with which the ball or balls would part: its derivatives
follow from those of the forces (`forces.py`) and of the drag.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics.engine.balls import share_of
from latolato.numerics.engine.doubts import CERTAIN
from latolato.numerics.engine.taut_step import TautStep, acceleration_with_drag
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import Run
from latolato.physics.damping import viscous_drag, viscous_drag_slope

# A contact ends by the balls' accelerations if these differ by less than this share.
_EQUAL = 1e-6


class ParameterDelays(NamedTuple):
    """The functions that find delays; see `make_parameter_delays`."""

    reach_contact: Callable[..., None]
    reach_release: Callable[..., None]


def make_parameter_delays(
    swing: TautStep, gap_change: Callable[..., float], count: int, part: Part = as_it_stands
) -> ParameterDelays:
    """Make the functions of delays of `count` balls."""
    two = count == 2

    @part
    def reach_contact(run: Run, side: float, closing: float) -> None:
        """Find by how much each parameter delays the contact that is met at `closing` [rad/s]."""
        for p in range(run.parameters):
            late = math.nan
            if run.doubt == CERTAIN and closing != 0.0:
                late = -gap_change(run, p, side) / closing
            run.delay[p] = late

    @part
    def acceleration_change(run: Run, i: int, p: int, rates: tuple[float, float]) -> float:
        """Derivative of a ball's angular acceleration with all drag, along one of the state's.

        `rates` are those of angle and angular velocity; p may be the time.
        """
        b, point, change = run.bodies[i], run.now[i], run.changes[p].bodies[i]
        pulled: float = swing.pull_change(run, i, run.t, point.angle, p)
        pulled += swing.pull_gradient(run, i, run.t, point.angle) * rates[0]
        pulled -= viscous_drag_slope(point.velocity, b) * rates[1]
        return pulled - viscous_drag(point.velocity, change) - point.sign * change.coulomb

    @part
    def reach_release(run: Run, turning: float) -> None:
        """Find by how much each parameter delays the end of rest or sticking contact.

        The guard is the difference of the balls' own accelerations, or the acceleration of one
        from its wall. For balls that part as they turn, at the acceleration `turning` [rad/s^2], it
        is their common velocity; `turning` is 0 for others. Where something else ended the contact,
        the delays are unknown.
        """
        swing.settle(run, 0, run.t, run.now[0])
        a0 = acceleration_with_drag(run.now[0], run.bodies[0])
        guard, scale, common = a0, abs(run.now[0].acceleration) + 1.0, 0.0
        if two:
            swing.settle(run, 1, run.t, run.now[1])
            a1 = acceleration_with_drag(run.now[1], run.bodies[1])
            share = share_of(run)
            guard, common = a0 - a1, share * a0 + (1.0 - share) * a1
            scale += abs(run.now[1].acceleration)
        is_other = abs(guard) > _EQUAL * scale
        for p in range(run.parameters):
            run.delay[p] = math.nan
            if turning != 0.0:
                run.delay[p] = -run.sensitivity[1, p] / turning
            if turning != 0.0 or is_other or run.doubt != CERTAIN:
                continue
            change, rate = 0.0, 0.0
            for i in range(count):
                sign, s, rates = 1.0 - 2.0 * i, run.sensitivity, (run.now[i].velocity, common)
                own = s[2 * i, p], s[2 * i + 1, p]
                change += sign * acceleration_change(run, i, p, own)
                rate += sign * acceleration_change(run, i, run.parameters, rates)
            if rate != 0.0:
                run.delay[p] = -change / rate

    return ParameterDelays(reach_contact, reach_release)
