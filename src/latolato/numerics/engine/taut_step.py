"""The splitting step of one taut ball, or of two as one body, and searches inside of it.

Kicks by gravity, drive and dry friction (`forces.py`) alternate with drifts under the exact drag;
see `latolato.numerics.steppers`. A point whose `sign` is 0 is held by friction and does not move.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.core.scalar import formula
from latolato.numerics.contact_time import MOST_TRIALS, is_located, next_trial
from latolato.numerics.engine.forces import make_planar, make_upright
from latolato.numerics.engine.laws import Laws
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.records import Body
from latolato.numerics.run_record import DRIFT_TIME, KICK, OFFSET, TIME_SLOPE, Point, Run
from latolato.physics.damping import drag, effective_time, effective_time_slope, viscous_drag

# The shortest step that changes the time, per time: an event ends a step at a later instant.
SHORTEST = 2.3e-16
# Below this speed dry friction stops a ball at once [rad/s]: far less than any tolerance.
STILL = 1e-13


class TautStep(NamedTuple):
    """The functions of a swing; see `make_taut_step`. Each begins with ``(run, body, ...)``."""

    write_forces: Callable[..., None]
    step: Callable[..., None]
    step_by: Callable[..., None]
    extend_step: Callable[..., None]
    prepare: Callable[..., None]
    free: Callable[..., float]
    settle: Callable[..., None]
    turn: Callable[..., float]
    prepare_tangent: Callable[..., None]
    tangent: Callable[..., Any]
    tension: Callable[..., float]
    static_tension: Callable[..., float]
    write_pivot_motion: Callable[..., None]
    pivot_change: Callable[..., Any]
    pull_change: Callable[..., float]
    pull_gradient: Callable[..., float]
    tension_change: Callable[..., float]


@formula
def acceleration_with_drag(point: Point, body: Body) -> float:
    """Angular acceleration with all drag, from that of a kick [rad/s^2]."""
    if point.sign == 0.0:
        return 0.0
    return point.acceleration - viscous_drag(point.velocity, body)


@formula
def acceleration_with_friction(free: float, velocity: float, body: Body) -> float:
    """Angular acceleration with drag and static friction, from that without [rad/s^2]."""
    if velocity == 0.0:
        if abs(free) <= body.coulomb:
            return 0.0
        return free - math.copysign(body.coulomb, free)
    sign = math.copysign(1.0, velocity)
    return free - drag(velocity, sign, body)


def make_taut_step(laws: Laws, part: Part = as_it_stands) -> TautStep:
    """Make the functions of a taut step under these laws.

    Points are records; a step goes from one to another one and writes work and loss there.
    """
    make_forces = make_upright if laws.plane is None else make_planar
    forces = make_forces(laws, part)
    free, write_forces, step = forces.free, forces.write_forces, forces.step
    sensitive = len(laws.changes) > 0

    @part
    def prepare(run: Run, body: int, table: int, length: float) -> None:
        """Fill a table with what a step of this length needs [s]."""
        rate = run.bodies[body].damping_rate
        for i in range(run.stages):
            run.tables[table, KICK, i] = run.kicks[i] * length
            run.tables[table, DRIFT_TIME, i] = effective_time(rate, run.drifts[i] * length)
            run.tables[table, OFFSET, i] = run.nodes[i] * length
            if sensitive:
                slope = effective_time_slope(rate, run.drifts[i] * length)
                run.path[table, i, TIME_SLOPE] = slope
        run.tables[table, KICK, run.stages] = run.kicks[run.stages] * length

    @part
    def step_by(run: Run, body: int, table: int, length: float, begin: Point, end: Point) -> None:
        """Take a step of any length [s]."""
        prepare(run, body, table, length)
        step(run, body, table, begin, end)

    @part
    def prepare_tangent(run: Run, body: int, table: int, length: float, begin: Point) -> None:
        """Prepare what `tangent` needs for a step of any length [s]: it may have to be recorded."""
        prepare(run, body, table, length)
        if sensitive:
            step(run, body, table, begin, run.passing[0])

    @part
    def extend_step(run: Run, body: int, t: float, missing: float, point: Point) -> None:
        """Extend a step to the time t, by a time so short that trapezia are exact to rounding."""
        if point.sign == 0.0:
            return
        b, v0, driven = run.bodies[body], point.velocity, point.driven
        a0 = acceleration_with_drag(point, b)
        point.angle += missing * (v0 + 0.5 * missing * a0)
        point.velocity = v0 + missing * a0
        write_forces(run, body, t, point)
        v1 = point.velocity = v0 + 0.5 * missing * (a0 + acceleration_with_drag(point, b))
        lost = v0 * drag(v0, point.sign, b)
        lost += v1 * drag(v1, point.sign, b)
        point.work += 0.5 * missing * (driven * v0 + point.driven * v1)
        point.loss += 0.5 * missing * lost

    @part
    def settle(run: Run, body: int, t: float, point: Point) -> None:
        """Find the direction in which a point moves or begins to, and the forces on it."""
        friction = run.bodies[body].coulomb
        if friction > 0.0 and abs(point.velocity) < STILL:
            point.velocity = 0.0
        if point.velocity != 0.0:
            point.sign = math.copysign(1.0, point.velocity)
        else:
            pulled = free(run, body, t, point.angle)
            held = friction > 0.0 and abs(pulled) <= friction
            point.sign = 0.0 if held else math.copysign(1.0, pulled)
        write_forces(run, body, t, point)

    @part
    def turn(run: Run, body: int, table: int, length: float, begin: Point, end: Point) -> float:
        """Time within a step at which a velocity that ends against its sign or as NaN is zero [s].

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
        rate = run.bodies[body].damping_rate
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

    return TautStep(
        write_forces=write_forces,
        step=step,
        step_by=step_by,
        extend_step=extend_step,
        prepare=prepare,
        free=free,
        settle=settle,
        turn=turn,
        prepare_tangent=prepare_tangent,
        tangent=forces.tangent,
        tension=forces.tension,
        static_tension=forces.static_tension,
        write_pivot_motion=forces.write_pivot_motion,
        pivot_change=forces.pivot_change,
        pull_change=forces.pull_change,
        pull_gradient=forces.pull_gradient,
        tension_change=forces.tension_change,
    )
