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
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.report import Report
from latolato.numerics.engine.slack_step import SlackStep, place_taut
from latolato.numerics.engine.taut_step import TautStep, acceleration_with_drag
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.run_record import (
    ANY_LENGTH,
    DELAY_ROWS,
    DRIFT_TIME,
    KICK,
    OFFSET,
    Point,
    Run,
)
from latolato.physics.damping import drift_changes_in_plane, drift_slopes_in_plane

# A string goes slack by itself where its tension is below this share of what speed and gravity
# make.
_CROSSES = 1e-7


class TangentMap(NamedTuple):
    """The functions of the tangent map; see `make_tangent_map`. No-ops where nothing wants it."""

    begin: Callable[..., None]
    step: Callable[..., None]
    write_tangent: Callable[..., None]
    reach_contact: Callable[..., None]
    reach_full_length: Callable[..., None]
    reach_slack: Callable[..., None]
    find_delays: Callable[..., None]
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
def _polar_perturbation(run: Run, i: int, column: int, point: Point) -> tuple[float, float]:
    """Perturbation of angle [rad] and angular velocity [rad/s] about the pivot, from a column.

    The derivatives of ``atan2(x, -y)`` and of ``(x vy - y vx)/r^2``.
    """
    z, row = run.state.tangent_map, 4 * i
    x, y, vx, vy = point.x, point.y, point.vx, point.vy
    dx, dy, dvx, dvy = z[row, column], z[row + 1, column], z[row + 2, column], z[row + 3, column]
    squared = max(x * x + y * y, 1e-300)
    turned = (dx * vy + x * dvy - dy * vx - y * dvx) / squared
    spin, farther = (x * vy - y * vx) / squared, 2.0 * (x * dx + y * dy) / squared
    return (x * dy - y * dx) / squared, turned - spin * farther


def make_tangent_map(
    swing: TautStep, fall: SlackStep, gaps: Gaps, report: Report, laws: Laws, count: int,
    part: Part = as_it_stands,
) -> TangentMap:  # fmt: skip
    """Make the functions of the tangent map of `count` balls.

    Where derivatives with respect to parameters are asked for, each parameter has a further column:
    what it does on its own since the first string went slack, with no perturbation before.
    """
    two, size, acceleration = count == 2, 2 * count, fall.acceleration
    sensitive = len(laws.changes) > 0

    @inlined(part)
    def columns_of(run: Run) -> int:
        """Number of columns."""
        return size + run.parameters if sensitive else size

    @inlined(part)
    def stretch_of(run: Run, i: int, column: int) -> float:
        """By how much a column's parameter lengthens a string [m]."""
        if not sensitive or column < size:
            return 0.0
        k = run.bodies[i].inverse_length
        longer: float = -run.changes[column - size].bodies[i].inverse_length / (k * k)
        return longer

    @part
    def write_taut(
        run: Run, i: int, column: int, point: Point, angle: float, velocity: float
    ) -> None:
        """Write a perturbation of angle and angular velocity on a taut string as one in the plane.

        The derivative of ``l (sin, -cos)`` and of its rate ``l w (cos, sin)``: a turn by the angle
        also turns the velocity, towards the pivot, and a longer string lengthens both.
        """
        length, s, c = 1.0 / run.bodies[i].inverse_length, sine(point.angle), cosine(point.angle)
        longer = stretch_of(run, i, column)
        around, inward = (
            length * velocity + longer * point.velocity,
            length * point.velocity * angle,
        )
        far = length * angle
        _write_column(
            run, i, column, far * c + longer * s, far * s - longer * c,
            around * c - inward * s, around * s + inward * c,
        )  # fmt: skip

    @part
    def taut_perturbation(run: Run, i: int, column: int, point: Point) -> tuple[float, float]:
        """Perturbation of angle [rad] and angular velocity [rad/s] on a taut string."""
        z, row = run.state.tangent_map, 4 * i
        inverse_length, s, c = run.bodies[i].inverse_length, sine(point.angle), cosine(point.angle)
        angle = inverse_length * (c * z[row, column] + s * z[row + 1, column])
        around = c * z[row + 2, column] + s * z[row + 3, column]
        velocity = inverse_length * (around - stretch_of(run, i, column) * point.velocity)
        return angle, velocity

    @part
    def gap_perturbation(run: Run, column: int) -> float:
        """Perturbation of the gap between the balls [m]."""
        z, (nx, ny, _) = run.state.tangent_map, gaps.line_of_centres(run.now)
        result: float = nx * z[0, column] + ny * z[1, column]
        if two:
            result -= nx * z[4, column] + ny * z[5, column]
        if sensitive and column >= size:
            for i in range(count):
                result -= run.changes[column - size].radius[i]
        return result

    @part
    def slackens_by_itself(run: Run, i: int, point: Point) -> bool:
        """Whether a string that goes slack does so for lack of tension, and not with an impact."""
        b = run.bodies[i]
        largest = point.velocity * point.velocity + run.settings.gravity * b.inverse_length
        slackens: bool = abs(swing.tension(run, i, point)) <= _CROSSES * largest
        return slackens

    @part
    def impact_delay(run: Run, column: int, rate: float) -> float:
        """By how much a perturbation delayed the impact that balls leave at this rate [m/s].

        Without a rebound it shows no more; the delays by parameters are known from the impact.
        """
        if run.settings.restitution > 0.0:
            return -gap_perturbation(run, column) / rate
        late = 0.0
        if sensitive and column >= size:
            late = run.delay[column - size]
        return late

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
        for column in range(columns_of(run)):
            for i in range(count):
                angle = 1.0 if column == 2 * i else 0.0
                velocity = 1.0 if column == 2 * i + 1 else 0.0
                write_taut(run, i, column, run.now[i], angle, velocity)
                state.tangent_map[DELAY_ROWS + i, column] = 0.0
        for i in range(count):
            place_taut(run.now[i], 1.0 / run.bodies[i].inverse_length)
        _, rate = gaps.gap(run, run.now)
        if state.touch == 0.0 or (run.settings.restitution > 0.0 and rate <= 0.0):
            return
        # Between the impact of the perturbed motion and this one the string does not push: what it
        # would have pushed, ``l w^2 - ...`` < 0 per mass, is missing for the time of the delay.
        for i in range(count):
            point, length = run.now[i], 1.0 / run.bodies[i].inverse_length
            pushed = length * swing.tension(run, i, point)
            if pushed >= 0.0 or slackens_by_itself(run, i, point):
                continue
            for column in range(columns_of(run)):
                missing = pushed * impact_delay(run, column, rate)
                state.tangent_map[4 * i + 2, column] -= missing * sine(point.angle)
                state.tangent_map[4 * i + 3, column] += missing * cosine(point.angle)

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
        t, span = run.t, run.tables[table, OFFSET, run.stages - 1]
        for k in range(run.stages):
            h, drift_time = run.tables[table, KICK, k], run.tables[table, DRIFT_TIME, k]
            vx -= h * (ax + b.damping_rate * wx)
            vy -= h * (gravity + ay + b.damping_rate * wy)
            if sensitive:
                kick_forcing(run, i, t, h, wx, wy)
            speed = math.hypot(vx, vy)
            far, kept, far_beside, kept_beside = drift_slopes_in_plane(speed, drift_time, b)
            ux, uy = (vx / speed, vy / speed) if speed > 0.0 else (0.0, 0.0)
            for column in range(columns_of(run)):
                x, y = z[row + 2, column], z[row + 3, column]
                along = ux * x + uy * y
                farther, faster = (far - far_beside) * along, (kept - kept_beside) * along
                z[row, column] += far_beside * x + farther * ux
                z[row + 1, column] += far_beside * y + farther * uy
                z[row + 2, column] = kept_beside * x + faster * ux
                z[row + 3, column] = kept_beside * y + faster * uy
            if sensitive:
                drift_forcing(run, i, speed, run.drifts[k] * span, ux, uy)
            vx *= kept_beside
            vy *= kept_beside
            t = run.t + run.tables[table, OFFSET, k]
            swing.write_pivot_motion(run, t, run.inside[i])
            ax, ay = run.inside[i].across, run.inside[i].pivot_acceleration
            wx, wy = run.inside[i].wind_x, run.inside[i].wind_y
        if sensitive:
            kick_forcing(run, i, t, run.tables[table, KICK, run.stages], wx, wy)

    @part
    def kick_forcing(run: Run, i: int, t: float, h: float, wx: float, wy: float) -> None:
        """Add what parameters change in a kick of a falling ball."""
        z, row, rate = run.state.tangent_map, 4 * i, run.bodies[i].damping_rate
        for p in range(run.parameters):
            change, column = run.changes[p], size + p
            dax, day, dwx, dwy = swing.pivot_change(run, t, p)
            rate_change = change.bodies[i].damping_rate
            z[row + 2, column] -= h * (dax + rate_change * wx + rate * dwx)
            z[row + 3, column] -= h * (change.gravity + day + rate_change * wy + rate * dwy)

    @part
    def drift_forcing(
        run: Run, i: int, speed: float, interval: float, ux: float, uy: float
    ) -> None:
        """Add what parameters change in a drift of a falling ball in the direction (ux, uy)."""
        z, row, b = run.state.tangent_map, 4 * i, run.bodies[i]
        for p in range(run.parameters):
            column = size + p
            far, fast = drift_changes_in_plane(speed, interval, b, run.changes[p].bodies[i])
            z[row, column] += far * ux
            z[row + 1, column] += far * uy
            z[row + 2, column] += fast * ux
            z[row + 3, column] += fast * uy

    @part
    def step(run: Run) -> None:
        """Follow the perturbations through the planned step."""
        step_by(run, run.length, run.end)

    @part
    def step_by(run: Run, length: float, points: list[Point]) -> None:
        """Follow the perturbations through a part of the step to `points`: fall or taut swing."""
        if run.state.has_tangent_map == 0:
            return
        for i in range(count):
            if run.state.is_slack[i] != 0:
                swing.prepare(run, i, ANY_LENGTH + i, length)
                follow_fall(run, i)
                continue
            swing.prepare_tangent(run, i, ANY_LENGTH + i, length, run.now[i])
            m11, m12, m21, m22 = swing.tangent(run, i, ANY_LENGTH + i, run.now[i])
            for column in range(columns_of(run)):
                angle, velocity = taut_perturbation(run, i, column, run.now[i])
                later, faster = m11 * angle + m12 * velocity, m21 * angle + m22 * velocity
                if sensitive and column >= size:
                    p = column - size
                    later += run.forcing[2 * i, p]
                    faster += run.forcing[2 * i + 1, p]
                    run.forcing[2 * i, p] = run.forcing[2 * i + 1, p] = 0.0
                write_taut(run, i, column, points[i], later, faster)

    @part
    def write_tangent(run: Run, length: float) -> None:
        """Write the tangent map from where slack began to a point in the step, ``run.inside``."""
        z, columns = run.state.tangent_map, columns_of(run)
        for column in range(columns):
            for row in range(len(z)):
                run.kept[row, column] = z[row, column]
        step_by(run, length, run.inside)
        write_map(run, run.inside)
        for column in range(columns):
            for row in range(len(z)):
                z[row, column] = run.kept[row, column]

    @part
    def write_map(run: Run, points: list[Point]) -> None:
        """Write the columns as angles and angular velocities into matrix and forcing."""
        for column in range(columns_of(run)):
            for i in range(count):
                angle, velocity = _polar_perturbation(run, i, column, points[i])
                if column < size:
                    run.jacobian[2 * i, column], run.jacobian[2 * i + 1, column] = angle, velocity
                else:
                    p = column - size
                    run.forcing[2 * i, p], run.forcing[2 * i + 1, p] = angle, velocity

    @part
    def find_delays(run: Run, i: int) -> None:
        """Find by how much parameters delay the present event of a ball."""
        if not sensitive:
            return
        z, row = run.state.tangent_map, DELAY_ROWS + i
        for p in range(run.parameters):
            run.delay[p] = z[row, size + p] if run.doubt == 0 else math.nan
            for column in range(size):
                run.delay[p] += z[row, column] * run.sensitivity[column, p]

    @part
    def reach_slack(run: Run, i: int) -> None:
        """Find by how much parameters delay the instant at which a taut string goes slack.

        The guard is the tension. A string that would push at once goes slack with the event of this
        instant, such as an impact or the start, and is as late as that.
        """
        if not sensitive:
            return
        swing.settle(run, i, run.t, run.now[i])
        point = run.now[i]
        rates = point.velocity, acceleration_with_drag(point, run.bodies[i])
        if not slackens_by_itself(run, i, point):
            return
        for p in range(run.parameters):
            own = run.sensitivity[2 * i, p], run.sensitivity[2 * i + 1, p]
            if run.state.has_tangent_map != 0:
                angle, velocity = taut_perturbation(run, i, size + p, point)
                for column in range(size):
                    one, other = taut_perturbation(run, i, column, point)
                    angle += one * run.sensitivity[column, p]
                    velocity += other * run.sensitivity[column, p]
                own = angle, velocity
            later = swing.tension_change(run, i, point, p, own)
            rate = swing.tension_change(run, i, point, run.parameters, rates)
            run.delay[p] = -later / rate if rate != 0.0 and run.doubt == 0 else math.nan

    @part
    def move(run: Run, sign: float) -> None:
        """Shift all perturbations to the event (sign 1), or back from it (-1), by their delays."""
        z = run.state.tangent_map
        for i in range(count):
            row, point, (ax, ay) = 4 * i, run.now[i], acceleration(run, i, run.now[i])
            for column in range(columns_of(run)):
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
        for column in range(columns_of(run)):
            delay = -gap_perturbation(run, column) / rate
            for i in range(count):
                run.state.tangent_map[DELAY_ROWS + i, column] = delay
        move(run, 1.0)

    @part
    def reach_full_length(run: Run) -> None:
        """Find the delays of strings that reach their full length, and shift there."""
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
                for column in range(columns_of(run)):
                    longer = point.x * z[row, column] + point.y * z[row + 1, column]
                    spare = stretch_of(run, i, column) - longer * b.inverse_length
                    z[DELAY_ROWS + i, column] = -spare / rate
        move(run, 1.0)

    @part
    def leave_event(run: Run) -> None:
        """Shift back from the event, with the velocities and accelerations after it."""
        if run.state.has_tangent_map == 0:
            return
        move(run, -1.0)
        for column in range(columns_of(run)):
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
        for column in range(columns_of(run)):
            x, y = k * z[row, column], k * z[row + 1, column]
            along = rx * x + ry * y
            x, y = x - along * rx, y - along * ry
            faster = rx * z[row + 2, column] + ry * z[row + 3, column]
            faster += x * point.vx + y * point.vy
            z[row + 2, column] -= back * (faster * rx + outward * x)
            z[row + 3, column] -= back * (faster * ry + outward * y)
            if sensitive and column >= size and restitution > 0.0:
                bouncier = run.changes[column - size].string_restitution * outward
                z[row + 2, column] -= bouncier * rx
                z[row + 3, column] -= bouncier * ry

    @part
    def mobility_of(run: Run, i: int, nx: float, ny: float) -> float:
        """Velocity along the line of centres per impulse along it [1/kg]: less on a taut string."""
        b, point, across = run.bodies[i], run.now[i], 1.0
        if run.state.is_slack[i] == 0:
            across = nx * cosine(point.angle) + ny * sine(point.angle)
        result: float = across * across / (b.inertia * b.inverse_length * b.inverse_length)
        return result

    @inlined(part)
    def heavier(run: Run, i: int, column: int) -> float:
        """By which share of it a column's parameter makes a ball's mass larger."""
        if not sensitive or column < size:
            return 0.0
        b, change = run.bodies[i], run.changes[column - size].bodies[i]
        shorter = 2.0 * change.inverse_length / b.inverse_length
        share: float = change.inertia / b.inertia + shorter
        return share

    @part
    def tangential_part(
        run: Run, i: int, column: int, nx: float, ny: float, x: float, y: float
    ) -> tuple[float, float]:
        """Component of the line of centres around the pivot, and its perturbation."""
        angle, _ = taut_perturbation(run, i, column, run.now[i])
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
        for column in range(columns_of(run)):
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
                mobility_change -= mobility_of(run, i, nx, ny) * heavier(run, i, column)
                if run.state.is_slack[i] == 0:
                    across, change = tangential_part(run, i, column, nx, ny, x, y)
                    mobility_change += (
                        2.0 * across * change / (b.inertia * b.inverse_length * b.inverse_length)
                    )
            pushed = back * (slower - closing * mobility_change / mobility) / mobility
            if sensitive and column >= size and restitution > 0.0:
                pushed += run.changes[column - size].restitution * closing / mobility
            for i in range(count):
                b, row = run.bodies[i], 4 * i
                per_mass = (1.0 - 2.0 * i) / (b.inertia * b.inverse_length * b.inverse_length)
                less = pushed - impulse * heavier(run, i, column)
                px, py = less * nx + impulse * x, less * ny + impulse * y
                if run.state.is_slack[i] == 0:
                    across, change = tangential_part(run, i, column, nx, ny, x, y)
                    angle, _ = taut_perturbation(run, i, column, run.now[i])
                    s, c = sine(run.now[i].angle), cosine(run.now[i].angle)
                    around = less * across + impulse * change
                    px = around * c - impulse * across * s * angle
                    py = around * s + impulse * across * c * angle
                z[row + 2, column] += per_mass * px
                z[row + 3, column] += per_mass * py

    @part
    def kick(run: Run, i: int, kicked: float) -> None:
        """Multiply by the derivative of a kick of a slack ball around the pivot [rad/s]."""
        z, row = run.state.tangent_map, 4 * i
        for column in range(columns_of(run)):
            z[row + 2, column] -= kicked * z[row + 1, column]
            z[row + 3, column] += kicked * z[row, column]

    @part
    def mark_undefined(run: Run) -> None:
        """Mark the tangent map as undefined (NaN): perturbations do not stay small here."""
        for column in range(columns_of(run)):
            run.state.tangent_map[0, column] = math.nan

    @part
    def finish(run: Run, accumulators: Accumulators) -> None:
        """Report the tangent map, now that all strings are taut.

        The logarithm of its determinant does not follow from the laws of motion alone: NaN.
        """
        if run.state.has_tangent_map == 0:
            return
        run.state.has_tangent_map = 0
        for i in range(count):
            place_taut(run.now[i], 1.0 / run.bodies[i].inverse_length)
        write_map(run, run.now)
        report.matrix(run, accumulators, size, run.t - run.state.tangent_map_start, math.nan)

    return TangentMap(
        begin=begin, step=step, write_tangent=write_tangent, reach_contact=reach_contact,
        reach_full_length=reach_full_length, reach_slack=reach_slack, find_delays=find_delays,
        tighten=tighten, collide=collide,
        leave_event=leave_event, kick=kick, mark_undefined=mark_undefined, finish=finish,
    )  # fmt: skip
