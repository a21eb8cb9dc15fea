"""Sticking contact: two balls swing as one body, until the contact force would pull.

The body is an equivalent pendulum of its own, see `latolato.physics.pair.joint_inverse_length`.
"""

from __future__ import annotations

import math

from latolato.numerics.callbacks import Accumulators
from latolato.numerics.contact_time import MOST_TRIALS, make_lowest
from latolato.numerics.engine.balls import Balls, share_of
from latolato.numerics.engine.modes import Mode
from latolato.numerics.engine.report import Report
from latolato.numerics.engine.sensitivity import Sensitivity
from latolato.numerics.engine.stiction import add_compression
from latolato.numerics.engine.taut_step import (
    SHORTEST,
    TautStep,
    acceleration_with_drag,
    acceleration_with_friction,
)
from latolato.numerics.matrices import write_joint_matrix
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import (
    ANY_LENGTH,
    NOTHING,
    PAIR_ROW,
    RELEASE,
    STICKING,
    TURN,
    Point,
    Run,
)
from latolato.physics.pair import contact_torque, radial_push

_TABLE = ANY_LENGTH + PAIR_ROW


def make_sticking(
    swing: TautStep, balls: Balls, report: Report, sensitivity: Sensitivity,
    part: Part = as_it_stands,
) -> Mode:  # fmt: skip
    """Make the mode of two balls in sticking contact."""
    begin_joint, finish_joint = sensitivity.begin_joint, sensitivity.finish_joint

    @part
    def body_of(run: Run) -> int:
        """Number of the body that both balls form."""
        return 2 if run.state.side < 0.0 else 3

    @part
    def gap_of(run: Run) -> float:
        """Separation of the balls in contact [rad]."""
        settings = run.settings
        return settings.low if run.state.side < 0.0 else settings.high

    @part
    def join(run: Run, points: list[Point]) -> None:
        """Make the point of both as one from those of the balls."""
        settings, one = run.settings, points[PAIR_ROW]
        offset = settings.offset_low if run.state.side < 0.0 else settings.offset_high
        one.angle, one.velocity = points[1].angle + offset, points[1].velocity

    @part
    def split(run: Run, points: list[Point]) -> None:
        """Make the points of the balls from that of both as one."""
        settings, one = run.settings, points[PAIR_ROW]
        offset = settings.offset_low if run.state.side < 0.0 else settings.offset_high
        points[1].angle = one.angle - offset
        points[0].angle = points[1].angle + gap_of(run)
        points[0].velocity = points[1].velocity = one.velocity

    @part
    def swing_by(run: Run, length: float, points: list[Point]) -> None:
        """Take a step of any length of both as one."""
        begin, end = run.now[PAIR_ROW], points[PAIR_ROW]
        swing.step_by(run, body_of(run), _TABLE, length, begin, end)

    @part
    def find_tensions(run: Run, t: float, points: list[Point]) -> None:
        """Write both tensions, each over mass and length: the contact pushes along the rods."""
        _settings, gap = run.settings, gap_of(run)
        one, two = run.bodies[0], run.bodies[1]
        torque = contact_torque(
            acceleration_with_friction(
                swing.free(run, 0, t, points[0].angle), points[0].velocity, one
            ),
            acceleration_with_friction(
                swing.free(run, 1, t, points[1].angle), points[1].velocity, two
            ),
            one.inertia,
            two.inertia,
        )
        for i in range(2):
            point, b = points[i], run.bodies[i]
            length, other = 1.0 / b.inverse_length, 1.0 / run.bodies[1 - i].inverse_length
            swing.write_forces(run, i, t, point)
            push = radial_push(torque, length, other, gap) * length / b.inertia
            point.tension = push + swing.tension(run, i, point)

    @part
    def margin(run: Run, length: float) -> float:
        """Guard of the release, `length` seconds into the step; negative beyond it.

        It ends when the balls would part, when friction no longer holds both at once, or when a
        string would have to push.
        """
        swing_by(run, length, run.inside)
        one = run.inside[PAIR_ROW]
        # A velocity beyond its zero belongs to the frozen sign only: friction sees it as zero.
        turns = run.event == TURN and length >= run.length
        if turns or one.velocity * one.sign < 0.0:
            one.velocity = 0.0
        split(run, run.inside)
        pressed = -balls.separation_acceleration(run, run.state.side, run.t + length, run.inside)
        if one.sign == 0.0:
            body = body_of(run)
            slip = abs(swing.free(run, body, run.t + length, one.angle))
            pressed = min(pressed, run.bodies[body].coulomb - slip)
        if run.settings.is_string != 0:
            find_tensions(run, run.t + length, run.inside)
            for i in range(2):
                pressed = min(pressed, run.inside[i].tension)
        return pressed

    find_lowest = make_lowest(margin, part)

    @part
    def dip(run: Run, length: float, last: float) -> float:
        """Time at which the margin is negative though it is not at the ends, or the length [s].

        The parabola through both ends and the middle tells whether the bottom is worth a look.
        """
        first, middle = margin(run, 0.0), margin(run, 0.5 * length)
        curvature, lowest = first - 2.0 * middle + last, middle
        if curvature > 0.0 and abs(last - first) < 2.0 * curvature:
            lowest = middle - 0.125 * (last - first) ** 2 / curvature
        if lowest > 0.02 * (first + last):
            return length
        s = find_lowest(run, 0.0, length)
        return s if margin(run, s) < 0.0 else length

    @part
    def parting_time(run: Run, end: float) -> float:
        """Time before `end` at which the balls part, by bisection [s]."""
        begin = 0.0
        for _ in range(MOST_TRIALS):
            s = 0.5 * (begin + end)
            if s <= begin or s >= end:
                break
            if margin(run, s) < 0.0:
                end = s
            else:
                begin = s
        return end

    @part
    def plan(run: Run) -> None:
        """Swing as one, up to the release, a turning point or the goal."""
        state = run.state
        balls.plan_length(run)
        join(run, run.now)
        one, end = run.now[PAIR_ROW], run.end[PAIR_ROW]
        swing.settle(run, body_of(run), run.t, one)
        if run.t < state.held_until < run.t_end:
            balls.shorten(run, state.held_until - run.t)
        swing_by(run, run.length, run.end)
        turn = math.inf
        if run.is_nonsmooth != 0 and not end.velocity * one.sign >= 0.0:
            s = swing.turn(run, body_of(run), _TABLE, run.length, one, end)
            balls.shorten(run, max(s, SHORTEST * run.t))
            run.event, turn = TURN, run.length
        if run.t >= state.held_until:
            last = margin(run, run.length)
            until = run.length if last < 0.0 else dip(run, run.length, last)
            if last < 0.0 or until < run.length:
                balls.shorten(run, parting_time(run, until))
                run.event = RELEASE
        swing_by(run, run.length, run.end)
        inertia = run.bodies[body_of(run)].inertia
        run.work, run.loss = inertia * end.work, inertia * end.loss
        if run.length >= turn:
            end.velocity = 0.0
        split(run, run.end)
        # Friction may have let go of both together: then they move on as one.
        is_released = run.event == RELEASE and one.sign == 0.0
        if run.settings.is_string != 0:  # or a string did
            pull = abs(swing.free(run, body_of(run), run.t_end, one.angle))
            is_released = is_released and pull > run.bodies[body_of(run)].coulomb
        if (
            is_released
            and balls.separation_acceleration(run, state.side, run.t_end, run.end) <= 0.0
        ):
            run.event = NOTHING

    @part
    def evaluate_inside(run: Run, length: float) -> None:
        """Swing a part of the step."""
        swing_by(run, length, run.inside)
        split(run, run.inside)
        inertia, one = run.bodies[body_of(run)].inertia, run.inside[PAIR_ROW]
        run.work_inside, run.loss_inside = inertia * one.work, inertia * one.loss

    @part
    def write_tangent(run: Run, length: float) -> None:
        """Write the tangent map of a part of the step of both as one."""
        body, side = body_of(run), run.state.side
        begin_joint(run, side)
        matrix = swing.tangent(run, body, _TABLE, run.now[PAIR_ROW])
        write_joint_matrix(run.jacobian, share_of(run), matrix)
        finish_joint(run, side)

    @part
    def note(run: Run, accumulators: Accumulators) -> None:
        """Add up compression, and report the step of each ball and the common tangent map."""
        body = body_of(run)
        begin, end = run.now[PAIR_ROW], run.end[PAIR_ROW]
        if run.settings.follows_tension != 0:
            find_tensions(run, run.t, run.now)
            find_tensions(run, run.t_end, run.end)
        for i in range(2):
            if run.settings.follows_tension != 0 and run.settings.is_string == 0:
                left, right = run.now[i].tension, run.end[i].tension
                add_compression(run.state, i, left, right, run.t, run.t_end)
            a0, a1 = (
                acceleration_with_drag(begin, run.bodies[body]),
                acceleration_with_drag(end, run.bodies[body]),
            )
            report.step(run, accumulators, i, a0, a1, 1.0)
        if report.wants_tangent_map(run):
            swing.prepare_tangent(run, body, _TABLE, run.length, begin)
            write_tangent(run, run.length)
            report.matrix(run, accumulators, 4, run.length, -math.inf)

    return Mode(STICKING, plan, evaluate_inside, note, write_tangent)
