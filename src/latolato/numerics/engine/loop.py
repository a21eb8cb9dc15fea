"""The loop: a mode plans a step, which is reported and taken, then the event there is applied."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from latolato.numerics.engine.apart import Apart, make_apart
from latolato.numerics.engine.balls import Balls, make_balls
from latolato.numerics.engine.book import follow_ledger, write_place, write_sample
from latolato.numerics.engine.compiling import Part, as_it_stands, inlined
from latolato.numerics.engine.events import Event, Output, make_events
from latolato.numerics.engine.fall import NO_FALL, Fall, make_fall
from latolato.numerics.engine.flight import make_flight
from latolato.numerics.engine.held import make_held
from latolato.numerics.engine.image import make_image
from latolato.numerics.engine.joint import make_joint
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.look import Look, make_look
from latolato.numerics.engine.modes import Mode
from latolato.numerics.engine.record import (
    CONTACT,
    FLIGHT,
    JOINT,
    NOTHING,
    RELEASE,
    REST,
    SLACK,
    UNSETTLED,
)
from latolato.numerics.engine.rest import make_rest
from latolato.numerics.engine.slack import make_slack
from latolato.numerics.engine.strings import NO_STRINGS, Strings, make_strings
from latolato.numerics.engine.swing import Swing, make_swing
from latolato.numerics.matrices import clear_matrix, write_matrix
from latolato.numerics.watch import Eyes, Watch
from latolato.physics.pendulum import swung

# As many rows of the contact table as one step may need: on rods, and on strings.
SPARE_ROWS, SPARE_IN_PLANE = 4, 20
# How far from a contact balls may be that touch [rad]: separations of two balls are rounded.
_TOUCH = 1e-12


class Timetable(NamedTuple):
    """When the drive or a kick changes something: arrays of shape (stretch,) or (kick,)."""

    stretches: Any
    kick_times: Any
    kick_sizes: Any  # rad/s, shape (ball, kick)


class Arguments(NamedTuple):
    """What an engine is given besides the run."""

    timetable: Timetable
    output: Output
    eyes: Eyes


@functools.cache
def empty_arguments(stretch: np.dtype[Any]) -> Arguments:
    """Return arrays of the kinds that an engine is given, without content."""
    floats, table, numbers = np.empty(0), np.empty((1, 0)), np.empty(0, dtype=np.int64)
    kicks = np.empty((2, 2))[:, :1]  # those of one point among many are not contiguous
    return Arguments(
        Timetable(np.empty(0, dtype=stretch), floats, kicks),
        Output(floats, table, floats, numbers, table),
        Eyes(floats, 0, 0),
    )


class Plane(NamedTuple):
    """What motions in the plane have besides."""

    fall: Fall
    apart: Apart
    strings: Strings


class Kit(NamedTuple):
    """What modes and events are built from; see `make_engine`."""

    swing: Swing
    balls: Balls
    look: Look
    laws: Laws
    balls_count: int
    part: Part
    plane: Plane | None = None


def usual_modes(kit: Kit) -> tuple[Mode, ...]:
    """Return the modes of exact contact."""
    swing, balls, look, laws, count, part, plane = kit
    held = make_held(swing, laws, part)
    strings = plane.strings if plane is not None else NO_STRINGS
    flight = make_flight(swing, balls, held, look, strings, count, part)
    lasting = make_joint(swing, balls, look, part) if count == 2 else make_rest(held, look, part)
    if plane is None:
        return flight, lasting
    fall, apart, strings = plane
    slack = make_slack(swing, fall, balls, held, apart, strings, look, count, part)
    return flight, lasting, slack


def usual_events(kit: Kit) -> tuple[Event, ...]:
    """Return the events of exact contact."""
    if kit.plane is not None:
        return kit.plane.strings.events
    return make_events(kit.swing, kit.balls, kit.look, kit.balls_count, kit.part)


def by_mode(modes: Sequence[Mode], what: str, part: Part) -> Callable[..., None]:
    """Return the function that calls what the present mode has under this name."""
    first, *others = modes
    function, number = getattr(first, what), first.number
    if not others:
        return function
    otherwise = by_mode(others, what, part)

    @part
    def chosen(run: Any, *rest: Any) -> None:
        if run.state.mode == number:
            function(run, *rest)
        else:
            otherwise(run, *rest)

    return chosen


def by_event(events: Sequence[Event], part: Part) -> Callable[..., None]:
    """Return the function that applies the present event."""
    first, *others = events
    function, number = first.apply, first.number
    otherwise = by_event(others, part) if others else None

    @part
    def chosen(run: Any, output: Output, eyes: Eyes) -> None:
        if run.event == number:
            function(run, output, eyes)
        elif otherwise is not None:
            otherwise(run, output, eyes)

    return chosen


def make_engine(
    laws: Laws,
    count: int,
    watch: Watch,
    part: Part = as_it_stands,
    *,
    make_modes: Callable[[Kit], tuple[Mode, ...]] = usual_modes,
    make_all_events: Callable[[Kit], tuple[Event, ...]] = usual_events,
) -> Callable[..., int]:
    """Return the function that carries the motion of `count` balls on.

    ``carry_on(run, timetable, output, eyes, stop, most_steps)`` begins where ``run.state`` is and
    stops at `stop` [s], after `most_steps` steps or when the contact table is full; it returns the
    rows written there and can be called again to go on.
    """
    two = count == 2
    lasting = JOINT if two else REST
    swing = make_swing(laws, part)
    in_plane = laws.plane is not None
    fall = make_fall(swing, part) if in_plane else NO_FALL
    balls = make_balls(swing, fall, laws, count, part)
    look = make_look(laws, watch, part)
    plane, strings, kick = None, NO_STRINGS, fall.kick
    if in_plane:
        apart, usual = make_apart(count, part), make_events(swing, balls, look, count, part)
        image = make_image(swing, fall, apart, look, count, part)
        strings = make_strings(swing, balls, apart, image, usual, count, part)
        plane = Plane(fall, apart, strings)
    loosen, jolt, throw_image = strings.loosen, strings.jolt, strings.throw_image
    kit = Kit(swing, balls, look, laws, count, part, plane)
    modes, events = make_modes(kit), make_all_events(kit)
    plan, note = by_mode(modes, "plan", part), by_mode(modes, "note", part)
    look_inside, apply = by_mode(modes, "look_inside", part), by_event(events, part)
    meet = next(event.apply for event in events if event.number == CONTACT)
    release = next(event.apply for event in events if event.number == RELEASE)
    restoring, slope = laws.restoring, laws.slope

    @part
    def begin(run: Any, timetable: Timetable) -> None:
        """Make everything of the step from the state."""
        state, h = run.state, run.settings.step
        run.stretch = timetable.stretches[state.stretch]
        run.t = state.t_base + state.steps * h
        run.rows = run.done = run.is_rough = 0
        for i in range(count):
            b = run.bodies[i]
            swing.prepare(run, i, i, h)
            if b.quadratic > 0.0 or b.coulomb > 0.0:
                run.is_rough = 1
            run.now[i].angle, run.now[i].velocity = state.angle[i], state.velocity[i]
            if in_plane:
                run.now[i].x, run.now[i].y = state.place[i, 0], state.place[i, 1]
                run.now[i].vx, run.now[i].vy = state.place[i, 2], state.place[i, 3]
        balls.settle(run)

    @part
    def settle_contact(run: Any, output: Output, eyes: Eyes) -> None:
        """Find out at time zero whether the balls touch, and whether they rest or strike then."""
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
                meet(run, output, eyes)

    @inlined(part)
    def aim(run: Any, timetable: Timetable, stop: float) -> None:
        """Find the next instant at which a step must end; no event is assumed before it."""
        state = run.state
        run.goal, run.event, run.keeps_touch = stop, NOTHING, 0
        if state.stretch + 1 < len(timetable.stretches):
            run.goal = min(run.goal, timetable.stretches[state.stretch + 1].start)
        if state.kick < len(timetable.kick_times):
            run.goal = min(run.goal, timetable.kick_times[state.kick])

    @inlined(part)
    def write_samples(run: Any, output: Output) -> None:
        """Write the samples that fall into the step."""
        times, state = output.sample_times, run.state
        while state.sample < len(times) and times[state.sample] < run.t_end:
            look_inside(run, times[state.sample] - run.t)
            if in_plane:
                write_place(run, output, run.inside, count)
            write_sample(run, output, run.inside, count, run.work_inside, run.loss_inside)

    @inlined(part)
    def take(run: Any) -> None:
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
    def shove(run: Any, timetable: Timetable, is_jump: bool, is_kick: bool) -> bool:
        """Let a jump of the pivot's velocity and a kick change velocities; return if they do."""
        state, moved = run.state, False
        jump = timetable.stretches[state.stretch + 1].jump if is_jump else 0.0
        for i in range(count):
            b, point = run.bodies[i], run.now[i]
            thrown = timetable.kick_sizes[i, state.kick] if is_kick else 0.0
            if in_plane and run.settings.is_string != 0:
                if jump != 0.0 and state.is_slack[i] == 0:
                    loosen(run, i)  # it tightens again where the jump pulls at it
                if state.is_slack[i] != 0:
                    worked, noise = kick(run, i, jump, thrown)
                    state.drive_work += worked
                    state.noise_work += noise
                    if thrown != 0.0 and state.has_image != 0:
                        throw_image(run, i, thrown)
                    moved = moved or jump != 0.0 or thrown != 0.0
                    continue
            pushed = swung(jump, b.coupling, restoring(point.angle, run.settings.is_linear))
            state.drive_work += b.inertia * pushed * (point.velocity + 0.5 * pushed)
            state.noise_work += b.inertia * thrown * (point.velocity + pushed + 0.5 * thrown)
            point.velocity += pushed + thrown
            moved = moved or pushed + thrown != 0.0
        return moved

    @part
    def change(run: Any, timetable: Timetable, output: Output, eyes: Eyes) -> None:
        """Start the drive's next stretch or apply a kick, if due."""
        state, kick_times, following = run.state, timetable.kick_times, run.state.stretch + 1
        stretches = timetable.stretches
        is_jump = following < len(stretches) and stretches[following].start <= run.t
        is_kick = state.kick < len(kick_times) and kick_times[state.kick] <= run.t
        if not (is_jump or is_kick):
            return
        moved = shove(run, timetable, is_jump, is_kick)
        is_slack = in_plane and (state.is_slack[0] != 0 or state.is_slack[count - 1] != 0)
        if is_jump:
            state.stretch += 1
            run.stretch = stretches[state.stretch]
        if is_jump and not is_slack:
            clear_matrix(run.jacobian, 4)
            for i in range(count):
                jump, coupling = run.stretch.jump, run.bodies[i].coupling
                bend = swung(jump, coupling, slope(run.now[i].angle, run.settings.is_linear))
                write_matrix(run.jacobian, i, (1.0, 0.0, bend, 1.0))
            look.matrix(run, eyes, 2 * count, 0.0, 0.0)
        if is_kick:
            state.kick += 1
        balls.settle(run)
        state.t_base, state.steps = run.t, 0
        if is_slack:
            state.mode = SLACK
            jolt(run, output, eyes)
        elif moved:
            closing = balls.gap_rate(run.now) * state.side
            rests = state.mode == lasting
            touches = rests or (state.mode == FLIGHT and state.touch != 0.0)
            if touches and closing > 0.0:
                run.side = state.side
                meet(run, output, eyes)
            elif rests and closing < 0.0:
                release(run, output, eyes)

    @part
    def finish(run: Any, output: Output, stop: float) -> None:
        """Write the last samples, and the state back."""
        state, times = run.state, output.sample_times
        while run.t >= stop and state.sample < len(times) and times[state.sample] <= stop:
            if in_plane:
                write_place(run, output, run.now, count)
            write_sample(run, output, run.now, count, 0.0, 0.0)
        for i in range(count):
            point = run.now[i]
            state.angle[i], state.velocity[i] = point.angle, point.velocity
            if in_plane:
                state.place[i, 0], state.place[i, 1] = point.x, point.y
                state.place[i, 2], state.place[i, 3] = point.vx, point.vy
        held = run.now[0].sign == 0.0 and run.now[count - 1].sign == 0.0
        state.rests = 1 if held or state.mode == lasting else 0
        state.contacts += run.rows
        state.total_steps += run.done

    def carry_on(
        run: Any, timetable: Timetable, output: Output, eyes: Eyes, stop: float, most_steps: int
    ) -> int:
        begin(run, timetable)
        room = len(output.contact_times) - (SPARE_IN_PLANE if in_plane else SPARE_ROWS)
        if run.state.mode == UNSETTLED:
            settle_contact(run, output, eyes)
        while run.t < stop and run.done < most_steps and run.rows < room:
            if in_plane and run.state.is_tangled != 0:
                break
            run.done += 1
            aim(run, timetable, stop)
            if run.goal > run.t:
                plan(run)
                write_samples(run, output)
                note(run, eyes)
                take(run)
                apply(run, output, eyes)
            if run.t >= run.goal:
                change(run, timetable, output, eyes)
        finish(run, output, stop)
        rows: int = run.rows
        return rows

    return carry_on
