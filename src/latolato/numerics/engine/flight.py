"""Flight: the balls swing freely, up to a contact, a turning point or the goal."""

from __future__ import annotations

import math
from collections.abc import Callable

from latolato.numerics.callbacks import Accumulators
from latolato.numerics.contact_time import GAP, RATE
from latolato.numerics.engine.balls import Balls
from latolato.numerics.engine.doubts import GRAZING, GRAZING_DEPTH
from latolato.numerics.engine.modes import Mode
from latolato.numerics.engine.report import Report
from latolato.numerics.engine.sensitivity import Sensitivity
from latolato.numerics.engine.stiction import Stiction, add_compression
from latolato.numerics.engine.strings import NO_STRINGS, Strings
from latolato.numerics.engine.taut_step import (
    SHORTEST,
    TautStep,
    acceleration_with_drag,
)
from latolato.numerics.matrices import clear_matrix, write_matrix
from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.run_record import ANY_LENGTH, CONTACT, FLIGHT, SETTLE, TURN, Point, Run
from latolato.numerics.wall_contact import hop
from latolato.observables.hermite import quintic_bounds
from latolato.physics.damping import divergence

# A step is cut here when the gap's acceleration changes sign beside a contact, so that a dip in
# between is seen by one of its parts; and here when the balls begin to part from touch.
_PARTS, _FIRST_PART = 0.25, 0.25 / 16.0
# The rounding of a gap, per sum of the angles' sizes and a few rad.
_ROUNDING = 1e-15


def make_cut_at_turn(
    swing: TautStep, balls: Balls, stiction: Stiction, part: Part = as_it_stands
) -> Callable[..., None]:
    """Make the function ``(run, i)`` that ends a step where friction changes ball i's motion."""

    @part
    def cut_at_turn(run: Run, i: int) -> None:
        """Shorten a step where a ball turns, or where friction lets go of it."""
        s = math.inf
        if run.now[i].sign == 0.0:
            s = stiction.release_time(run, i, 0.0, run.now[i].angle, run.t, run.t_end) - run.t
        elif not run.end[i].velocity * run.now[i].sign >= 0.0:  # NaN: far beyond the turn
            s = swing.turn(run, i, ANY_LENGTH + i, run.length, run.now[i], run.end[i])
        if s <= run.length:
            balls.shorten(run, max(s, SHORTEST * run.t))
            run.event, run.ball = TURN, i
            balls.fly_by(run, run.length, run.end)

    return cut_at_turn


def make_flight(
    swing: TautStep, balls: Balls, stiction: Stiction, report: Report, strings: Strings,
    sensitivity: Sensitivity, count: int, part: Part = as_it_stands,
) -> Mode:  # fmt: skip
    """Make the mode of `count` balls in flight; their strings, if any, are taut."""
    two, await_slack, has_strings = count == 2, strings.await_slack, strings is not NO_STRINGS
    gap, gap_rate, fly_by = balls.gap, balls.gap_rate, balls.fly_by
    gap_course, doubt = balls.gap_course, sensitivity.doubt
    tension, cut_at_turn = balls.tension, make_cut_at_turn(swing, balls, stiction, part)

    @inlined(part)
    def plan(run: Run) -> None:
        """Plan a step, up to the first event in it."""
        balls.plan_length(run)
        is_still = run.now[0].sign == 0.0 and run.now[count - 1].sign == 0.0
        if is_still and run.settings.is_string == 0:  # nothing moves till then
            run.length, run.t_end, run.is_whole = run.goal - run.t, run.goal, 0
        if run.is_whole != 0:
            balls.fly(run)
        else:
            fly_by(run, run.length, run.end)
        soon = hop_time(run)
        if soon == 0.0:
            cut_beside_contact(run)
            if run.is_nonsmooth != 0:
                for i in range(count):
                    cut_at_turn(run, i)
        side = contact_ahead(run, soon)
        if side != 0.0:
            end_at_contact(run, side, soon)
        if has_strings and run.settings.is_string != 0:
            for i in range(count):
                await_slack(run, i)
        sum_up(run, run.end, run.t_end)

    @inlined(part)
    def hop_time(run: Run) -> float:
        """Duration of a rebound that is too small for the angle's digits, 0 if larger [s]."""
        touch, speed = run.state.touch, gap_rate(run.now)
        if speed * touch >= 0.0:
            return 0.0
        friction = run.bodies[0].coulomb
        if two:
            slowest = min(abs(run.now[0].velocity), abs(run.now[1].velocity))
            rubs = friction > 0.0 or run.bodies[1].coulomb > 0.0
            if rubs and slowest < 100.0 * abs(speed):
                return 0.0
            friction = 0.0
        soon, _ = hop(speed, -balls.separation_acceleration(run, touch, run.t, run.now), friction)
        return soon if soon < run.goal - run.t else 0.0

    @inlined(part)
    def cut_beside_contact(run: Run) -> None:
        """Shorten a step in which the gap's acceleration changes its sign and a contact may be."""
        # From touch without any rate the first dip has no sign that the ends would show.
        level = run.state.touch != 0.0 and gap_rate(run.now) == 0.0
        x0, v0, a0, x1, v1, a1 = gap_course(run, 0.0)
        dips = False
        if a0 * a1 < 0.0:
            lowest, highest = quintic_bounds(run.length, x0, v0, a0, x1, v1, a1)
            dips = lowest < run.settings.low or highest > run.settings.high
        if level or dips:
            balls.shorten(run, run.length * (_FIRST_PART if level else _PARTS))
            fly_by(run, run.length, run.end)

    @inlined(part)
    def contact_ahead(run: Run, soon: float) -> float:
        """Side of the contact that a step reaches or may dip into, 0 for none."""
        low, high = run.settings.low, run.settings.high
        if soon > 0.0:
            return run.state.touch
        begin, end = gap(run.now), gap(run.end)
        if end <= low:
            return -1.0
        if end >= high:
            return 1.0
        v0, v1 = gap_rate(run.now), gap_rate(run.end)
        if v0 < 0.0 < v1 and min(begin, end) - max(-v0, v1) * run.length <= low:
            return -1.0
        if v1 < 0.0 < v0 and max(begin, end) + max(v0, -v1) * run.length >= high:
            return 1.0
        return 0.0

    @part
    def end_at_contact(run: Run, side: float, soon: float) -> None:
        """End the step at the contact on this side, if it is met indeed."""
        wall = run.settings.low if side < 0.0 else run.settings.high
        if soon > 0.0:
            land(run, side, wall, soon)
            return
        if (gap(run.end) - wall) * side < 0.0 and not dips_beyond(run, side, wall):
            return
        begin = 0.0
        if run.state.touch == side:
            begin = balls.leave(run, wall, side, run.length)
            if begin == 0.0:
                stay(run, side, wall)
                return
        length = balls.locate(run, GAP, wall, begin, run.length)
        balls.shorten(run, length)
        # Rounding may have turned a grazing velocity round.
        balls.place(run, run.end, wall, side * abs(gap_rate(run.end)))
        run.event, run.side = CONTACT, side

    @part
    def dips_beyond(run: Run, side: float, wall: float) -> bool:
        """Whether the gap dips beyond a contact within the step, which then ends at the bottom."""
        length, was_whole, t_end = run.length, run.is_whole, run.t_end
        balls.shorten(run, balls.locate(run, RATE, 0.0, 0.0, length))
        depth = (gap(run.end) - wall) * side
        if abs(depth) < GRAZING_DEPTH:
            run.state.grazes += 1
        if depth > 0.0:
            return True
        if -depth < GRAZING_DEPTH:
            doubt(run, GRAZING)
        run.length, run.is_whole, run.t_end = length, was_whole, t_end
        fly_by(run, length, run.end)
        return False

    @part
    def land(run: Run, side: float, wall: float, soon: float) -> None:
        """Take a rebound that the angle's digits cannot show as a parabola in time."""
        before, friction = gap_rate(run.now), 0.0 if two else run.bodies[0].coulomb
        _, back = hop(before, -balls.separation_acceleration(run, side, run.t, run.now), friction)
        balls.shorten(run, soon)
        fly_by(run, soon, run.end)
        balls.place(run, run.end, wall, side * back)
        if not two:
            run.end[0].work, run.end[0].loss = 0.0, 0.5 * (before - back) * (before + back)
        run.event, run.side = CONTACT, side

    @part
    def stay(run: Run, side: float, wall: float) -> None:
        """Decide whether balls whose separation is below rounding begin to part or rest."""
        fly_by(run, run.length, run.end)
        tiny = 10.0 * _ROUNDING
        for i in range(count):
            tiny += _ROUNDING * abs(run.end[i].angle)
        run.keeps_touch = 1
        if gap_rate(run.end) * side >= 0.0 or abs(gap(run.end) - wall) > tiny:
            run.event, run.side = SETTLE, side
            balls.shorten(run, 0.0)
            for i in range(count):
                run.end[i] = run.now[i]
                run.end[i].work = run.end[i].loss = 0.0

    @inlined(part)
    def sum_up(run: Run, points: list[Point], t: float) -> None:
        """Add up work and loss of all balls, and find their tensions."""
        run.work, run.loss = 0.0, 0.0
        for i in range(count):
            b, point = run.bodies[i], points[i]
            run.work += b.inertia * point.work
            run.loss += b.inertia * point.loss
            if point.sign == 0.0:
                swing.write_pivot_motion(run, t, point)
            if run.settings.follows_tension != 0:
                point.tension = swing.tension(run, i, point)

    @part
    def evaluate_inside(run: Run, length: float) -> None:
        """Fly a part of the step."""
        fly_by(run, length, run.inside)
        if run.event == CONTACT:
            wall = run.settings.low if run.side < 0.0 else run.settings.high
            if (gap(run.inside) - wall) * run.side > 0.0:  # by a rounding
                balls.place(run, run.inside, wall, gap_rate(run.inside))
        run.work_inside, run.loss_inside = 0.0, 0.0
        for i in range(count):
            run.work_inside += run.bodies[i].inertia * run.inside[i].work
            run.loss_inside += run.bodies[i].inertia * run.inside[i].loss

    @part
    def note_compression(run: Run, i: int) -> None:
        """Add the compression of a rod; zeros of the tension are located, one in each half."""
        begin, end = run.now[i], run.end[i]
        state = run.state
        if begin.sign == 0.0:
            stiction.note_compression(run, i, begin.angle)
            return
        margin = tension.margin(run, i)
        if max(begin.tension, end.tension) < -margin:
            add_compression(state, i, begin.tension, end.tension, run.t, run.t_end)
            return
        if min(begin.tension, end.tension) >= margin:
            return
        half = 0.5 * run.length
        middle = tension.seen(run, i, half)
        left, right = begin.tension, middle
        for piece in range(2):
            s0 = half * piece
            if (left < 0.0) != (right < 0.0):
                root = tension.zero(run, i, s0, s0 + half, left, right)
                add_compression(state, i, left, math.copysign(0.0, left), run.t + s0, run.t + root)
                add_compression(state, i, right, right, run.t + root, run.t + s0 + half)
            else:
                add_compression(state, i, left, right, run.t + s0, run.t + s0 + half)
            left, right = middle, end.tension

    @inlined(part)
    def note(run: Run, accumulators: Accumulators) -> None:
        """Add up compression, and report the step and its tangent map."""
        for i in range(count):
            if run.settings.follows_tension != 0 and run.settings.is_string == 0:
                note_compression(run, i)
            a0, a1 = (
                acceleration_with_drag(run.now[i], run.bodies[i]),
                acceleration_with_drag(run.end[i], run.bodies[i]),
            )
            report.step(run, accumulators, i, a0, a1, 1.0 if run.now[i].sign == 0.0 else 0.0)
        if report.wants_tangent_map(run):
            note_matrix(run, accumulators)

    @part
    def write_tangent(run: Run, length: float) -> None:
        """Write the tangent map of a part of the step, one block a ball."""
        clear_matrix(run.jacobian, 4)
        is_whole = run.is_whole != 0 and length == run.length
        for i in range(count):
            table = i if is_whole else ANY_LENGTH + i
            write_matrix(run.jacobian, i, swing.tangent(run, i, table, run.now[i]))

    @part
    def note_matrix(run: Run, accumulators: Accumulators) -> None:
        """Report the tangent map of the step."""
        spread = 0.0
        if run.is_whole == 0:
            for i in range(count):
                swing.prepare_tangent(run, i, ANY_LENGTH + i, run.length, run.now[i])
        write_tangent(run, run.length)
        for i in range(count):
            b, begin, end = run.bodies[i], run.now[i], run.end[i]
            spread += divergence(run.length, end.angle - begin.angle, b)
            if begin.sign == 0.0:
                spread = -math.inf
        report.matrix(run, accumulators, 2 * count, run.length, spread)

    return Mode(FLIGHT, plan, evaluate_inside, note, write_tangent)
