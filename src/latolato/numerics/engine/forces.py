"""Forces on a ball whose rod or string is taut, and its splitting step under them.

A pivot that only moves up and down leaves gravity's direction alone (`make_upright`). In the plane
it pulls sideways too, and air at rest in the room blows past the pivot (`make_planar`). Both say
only what pulls; the step is one (`make_forces`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.core.scalar import cosine, formula, sine
from latolato.numerics.engine.laws import Laws
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.records import Body, Floats
from latolato.numerics.run_record import (
    DRIFT_TIME,
    FAR,
    FASTER,
    GRADIENT,
    KEPT,
    KICK,
    LATER,
    OFFSET,
    TIME_SLOPE,
    VELOCITY,
    WEIGHTS,
    Point,
    Run,
)
from latolato.physics.damping import (
    drift,
    drift_quadratic_weights,
    drift_rate_weights,
    drift_slopes,
)
from latolato.physics.pendulum import swung

# The pivot's acceleration [m/s^2] and its velocity against the air [m/s], x and y each.
Motion = tuple[float, float, float, float]
# Derivatives of an angular acceleration in the plane.
PlaneWeights = tuple[float, float, float, float, float, float, float]


class Pull(NamedTuple):
    """What pulls at a ball; `moving` is a `Motion` of the pivot.

    Attributes
    ----------
    motion : function ``(run, t)``
        The pivot's `Motion`.
    accelerations : function ``(run, b, angle, moving)``
        The angular accelerations by the drive, by gravity and by the wind [rad/s^2].
    gradient : function ``(run, b, angle, moving)``
        The derivative of their sum with respect to the angle [1/s^2].
    tension : function ``(run, b, angle, velocity, moving)``
        The tension over mass and length [1/s^2].
    moved : function ``(run, t, p)``
        The derivative of the pivot's `Motion` with respect to parameter p.
    weights : function ``(run, b, angle, moving)``
        The derivatives of the sum of `accelerations`, at a fixed angle, by the numbers in it.
    no_weights : tuple
        Weights of zero.
    write_weights : function ``(path, weights)``
        Write weights into the record of a kick, ``run.path``.
    read_weights : function ``(path)``
        The weights that were written there.
    add_weights : function ``(totals, weights, share)``
        Totals of weights with a share of further ones.
    driven_change : function ``(weights, moved)``
        By how much the pivot's changed motion changes that sum.
    steady_change : function ``(run, weights, body, p)``
        By how much parameter p changes it otherwise, for the body of this number.
    """

    motion: Callable[..., Motion]
    accelerations: Callable[..., tuple[float, float, float]]
    gradient: Callable[..., float]
    tension: Callable[..., float]
    moved: Callable[..., Motion]
    weights: Callable[..., Any]
    no_weights: tuple[float, ...]
    write_weights: Callable[..., None]
    read_weights: Callable[..., Any]
    add_weights: Callable[..., Any]
    driven_change: Callable[..., float]
    steady_change: Callable[..., float]


class Forces(NamedTuple):
    """The functions that depend on the forces; each begins with ``(run, body, ...)``."""

    free: Callable[..., float]
    write_forces: Callable[..., None]
    step: Callable[..., None]
    tangent: Callable[..., Any]
    tension: Callable[..., float]
    static_tension: Callable[..., float]
    write_pivot_motion: Callable[..., None]
    pivot_change: Callable[..., Motion]
    pull_change: Callable[..., float]
    pull_gradient: Callable[..., float]
    tension_change: Callable[..., float]


@formula
def no_change(t: float, segment: Any, change: Any) -> float:
    """Return zero: where derivatives with respect to parameters are not asked for."""
    return 0.0


@formula
def tension_at(
    angle: float, velocity: float, pivot_acceleration: float, gravity: float, inverse_length: float
) -> float:
    """Tension in flight over mass and length [1/s^2]."""
    return velocity * velocity + (gravity + pivot_acceleration) * inverse_length * cosine(angle)


def make_upright(laws: Laws, part: Part = as_it_stands) -> Forces:
    """Make the functions for a pivot that moves up and down."""
    inline = inlined(part)
    pivot_acceleration, restoring, slope = laws.pivot_acceleration, laws.restoring, laws.slope
    (acceleration_change,) = laws.changes or (no_change,)

    @inline
    def motion(run: Run, t: float) -> Motion:
        return 0.0, pivot_acceleration(t, run.segment), 0.0, 0.0

    @inline
    def accelerations(
        run: Run, b: Body, angle: float, moving: Motion
    ) -> tuple[float, float, float]:
        restored = restoring(angle, run.settings.is_linear)
        driven = swung(moving[1], b.inverse_length, restored)
        return driven, swung(run.settings.gravity, b.inverse_length, restored), 0.0

    @inline
    def gradient(run: Run, b: Body, angle: float, moving: Motion) -> float:
        lifted = run.settings.gravity + moving[1]
        return swung(lifted, b.inverse_length, slope(angle, run.settings.is_linear))

    @inline
    def tension(run: Run, b: Body, angle: float, velocity: float, moving: Motion) -> float:
        return tension_at(angle, velocity, moving[1], run.settings.gravity, b.inverse_length)

    @inline
    def moved(run: Run, t: float, p: int) -> Motion:
        return 0.0, acceleration_change(t, run.segment, run.segment_changes[p]), 0.0, 0.0

    @inline
    def weights(run: Run, b: Body, angle: float, moving: Motion) -> tuple[float, float]:
        """By gravity and by the inverse length."""
        restored = restoring(angle, run.settings.is_linear)
        lifted = run.settings.gravity + moving[1]
        return swung(1.0, b.inverse_length, restored), swung(lifted, 1.0, restored)

    @inline
    def write_weights(path: Floats, weights: tuple[float, float]) -> None:
        path[WEIGHTS], path[WEIGHTS + 1] = weights

    @inline
    def read_weights(path: Floats) -> tuple[float, float]:
        return path[WEIGHTS], path[WEIGHTS + 1]

    @inline
    def add_weights(
        totals: tuple[float, float], weights: tuple[float, float], share: float
    ) -> tuple[float, float]:
        return totals[0] + share * weights[0], totals[1] + share * weights[1]

    @inline
    def driven_change(weights: tuple[float, float], moved: Motion) -> float:
        return weights[0] * moved[1]

    @inline
    def steady_change(run: Run, weights: tuple[float, float], body: int, p: int) -> float:
        changed = run.changes[p]
        shorter: float = changed.bodies[body].inverse_length
        return weights[0] * changed.gravity + weights[1] * shorter

    pull = Pull(
        motion, accelerations, gradient, tension, moved, weights, (0.0,) * 2, write_weights,
        read_weights, add_weights, driven_change, steady_change,
    )  # fmt: skip
    return make_forces(pull, laws, part)


def make_planar(laws: Laws, part: Part = as_it_stands) -> Forces:
    """Make the functions for a pivot that moves in the plane.

    With the pivot's acceleration ``(ax, ay)`` and its velocity against the air ``(wx, wy)`` each
    kilogram is pulled by ``(-ax - c wx, -(g + ay) - c wy)``, c the rate of the linear drag. Its
    part across the string swings the ball, its part along it is the tension's.
    """
    assert laws.plane is not None
    inline, pivot_acceleration = inlined(part), laws.pivot_acceleration
    across_acceleration, up_velocity, across_velocity = laws.plane
    up_change, across_change, up_velocity_change, across_velocity_change = (
        laws.changes or (no_change,) * 4
    )

    @part
    def motion(run: Run, t: float) -> Motion:
        ax = across_acceleration(t, run.segment)
        ay = pivot_acceleration(t, run.segment)
        if run.settings.in_lab == 0:
            return ax, ay, 0.0, 0.0
        return ax, ay, across_velocity(t, run.segment), up_velocity(t, run.segment)

    @part
    def angular_acceleration(b: Body, angle: float, x: float, y: float) -> float:
        """Angular acceleration by a force per mass (x, y) [rad/s^2]."""
        sideways = b.inverse_length * x * cosine(angle) if x != 0.0 else 0.0
        result: float = sideways + b.inverse_length * y * sine(angle)
        return result

    @part
    def wind_acceleration(b: Body, angle: float, wx: float, wy: float) -> float:
        """Angular acceleration by the air that the pivot moves through [rad/s^2]."""
        if wx == 0.0 and wy == 0.0:
            return 0.0
        turned = angle + b.wind_offset
        result: float = -b.wind_drag * (wx * cosine(turned) + wy * sine(turned))
        return result

    @inline
    def accelerations(
        run: Run, b: Body, angle: float, moving: Motion
    ) -> tuple[float, float, float]:
        ax, ay, wx, wy = moving
        driven = angular_acceleration(b, angle, -ax, -ay)
        falling = angular_acceleration(b, angle, 0.0, -run.settings.gravity)
        return driven, falling, wind_acceleration(b, angle, wx, wy)

    @part
    def gradient(run: Run, b: Body, angle: float, moving: Motion) -> float:
        """The pull at a right angle to what turns the ball."""
        ax, ay, wx, wy = moving
        pulled: float = angular_acceleration(b, angle, -(run.settings.gravity + ay), ax)
        return pulled + wind_acceleration(b, angle, wy, -wx)

    @part
    def tension(run: Run, b: Body, angle: float, velocity: float, moving: Motion) -> float:
        ax, ay, wx, wy = moving
        x = -ax - b.damping_rate * wx
        y = -(run.settings.gravity + ay) - b.damping_rate * wy
        along: float = x * sine(angle) - y * cosine(angle)
        return velocity * velocity + b.inverse_length * along

    @part
    def moved(run: Run, t: float, p: int) -> Motion:
        segment, changed = run.segment, run.segment_changes[p]
        ax, ay = across_change(t, segment, changed), up_change(t, segment, changed)
        if run.settings.in_lab == 0:
            return ax, ay, 0.0, 0.0
        wx = across_velocity_change(t, segment, changed)
        return ax, ay, wx, up_velocity_change(t, segment, changed)

    @part
    def weights(run: Run, b: Body, angle: float, moving: Motion) -> PlaneWeights:
        """By the pivot's acceleration, the inverse length, the wind, its drag and its offset."""
        ax, ay, wx, wy = moving
        c, s = cosine(angle), sine(angle)
        along = -ax * c - (run.settings.gravity + ay) * s
        if run.settings.in_lab == 0:
            return -b.inverse_length * c, -b.inverse_length * s, along, 0.0, 0.0, 0.0, 0.0
        turned = angle + b.wind_offset
        c_wind, s_wind = cosine(turned), sine(turned)
        blown, crossing = -(wx * c_wind + wy * s_wind), -b.wind_drag * (wy * c_wind - wx * s_wind)
        return (
            -b.inverse_length * c, -b.inverse_length * s, along, -b.wind_drag * c_wind,
            -b.wind_drag * s_wind, blown, crossing,
        )  # fmt: skip

    @inline
    def write_weights(path: Floats, weights: PlaneWeights) -> None:
        path[WEIGHTS], path[WEIGHTS + 1], path[WEIGHTS + 2] = weights[0], weights[1], weights[2]
        path[WEIGHTS + 3], path[WEIGHTS + 4] = weights[3], weights[4]
        path[WEIGHTS + 5], path[WEIGHTS + 6] = weights[5], weights[6]

    @inline
    def read_weights(path: Floats) -> PlaneWeights:
        return (
            path[WEIGHTS], path[WEIGHTS + 1], path[WEIGHTS + 2], path[WEIGHTS + 3],
            path[WEIGHTS + 4], path[WEIGHTS + 5], path[WEIGHTS + 6],
        )  # fmt: skip

    @inline
    def add_weights(totals: PlaneWeights, weights: PlaneWeights, share: float) -> PlaneWeights:
        return (
            totals[0] + share * weights[0], totals[1] + share * weights[1],
            totals[2] + share * weights[2], totals[3] + share * weights[3],
            totals[4] + share * weights[4], totals[5] + share * weights[5],
            totals[6] + share * weights[6],
        )  # fmt: skip

    @inline
    def driven_change(weights: PlaneWeights, moved: Motion) -> float:
        pulled = weights[0] * moved[0] + weights[1] * moved[1]
        return pulled + weights[3] * moved[2] + weights[4] * moved[3]

    @inline
    def steady_change(run: Run, weights: PlaneWeights, body: int, p: int) -> float:
        other = run.changes[p].bodies[body]
        result: float = weights[1] * run.changes[p].gravity + weights[2] * other.inverse_length
        return result + weights[5] * other.wind_drag + weights[6] * other.wind_offset

    pull = Pull(
        motion, accelerations, gradient, tension, moved, weights, (0.0,) * 7, write_weights,
        read_weights, add_weights, driven_change, steady_change,
    )  # fmt: skip
    return make_forces(pull, laws, part)


def make_forces(pull: Pull, laws: Laws, part: Part) -> Forces:
    """Make the functions of a ball under a pull."""
    accelerations, gradient, pull_tension = pull.accelerations, pull.gradient, pull.tension
    motion, push, push_slope = pull.motion, laws.push, laws.push_slope
    moved, weights, add_weights = pull.moved, pull.weights, pull.add_weights
    write_weights, read_weights = pull.write_weights, pull.read_weights
    no_weights = pull.no_weights
    driven_change, steady_change = pull.driven_change, pull.steady_change
    sensitive = len(laws.changes) > 0
    follows_always = laws.plane is not None  # strings need it

    @part
    def pivot_motion(run: Run, t: float) -> Motion:
        """The pivot's motion: one copy of its forms, for all but steps."""
        moving: Motion = motion(run, t)
        return moving

    @part
    def write_pivot_motion(run: Run, t: float, point: Point) -> None:
        """Write the pivot's acceleration and its velocity against the air into a point."""
        point.across, point.pivot_acceleration, point.wind_x, point.wind_y = pivot_motion(run, t)

    @inlined(part)
    def motion_of(point: Point) -> Motion:
        """The pivot's motion that was written into a point."""
        return point.across, point.pivot_acceleration, point.wind_x, point.wind_y

    @part
    def tension(run: Run, body: int, point: Point) -> float:
        """Tension in flight over mass and length [1/s^2]."""
        b = run.bodies[body]
        result: float = pull_tension(run, b, point.angle, point.velocity, motion_of(point))
        return result

    @part
    def static_tension(run: Run, body: int, t: float, angle: float) -> float:
        """Tension over mass of a ball that does not move [m/s^2]."""
        b = run.bodies[body]
        result: float = pull_tension(run, b, angle, 0.0, pivot_motion(run, t)) / b.inverse_length
        return result

    @part
    def free(run: Run, body: int, t: float, angle: float) -> float:
        """Angular acceleration without drag against the pivot [rad/s^2]."""
        driven, falling, blown = accelerations(run, run.bodies[body], angle, pivot_motion(run, t))
        return driven + falling + blown + push(angle, run)

    @part
    def write_forces(run: Run, body: int, t: float, point: Point) -> None:
        """Write the accelerations by all forces but drag into a point, and the tension."""
        b = run.bodies[body]
        write_pivot_motion(run, t, point)
        point.acceleration = point.driven = 0.0
        if point.sign != 0.0:
            driven, falling, blown = accelerations(run, b, point.angle, motion_of(point))
            other = blown + push(point.angle, run) - b.coulomb * point.sign
            point.driven, point.acceleration = driven, driven + falling + other
        if follows_always or run.settings.follows_tension != 0:
            point.tension = tension(run, body, point)

    @inlined(part)
    def record_kick(
        run: Run, b: Body, table: int, i: int, angle: float, velocity: float, moving: Motion
    ) -> None:
        """Record the derivatives of a kick at this angle, and the velocity after it.

        A step waits for one angle after the other; meanwhile this costs it little.
        """
        path = run.path[table, i]
        path[VELOCITY] = velocity
        path[GRADIENT] = gradient(run, b, angle, moving) + push_slope(angle, run)
        write_weights(path, weights(run, b, angle, moving))

    @inlined(part)
    def record_drift(run: Run, b: Body, table: int, i: int, velocity: float, sign: float) -> None:
        """Record the derivatives of the drift that follows a kick."""
        path, drift_time = run.path[table, i], run.tables[table, DRIFT_TIME, i]
        path[FAR], path[KEPT] = drift_slopes(velocity, sign, drift_time, b)

    @inlined(part)
    def step(run: Run, body: int, table: int, begin: Point, end: Point) -> None:
        """Take the step of a table that was prepared.

        Kicks by all that depends on angle and time alternate with drifts under the drag against
        the pivot, both exact. In a kick ``dW = driven h (w + w')/2`` is the exact work of the
        drive's part, and that of dry friction and of the wind counts as a loss by drag, which may
        be negative; in a drift the loss is the drop of w^2/2.
        """
        angle, velocity, sign = begin.angle, begin.velocity, begin.sign
        a, driven, moving = begin.acceleration, begin.driven, motion_of(begin)
        work, loss, t, b = 0.0, 0.0, run.t, run.bodies[body]
        friction = b.coulomb * sign
        if sign == 0.0:
            end.angle, end.velocity, end.sign, end.work, end.loss = angle, 0.0, 0.0, 0.0, 0.0
            write_forces(run, body, t + run.tables[table, OFFSET, run.stages - 1], end)
            return
        _, _, blown = accelerations(run, b, angle, moving)
        for i in range(run.stages):
            h = run.tables[table, KICK, i]
            change = h * a
            middle = velocity + 0.5 * change
            work += h * driven * middle
            loss += h * (friction - blown) * middle
            velocity += change
            if sensitive:
                record_kick(run, b, table, i, angle, velocity, moving)
                record_drift(run, b, table, i, velocity, sign)
            travelled, slower = drift(velocity, sign, run.tables[table, DRIFT_TIME, i], b)
            loss += 0.5 * (velocity - slower) * (velocity + slower)
            angle += travelled
            velocity = slower
            moving = motion(run, t + run.tables[table, OFFSET, i])
            driven, falling, blown = accelerations(run, b, angle, moving)
            a = driven + falling + (blown + push(angle, run) - friction)
        h = run.tables[table, KICK, run.stages]
        change = h * a
        middle = velocity + 0.5 * change
        work += h * driven * middle
        loss += h * (friction - blown) * middle
        velocity += change
        if sensitive:
            record_kick(run, b, table, run.stages, angle, velocity, moving)
        end.angle, end.velocity, end.sign = angle, velocity, sign
        end.acceleration, end.driven = a, driven
        end.across, end.pivot_acceleration, end.wind_x, end.wind_y = moving
        end.work, end.loss = work, loss

    @part
    def pivot_change(run: Run, t: float, p: int) -> Motion:
        """The derivative of the pivot's motion with respect to parameter p."""
        if run.changes[p].moves_pivot == 0:
            return 0.0, 0.0, 0.0, 0.0
        result: Motion = moved(run, t, p)
        return result

    @part
    def pull_change(run: Run, body: int, t: float, angle: float, p: int) -> float:
        """Derivative of `free` with respect to parameter p, at a fixed angle."""
        by = weights(run, run.bodies[body], angle, pivot_motion(run, t))
        result: float = driven_change(by, pivot_change(run, t, p))
        return result + steady_change(run, by, body, p)

    @part
    def pull_gradient(run: Run, body: int, t: float, angle: float) -> float:
        """Derivative of `free` with respect to the angle [1/s^2]."""
        result: float = gradient(run, run.bodies[body], angle, pivot_motion(run, t))
        return result

    @part
    def tension_change(
        run: Run, body: int, point: Point, p: int, rates: tuple[float, float]
    ) -> float:
        """Derivative of `tension` with respect to parameter p, along rates of the point.

        These are those of angle and angular velocity. With a force per mass (x, y) the tension
        over mass and length is ``w^2 + (x sin - y cos)/l``.
        """
        b, other, (turned, faster) = run.bodies[body], run.changes[p].bodies[body], rates
        (ax, ay, wx, wy), rate = motion_of(point), b.damping_rate
        dax, day, dwx, dwy = pivot_change(run, run.t, p)
        s, c = sine(point.angle), cosine(point.angle)
        x, y = -ax - rate * wx, -(run.settings.gravity + ay) - rate * wy
        dx = -dax - rate * dwx - other.damping_rate * wx
        dy = -run.changes[p].gravity - day - rate * dwy - other.damping_rate * wy
        pulled = (x * c + y * s) * turned + dx * s - dy * c
        shorter: float = other.inverse_length * (x * s - y * c)
        return 2.0 * point.velocity * faster + b.inverse_length * pulled + shorter

    @part
    def changes_drag(run: Run, body: int) -> tuple[bool, bool]:
        """Whether a parameter changes the linear drag against the pivot, and the quadratic one."""
        linear = quadratic = False
        for p in range(run.parameters):
            other = run.changes[p].bodies[body]
            linear = linear or other.damping_rate != 0.0
            quadratic = quadratic or other.quadratic != 0.0
        return linear, quadratic

    @part
    def changes_drive(run: Run) -> bool:
        """Whether a parameter changes the pivot's motion."""
        seen = False
        for p in range(run.parameters):
            seen = seen or run.changes[p].moves_pivot != 0
        return seen

    @inlined(part)
    def add_drive_forcing(run: Run, row: int, table: int) -> None:
        """Add to the forcing what the pivot's changed motion does in the kicks of a step."""
        for p in range(run.parameters):
            if run.changes[p].moves_pivot == 0:
                continue
            later, faster, t = 0.0, 0.0, run.t
            for i in range(run.stages + 1):
                path = run.path[table, i]
                pulled = driven_change(read_weights(path), moved(run, t, p))
                later += path[LATER] * pulled
                faster += path[FASTER] * pulled
                t = run.t + run.tables[table, OFFSET, i]
            run.forcing[row, p] += later
            run.forcing[row + 1, p] += faster

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
        b, moving = run.bodies[body], motion_of(begin)
        angle, velocity, a = begin.angle, begin.velocity, begin.acceleration
        # The columns of the matrix: what starts as a unit of angle, and of velocity.
        x1, v1, x2, v2 = 1.0, 0.0, 0.0, 1.0
        for i in range(run.stages + 1):
            h = run.tables[table, KICK, i]
            kicked = h * (gradient(run, b, angle, moving) + push_slope(angle, run))
            velocity += h * a
            v1 += kicked * x1
            v2 += kicked * x2
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
            moving = motion(run, run.t + run.tables[table, OFFSET, i])
            driven, falling, blown = accelerations(run, b, angle, moving)
            a = driven + falling + (blown + push(angle, run) - b.coulomb * sign)
        return x1, x2, v1, v2

    @part
    def recorded_tangent(
        run: Run, body: int, table: int, begin: Point
    ) -> tuple[float, float, float, float]:
        """Tangent map as above along the recorded step, and the forcing of parameters with it.

        The step is followed backwards. The map from a kick or a drift to the end of the step tells
        what a change there does: those of gravity, length and drag add up for all parameters
        together, and only the pivot's changed motion is one for each of them. The forcing goes on
        in ``run.forcing`` from where it begins, in the rows of the ball or, of two balls as one
        body, in the first two.
        """
        sign = begin.sign
        if sign == 0.0:
            return 1.0, 0.0, 0.0, 0.0
        b, drives, (brakes, draws) = run.bodies[body], changes_drive(run), changes_drag(run, body)
        row = 2 * body if body < 2 else 0
        for p in range(run.parameters):
            for k in range(2):
                run.begun[k, p], run.forcing[row + k, p] = run.forcing[row + k, p], 0.0
        m11, m12, m21, m22 = 1.0, 0.0, 0.0, 1.0
        later = faster = no_weights
        pushed_1 = pushed_2 = braked_1 = braked_2 = drawn_1 = drawn_2 = 0.0
        for i in range(run.stages, -1, -1):
            path = run.path[table, i]
            if i < run.stages:
                far, kept = path[FAR], path[KEPT]
                velocity, time = path[VELOCITY], run.tables[table, DRIFT_TIME, i]
                if brakes:
                    way, slower = drift_rate_weights(velocity, sign, time, path[TIME_SLOPE], b)
                    braked_1 += m11 * way + m12 * slower
                    braked_2 += m21 * way + m22 * slower
                if draws:
                    way, slower = drift_quadratic_weights(velocity, sign, time, b)
                    drawn_1 += m11 * way + m12 * slower
                    drawn_2 += m21 * way + m22 * slower
                m12, m22 = m11 * far + m12 * kept, m21 * far + m22 * kept
            h = run.tables[table, KICK, i]
            by = read_weights(path)
            later, faster = add_weights(later, by, h * m12), add_weights(faster, by, h * m22)
            pushed_1 += h * m12
            pushed_2 += h * m22
            if drives:
                path[LATER], path[FASTER] = h * m12, h * m22
            kicked = h * path[GRADIENT]
            m11 += m12 * kicked
            m21 += m22 * kicked
        for p in range(run.parameters):
            other, x, v = run.changes[p].bodies[body], run.begun[0, p], run.begun[1, p]
            run.forcing[row, p] += m11 * x + m12 * v + steady_change(run, later, body, p)
            run.forcing[row, p] += braked_1 * other.damping_rate + drawn_1 * other.quadratic
            run.forcing[row, p] -= sign * pushed_1 * other.coulomb
            run.forcing[row + 1, p] += m21 * x + m22 * v + steady_change(run, faster, body, p)
            run.forcing[row + 1, p] += braked_2 * other.damping_rate + drawn_2 * other.quadratic
            run.forcing[row + 1, p] -= sign * pushed_2 * other.coulomb
        if drives:
            add_drive_forcing(run, row, table)
        return m11, m12, m21, m22

    return Forces(
        free=free,
        write_forces=write_forces,
        step=step,
        tangent=recorded_tangent if sensitive else tangent,
        tension=tension,
        static_tension=static_tension,
        write_pivot_motion=write_pivot_motion,
        pivot_change=pivot_change,
        pull_change=pull_change,
        pull_gradient=pull_gradient,
        tension_change=tension_change,
    )
