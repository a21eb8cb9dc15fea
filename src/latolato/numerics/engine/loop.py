"""The loop: a mode plans a step, which is reported and taken, then the event there is applied."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from latolato.numerics.callbacks import Accumulators, Callbacks
from latolato.numerics.engine.balls import Balls, make_balls
from latolato.numerics.engine.events import Event, make_events
from latolato.numerics.engine.flight import make_flight
from latolato.numerics.engine.gaps import Gaps, make_gaps
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.modes import Mode
from latolato.numerics.engine.report import Report, make_report
from latolato.numerics.engine.rest import make_rest
from latolato.numerics.engine.samples import follow_ledger, write_place, write_sample
from latolato.numerics.engine.sensitivity import Sensitivity, make_sensitivity
from latolato.numerics.engine.slack import make_slack
from latolato.numerics.engine.slack_step import NO_SLACK_STEP, SlackStep, make_slack_step
from latolato.numerics.engine.sticking import make_sticking
from latolato.numerics.engine.stiction import make_stiction
from latolato.numerics.engine.strings import NO_STRINGS, Strings, make_strings
from latolato.numerics.engine.tangent_map import make_tangent_map
from latolato.numerics.engine.taut_step import TautStep, make_taut_step
from latolato.numerics.matrices import clear_matrix, write_matrix
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.records import PLANE_ROWS, SAMPLE_ROWS, Floats, Records
from latolato.numerics.run_record import (
    CONTACT,
    FLIGHT,
    NOTHING,
    RELEASE,
    REST,
    SLACK,
    STICKING,
    UNSETTLED,
    Output,
    Run,
)
from latolato.physics.damping import is_nonsmooth
from latolato.physics.pendulum import swung

# As many rows of the contact table as one step may need: on rods, and on strings.
SPARE_ROWS, SPARE_IN_PLANE = 4, 20
# How far from a contact balls may be that touch [rad]: separations of two balls are rounded.
_TOUCH = 1e-12


class Timetable(NamedTuple):
    """When the drive or a kick changes something: arrays of shape (segment,) or (kick,)."""

    segments: Records
    kick_times: Floats
    kick_sizes: Floats  # rad/s, shape (ball, kick)
    # How the segments change with parameters: one row of segments after the other.
    segment_changes: Records


class Arguments(NamedTuple):
    """What an engine is given besides the run."""

    timetable: Timetable
    output: Output
    accumulators: Accumulators


@functools.cache
def empty_arguments(segment: np.dtype[Any]) -> Arguments:
    """Empty arrays of the kinds that an engine takes."""
    floats, table, numbers = np.empty(0), np.empty((1, 0)), np.empty(0, dtype=np.int64)
    kicks = np.empty((2, 2))[:, :1]  # those of one point among many are not contiguous
    return Arguments(
        Timetable(np.empty(0, dtype=segment), floats, kicks, np.empty(0, dtype=segment)),
        Output(floats, table, floats, numbers, table),
        Accumulators(floats, 0, 0),
    )


class Plane(NamedTuple):
    """What motions in the plane have besides."""

    fall: SlackStep
    gaps: Gaps
    strings: Strings


class Kit(NamedTuple):
    """What modes and events are built from; see `make_engine`."""

    swing: TautStep
    balls: Balls
    report: Report
    laws: Laws
    sensitivity: Sensitivity
    balls_count: int
    part: Part
    plane: Plane | None = None


def usual_modes(kit: Kit) -> tuple[Mode, ...]:
    """Make the modes of exact contact."""
    swing, balls, report, laws, sensitivity, count, part, plane = kit
    stiction = make_stiction(swing, laws, part)
    strings = plane.strings if plane is not None else NO_STRINGS
    flight = make_flight(swing, balls, stiction, report, strings, sensitivity, count, part)
    sticking = (
        make_sticking(swing, balls, report, sensitivity, part)
        if count == 2
        else make_rest(stiction, report, sensitivity, part)
    )
    if plane is None:
        return flight, sticking
    fall, gaps, strings = plane
    slack = make_slack(swing, fall, balls, stiction, gaps, strings, report, count, part)
    return flight, sticking, slack


def usual_events(kit: Kit) -> tuple[Event, ...]:
    """Make the events of exact contact."""
    if kit.plane is not None:
        return kit.plane.strings.events
    return make_events(kit.swing, kit.balls, kit.report, kit.sensitivity, kit.balls_count, kit.part)


def by_mode(modes: Sequence[Mode], what: str, part: Part) -> Callable[..., None]:
    """Make the function that calls the one of this name of the present mode."""
    first, *others = modes
    function, number = getattr(first, what), first.number
    if not others:
        return function
    otherwise = by_mode(others, what, part)

    @part
    def chosen(run: Run, *rest: Any) -> None:
        if run.state.mode == number:
            function(run, *rest)
        else:
            otherwise(run, *rest)

    return chosen


def by_event(events: Sequence[Event], part: Part) -> Callable[..., None]:
    """Make the function that applies the present event."""
    first, *others = events
    function, number = first.apply, first.number
    otherwise = by_event(others, part) if others else None

    @part
    def chosen(run: Run, output: Output, accumulators: Accumulators) -> None:
        if run.event == number:
            function(run, output, accumulators)
        elif otherwise is not None:
            otherwise(run, output, accumulators)

    return chosen


def make_engine(
    laws: Laws,
    count: int,
    callbacks: Callbacks,
    part: Part = as_it_stands,
    *,
    make_modes: Callable[[Kit], tuple[Mode, ...]] = usual_modes,
    make_all_events: Callable[[Kit], tuple[Event, ...]] = usual_events,
) -> Callable[..., int]:
    """Make the function that carries the motion of `count` balls on.

    ``carry_on(run, timetable, output, accumulators, stop, most_steps)`` begins where ``run.state``
    is and stops at `stop` [s], after `most_steps` steps or when the contact table is full; it
    returns the rows written there and can be called again to go on.
    """
    two = count == 2
    sticking = STICKING if two else REST
    swing = make_taut_step(laws, part)
    in_plane = laws.plane is not None
    fall = make_slack_step(swing, part) if in_plane else NO_SLACK_STEP
    balls = make_balls(swing, fall, laws, count, part)
    report = make_report(laws, callbacks, part)
    sensitivity, sensitive = make_sensitivity(swing, balls, laws, count, part), bool(laws.changes)
    plane, strings, kick = None, NO_STRINGS, fall.kick
    if in_plane:
        gaps = make_gaps(count, part)
        usual = make_events(swing, balls, report, sensitivity, count, part)
        tangent_map = make_tangent_map(swing, fall, gaps, report, laws, count, part)
        strings = make_strings(swing, balls, gaps, tangent_map, sensitivity, usual, count, part)
        plane = Plane(fall, gaps, strings)
    release_string, resolve_contacts, kick_tangent_map = (
        strings.release_string,
        strings.resolve_contacts,
        strings.kick_tangent_map,
    )
    kit = Kit(swing, balls, report, laws, sensitivity, count, part, plane)
    modes, events = make_modes(kit), make_all_events(kit)
    plan, note = by_mode(modes, "plan", part), by_mode(modes, "note", part)
    evaluate_inside, apply = by_mode(modes, "evaluate_inside", part), by_event(events, part)
    write_tangent = by_mode(modes, "write_tangent" if sensitive else "evaluate_inside", part)
    apply_impact = next(event.apply for event in events if event.number == CONTACT)
    release = next(event.apply for event in events if event.number == RELEASE)
    restoring, slope = laws.restoring, laws.slope

    @part
    def enter_segment(run: Run, timetable: Timetable) -> None:
        """Take over the drive's present segment, and how it changes with parameters."""
        run.segment = timetable.segments[run.state.segment]
        if sensitive:
            for p in range(run.parameters):
                at = p * len(timetable.segments) + run.state.segment
                run.segment_changes[p] = timetable.segment_changes[at]

    @part
    def begin(run: Run, timetable: Timetable) -> None:
        """Set up everything that a step needs from the state."""
        state, h = run.state, run.settings.step
        enter_segment(run, timetable)
        run.t = state.t_base + state.steps * h
        run.rows = run.done = run.is_nonsmooth = 0
        for i in range(count):
            b = run.bodies[i]
            swing.prepare(run, i, i, h)
            if is_nonsmooth(b):
                run.is_nonsmooth = 1
            if sensitive:  # the derivative by a drag that is zero has the sign of the velocity
                for p in range(run.parameters):
                    other = run.changes[p].bodies[i]
                    if other.quadratic != 0.0 or other.coulomb != 0.0:
                        run.is_nonsmooth = 1
            run.now[i].angle, run.now[i].velocity = state.angle[i], state.velocity[i]
            if in_plane:
                run.now[i].x, run.now[i].y = state.place[i, 0], state.place[i, 1]
                run.now[i].vx, run.now[i].vy = state.place[i, 2], state.place[i, 3]
        balls.settle(run)

    @part
    def settle_contact(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Apply the contact of balls that touch at time zero."""
        state, settings = run.state, run.settings
        state.mode = FLIGHT
        if settings.follows_ledger != 0:
            state.first_energy = state.largest_energy = balls.energy(run)
        if in_plane and (state.is_slack[0] != 0 or state.is_slack[count - 1] != 0):
            state.mode = SLACK
            return
        gap, margin = balls.gap(run.now), _TOUCH if two else 0.0
        if gap <= settings.low + margin or gap >= settings.high - margin:
            state.touch = state.side = -1.0 if gap <= settings.low + margin else 1.0
            if balls.gap_rate(run.now) * state.side >= 0.0:
                run.side = state.side
                apply_impact(run, output, accumulators)

    @inlined(part)
    def set_goal(run: Run, timetable: Timetable, stop: float) -> None:
        """Set the next instant at which a step must end; no event is known before it."""
        state = run.state
        run.goal, run.event, run.keeps_touch = stop, NOTHING, 0
        if state.segment + 1 < len(timetable.segments):
            run.goal = min(run.goal, timetable.segments[state.segment + 1].start)
        if state.kick < len(timetable.kick_times):
            run.goal = min(run.goal, timetable.kick_times[state.kick])

    @part
    def write_derivatives(run: Run, output: Output, length: float) -> None:
        """Write the derivatives of the state at a sample, for which ``run.inside`` is there."""
        write_tangent(run, length)
        sensitivity.write_sample(run, output, PLANE_ROWS if in_plane else SAMPLE_ROWS)

    @inlined(part)
    def write_samples(run: Run, output: Output) -> None:
        """Write the samples that fall into the step."""
        times, state = output.sample_times, run.state
        while state.sample < len(times) and times[state.sample] < run.t_end:
            evaluate_inside(run, times[state.sample] - run.t)
            if in_plane:
                write_place(run, output, run.inside, count)
            if sensitive:
                write_derivatives(run, output, times[state.sample] - run.t)
            write_sample(run, output, run.inside, count, run.work_inside, run.loss_inside)

    @inlined(part)
    def accept_step(run: Run) -> None:
        """Go to the end of the step."""
        state = run.state
        for i in range(count):
            run.now[i] = run.end[i]
        if two and run.settings.mirrored != 0:  # an unstable symmetry would be lost to roundings
            one, other = run.now[0], run.now[1]
            one.angle = 0.5 * (one.angle - other.angle)
            one.velocity = 0.5 * (one.velocity - other.velocity)
            other.angle, other.velocity = -one.angle, -one.velocity
            if in_plane:
                one.x, one.vx = 0.5 * (one.x - other.x), 0.5 * (one.vx - other.vx)
                one.y, one.vy = 0.5 * (one.y + other.y), 0.5 * (one.vy + other.vy)
                other.x, other.y, other.vx, other.vy = -one.x, one.y, -one.vx, one.vy
        state.drive_work += run.work
        state.damping_loss += run.loss
        if run.is_whole != 0:
            state.steps += 1
        else:
            state.t_base, state.steps = run.t_end, 0
        run.t = run.t_end
        if run.keeps_touch == 0:
            state.touch = 0.0
        if run.settings.follows_ledger != 0:
            follow_ledger(state, balls.energy(run))

    @part
    def apply_jump_and_kick(run: Run, timetable: Timetable, is_jump: bool, is_kick: bool) -> bool:
        """Apply a jump of the pivot's velocity and a kick; whether any velocity changes."""
        state, moved = run.state, False
        jump = timetable.segments[state.segment + 1].jump if is_jump else 0.0
        for i in range(count):
            b, point = run.bodies[i], run.now[i]
            kicked = timetable.kick_sizes[i, state.kick] if is_kick else 0.0
            if in_plane and run.settings.is_string != 0:
                if jump != 0.0 and state.is_slack[i] == 0:
                    release_string(run, i)  # it tightens again where the jump pulls at it
                if state.is_slack[i] != 0:
                    worked, noise = kick(run, i, jump, kicked)
                    state.drive_work += worked
                    state.noise_work += noise
                    if kicked != 0.0 and state.has_tangent_map != 0:
                        kick_tangent_map(run, i, kicked)
                    moved = moved or jump != 0.0 or kicked != 0.0
                    continue
            pushed = swung(jump, b.inverse_length, restoring(point.angle, run.settings.is_linear))
            state.drive_work += b.inertia * pushed * (point.velocity + 0.5 * pushed)
            state.noise_work += b.inertia * kicked * (point.velocity + pushed + 0.5 * kicked)
            point.velocity += pushed + kicked
            moved = moved or pushed + kicked != 0.0
        return moved

    @part
    def change(run: Run, timetable: Timetable, output: Output, accumulators: Accumulators) -> None:
        """Start the drive's next segment or apply a kick, if due."""
        state, kick_times, following = run.state, timetable.kick_times, run.state.segment + 1
        segments = timetable.segments
        is_jump = following < len(segments) and segments[following].start <= run.t
        is_kick = state.kick < len(kick_times) and kick_times[state.kick] <= run.t
        if not (is_jump or is_kick):
            return
        if sensitive and is_jump:
            sensitivity.note_rates(run)
        moved = apply_jump_and_kick(run, timetable, is_jump, is_kick)
        is_slack = in_plane and (state.is_slack[0] != 0 or state.is_slack[count - 1] != 0)
        if is_jump:
            state.segment += 1
            enter_segment(run, timetable)
        if is_jump and is_slack:
            sensitivity.check_slack_segment(run)
        if is_jump and not is_slack:
            clear_matrix(run.jacobian, 4)
            jump = run.segment.jump
            for i in range(count):
                inverse_length = run.bodies[i].inverse_length
                curvature = swung(
                    jump, inverse_length, slope(run.now[i].angle, run.settings.is_linear)
                )
                write_matrix(run.jacobian, i, (1.0, 0.0, curvature, 1.0))
            if sensitive:
                balls.settle(run)
                one, other = run.now[0].angle, run.now[count - 1].angle
                is_linear = run.settings.is_linear
                restored = restoring(one, is_linear), restoring(other, is_linear)
                sensitivity.add_segment(run, output, jump, restored)
            report.matrix(run, accumulators, 2 * count, 0.0, 0.0)
        if is_kick:
            state.kick += 1
        balls.settle(run)
        state.t_base, state.steps = run.t, 0
        if is_slack:
            state.mode = SLACK
            resolve_contacts(run, output, accumulators)
        elif moved:
            closing = balls.gap_rate(run.now) * state.side
            rests = state.mode == sticking
            touches = rests or (state.mode == FLIGHT and state.touch != 0.0)
            if touches and closing > 0.0:
                run.side = state.side
                apply_impact(run, output, accumulators)
            elif rests and closing < 0.0:
                release(run, output, accumulators)

    @part
    def finish(run: Run, output: Output, stop: float) -> None:
        """Write the last samples, and the state back."""
        state, times = run.state, output.sample_times
        while run.t >= stop and state.sample < len(times) and times[state.sample] <= stop:
            if in_plane:
                write_place(run, output, run.now, count)
            if sensitive:
                evaluate_inside(run, 0.0)
                write_derivatives(run, output, 0.0)
            write_sample(run, output, run.now, count, 0.0, 0.0)
        for i in range(count):
            point = run.now[i]
            state.angle[i], state.velocity[i] = point.angle, point.velocity
            if in_plane:
                state.place[i, 0], state.place[i, 1] = point.x, point.y
                state.place[i, 2], state.place[i, 3] = point.vx, point.vy
        held = run.now[0].sign == 0.0 and run.now[count - 1].sign == 0.0
        state.rests = 1 if held or state.mode == sticking else 0
        state.contacts += run.rows
        state.total_steps += run.done

    def carry_on(
        run: Run,
        timetable: Timetable,
        output: Output,
        accumulators: Accumulators,
        stop: float,
        most_steps: int,
    ) -> int:
        begin(run, timetable)
        room = len(output.contact_times) - (SPARE_IN_PLANE if in_plane else SPARE_ROWS)
        if run.state.mode == UNSETTLED:
            settle_contact(run, output, accumulators)
        while run.t < stop and run.done < most_steps and run.rows < room:
            if in_plane and run.state.is_outside_model != 0:
                break
            run.done += 1
            set_goal(run, timetable, stop)
            if run.goal > run.t:
                plan(run)
                write_samples(run, output)
                note(run, accumulators)
                accept_step(run)
                apply(run, output, accumulators)
            if run.t >= run.goal:
                change(run, timetable, output, accumulators)
        finish(run, output, stop)
        rows: int = run.rows
        return rows

    return carry_on
