"""A swing: the splitting step of one ball, or of two as one body, and searches inside of it.

Kicks by gravity, drive and dry friction alternate with drifts under the exact drag; see
`latolato.numerics.steppers`. A point whose `sign` is 0 is held by friction and does not move.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.core.scalar import cosine, formula
from latolato.numerics.contact_time import MOST_TRIALS, is_located, next_trial
from latolato.numerics.engine.compiling import Part, as_it_stands, inlined
from latolato.numerics.engine.laws import Laws
from latolato.physics.damping import decay_time, drag, drift, drift_slopes
from latolato.physics.pendulum import swung

# Rows of a step's table.
KICK, REACH, OFFSET = 0, 1, 2
# Tables of full steps are those of ball 1 and ball 2; then come those of steps of any length, for
# ball 1, ball 2 and both as one body.
ANY_LENGTH = 2
# The shortest step that changes the time, per time: an event ends a step at a later instant.
SHORTEST = 2.3e-16
# Below this speed dry friction stops a ball at once [rad/s]: far less than any tolerance.
STILL = 1e-13


class Swing(NamedTuple):
    """The functions of a swing; see `make_swing`. Each begins with ``(run, body, ...)``."""

    feel: Callable[..., None]
    step: Callable[..., None]
    step_by: Callable[..., None]
    prepare: Callable[..., None]
    free: Callable[..., float]
    settle: Callable[..., None]
    turn: Callable[..., float]
    tangent: Callable[..., Any]


@formula
def slowed(point: Any, body: Any) -> float:
    """Return the acceleration with all drag from that of a kick [rad/s^2]."""
    if point.sign == 0.0:
        return 0.0
    return point.acceleration - drag(point.velocity, point.sign, body.rate, body.quadratic, 0.0)


@formula
def freed(free: float, velocity: float, body: Any) -> float:
    """Return the acceleration with all drag from that without, static friction included."""
    if velocity == 0.0:
        if abs(free) <= body.coulomb:
            return 0.0
        return free - math.copysign(body.coulomb, free)
    sign = math.copysign(1.0, velocity)
    return free - drag(velocity, sign, body.rate, body.quadratic, body.coulomb)


@formula
def tension_at(
    angle: float, velocity: float, pivot_acceleration: float, gravity: float, coupling: float
) -> float:
    """Return the tension in flight over mass and length [1/s^2]."""
    return velocity * velocity + (gravity + pivot_acceleration) * coupling * cosine(angle)


def make_swing(laws: Laws, part: Part = as_it_stands) -> Swing:
    """Return the functions of a swing under these laws.

    Points are records; a step goes from one to another one and writes work and loss there.
    """
    pivot_acceleration, restoring, slope = laws.pivot_acceleration, laws.restoring, laws.slope
    push, push_slope = laws.push, laws.push_slope

    @part
    def free(run: Any, body: int, t: float, angle: float) -> float:
        """Return the angular acceleration without drag [rad/s^2]."""
        b, settings = run.bodies[body], run.settings
        lifted = settings.gravity + pivot_acceleration(t, run.stretch)
        restored = restoring(angle, settings.is_linear)
        return swung(lifted, b.coupling, restored) + push(angle, run)

    @part
    def feel(run: Any, body: int, t: float, point: Any) -> None:
        """Write what pulls at a point into it."""
        b, gravity = run.bodies[body], run.settings.gravity
        ay = pivot_acceleration(t, run.stretch)
        point.pivot_acceleration = ay
        point.acceleration = point.driven = 0.0
        if point.sign != 0.0:
            restored = restoring(point.angle, run.settings.is_linear)
            point.driven = swung(ay, b.coupling, restored)
            other = push(point.angle, run) - b.coulomb * point.sign
            point.acceleration = point.driven + swung(gravity, b.coupling, restored) + other
        if run.settings.follows_tension != 0:
            angle, velocity = point.angle, point.velocity
            point.tension = tension_at(angle, velocity, ay, gravity, b.coupling)

    @part
    def prepare(run: Any, body: int, table: int, length: float) -> None:
        """Fill a table with what a step of this length needs [s]."""
        rate = run.bodies[body].rate
        for i in range(run.stages):
            run.tables[table, KICK, i] = run.kicks[i] * length
            run.tables[table, REACH, i] = decay_time(rate, run.drifts[i] * length)
            run.tables[table, OFFSET, i] = run.nodes[i] * length
        run.tables[table, KICK, run.stages] = run.kicks[run.stages] * length

    @inlined(part)
    def step(run: Any, body: int, table: int, begin: Any, end: Any) -> None:
        """Take the step of a table that was prepared.

        In a kick ``dW = driven h (w + w')/2`` is the exact work of the drive's part; in a drift the
        loss is the drop of w^2/2.
        """
        angle, velocity, sign = begin.angle, begin.velocity, begin.sign
        a, driven, ay = begin.acceleration, begin.driven, begin.pivot_acceleration
        work, loss, t = 0.0, 0.0, run.t
        b, gravity, is_linear = run.bodies[body], run.settings.gravity, run.settings.is_linear
        coupling, rate, quadratic, friction = b.coupling, b.rate, b.quadratic, b.coulomb * sign
        if sign == 0.0:
            end.angle, end.velocity, end.sign, end.work, end.loss = angle, 0.0, 0.0, 0.0, 0.0
            end.acceleration = end.driven = 0.0
            return
        for i in range(run.stages):
            h = run.tables[table, KICK, i]
            change = h * a
            middle = velocity + 0.5 * change
            work += h * driven * middle
            loss += h * friction * middle
            velocity += change
            reach = run.tables[table, REACH, i]
            travelled, slower = drift(velocity, sign, reach, rate, quadratic)
            loss += 0.5 * (velocity - slower) * (velocity + slower)
            angle += travelled
            velocity = slower
            ay = pivot_acceleration(t + run.tables[table, OFFSET, i], run.stretch)
            restored = restoring(angle, is_linear)
            driven = swung(ay, coupling, restored)
            a = driven + swung(gravity, coupling, restored) + (push(angle, run) - friction)
        h = run.tables[table, KICK, run.stages]
        change = h * a
        middle = velocity + 0.5 * change
        work += h * driven * middle
        loss += h * friction * middle
        velocity += change
        end.angle, end.velocity, end.sign = angle, velocity, sign
        end.acceleration, end.driven, end.pivot_acceleration = a, driven, ay
        end.work, end.loss = work, loss

    @part
    def step_by(run: Any, body: int, table: int, length: float, begin: Any, end: Any) -> None:
        """Take a step of any length [s]."""
        prepare(run, body, table, length)
        step(run, body, table, begin, end)

    @part
    def settle(run: Any, body: int, t: float, point: Any) -> None:
        """Find the direction in which a point moves or begins to, and what pulls at it."""
        friction = run.bodies[body].coulomb
        if friction > 0.0 and abs(point.velocity) < STILL:
            point.velocity = 0.0
        if point.velocity != 0.0:
            point.sign = math.copysign(1.0, point.velocity)
        else:
            pulled = free(run, body, t, point.angle)
            held = friction > 0.0 and abs(pulled) <= friction
            point.sign = 0.0 if held else math.copysign(1.0, pulled)
        feel(run, body, t, point)

    @part
    def turn(run: Any, body: int, table: int, length: float, begin: Any, end: Any) -> float:
        """Return when, within a step, a velocity that ends against its sign or as NaN is zero [s].

        The length itself if that cannot be seen. Bracketed Newton on the step, to rounding.
        """
        low, high, sign = 0.0, length, begin.sign
        if begin.velocity == 0.0:  # it must leave zero before it can return
            low = 0.5 * length
            for _ in range(50):
                step_by(run, body, table, low, begin, end)
                if end.velocity * sign > 0.0:
                    break
                low *= 0.5
            if not end.velocity * sign > 0.0:
                return length
        s = 0.5 * (low + high)
        span = move = high - low
        rate = run.bodies[body].rate
        for _ in range(MOST_TRIALS):
            step_by(run, body, table, s, begin, end)
            value = end.velocity
            if value == 0.0:
                return s
            if value * sign > 0.0:
                low = s
            else:  # beyond the turn, so far perhaps that there is no number for it
                high = s
            # The drag's share of the slope only slows Newton; the bracket keeps it safe.
            slowing = end.acceleration - rate * value
            trial, newton = next_trial(s, value, slowing, low, high, move)
            move = trial - s
            s = trial
            done = newton and is_located(move, slowing, end.acceleration, span)
            if done or high - low <= 4e-16 * span:
                return s
        return s

    @part
    def tangent(run: Any, body: int, table: int, begin: Any) -> tuple[float, float, float, float]:
        """Return the matrix by which a prepared step changes small deviations, row by row.

        A kick adds ``h a'(angle)`` times the angle's deviation to the velocity's, a drift is linear
        in it: the matrix belongs to the very step, not to an approximation of the flow.
        """
        sign = begin.sign
        if sign == 0.0:
            return 1.0, 0.0, 0.0, 0.0
        b, gravity = run.bodies[body], run.settings.gravity
        angle, velocity, a, t = begin.angle, begin.velocity, begin.acceleration, run.t
        lifted = gravity + begin.pivot_acceleration
        is_linear = run.settings.is_linear
        # The columns of the matrix: what starts as a unit of angle, and of velocity.
        x1, v1, x2, v2 = 1.0, 0.0, 0.0, 1.0
        for i in range(run.stages):
            h = run.tables[table, KICK, i]
            bend = swung(lifted, b.coupling, slope(angle, is_linear)) + push_slope(angle, run)
            bend *= h
            velocity += h * a
            v1 += bend * x1
            v2 += bend * x2
            reach = run.tables[table, REACH, i]
            far, kept = drift_slopes(velocity, sign, reach, b.rate, b.quadratic)
            x1 += far * v1
            x2 += far * v2
            v1 *= kept
            v2 *= kept
            travelled, velocity = drift(velocity, sign, reach, b.rate, b.quadratic)
            angle += travelled
            lifted = gravity + pivot_acceleration(t + run.tables[table, OFFSET, i], run.stretch)
            a = swung(lifted, b.coupling, restoring(angle, is_linear)) + push(angle, run)
            a -= b.coulomb * sign
        bend = swung(lifted, b.coupling, slope(angle, is_linear)) + push_slope(angle, run)
        bend *= run.tables[table, KICK, run.stages]
        return x1, x2, v1 + bend * x1, v2 + bend * x2

    return Swing(feel, step, step_by, prepare, free, settle, turn, tangent)
