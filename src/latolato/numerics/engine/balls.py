"""What all balls do together, and the gap: one ball's angle, or the separation of two.

Contacts are met where the gap reaches ``settings.low`` (side -1, the bottom) or ``settings.high``
(side 1, the top). One ball meets walls there, two balls each other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.core.scalar import formula
from latolato.numerics.contact_time import GAP, crossing, make_root
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.slack_step import NO_SLACK_STEP, SlackStep, place_taut
from latolato.numerics.engine.taut_step import (
    TautStep,
    acceleration_with_drag,
    acceleration_with_friction,
)
from latolato.numerics.engine.tension import Tension, make_tension
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.run_record import ANY_LENGTH, Point, Run


class Balls(NamedTuple):
    """The functions of all balls; see `make_balls`."""

    gap: Callable[..., float]
    gap_rate: Callable[..., float]
    gap_course: Callable[..., Any]
    place: Callable[..., None]
    fly: Callable[..., None]
    fly_by: Callable[..., None]
    settle: Callable[..., None]
    guess: Callable[..., float]
    locate: Callable[..., float]
    leave: Callable[..., float]
    separation_acceleration: Callable[..., float]
    energy: Callable[..., float]
    plan_length: Callable[..., None]
    shorten: Callable[..., None]
    tension: Tension


@formula
def share_of(run: Run) -> float:
    """Share of the first ball in the moment of inertia of both."""
    share: float = run.bodies[0].inertia / (run.bodies[0].inertia + run.bodies[1].inertia)
    return share


def make_balls(
    swing: TautStep, fall: SlackStep, laws: Laws, count: int, part: Part = as_it_stands
) -> Balls:
    """Make the functions of one or two balls whose motion is that of `swing`.

    In the plane the string of a ball may be slack, and it moves by `fall` then.
    """
    two, in_plane = count == 2, fall is not NO_SLACK_STEP
    fall_by, hang, slopes = fall.step_by, fall.hang, fall.slopes
    potential, push_potential = laws.potential, laws.push_potential

    @inlined(part)
    def gap(points: list[Point]) -> float:
        """The gap [rad]."""
        angle: float = points[0].angle - points[1].angle if two else points[0].angle
        return angle

    @inlined(part)
    def gap_rate(points: list[Point]) -> float:
        """Rate of the gap [rad/s]."""
        speed: float = points[0].velocity - points[1].velocity if two else points[0].velocity
        return speed

    @inlined(part)
    def gap_acceleration(run: Run, points: list[Point]) -> float:
        """Acceleration of the gap with all drag [rad/s^2]."""
        curvature: float = acceleration_with_drag(points[0], run.bodies[0])
        return curvature - acceleration_with_drag(points[1], run.bodies[1]) if two else curvature

    @part
    def gap_course(run: Run, wall: float) -> tuple[float, float, float, float, float, float]:
        """The gap above a wall, its rate and acceleration, at both ends of the step."""
        a0, a1 = gap_acceleration(run, run.now), gap_acceleration(run, run.end)
        begin, end = gap(run.now) - wall, gap(run.end) - wall
        return begin, gap_rate(run.now), a0, end, gap_rate(run.end), a1

    @part
    def place(run: Run, points: list[Point], wanted: float, rate: float) -> None:
        """Set the gap and its rate, with the mean angle and the angular momentum kept."""
        if two:
            share, angle = share_of(run), wanted - gap(points)
            velocity = rate - gap_rate(points)
            points[0].angle += 0.5 * angle
            points[1].angle -= 0.5 * angle
            points[0].velocity += (1.0 - share) * velocity
            points[1].velocity -= share * velocity
        else:
            points[0].angle, points[0].velocity = wanted, rate

    @inlined(part)
    def fly(run: Run) -> None:
        """Take a full step of all balls."""
        for i in range(count):
            if in_plane and run.state.is_slack[i] != 0:
                fall_by(run, i, ANY_LENGTH + i, run.length, run.now[i], run.end[i])
            else:
                swing.step(run, i, i, run.now[i], run.end[i])
                if in_plane and two:
                    place_taut(run.end[i], 1.0 / run.bodies[i].inverse_length)

    @part
    def fly_by(run: Run, length: float, points: list[Point]) -> None:
        """Take a step of any length of all balls."""
        for i in range(count):
            if in_plane and run.state.is_slack[i] != 0:
                fall_by(run, i, ANY_LENGTH + i, length, run.now[i], points[i])
            else:
                swing.step_by(run, i, ANY_LENGTH + i, length, run.now[i], points[i])
                if in_plane and two:
                    place_taut(points[i], 1.0 / run.bodies[i].inverse_length)

    @part
    def settle(run: Run) -> None:
        """Find the directions in which the balls move, and the forces on them."""
        for i in range(count):
            if not in_plane or run.state.is_slack[i] == 0:
                swing.settle(run, i, run.t, run.now[i])
            if in_plane:
                hang(run, i, run.now[i])

    @part
    def guess(
        what: int, low: float, high: float, far: float, h: float,
        course: tuple[float, float, float, float, float, float],
    ) -> float:  # fmt: skip
        """The `crossing` of a course through a step: one copy of its code."""
        return crossing(what, low, high, far, h, *course)

    @part
    def extend_step(run: Run, s: float, missing: float) -> None:
        """Extend ``run.end``, s seconds into the step, by a tiny missing time; all are taut."""
        if run.settings.in_lab != 0:  # what moving air takes is counted in whole steps
            fly_by(run, s + missing, run.end)
            return
        for i in range(count):
            swing.extend_step(run, i, run.t + s + missing, missing, run.end[i])
            if in_plane and two:
                place_taut(run.end[i], 1.0 / run.bodies[i].inverse_length)

    @part
    def value_at(run: Run, s: float, what: int, target: float) -> tuple[float, float, float]:
        """The guard to be located, its slope and curvature, s seconds into the step."""
        fly_by(run, s, run.end)
        rate, curvature = gap_rate(run.end), gap_acceleration(run, run.end)
        if what == GAP:
            return gap(run.end) - target, rate, curvature
        return rate - target, curvature, 0.0

    find = make_root(value_at, part)

    @part
    def locate(run: Run, what: int, target: float, low: float, high: float) -> float:
        """Length in [low, high] of a step to where the gap or its rate reaches `target` [s].

        ``run.end``, where the step of length `high` ends, becomes where that one ends. The value
        minus the target changes its sign between the ends. Bracketed Newton on the step itself.
        """
        value = (gap(run.end) if what == GAP else gap_rate(run.end)) - target
        if value == 0.0:
            return high
        far, wall = 1.0 if value > 0.0 else -1.0, target if what == GAP else 0.0
        s = guess(what, low, high, far, high, gap_course(run, wall))
        s, missing = find(run, s, low, high, far, what, target)
        extend_step(run, s, missing)
        return s + missing

    @part
    def leave(run: Run, target: float, far: float, high: float) -> float:
        """Length of a step after which the gap has left `target`, on the near side [s].

        Zero if the motion on the near side is too small to be seen in double precision.
        """
        s = 0.5 * high
        for _ in range(50):
            fly_by(run, s, run.inside)
            if (gap(run.inside) - target) * far < 0.0:
                return s
            s *= 0.5
        return 0.0

    @part
    def separation_acceleration(run: Run, side: float, t: float, points: list[Point]) -> float:
        """Acceleration of the gap away from a contact, with all drag [rad/s^2]."""
        separating = 0.0
        for i in range(count):
            free = swing.free(run, i, t, points[i].angle)
            pulled = acceleration_with_friction(free, points[i].velocity, run.bodies[i])
            separating += pulled if i == 0 else -pulled
        return -side * separating

    @inlined(part)
    def energy(run: Run) -> float:
        """Energy of all balls [J]."""
        total, settings = 0.0, run.settings
        for i in range(count):
            b, point = run.bodies[i], run.now[i]
            if in_plane and run.state.is_slack[i] != 0:
                total += b.inertia * slopes(run, i, point)[1]
                continue
            height = (
                settings.gravity * b.inverse_length * potential(point.angle, settings.is_linear)
            )
            pushed = push_potential(point.angle, run)
            total += b.inertia * (0.5 * point.velocity * point.velocity + height + pushed)
        return total

    @inlined(part)
    def plan_length(run: Run) -> None:
        """Plan a full step, or one that ends at the goal."""
        h = run.settings.step
        run.length, run.is_whole = h, 1
        run.t_end = run.state.t_base + (run.state.steps + 1) * h
        if run.t_end >= run.goal - 1e-9 * h:
            run.length, run.t_end, run.is_whole = run.goal - run.t, run.goal, 0

    @inlined(part)
    def shorten(run: Run, length: float) -> None:
        """End the step earlier."""
        run.length, run.t_end, run.is_whole = length, run.t + length, 0

    return Balls(
        gap=gap,
        gap_rate=gap_rate,
        gap_course=gap_course,
        place=place,
        fly=fly,
        fly_by=fly_by,
        settle=settle,
        guess=guess,
        locate=locate,
        leave=leave,
        separation_acceleration=separation_acceleration,
        energy=energy,
        plan_length=plan_length,
        shorten=shorten,
        tension=make_tension(swing, part),
    )
