"""What parameters do at events besides what they did to the state: the forcing of resets.

A contact moves with radius and length. Measured from the moving wall its saltation is that of a
wall at rest, so an offset ``o`` of the state that moves with the contact adds ``o - M o``, with the
event's matrix M. For two balls the offset is split such that their joint angle does not change.
What remains is the derivative of the reset at a fixed state, and for the drive's next segment the
difference of the rates before and after, times the shift of its start.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics.engine.balls import Balls, share_of
from latolato.numerics.engine.doubts import TOGETHER
from latolato.numerics.engine.taut_step import acceleration_with_drag
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import REST, STICKING, Change, Output, Run

# Events are at one instant if they are this close, per time from the start [s] (and 1 s).
_AT_ONCE = 1e-12


class ContactChanges(NamedTuple):
    """How contacts move; see `make_contact_changes`."""

    contact_change: Callable[..., float]
    offsets: Callable[..., tuple[float, float]]
    gap_change: Callable[..., float]


class ImpactForcing(NamedTuple):
    """The forcing of impacts and of balls in contact; see `make_impact_forcing`."""

    add_contact: Callable[..., None]
    add_impact: Callable[..., None]


class JointForcing(NamedTuple):
    """The forcing of two balls that swing as one; see `make_joint_forcing`."""

    begin_joint: Callable[..., None]
    finish_joint: Callable[..., None]


class SegmentForcing(NamedTuple):
    """The forcing of the drive's next segment; see `make_segment_forcing`."""

    note_rates: Callable[..., None]
    add_segment: Callable[..., None]


def make_contact_changes(count: int, part: Part = as_it_stands) -> ContactChanges:
    """Make the functions that tell how parameters move the contacts of `count` balls."""
    two = count == 2

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

    return ContactChanges(contact_change, offsets, gap_change)


def make_impact_forcing(
    offsets: Callable[..., tuple[float, float]], count: int, part: Part = as_it_stands
) -> ImpactForcing:
    """Make the functions of forcing at contacts that move by `offsets`."""
    two, size = count == 2, 2 * count

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

    return ImpactForcing(add_contact, add_impact)


def make_joint_forcing(
    offsets: Callable[..., tuple[float, float]], add_contact: Callable[..., None],
    part: Part = as_it_stands,
) -> JointForcing:  # fmt: skip
    """Make the functions before and after a step of two balls as one, whose body moves."""

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

    return JointForcing(begin_joint, finish_joint)


def make_segment_forcing(
    balls: Balls, doubt: Callable[..., None], count: int, part: Part = as_it_stands
) -> SegmentForcing:
    """Make the functions before and after a segment begins."""

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

    return SegmentForcing(note_rates, add_segment)
