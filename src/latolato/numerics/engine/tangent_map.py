"""The tangent map of a motion through slack: how it changes perturbations of its start.

With all strings taut a perturbation has an angle and an angular velocity per ball. A slack string
gives its ball two more degrees of freedom. From the instant at which the first string goes slack
each unit perturbation of the taut state is therefore followed as one of position and velocity in
the plane, a column of ``z``: rows 4 i to 4 i + 3 hold x, y, vx and vy of ball i, measured from the
pivot in its frame. Once all strings are taut again the columns are written as angles and angular
velocities; the matrix from the former to the latter is the tangent map of the whole interval, which
is reported to the observables.

An event whose guard the perturbation reaches dt later changes it by the saltation
``z+ = D z- + (D f- - f+) dt``. f are the velocities and accelerations before and after the event,
and D is the derivative of the reset at the event itself (Aizerman & Gantmacher 1958). In code:
`reach_contact` or `reach_full_length` finds dt and shifts z to the event by ``f- dt``, `tighten` or
`collide` multiplies by D, and `leave_event` shifts back by ``f+ dt``. Several resets may follow
each other at one instant, all between the same two shifts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.core.scalar import cosine, formula, sine
from latolato.numerics.callbacks import Accumulators
from latolato.numerics.engine.gaps import THERE, Gaps
from latolato.numerics.engine.report import Report
from latolato.numerics.engine.slack_step import SlackStep, place_taut
from latolato.numerics.engine.taut_step import ANY_LENGTH, TautStep
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import DELAY_ROWS, DRIFT_TIME, KICK, Point, Run
from latolato.physics.damping import drift_slopes_in_plane


class TangentMap(NamedTuple):
    """The functions of the tangent map; see `make_tangent_map`. No-ops where nothing wants it."""

    begin: Callable[..., None]
    step: Callable[..., None]
    reach_contact: Callable[..., None]
    reach_full_length: Callable[..., None]
    tighten: Callable[..., None]
    collide: Callable[..., None]
    leave_event: Callable[..., None]
    kick: Callable[..., None]
    mark_undefined: Callable[..., None]
    finish: Callable[..., None]


@formula
def _write_column(run: Run, i: int, column: int, x: float, y: float, vx: float, vy: float) -> None:
    """Write the perturbation of one ball into a column [m, m/s]."""
    z, row = run.state.tangent_map, 4 * i
    z[row, column], z[row + 1, column] = x, y
    z[row + 2, column], z[row + 3, column] = vx, vy


@formula
def _write_taut(run: Run, i: int, column: int, point: Point, angle: float, velocity: float) -> None:
    """Write a perturbation of angle and angular velocity on a taut string as one in the plane.

    The derivative of ``l (sin, -cos)`` and of its rate ``l w (cos, sin)``: a turn by the angle also
    turns the velocity, towards the pivot.
    """
    length, s, c = 1.0 / run.bodies[i].inverse_length, sine(point.angle), cosine(point.angle)
    around, inward = length * velocity, length * point.velocity * angle
    far = length * angle
    _write_column(
        run, i, column, far * c, far * s, around * c - inward * s, around * s + inward * c
    )


@formula
def _taut_perturbation(run: Run, i: int, column: int, point: Point) -> tuple[float, float]:
    """Perturbation of angle [rad] and angular velocity [rad/s] on a taut string, from a column."""
    z, row = run.state.tangent_map, 4 * i
    inverse_length, s, c = run.bodies[i].inverse_length, sine(point.angle), cosine(point.angle)
    angle = inverse_length * (c * z[row, column] + s * z[row + 1, column])
    velocity = inverse_length * (c * z[row + 2, column] + s * z[row + 3, column])
    return angle, velocity


def make_tangent_map(
    swing: TautStep,
    fall: SlackStep,
    gaps: Gaps,
    report: Report,
    count: int,
    part: Part = as_it_stands,
) -> TangentMap:
    """Make the functions of the tangent map of `count` balls."""
    two, size, acceleration = count == 2, 2 * count, fall.acceleration

    @part
    def gap_perturbation(run: Run, column: int) -> float:
        """Perturbation of the gap between the balls [m]."""
        z, (nx, ny, _) = run.state.tangent_map, gaps.line_of_centres(run.now)
        result: float = nx * z[0, column] + ny * z[1, column]
        if two:
            result -= nx * z[4, column] + ny * z[5, column]
        return result

    @part
    def begin(run: Run) -> None:
        """Begin with a unit perturbation of each angle and angular velocity, all strings taut.

        A string that an impact would make push goes slack at that impact. Its ball then falls from
        the impact on, which the perturbation delays, and not from this instant on.
        """
        state = run.state
        is_slack = state.is_slack[0] != 0 or state.is_slack[count - 1] != 0
        if is_slack or state.has_tangent_map != 0 or not report.wants_tangent_map(run):
            return
        state.has_tangent_map, state.tangent_map_start = 1, run.t
        for column in range(size):
            for i in range(count):
                angle = 1.0 if column == 2 * i else 0.0
                velocity = 1.0 if column == 2 * i + 1 else 0.0
                _write_taut(run, i, column, run.now[i], angle, velocity)
                state.tangent_map[DELAY_ROWS + i, column] = 0.0
        for i in range(count):
            place_taut(run.now[i], 1.0 / run.bodies[i].inverse_length)
        _, rate = gaps.gap(run, run.now)
        if state.touch == 0.0 or rate <= 0.0:
            return
        # Between the impact of the perturbed motion and this one the string does not push: what it
        # would have pushed, ``l w^2 - ...`` < 0 per mass, is missing for the time of the delay.
        for column in range(size):
            delay = -gap_perturbation(run, column) / rate
            for i in range(count):
                point, length = run.now[i], 1.0 / run.bodies[i].inverse_length
                pushed = length * min(swing.tension(run, i, point), 0.0) * delay
                state.tangent_map[4 * i + 2, column] -= pushed * sine(point.angle)
                state.tangent_map[4 * i + 3, column] += pushed * cosine(point.angle)

    @part
    def follow_fall(run: Run, i: int) -> None:
        """Follow the perturbation of a falling ball through a step.

        Gravity and pivot pull alike everywhere in the plane, so a kick leaves a perturbation as it
        is. A drift multiplies the velocity by a factor that depends on the speed: along the
        velocity the perturbation sees the derivative of `drift`, beside it only the factor.
        """
        z, row, b, table = run.state.tangent_map, 4 * i, run.bodies[i], ANY_LENGTH + i
        vx, vy, gravity = run.now[i].vx, run.now[i].vy, run.settings.gravity
        ax, ay = run.now[i].across, run.now[i].pivot_acceleration
        wx, wy = run.now[i].wind_x, run.now[i].wind_y
        for k in range(run.stages):
            h, drift_time = run.tables[table, KICK, k], run.tables[table, DRIFT_TIME, k]
            vx -= h * (ax + b.damping_rate * wx)
            vy -= h * (gravity + ay + b.damping_rate * wy)
            speed = math.hypot(vx, vy)
            far, kept, far_beside, kept_beside = drift_slopes_in_plane(speed, drift_time, b)
            ux, uy = (vx / speed, vy / speed) if speed > 0.0 else (0.0, 0.0)
            for column in range(size):
                x, y = z[row + 2, column], z[row + 3, column]
                along = ux * x + uy * y
                farther, faster = (far - far_beside) * along, (kept - kept_beside) * along
                z[row, column] += far_beside * x + farther * ux
                z[row + 1, column] += far_beside * y + farther * uy
                z[row + 2, column] = kept_beside * x + faster * ux
                z[row + 3, column] = kept_beside * y + faster * uy
            vx *= kept_beside
            vy *= kept_beside
            swing.write_pivot_motion(run, run.t + run.nodes[k] * run.length, run.inside[i])
            ax, ay = run.inside[i].across, run.inside[i].pivot_acceleration
            wx, wy = run.inside[i].wind_x, run.inside[i].wind_y

    @part
    def step(run: Run) -> None:
        """Follow the perturbations through the planned step: fall or taut swing."""
        if run.state.has_tangent_map == 0:
            return
        for i in range(count):
            swing.prepare(run, i, ANY_LENGTH + i, run.length)
            if run.state.is_slack[i] != 0:
                follow_fall(run, i)
                continue
            m11, m12, m21, m22 = swing.tangent(run, i, ANY_LENGTH + i, run.now[i])
            for column in range(size):
                angle, velocity = _taut_perturbation(run, i, column, run.now[i])
                later, faster = m11 * angle + m12 * velocity, m21 * angle + m22 * velocity
                _write_taut(run, i, column, run.end[i], later, faster)

    @part
    def move(run: Run, sign: float) -> None:
        """Shift all perturbations to the event (sign 1), or back from it (-1), by their delays."""
        z = run.state.tangent_map
        for i in range(count):
            row, point, (ax, ay) = 4 * i, run.now[i], acceleration(run, i, run.now[i])
            for column in range(size):
                delay = sign * z[DELAY_ROWS + i, column]
                z[row, column] += point.vx * delay
                z[row + 1, column] += point.vy * delay
                z[row + 2, column] += ax * delay
                z[row + 3, column] += ay * delay

    @part
    def reach_contact(run: Run) -> None:
        """Find by how much each perturbation delays the balls' contact, and shift it there."""
        begin(run)
        _, rate = gaps.gap(run, run.now)
        if run.state.has_tangent_map == 0 or rate >= 0.0:
            return
        for column in range(size):
            delay = -gap_perturbation(run, column) / rate
            for i in range(count):
                run.state.tangent_map[DELAY_ROWS + i, column] = delay
        move(run, 1.0)

    @part
    def reach_full_length(run: Run) -> None:
        """Find the delays of strings that drift_time their full length, and shift there."""
        if run.state.has_tangent_map == 0:
            return
        z = run.state.tangent_map
        for i in range(count):
            row, point, b = 4 * i, run.now[i], run.bodies[i]
            spare_length, rate = gaps.spare_length(run, i, point)
            if (
                run.state.is_slack[i] != 0
                and spare_length * b.inverse_length <= THERE
                and rate < 0.0
            ):
                for column in range(size):
                    longer = point.x * z[row, column] + point.y * z[row + 1, column]
                    z[DELAY_ROWS + i, column] = longer * b.inverse_length / rate
        move(run, 1.0)

    @part
    def leave_event(run: Run) -> None:
        """Shift back from the event, with the velocities and accelerations after it."""
        if run.state.has_tangent_map == 0:
            return
        move(run, -1.0)
        for column in range(size):
            for i in range(count):
                run.state.tangent_map[DELAY_ROWS + i, column] = 0.0

    @part
    def tighten(run: Run, i: int, restitution: float) -> None:
        """Multiply by the derivative of a string's tightening, ``v+ = v - (1 + e_s) (r v) r``.

        r is the unit vector from the pivot to the ball; its perturbation is the ball's across r,
        over the length.
        """
        if run.state.has_tangent_map == 0:
            return
        z, row, point, k = run.state.tangent_map, 4 * i, run.now[i], run.bodies[i].inverse_length
        rx, ry, back = k * point.x, k * point.y, 1.0 + restitution
        outward = rx * point.vx + ry * point.vy
        for column in range(size):
            x, y = k * z[row, column], k * z[row + 1, column]
            along = rx * x + ry * y
            x, y = x - along * rx, y - along * ry
            faster = rx * z[row + 2, column] + ry * z[row + 3, column]
            faster += x * point.vx + y * point.vy
            z[row + 2, column] -= back * (faster * rx + outward * x)
            z[row + 3, column] -= back * (faster * ry + outward * y)

    @part
    def mobility_of(run: Run, i: int, nx: float, ny: float) -> float:
        """Velocity along the line of centres per impulse along it [1/kg]: less on a taut string."""
        b, point, across = run.bodies[i], run.now[i], 1.0
        if run.state.is_slack[i] == 0:
            across = nx * cosine(point.angle) + ny * sine(point.angle)
        result: float = across * across / (b.inertia * b.inverse_length * b.inverse_length)
        return result

    @part
    def tangential_part(
        run: Run, i: int, column: int, nx: float, ny: float, x: float, y: float
    ) -> tuple[float, float]:
        """Component of the line of centres around the pivot, and its perturbation."""
        angle, _ = _taut_perturbation(run, i, column, run.now[i])
        s, c = sine(run.now[i].angle), cosine(run.now[i].angle)
        return nx * c + ny * s, x * c + y * s + (ny * c - nx * s) * angle

    @part
    def collide(run: Run, restitution: float) -> None:
        """Multiply by the derivative of a collision.

        The impulse is ``(1 + e) c / m`` along the line of centres n, with the closing speed c and
        the sum m of both mobilities. A perturbation changes n (by the balls' places), c (by n and
        by the velocities) and m (by n and by the directions of taut strings); a ball on a taut
        string takes only the part of the impulse around the pivot. Velocities are those before the
        collision, and strings taut those that stay so.
        """
        if run.state.has_tangent_map == 0:
            return
        z, (nx, ny, distance) = run.state.tangent_map, gaps.line_of_centres(run.now)
        closing, mobility = -gaps.gap(run, run.now)[1], 0.0
        for i in range(count):
            mobility += mobility_of(run, i, nx, ny)
        back = 1.0 + restitution
        impulse = back * closing / mobility
        for column in range(size):
            # Perturbations of the line of centres, of the closing speed and of the mobility.
            x, y, slower, mobility_change = 0.0, 0.0, 0.0, 0.0
            if two:
                x = (z[0, column] - z[4, column]) / distance
                y = (z[1, column] - z[5, column]) / distance
                along = nx * x + ny * y
                x, y = x - along * nx, y - along * ny
            for i in range(count):
                row, sign, point, b = 4 * i, 1.0 - 2.0 * i, run.now[i], run.bodies[i]
                slower -= sign * (x * point.vx + y * point.vy)
                slower -= sign * (nx * z[row + 2, column] + ny * z[row + 3, column])
                if run.state.is_slack[i] == 0:
                    across, change = tangential_part(run, i, column, nx, ny, x, y)
                    mobility_change += (
                        2.0 * across * change / (b.inertia * b.inverse_length * b.inverse_length)
                    )
            pushed = back * (slower - closing * mobility_change / mobility) / mobility
            for i in range(count):
                b, row = run.bodies[i], 4 * i
                per_mass = (1.0 - 2.0 * i) / (b.inertia * b.inverse_length * b.inverse_length)
                px, py = pushed * nx + impulse * x, pushed * ny + impulse * y
                if run.state.is_slack[i] == 0:
                    across, change = tangential_part(run, i, column, nx, ny, x, y)
                    angle, _ = _taut_perturbation(run, i, column, run.now[i])
                    s, c = sine(run.now[i].angle), cosine(run.now[i].angle)
                    around = pushed * across + impulse * change
                    px = around * c - impulse * across * s * angle
                    py = around * s + impulse * across * c * angle
                z[row + 2, column] += per_mass * px
                z[row + 3, column] += per_mass * py

    @part
    def kick(run: Run, i: int, kicked: float) -> None:
        """Multiply by the derivative of a kick of a slack ball around the pivot [rad/s]."""
        z, row = run.state.tangent_map, 4 * i
        for column in range(size):
            z[row + 2, column] -= kicked * z[row + 1, column]
            z[row + 3, column] += kicked * z[row, column]

    @part
    def mark_undefined(run: Run) -> None:
        """Mark the tangent map as undefined (NaN): perturbations do not stay small here."""
        for column in range(size):
            run.state.tangent_map[0, column] = math.nan

    @part
    def finish(run: Run, accumulators: Accumulators) -> None:
        """Report the tangent map, now that all strings are taut.

        The logarithm of its determinant does not follow from the laws of motion alone: NaN.
        """
        if run.state.has_tangent_map == 0:
            return
        run.state.has_tangent_map = 0
        for column in range(size):
            for i in range(count):
                angle, velocity = _taut_perturbation(run, i, column, run.now[i])
                run.jacobian[2 * i, column], run.jacobian[2 * i + 1, column] = angle, velocity
        report.matrix(run, accumulators, size, run.t - run.state.tangent_map_start, math.nan)

    return TangentMap(
        begin=begin, step=step, reach_contact=reach_contact, reach_full_length=reach_full_length,
        tighten=tighten, collide=collide, leave_event=leave_event, kick=kick,
        mark_undefined=mark_undefined, finish=finish,
    )  # fmt: skip
