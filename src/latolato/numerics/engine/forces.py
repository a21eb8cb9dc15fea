"""Forces on a ball whose rod or string is taut, and its splitting step under them.

A pivot that only moves up and down leaves gravity's direction alone (`make_upright`). In the plane
it pulls sideways too, and air at rest in the room blows past the pivot (`make_planar`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.core.scalar import cosine, formula, sine
from latolato.numerics.engine.laws import Laws
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.records import Body
from latolato.numerics.run_record import DRIFT_TIME, KICK, OFFSET, Point, Run
from latolato.physics.damping import drift, drift_slopes
from latolato.physics.pendulum import swung


class Forces(NamedTuple):
    """The functions that depend on the forces; each begins with ``(run, body, ...)``."""

    free: Callable[..., float]
    write_forces: Callable[..., None]
    step: Callable[..., None]
    tangent: Callable[..., Any]
    tension: Callable[..., float]
    static_tension: Callable[..., float]
    write_pivot_motion: Callable[..., None]


@formula
def tension_at(
    angle: float, velocity: float, pivot_acceleration: float, gravity: float, inverse_length: float
) -> float:
    """Tension in flight over mass and length [1/s^2]."""
    return velocity * velocity + (gravity + pivot_acceleration) * inverse_length * cosine(angle)


def make_upright(laws: Laws, part: Part = as_it_stands) -> Forces:
    """Make the functions for a pivot that moves up and down."""
    pivot_acceleration, restoring, slope = laws.pivot_acceleration, laws.restoring, laws.slope
    push, push_slope = laws.push, laws.push_slope

    @part
    def pivot_motion(run: Run, t: float) -> float:
        """Vertical acceleration of the pivot [m/s^2]: one copy of its forms, for all but steps."""
        ay: float = pivot_acceleration(t, run.segment)
        return ay

    @part
    def free(run: Run, body: int, t: float, angle: float) -> float:
        """Angular acceleration without drag [rad/s^2]."""
        b, settings = run.bodies[body], run.settings
        lifted = settings.gravity + pivot_motion(run, t)
        restored = restoring(angle, settings.is_linear)
        return swung(lifted, b.inverse_length, restored) + push(angle, run)

    @part
    def write_forces(run: Run, body: int, t: float, point: Point) -> None:
        """Write the accelerations by all forces but drag into a point, and the tension."""
        b, gravity = run.bodies[body], run.settings.gravity
        ay = point.pivot_acceleration = pivot_motion(run, t)
        point.acceleration = point.driven = 0.0
        if point.sign != 0.0:
            restored = restoring(point.angle, run.settings.is_linear)
            point.driven = swung(ay, b.inverse_length, restored)
            other = push(point.angle, run) - b.coulomb * point.sign
            point.acceleration = point.driven + swung(gravity, b.inverse_length, restored) + other
        if run.settings.follows_tension != 0:
            angle, velocity = point.angle, point.velocity
            point.tension = tension_at(angle, velocity, ay, gravity, b.inverse_length)

    @inlined(part)
    def step(run: Run, body: int, table: int, begin: Point, end: Point) -> None:
        """Take the step of a table that was prepared.

        In a kick ``dW = driven h (w + w')/2`` is the exact work of the drive's part; in a drift the
        loss is the drop of w^2/2.
        """
        angle, velocity, sign = begin.angle, begin.velocity, begin.sign
        a, driven, ay = begin.acceleration, begin.driven, begin.pivot_acceleration
        work, loss, t = 0.0, 0.0, run.t
        b, gravity, is_linear = run.bodies[body], run.settings.gravity, run.settings.is_linear
        inverse_length, friction = b.inverse_length, b.coulomb * sign
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
            drift_time = run.tables[table, DRIFT_TIME, i]
            travelled, slower = drift(velocity, sign, drift_time, b)
            loss += 0.5 * (velocity - slower) * (velocity + slower)
            angle += travelled
            velocity = slower
            ay = pivot_acceleration(t + run.tables[table, OFFSET, i], run.segment)
            restored = restoring(angle, is_linear)
            driven = swung(ay, inverse_length, restored)
            a = driven + swung(gravity, inverse_length, restored) + (push(angle, run) - friction)
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
    def tangent(run: Run, body: int, table: int, begin: Point) -> tuple[float, float, float, float]:
        """Tangent map of a prepared step, row by row.

        A kick adds ``h a'(angle)`` times the perturbation of the angle to that of the velocity, and
        a drift is differentiated exactly: the map belongs to the very step, not to an approximation
        of the flow.
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
            gradient = swung(lifted, b.inverse_length, slope(angle, is_linear)) + push_slope(
                angle, run
            )
            gradient *= h
            velocity += h * a
            v1 += gradient * x1
            v2 += gradient * x2
            drift_time = run.tables[table, DRIFT_TIME, i]
            far, kept = drift_slopes(velocity, sign, drift_time, b)
            x1 += far * v1
            x2 += far * v2
            v1 *= kept
            v2 *= kept
            travelled, velocity = drift(velocity, sign, drift_time, b)
            angle += travelled
            lifted = gravity + pivot_acceleration(t + run.tables[table, OFFSET, i], run.segment)
            a = swung(lifted, b.inverse_length, restoring(angle, is_linear)) + push(angle, run)
            a -= b.coulomb * sign
        gradient = swung(lifted, b.inverse_length, slope(angle, is_linear)) + push_slope(angle, run)
        gradient *= run.tables[table, KICK, run.stages]
        return x1, x2, v1 + gradient * x1, v2 + gradient * x2

    @part
    def tension(run: Run, body: int, point: Point) -> float:
        """Tension in flight over mass and length [1/s^2]."""
        return tension_at(
            point.angle, point.velocity, point.pivot_acceleration, run.settings.gravity,
            run.bodies[body].inverse_length,
        )  # fmt: skip

    @part
    def write_pivot_motion(run: Run, t: float, point: Point) -> None:
        """Write the pivot's acceleration into a point."""
        point.pivot_acceleration = pivot_motion(run, t)

    @part
    def static_tension(run: Run, body: int, t: float, angle: float) -> float:
        """Tension over mass of a ball that does not move [m/s^2]."""
        along: float = run.settings.gravity + pivot_motion(run, t)
        return along * cosine(angle)

    return Forces(
        free=free,
        write_forces=write_forces,
        step=step,
        tangent=tangent,
        tension=tension,
        static_tension=static_tension,
        write_pivot_motion=write_pivot_motion,
    )


def make_planar(laws: Laws, part: Part = as_it_stands) -> Forces:
    """Make the functions for a pivot that moves in the plane.

    With the pivot's acceleration ``(ax, ay)`` and its velocity against the air ``(wx, wy)`` each
    kilogram is pulled by ``(-ax - c wx, -(g + ay) - c wy)``, c the rate of the linear drag. Its
    part across the string swings the ball, its part along it is the tension's.
    """
    assert laws.plane is not None
    pivot_acceleration = laws.pivot_acceleration
    across_acceleration, up_velocity, across_velocity = laws.plane
    push, push_slope = laws.push, laws.push_slope

    @part
    def pivot_motion(run: Run, t: float) -> tuple[float, float, float, float]:
        """Acceleration of the pivot and its velocity against the air, x and y each."""
        ax = across_acceleration(t, run.segment)
        ay = pivot_acceleration(t, run.segment)
        if run.settings.in_lab == 0:
            return ax, ay, 0.0, 0.0
        return ax, ay, across_velocity(t, run.segment), up_velocity(t, run.segment)

    @part
    def write_pivot_motion(run: Run, t: float, point: Point) -> None:
        """Write the pivot's acceleration and its velocity against the air into a point."""
        point.across, point.pivot_acceleration, point.wind_x, point.wind_y = pivot_motion(run, t)

    @part
    def angular_acceleration(b: Body, angle: float, x: float, y: float) -> float:
        """Angular acceleration by a force per mass (x, y) [rad/s^2]."""
        sideways = b.inverse_length * x * cosine(angle) if x != 0.0 else 0.0
        result: float = sideways + b.inverse_length * y * sine(angle)
        return result

    @part
    def tension(run: Run, body: int, point: Point) -> float:
        """Tension in flight over mass and length [1/s^2]."""
        b = run.bodies[body]
        x = -point.across - b.damping_rate * point.wind_x
        y = -(run.settings.gravity + point.pivot_acceleration) - b.damping_rate * point.wind_y
        along: float = x * sine(point.angle) - y * cosine(point.angle)
        return point.velocity * point.velocity + b.inverse_length * along

    @part
    def static_tension(run: Run, body: int, t: float, angle: float) -> float:
        """Tension over mass of a ball that does not move [m/s^2]."""
        b, (ax, ay, wx, wy) = run.bodies[body], pivot_motion(run, t)
        x, y = -ax - b.damping_rate * wx, -(run.settings.gravity + ay) - b.damping_rate * wy
        along: float = x * sine(angle) - y * cosine(angle)
        return along

    @part
    def wind_acceleration(b: Body, angle: float, wx: float, wy: float) -> float:
        """Angular acceleration by the air that the pivot moves through [rad/s^2]."""
        if wx == 0.0 and wy == 0.0:
            return 0.0
        turned = angle + b.wind_offset
        result: float = -b.wind_drag * (wx * cosine(turned) + wy * sine(turned))
        return result

    @part
    def free(run: Run, body: int, t: float, angle: float) -> float:
        """Angular acceleration without drag against the pivot [rad/s^2]."""
        b, (ax, ay, wx, wy) = run.bodies[body], pivot_motion(run, t)
        pulled = angular_acceleration(b, angle, -ax, -(run.settings.gravity + ay))
        return pulled + wind_acceleration(b, angle, wx, wy) + push(angle, run)

    @part
    def write_forces(run: Run, body: int, t: float, point: Point) -> None:
        """Write the accelerations by all forces but drag into a point, and the tension."""
        b = run.bodies[body]
        write_pivot_motion(run, t, point)
        ax, ay, wx, wy = point.across, point.pivot_acceleration, point.wind_x, point.wind_y
        point.acceleration = point.driven = 0.0
        if point.sign != 0.0:
            point.driven = angular_acceleration(b, point.angle, -ax, -ay)
            other = push(point.angle, run) - b.coulomb * point.sign
            other += angular_acceleration(b, point.angle, 0.0, -run.settings.gravity)
            other += wind_acceleration(b, point.angle, wx, wy)
            point.acceleration = point.driven + other
        point.tension = tension(run, body, point)

    @inlined(part)
    def step(run: Run, body: int, table: int, begin: Point, end: Point) -> None:
        """Take the step of a table that was prepared, with its work and loss.

        The wind's part of a kick counts as a loss by drag, which may be negative.
        """
        angle, velocity, sign = begin.angle, begin.velocity, begin.sign
        a, driven = begin.acceleration, begin.driven
        ax, ay, wx, wy = begin.across, begin.pivot_acceleration, begin.wind_x, begin.wind_y
        work, loss, t = 0.0, 0.0, run.t
        b, gravity = run.bodies[body], run.settings.gravity
        friction = b.coulomb * sign
        wind = wind_acceleration(b, angle, wx, wy)
        if sign == 0.0:
            end.angle, end.velocity, end.sign, end.work, end.loss = angle, 0.0, 0.0, 0.0, 0.0
            write_forces(run, body, t + run.tables[table, OFFSET, run.stages - 1], end)
            return
        for i in range(run.stages):
            h = run.tables[table, KICK, i]
            change = h * a
            middle = velocity + 0.5 * change
            work += h * driven * middle
            loss += h * (friction - wind) * middle
            velocity += change
            travelled, slower = drift(velocity, sign, run.tables[table, DRIFT_TIME, i], b)
            loss += 0.5 * (velocity - slower) * (velocity + slower)
            angle += travelled
            velocity = slower
            ax, ay, wx, wy = pivot_motion(run, t + run.tables[table, OFFSET, i])
            driven = angular_acceleration(b, angle, -ax, -ay)
            wind = wind_acceleration(b, angle, wx, wy)
            a = driven + (
                angular_acceleration(b, angle, 0.0, -gravity) + (wind + push(angle, run) - friction)
            )
        h = run.tables[table, KICK, run.stages]
        change = h * a
        middle = velocity + 0.5 * change
        work += h * driven * middle
        loss += h * (friction - wind) * middle
        velocity += change
        end.angle, end.velocity, end.sign = angle, velocity, sign
        end.acceleration, end.driven = a, driven
        end.across, end.pivot_acceleration, end.wind_x, end.wind_y = ax, ay, wx, wy
        end.work, end.loss = work, loss

    @part
    def tangent(run: Run, body: int, table: int, begin: Point) -> tuple[float, float, float, float]:
        """Tangent map of a prepared step, row by row."""
        sign = begin.sign
        if sign == 0.0:
            return 1.0, 0.0, 0.0, 0.0
        b, gravity, t = run.bodies[body], run.settings.gravity, run.t
        angle, velocity, a = begin.angle, begin.velocity, begin.acceleration
        ax, ay, wx, wy = begin.across, begin.pivot_acceleration, begin.wind_x, begin.wind_y
        x1, v1, x2, v2 = 1.0, 0.0, 0.0, 1.0  # what starts as a unit of angle, and of velocity
        for i in range(run.stages + 1):
            h = run.tables[table, KICK, i]
            # The slope is the pull at a right angle to what turns the ball.
            gradient = angular_acceleration(b, angle, -(gravity + ay), ax) + wind_acceleration(
                b, angle, wy, -wx
            )
            gradient = h * (gradient + push_slope(angle, run))
            velocity += h * a
            v1 += gradient * x1
            v2 += gradient * x2
            if i == run.stages:
                break
            drift_time = run.tables[table, DRIFT_TIME, i]
            far, kept = drift_slopes(velocity, sign, drift_time, b)
            x1 += far * v1
            x2 += far * v2
            v1 *= kept
            v2 *= kept
            travelled, velocity = drift(velocity, sign, drift_time, b)
            angle += travelled
            ax, ay, wx, wy = pivot_motion(run, t + run.tables[table, OFFSET, i])
            a = angular_acceleration(b, angle, -ax, -(gravity + ay)) + wind_acceleration(
                b, angle, wx, wy
            )
            a += push(angle, run) - b.coulomb * sign
        return x1, x2, v1, v2

    return Forces(
        free=free,
        write_forces=write_forces,
        step=step,
        tangent=tangent,
        tension=tension,
        static_tension=static_tension,
        write_pivot_motion=write_pivot_motion,
    )
