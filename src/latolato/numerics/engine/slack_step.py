"""The splitting step of a ball whose string is slack, free in the plane.

Positions and velocities are those against the pivot. Kicks by gravity and drive alternate with
drifts under the exact drag, as in a swing; the hinge's dry friction does not drift_time the ball.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.core.scalar import cosine, formula, sine
from latolato.numerics.engine.taut_step import TautStep, acceleration_with_drag
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import DRIFT_TIME, KICK, Point, Run
from latolato.physics.damping import drift_in_plane, slowing_in_plane


class SlackStep(NamedTuple):
    """The functions of a falling ball; see `make_slack_step`."""

    step_by: Callable[..., None]
    hang: Callable[..., None]
    kick: Callable[..., Any]
    acceleration: Callable[..., Any]
    slopes: Callable[..., Any]


@formula
def place_taut(point: Point, length: float) -> None:
    """Write position and velocity of a ball at the end of its taut string."""
    s, c, speed = sine(point.angle), cosine(point.angle), length * point.velocity
    point.x, point.y, point.vx, point.vy = length * s, -length * c, speed * c, speed * s


@formula
def turn_to_place(point: Point) -> None:
    """Write angle (unwrapped) and angular velocity of a ball from its position and velocity."""
    squared = point.x * point.x + point.y * point.y
    if squared == 0.0:  # at the pivot there is no angle: keep the last one
        point.velocity = 0.0
        return
    turn = math.atan2(point.x, -point.y) - point.angle
    point.angle += turn - math.tau * math.floor(turn / math.tau + 0.5)
    point.velocity = (point.x * point.vy - point.y * point.vx) / squared


@formula
def radial_rate(point: Point) -> float:
    """Rate of the distance from the pivot [m/s]."""
    outward: float = point.x * point.vx + point.y * point.vy
    distance = math.hypot(point.x, point.y)
    return outward / distance if distance > 0.0 else math.hypot(point.vx, point.vy)


@formula
def _nothing(run: Run, i: int, *rest: Any) -> None:
    """Do nothing."""


@formula
def _no_works(run: Run, i: int, *rest: Any) -> tuple[float, float]:
    """Zeros."""
    return 0.0, 0.0


# Of balls on rods, which never fall.
NO_SLACK_STEP = SlackStep(
    step_by=_nothing,
    hang=_nothing,
    kick=_no_works,
    acceleration=_no_works,
    slopes=_no_works,
)


def make_slack_step(swing: TautStep, part: Part = as_it_stands) -> SlackStep:
    """Make the functions of a ball whose string is slack; each begins with ``(run, ball, ...)``.

    What pulls at a point is written by `swing.write_forces`.
    """

    @part
    def step_by(run: Run, i: int, table: int, length: float, begin: Point, end: Point) -> None:
        """Take a step of any length [s], with its work and loss over the moment of inertia."""
        swing.prepare(run, i, table, length)
        b, gravity, t = run.bodies[i], run.settings.gravity, run.t
        x, y, vx, vy = begin.x, begin.y, begin.vx, begin.vy
        ax, ay, wx, wy = begin.across, begin.pivot_acceleration, begin.wind_x, begin.wind_y
        work, loss = 0.0, 0.0
        for k in range(run.stages + 1):
            h = run.tables[table, KICK, k]
            change_x = -h * (ax + b.damping_rate * wx)
            change_y = -h * (gravity + ay + b.damping_rate * wy)
            middle_x, middle_y = vx + 0.5 * change_x, vy + 0.5 * change_y
            work -= h * (ax * middle_x + ay * middle_y)
            loss += h * b.damping_rate * (wx * middle_x + wy * middle_y)
            vx += change_x
            vy += change_y
            if k == run.stages:
                break
            drift_time = run.tables[table, DRIFT_TIME, k]
            far_x, far_y, slow_x, slow_y = drift_in_plane(vx, vy, drift_time, b)
            loss += 0.5 * ((vx - slow_x) * (vx + slow_x) + (vy - slow_y) * (vy + slow_y))
            x += far_x
            y += far_y
            vx, vy = slow_x, slow_y
            swing.write_pivot_motion(run, t + run.nodes[k] * length, end)
            ax, ay, wx, wy = end.across, end.pivot_acceleration, end.wind_x, end.wind_y
        end.angle, end.sign, end.x, end.y, end.vx, end.vy = begin.angle, 1.0, x, y, vx, vy
        end.acceleration = end.driven = end.tension = 0.0
        per_inertia = b.inverse_length * b.inverse_length
        end.work, end.loss = work * per_inertia, loss * per_inertia
        turn_to_place(end)

    @part
    def hang(run: Run, i: int, point: Point) -> None:
        """Write the ball's position if its string is taut, and the forces on it."""
        if run.state.is_slack[i] == 0:
            place_taut(point, 1.0 / run.bodies[i].inverse_length)
            return
        point.sign, point.acceleration, point.driven, point.tension = 1.0, 0.0, 0.0, 0.0
        swing.write_pivot_motion(run, run.t, point)

    @part
    def kick(run: Run, i: int, jump: float, kicked: float) -> tuple[float, float]:
        """Apply a jump of the pivot's velocity [m/s] and a kick [rad/s]; their works [J]."""
        point, mass = run.now[i], run.bodies[i].inertia * run.bodies[i].inverse_length ** 2
        worked = -mass * jump * (point.vy - 0.5 * jump)
        point.vy -= jump
        x, y = -point.y * kicked, point.x * kicked
        kick_work = mass * (x * (point.vx + 0.5 * x) + y * (point.vy + 0.5 * y))
        point.vx += x
        point.vy += y
        turn_to_place(point)
        return worked, kick_work

    @part
    def acceleration(run: Run, i: int, point: Point) -> tuple[float, float]:
        """Acceleration of a ball, slack or taut, in the frame of the pivot [m/s^2]."""
        b, gravity = run.bodies[i], run.settings.gravity
        if run.state.is_slack[i] == 0:
            around, inward = acceleration_with_drag(point, b), point.velocity * point.velocity
            return -around * point.y - inward * point.x, around * point.x - inward * point.y
        slowing = slowing_in_plane(math.hypot(point.vx, point.vy), b)
        ax = -point.across - b.damping_rate * point.wind_x - slowing * point.vx
        ay = (
            -gravity - point.pivot_acceleration - b.damping_rate * point.wind_y - slowing * point.vy
        )
        return ax, ay

    @part
    def slopes(run: Run, i: int, point: Point) -> tuple[float, float, float]:
        """Angular acceleration, energy and its rate, the last two over the moment of inertia."""
        b, gravity, (ax, ay) = run.bodies[i], run.settings.gravity, acceleration(run, i, point)
        squared = max(point.x * point.x + point.y * point.y, 1e-300)
        outward = point.x * point.vx + point.y * point.vy
        turned = (point.x * ay - point.y * ax - 2.0 * outward * point.velocity) / squared
        per_inertia = b.inverse_length * b.inverse_length
        energy = 0.5 * (point.vx * point.vx + point.vy * point.vy)
        energy += gravity * (1.0 / b.inverse_length + point.y)
        gained = ax * point.vx + (ay + gravity) * point.vy
        return turned, energy * per_inertia, gained * per_inertia

    return SlackStep(
        step_by=step_by, hang=hang, kick=kick, acceleration=acceleration, slopes=slopes
    )
