"""Events at the end of a step: what each does to the motion and to perturbations."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.core.scalar import formula
from latolato.numerics.callbacks import Accumulators
from latolato.numerics.engine.balls import Balls, share_of
from latolato.numerics.engine.doubts import CAPTURED
from latolato.numerics.engine.report import Report
from latolato.numerics.engine.sensitivity import Sensitivity
from latolato.numerics.engine.taut_step import (
    SHORTEST,
    TautStep,
    acceleration_with_drag,
    acceleration_with_friction,
)
from latolato.numerics.matrices import UNCHANGED, clear_matrix, write_joint_matrix, write_matrix
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.records import CONTACT_ROWS
from latolato.numerics.run_record import (
    CONTACT,
    FLIGHT,
    PAIR_ROW,
    RELEASE,
    REST,
    SETTLE,
    STICKING,
    TURN,
    Output,
    Run,
)
from latolato.numerics.wall_contact import wall_contact
from latolato.physics import contacts
from latolato.physics.contacts import BOTTOM, TOP, pair_impact, wall_saltation
from latolato.physics.pair import write_pair_saltation

# How long balls stay together that part too little to be seen, as shares of the time to the goal
# and of a full step; without the lower bound the waits before a stop would shrink to zero.
_HOLD, _SHORTEST_REST = 0.25 / 16.0, 1e-3

# What rounding can take from the difference of two velocities, per sum of their sizes: an impact
# whose closing speed is a few units in the last place may repeat itself for ever.
_ROUNDING = 1e-15


class Event(NamedTuple):
    """What happens at the end of a step: ``apply(run, output, accumulators)``."""

    number: int
    apply: Callable[..., None]


@formula
def logarithm(ratio: float) -> float:
    """Natural logarithm, minus infinity at 0."""
    return math.log(ratio) if ratio > 0.0 else -math.inf


def make_events(
    swing: TautStep, balls: Balls, report: Report, sensitivity: Sensitivity, count: int,
    part: Part = as_it_stands,
) -> tuple[Event, ...]:  # fmt: skip
    """Make the events of `count` balls under exact contact."""
    two, delay_rows = count == 2, CONTACT_ROWS
    doubt, write_delays, forget_delays, reach_contact = (
        sensitivity.doubt, sensitivity.write_delays, sensitivity.forget_delays,
        sensitivity.reach_contact,
    )  # fmt: skip
    add_contact, add_impact = sensitivity.add_contact, sensitivity.add_impact
    begin_joint, finish_joint = sensitivity.begin_joint, sensitivity.finish_joint
    sticking = STICKING if two else REST

    @part
    def write_row(run: Run, output: Output, kind: int, before_1: float, before_2: float) -> None:
        """Write a row of the contact table; the velocities after it are those of now."""
        row, values = run.rows, output.contact_values
        output.contact_times[row], output.contact_kinds[row] = run.t, kind
        values[0, row] = before_1
        values[count, row] = run.now[0].velocity
        if two:
            values[1, row], values[3, row] = before_2, run.now[1].velocity
        write_delays(run, output, delay_rows)
        run.rows += 1

    @part
    def report_sticking_start(run: Run, accumulators: Accumulators) -> None:
        """Report the tangent map of a start of sticking contact: perturbations off it are lost."""
        clear_matrix(run.jacobian, 4)
        if two:
            write_joint_matrix(run.jacobian, share_of(run), UNCHANGED)
        add_contact(run, run.state.side)
        report.matrix(run, accumulators, 2 * count, 0.0, -math.inf)

    @part
    def turn(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Event: a ball turns round, begins to move or stops, so friction changes its direction."""
        if run.state.mode == STICKING:
            turn_together(run, accumulators)
            return
        point = run.now[run.ball]
        was_held, before = point.sign == 0.0, point.acceleration
        point.velocity = 0.0
        balls.settle(run)
        if was_held:
            return
        ratio = point.acceleration / before if before != 0.0 else 0.0
        clear_matrix(run.jacobian, 4)
        for i in range(count):
            write_matrix(run.jacobian, i, UNCHANGED)
        write_matrix(run.jacobian, run.ball, (1.0, 0.0, 0.0, ratio))
        report.matrix(run, accumulators, 2 * count, 0.0, logarithm(ratio))

    @part
    def turn_together(run: Run, accumulators: Accumulators) -> None:
        """Turn of two balls in sticking contact."""
        body = 2 if run.state.side < 0.0 else 3
        end = run.end[PAIR_ROW]
        pulled = acceleration_with_friction(
            swing.free(run, body, run.t, end.angle), 0.0, run.bodies[body]
        )
        ratio = pulled / end.acceleration if end.acceleration != 0.0 else 0.0
        balls.settle(run)
        begin_joint(run, run.state.side)
        write_joint_matrix(run.jacobian, share_of(run), (1.0, 0.0, 0.0, ratio))
        finish_joint(run, run.state.side)
        report.matrix(run, accumulators, 4, 0.0, -math.inf)

    @part
    def collide_with_wall(run: Run, side: float) -> bool:
        """Apply the impact of one ball on a wall; whether it rests there."""
        settings, b, point = run.settings, run.bodies[0], run.now[0]
        outward = -side * swing.free(run, 0, run.t, point.angle)
        point.velocity, lost, caught, rests = wall_contact(
            point.velocity, outward, settings.restitution, settings.rest_speed, b.coulomb
        )
        run.state.impact_loss += b.inertia * lost
        run.state.capture_loss += b.inertia * caught
        return rests

    @part
    def collide_balls(run: Run, side: float) -> bool:
        """Apply the impact of two balls; whether they rest on each other.

        The capture speed counts for each of two mirrored balls, so twice it for the gap's rate.
        """
        one, two = run.now[0], run.now[1]
        i1, i2 = run.bodies[0].inertia, run.bodies[1].inertia
        speed, e = one.velocity - two.velocity, run.settings.restitution
        energy = 0.5 * i1 * i2 / (i1 + i2) * speed * speed
        slow = speed == 0.0 or (e < 1.0 and abs(speed) <= 2.0 * run.settings.rest_speed)
        captures = slow and balls.separation_acceleration(run, side, run.t, run.now) <= 0.0
        if captures:
            e = 0.0
        one.velocity, two.velocity = pair_impact(one.velocity, two.velocity, i1, i2, e)
        # A rebound of the last digits is none: it would repeat itself for ever.
        lost = _ROUNDING * (abs(one.velocity) + abs(two.velocity))
        joins = (one.velocity - two.velocity) * side >= -lost
        if joins:
            two.velocity = one.velocity  # equal to the last bit: they move as one from here on
        if captures:
            run.state.capture_loss += energy
        else:
            run.state.impact_loss += energy * (1.0 - e * e)
        # Drag pulls at the balls as they move now.
        presses = joins and balls.separation_acceleration(run, side, run.t, run.now) <= 0.0
        return captures or presses

    @part
    def apply_impact(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Event: balls meet on ``run.side``, with an impact, a capture, or both."""
        side, state = run.side, run.state
        v1, v2 = run.now[0].velocity, run.now[1].velocity
        b1, b2 = run.bodies[0], run.bodies[1]
        a1, a2 = acceleration_with_drag(run.now[0], b1), acceleration_with_drag(run.now[1], b2)
        lost, closing = state.impact_loss, v1 - v2 if two else v1
        reach_contact(run, side, closing)
        if run.t == 0.0:
            sensitivity.check_start(run, side)
        else:
            sensitivity.check_graze(run, side, closing)
        rests = collide_balls(run, side) if two else collide_with_wall(run, side)
        captures = rests and state.impact_loss == lost
        if captures and closing != 0.0:
            forget_delays(run)
            if two:
                doubt(run, CAPTURED)
        if closing != 0.0 or run.t > 0.0:
            impact = BOTTOM if side < 0.0 else TOP
            write_row(run, output, contacts.REST if captures else impact, v1, v2)
            if rests and not captures:
                write_row(run, output, contacts.REST, run.now[0].velocity, run.now[1].velocity)
        balls.settle(run)
        state.touch = state.side = side
        state.mode = sticking if rests else FLIGHT
        if rests and (closing == 0.0 or not two):
            report_sticking_start(run, accumulators)
        elif closing != 0.0 and report.wants_tangent_map(run):
            report_impact(run, accumulators, v1, v2, a1, a2, rests)

    @part
    def report_impact(
        run: Run,
        accumulators: Accumulators,
        v1: float,
        v2: float,
        a1: float,
        a2: float,
        rests: bool,
    ) -> None:
        """Report the saltation matrix; velocities and accelerations are those just before.

        Two balls that rest move as one from then on, with the mean of their accelerations.
        """
        b1, b2 = run.bodies[0], run.bodies[1]
        e = 0.0 if rests else run.settings.restitution
        if two:
            share = share_of(run)
            pull_1, pull_2 = (
                acceleration_with_drag(run.now[0], b1),
                acceleration_with_drag(run.now[1], b2),
            )
            if rests:
                pull_1 = pull_2 = share * pull_1 + (1.0 - share) * pull_2
            after = (run.now[0].velocity, run.now[1].velocity)
            write_pair_saltation(
                run.jacobian, share, e, (v1, v2), after, (a1, a2), (pull_1, pull_2)
            )
        else:
            after_1 = run.now[0].velocity
            write_matrix(
                run.jacobian,
                0,
                wall_saltation(v1, after_1, a1, acceleration_with_drag(run.now[0], b1)),
            )
        add_impact(run, run.side, e, v1, v2)
        report.matrix(run, accumulators, 2 * count, 0.0, 2.0 * logarithm(e))

    @part
    def start_sticking(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Event: sticking contact begins where a separation is below rounding; release waits."""
        state, settings = run.state, run.settings
        state.grazes += 1
        v1, v2 = run.now[0].velocity, run.now[1].velocity
        b1, b2 = run.bodies[0].inertia, run.bodies[1].inertia
        if two:
            state.capture_loss += 0.5 * b1 * b2 / (b1 + b2) * (v1 - v2) ** 2
            run.now[0].velocity, _ = pair_impact(v1, v2, b1, b2, 0.0)
            run.now[1].velocity = run.now[0].velocity
        else:
            state.capture_loss += 0.5 * b1 * v1 * v1
            run.now[0].velocity = 0.0
        state.mode, state.side, state.touch = sticking, run.side, 0.0
        forget_delays(run)
        report_sticking_start(run, accumulators)
        h = settings.step
        least = max(_HOLD * min(h, run.goal - run.t), _SHORTEST_REST * h, SHORTEST * run.t)
        state.held_until = min(run.t + least, run.goal)
        if run.rows > 0 and output.contact_kinds[run.rows - 1] == contacts.RELEASE:
            run.rows -= 1
        else:
            write_row(run, output, contacts.REST, run.now[0].velocity, run.now[1].velocity)
        balls.settle(run)

    @part
    def acceleration_at_turn(run: Run) -> float:
        """Acceleration of two balls in contact that turn at the end of a step, else 0 [rad/s^2]."""
        end, body = run.end[PAIR_ROW], 2 if run.state.side < 0.0 else 3
        turns = two and run.is_nonsmooth != 0 and end.velocity * end.sign <= 0.0
        if not turns or balls.gap_rate(run.now) != 0.0:
            return 0.0
        turning: float = acceleration_with_drag(end, run.bodies[body])
        return turning

    @part
    def report_parting(run: Run, accumulators: Accumulators, before: float) -> None:
        """Report the saltation matrix of two balls that part as they turn, by their own friction.

        Their acceleration just before is the same.
        """
        clear_matrix(run.jacobian, 4)
        for i in range(2):
            after = acceleration_with_drag(run.now[i], run.bodies[i])
            write_matrix(run.jacobian, i, (1.0, 0.0, 0.0, after / before))
        report.matrix(run, accumulators, 4, 0.0, -math.inf)

    @part
    def release(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Event: sticking contact ends."""
        state, turning = run.state, acceleration_at_turn(run)
        sensitivity.reach_release(run, turning)
        state.mode, state.touch = FLIGHT, state.side
        write_row(run, output, contacts.RELEASE, run.now[0].velocity, run.now[1].velocity)
        balls.settle(run)
        if turning != 0.0:
            report_parting(run, accumulators, turning)

    return (
        Event(TURN, turn), Event(CONTACT, apply_impact), Event(SETTLE, start_sticking),
        Event(RELEASE, release),
    )  # fmt: skip
