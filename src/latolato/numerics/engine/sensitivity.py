"""Derivatives of a motion with respect to parameters, carried along with it.

A parameter changes the numbers that a run reads: of bodies, walls, gravity and drive (`Change`).
The derivative ``s`` of the state with respect to it, at a fixed time, obeys the variational
equation: a step or an event with the tangent map ``M`` makes ``s`` into ``M s + g``, where the
forcing ``g`` is what the parameter does within it. A step's forcing belongs to the very splitting
step (`forces.py`). At an event whose guard ``q(x, t, p) = 0`` the parameter also changes the
instant, by ``dt = -(q_x s + q_p)/(dq/dt)``; a state that is reset there by ``x+ = R(x-, p)`` gains
``R_p + (R_x f- - f+) dt``, with the rates f before and after (Hiskens & Pai, IEEE Trans. Circuits
Syst. I 47 (2000) 204). The part of this that is linear in ``s`` is the saltation matrix, which the
event knows; what remains is written here.

Walls move with radius and length. Measured from the moving wall the saltation is that of a wall at
rest, so an offset ``o`` of the state that moves with the contact adds ``o - M o``. For two balls
the offset is split such that their joint angle does not change.

All this holds no more once the motion depends on a parameter in a way that has no derivative, or
one that cannot be trusted: `doubt` then marks all derivatives as unknown from there on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics.engine.balls import Balls, share_of
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.taut_step import TautStep, acceleration_with_drag
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import REST, STICKING, Change, Output, Run
from latolato.physics.damping import viscous_drag, viscous_drag_slope

# Why derivatives are not known any more; `simulation.sensitivity` has the sentences.
CERTAIN, GRAZING, TOGETHER, CAPTURED, SLACKENED, START, JUMP_IN_SLACK = range(7)

# An impact is a graze if the balls would have turned round this close behind the wall [rad].
GRAZING_DEPTH = 1e-9
# Events are at one instant if they are this close, per time from the start [s] (and 1 s).
_AT_ONCE = 1e-12
# A gap that changes less than this per unit of a parameter does not change [rad].
_NONE = 1e-12
# A contact ends by the balls' accelerations if these differ by less than this share.
_EQUAL = 1e-6


class Sensitivity(NamedTuple):
    """The functions of derivatives; see `make_sensitivity`. No-ops where nothing asks for them."""

    write_sample: Callable[..., None]
    write_delays: Callable[..., None]
    forget_delays: Callable[..., None]
    doubt: Callable[..., None]
    check_start: Callable[..., None]
    check_graze: Callable[..., None]
    reach_contact: Callable[..., None]
    reach_release: Callable[..., None]
    add_contact: Callable[..., None]
    add_impact: Callable[..., None]
    begin_joint: Callable[..., None]
    finish_joint: Callable[..., None]
    note_rates: Callable[..., None]
    add_segment: Callable[..., None]
    check_slack_segment: Callable[..., None]


def _nothing(run: Run, *rest: object) -> None:
    """Do nothing."""


def make_sensitivity(
    swing: TautStep, balls: Balls, laws: Laws, count: int, part: Part = as_it_stands
) -> Sensitivity:
    """Make the functions of derivatives of `count` balls, if the laws have their own."""
    two, size, sensitive = count == 2, 2 * count, len(laws.changes) > 0

    @part
    def write_sample(run: Run, output: Output, first: int) -> None:
        """Write the derivatives at the next sample, from row `first` on, and forget the forcing.

        Map and forcing are those from the beginning of the step to the sample.
        """
        k = run.state.sample
        for p in range(run.parameters):
            for row in range(size):
                value = run.forcing[row, p]
                for column in range(size):
                    value += run.jacobian[row, column] * run.sensitivity[column, p]
                output.samples[first + size * p + row, k] = value
            for row in range(size):
                run.forcing[row, p] = 0.0

    @part
    def write_delays(run: Run, output: Output, first: int) -> None:
        """Write by how much the present contact is later, from row `first` of the table on."""
        for p in range(run.parameters):
            output.contact_values[first + p, run.rows] = run.delay[p]

    @part
    def forget_delays(run: Run) -> None:
        """Mark the delays of the present contact as unknown."""
        for p in range(run.parameters):
            run.delay[p] = math.nan

    @part
    def doubt(run: Run, reason: int) -> None:
        """Mark all derivatives as unknown from now on."""
        if run.parameters == 0 or run.doubt != CERTAIN:
            return
        run.doubt, run.doubted_since = reason, run.t
        forget_delays(run)
        for p in range(run.parameters):
            for row in range(size):
                run.sensitivity[row, p] = math.nan

    @part
    def contact_change(run: Run, change: Change, side: float) -> float:
        """By how much the contact on this side moves per unit of a parameter [rad]."""
        moved: float = change.low if side < 0.0 else change.high
        return moved

    @part
    def offsets(run: Run, change: Change, side: float) -> tuple[float, float]:
        """How far the balls move with the contact, with their joint angle at rest [rad]."""
        moved = contact_change(run, change, side)
        if not two:
            return moved, 0.0
        share = share_of(run)
        return (1.0 - share) * moved, -share * moved

    @part
    def gap_change(run: Run, p: int, side: float) -> float:
        """By how much the gap above the contact changes per unit of a parameter [rad]."""
        gap: float = run.sensitivity[0, p]
        if two:
            gap -= run.sensitivity[2, p]
        return gap - contact_change(run, run.changes[p], side)

    @part
    def check_start(run: Run, side: float) -> None:
        """Doubt derivatives that would lift the balls off a contact at time zero, or push in."""
        for p in range(run.parameters):
            if abs(gap_change(run, p, side)) > _NONE:
                doubt(run, START)

    @part
    def check_graze(run: Run, side: float, closing: float) -> None:
        """Doubt derivatives at an impact that a slightly larger gap would have spared.

        Balls that meet at `closing` [rad/s] while they are pulled apart would have turned round
        ``closing^2/(2 a)`` behind the contact; the derivative grows like the inverse of the speed.
        """
        pulled = balls.separation_acceleration(run, side, run.t, run.now)
        if pulled > 0.0 and closing * closing < 2.0 * pulled * GRAZING_DEPTH:
            doubt(run, GRAZING)

    @part
    def reach_contact(run: Run, side: float, closing: float) -> None:
        """Find by how much each parameter delays the contact that is met at `closing` [rad/s]."""
        for p in range(run.parameters):
            late = math.nan
            if run.doubt == CERTAIN and closing != 0.0:
                late = -gap_change(run, p, side) / closing
            run.delay[p] = late

    @part
    def acceleration_change(run: Run, i: int, p: int, rates: tuple[float, float]) -> float:
        """Derivative of a ball's angular acceleration with all drag, along one of the state's.

        `rates` are those of angle and angular velocity; p may be the time.
        """
        b, point, change = run.bodies[i], run.now[i], run.changes[p].bodies[i]
        pulled: float = swing.pull_change(run, i, run.t, point.angle, p)
        pulled += swing.pull_gradient(run, i, run.t, point.angle) * rates[0]
        pulled -= viscous_drag_slope(point.velocity, b) * rates[1]
        return pulled - viscous_drag(point.velocity, change) - point.sign * change.coulomb

    @part
    def reach_release(run: Run, turning: float) -> None:
        """Find by how much each parameter delays the end of rest or sticking contact.

        The guard is the difference of the balls' own accelerations, or the acceleration of one
        from its wall. For balls that part as they turn, at the acceleration `turning` [rad/s^2], it
        is their common velocity; `turning` is 0 for others. Where something else ended the contact,
        the delays are unknown.
        """
        swing.settle(run, 0, run.t, run.now[0])
        a0 = acceleration_with_drag(run.now[0], run.bodies[0])
        guard, scale, common = a0, abs(run.now[0].acceleration) + 1.0, 0.0
        if two:
            swing.settle(run, 1, run.t, run.now[1])
            a1 = acceleration_with_drag(run.now[1], run.bodies[1])
            share = share_of(run)
            guard, common = a0 - a1, share * a0 + (1.0 - share) * a1
            scale += abs(run.now[1].acceleration)
        is_other = abs(guard) > _EQUAL * scale
        for p in range(run.parameters):
            run.delay[p] = math.nan
            if turning != 0.0:
                run.delay[p] = -run.sensitivity[1, p] / turning
            if turning != 0.0 or is_other or run.doubt != CERTAIN:
                continue
            change, rate = 0.0, 0.0
            for i in range(count):
                sign, s, rates = 1.0 - 2.0 * i, run.sensitivity, (run.now[i].velocity, common)
                own = s[2 * i, p], s[2 * i + 1, p]
                change += sign * acceleration_change(run, i, p, own)
                rate += sign * acceleration_change(run, i, run.parameters, rates)
            if rate != 0.0:
                run.delay[p] = -change / rate

    @part
    def add_contact(run: Run, side: float) -> None:
        """Add to the forcing that the contact moves: ``o - M o``, M being in ``run.jacobian``."""
        for p in range(run.parameters):
            one, other = offsets(run, run.changes[p], side)
            for row in range(size):
                carried = run.jacobian[row, 0] * one
                if two:
                    carried += run.jacobian[row, 2] * other
                run.forcing[row, p] -= carried
            run.forcing[0, p] += one
            if two:
                run.forcing[2, p] += other

    @part
    def add_impact(run: Run, side: float, restitution: float, v1: float, v2: float) -> None:
        """Add to the forcing what an impact at these velocities depends on besides the state.

        One ball leaves with ``-e w``. With the share c of ball 1 in the inertia and the closing
        speed D two leave with ``w1 - (1 + e)(1 - c) D`` and ``w2 + (1 + e) c D``. Balls that rest
        have lost their restitution, `restitution` is 0 then and its change does not count.
        """
        add_contact(run, side)
        for p in range(run.parameters):
            change = run.changes[p]
            e_change = change.restitution if restitution > 0.0 else 0.0
            if not two:
                run.forcing[1, p] -= e_change * v1
                continue
            share, closing = share_of(run), v1 - v2
            total = run.bodies[0].inertia + run.bodies[1].inertia
            share_change = change.bodies[0].inertia * (1.0 - share)
            share_change -= change.bodies[1].inertia * share
            both = share_change / total * (1.0 + restitution) * closing
            run.forcing[1, p] += both - e_change * (1.0 - share) * closing
            run.forcing[3, p] += both + e_change * share * closing

    @part
    def joint_offset(run: Run, p: int, side: float) -> float:
        """How far the angle of the joint body moves with the contact [rad]."""
        change = run.changes[p]
        _, other = offsets(run, change, side)
        moved: float = other + (change.offset_low if side < 0.0 else change.offset_high)
        return moved

    @part
    def begin_joint(run: Run, side: float) -> None:
        """Begin the forcing of two balls that swing as one with how far their angle moves."""
        for p in range(run.parameters):
            run.forcing[0, p], run.forcing[1, p] = joint_offset(run, p, side), 0.0

    @part
    def finish_joint(run: Run, side: float) -> None:
        """Make the forcing of both as one that of each ball."""
        for p in range(run.parameters):
            run.forcing[0, p] -= joint_offset(run, p, side)
            run.forcing[2, p], run.forcing[3, p] = run.forcing[0, p], run.forcing[1, p]
        add_contact(run, side)

    @part
    def write_rates(run: Run) -> None:
        """Write the accelerations of now; balls that stay in contact have those they have there."""
        one, other = run.inside[0], run.inside[count - 1]
        for i in range(count):
            run.inside[i] = run.now[i]
            run.inside[i].acceleration = acceleration_with_drag(run.now[i], run.bodies[i])
        pulled = balls.separation_acceleration(run, run.state.side, run.t, run.now)
        if balls.gap_rate(run.now) != 0.0 or pulled > 0.0:
            return
        if run.state.mode == REST:
            one.acceleration = 0.0
        elif run.state.mode == STICKING:
            share = share_of(run)
            common = share * one.acceleration + (1.0 - share) * other.acceleration
            one.acceleration = other.acceleration = common

    @part
    def note_rates(run: Run) -> None:
        """Keep velocities and accelerations from before the drive's next segment begins."""
        balls.settle(run)
        write_rates(run)
        for i in range(count):
            run.end[i] = run.inside[i]

    @part
    def add_segment(run: Run, output: Output, jump: float, restored: tuple[float, float]) -> None:
        """Add to the forcing what the beginning of a segment depends on besides the state.

        The pivot's velocity jumps by ``jump``, so that ball i gains ``-jump restored_i/length``,
        and its acceleration may change; both happen later by the change of the segment's start.
        """
        write_rates(run)
        is_seen = False
        for p in range(run.parameters):
            late, jump_change = run.segment_changes[p].start, run.segment_changes[p].jump
            for i in range(count):
                b, change = run.bodies[i], run.changes[p].bodies[i]
                before, after = run.end[i], run.inside[i]
                gained = jump_change * b.inverse_length + jump * change.inverse_length
                curved = run.jacobian[2 * i + 1, 2 * i] * before.velocity
                bent = before.acceleration - after.acceleration
                run.forcing[2 * i, p] += (before.velocity - after.velocity) * late
                run.forcing[2 * i + 1, p] += (curved + bent) * late - gained * restored[i]
                is_seen = is_seen or jump != 0.0 or bent != 0.0
        for row in range(run.rows):
            behind = run.t - output.contact_times[row]
            if is_seen and behind <= _AT_ONCE * (1.0 + run.t) and run.t > 0.0:
                doubt(run, TOGETHER)

    @part
    def check_slack_segment(run: Run) -> None:
        """Doubt derivatives of where a segment begins, or of its jump, while a string is slack."""
        for p in range(run.parameters):
            if run.segment_changes[p].start != 0.0 or run.segment_changes[p].jump != 0.0:
                doubt(run, JUMP_IN_SLACK)

    if not sensitive:
        return Sensitivity(*[part(_nothing)] * len(Sensitivity._fields))
    return Sensitivity(
        write_sample=write_sample,
        write_delays=write_delays,
        forget_delays=forget_delays,
        doubt=doubt,
        check_start=check_start,
        check_graze=check_graze,
        reach_contact=reach_contact,
        reach_release=reach_release,
        add_contact=add_contact,
        add_impact=add_impact,
        begin_joint=begin_joint,
        finish_joint=finish_joint,
        note_rates=note_rates,
        add_segment=add_segment,
        check_slack_segment=check_slack_segment,
    )
