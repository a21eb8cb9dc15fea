"""Slack: at least one ball's string is slack, and that ball moves freely in the plane."""

from __future__ import annotations

import math

from latolato.core.scalar import formula
from latolato.numerics.callbacks import Accumulators
from latolato.numerics.contact_time import GAP, RATE, make_root
from latolato.numerics.engine.balls import Balls
from latolato.numerics.engine.flight import make_cut_at_turn
from latolato.numerics.engine.gaps import ROUNDING, THERE, Gaps
from latolato.numerics.engine.modes import Mode
from latolato.numerics.engine.report import Report
from latolato.numerics.engine.slack_step import SlackStep, place_taut, radial_rate
from latolato.numerics.engine.stiction import Stiction
from latolato.numerics.engine.strings import Strings
from latolato.numerics.engine.taut_step import SHORTEST, TautStep, acceleration_with_drag
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import CONTACT, RETENSION, SLACK, Point, Run
from latolato.numerics.wall_contact import SMALLEST_HOP
from latolato.observables.hermite import quintic_bounds

# What a search looks at: a string's spare length or the gap between balls, or its rate.
_STRING, _GAP = 0, 1
# A step is cut here where a string may tighten and loosen unseen.
_PARTS = 0.25
# The least part of a step to which quadratic drag near rest shortens it.
_LEAST_SHARE = 1.0 / 32.0
# A string pulls where its tension would be more than this share of the largest one.
_PULLS = 1e-9


@formula
def place_at_end(point: Point, length: float, outward: float) -> None:
    """Put a ball on the end of its string, with this radial velocity [m/s]."""
    place_taut(point, length)
    point.vx += outward * point.x / length
    point.vy += outward * point.y / length


def make_slack(
    swing: TautStep, fall: SlackStep, balls: Balls, stiction: Stiction, gaps: Gaps,
    strings: Strings, report: Report, count: int, part: Part = as_it_stands,
) -> Mode:  # fmt: skip
    """Make the mode of `count` balls of which at least one has a slack string."""
    await_slack, stop_at_once, await_string_contact = strings[:3]
    follow_tangent_map, write_tangent = strings.follow_tangent_map, strings.write_tangent
    tension, cut_at_turn = balls.tension, make_cut_at_turn(swing, balls, stiction, part)
    slopes, acceleration, spare_length_of, gap_of = (
        fall.slopes,
        fall.acceleration,
        gaps.spare_length,
        gaps.gap,
    )

    @part
    def measured(run: Run, points: list[Point], what: int, i: int) -> tuple[float, float]:
        """Guard of an event, a spare length or the gap [m], and its rate [m/s]."""
        if what == _STRING:
            value, rate = spare_length_of(run, i, points[i])
            return value, rate
        value, rate = gap_of(run, points)
        return value, rate

    @part
    def curvature(run: Run, points: list[Point], what: int, i: int) -> float:
        """Acceleration of a guard [m/s^2].

        The second derivative of a distance r: ``(|x cross v|^2/r^2 + x a)/r``.
        """
        point, (ax, ay) = points[i], acceleration(run, i, points[i])
        x, y, vx, vy = point.x, point.y, point.vx, point.vy
        if what == _GAP:
            if count == 1:
                return ax
            other, (bx, by) = points[1], acceleration(run, 1, points[1])
            x, y, vx, vy = x - other.x, y - other.y, vx - other.vx, vy - other.vy
            ax, ay = ax - bx, ay - by
        distance, turned = math.hypot(x, y), x * vy - y * vx
        if distance == 0.0:
            return 0.0
        second = (turned * turned / (distance * distance) + x * ax + y * ay) / distance
        return second if what == _GAP else -second

    @part
    def course(run: Run, what: int, i: int) -> tuple[float, float, float, float, float, float]:
        """A guard, its rate and its acceleration, at both ends of the step."""
        begin, begin_rate = measured(run, run.now, what, i)
        end, end_rate = measured(run, run.end, what, i)
        a0, a1 = curvature(run, run.now, what, i), curvature(run, run.end, what, i)
        return begin, begin_rate, a0, end, end_rate, a1

    @part
    def value_at(run: Run, s: float, what: int, i: int) -> tuple[float, float, float]:
        """A guard, its rate and its acceleration s seconds into the step."""
        balls.fly_by(run, s, run.inside)
        value, rate = measured(run, run.inside, what, i)
        return value, rate, curvature(run, run.inside, what, i)

    find_end = make_root(value_at, part)

    @part
    def leave_time(run: Run, high: float, what: int, i: int) -> float:
        """A length of a step after which a guard that begins at zero is positive, or 0 [s]."""
        s = 0.5 * high
        for _ in range(50):
            value, _, _ = value_at(run, s, what, i)
            if value > 0.0:
                return s
            s *= 0.5
        return 0.0

    @part
    def await_end(run: Run, what: int, i: int, leaves: bool, event: int) -> None:
        """End the step where a string runs out of spare length, or where balls meet.

        What begins at zero leaves it first, like the third power of the time from a string; what
        does not get away from zero by more than rounding is no event.
        """
        least = -ROUNDING / run.bodies[i].inverse_length if leaves else 0.0
        motion = course(run, what, i)
        begin, begin_rate, _, end, end_rate, _ = motion
        high = run.length
        if end >= least:
            reach = max(-begin_rate, end_rate) * run.length
            if not begin_rate < 0.0 < end_rate or min(begin, end) - reach > 0.0:
                return
            high = balls.guess(RATE, 0.0, high, 1.0, run.length, motion)
            lowest, _, _ = value_at(run, high, what, i)
            if lowest >= least:
                return
        low = 0.0
        if leaves:
            low = leave_time(run, high, what, i)
            if low == 0.0:
                if what == _STRING:  # it opens by less than can be seen: it is taut
                    run.state.taut_until[i] = run.t + _PARTS * run.length
                stop_at_once(run, event, i)
                return
        s = 0.0
        if begin > 0.0 or leaves:
            s = balls.guess(GAP, low, high, -1.0, run.length, motion)
            s, missing = find_end(run, s, low, high, -1.0, what, i)
            s += missing
        balls.shorten(run, max(s, SHORTEST * run.t))
        run.event, run.ball = event, i
        balls.fly_by(run, run.length, run.end)

    @part
    def pulls(run: Run, i: int, point: Point) -> bool:
        """Whether a string would pull here, by more than rounding."""
        least = _PULLS * tension.margin(run, i) / run.settings.tension_dip
        result: bool = swing.tension(run, i, point) > least
        return result

    @part
    def bounce_time(run: Run, i: int) -> float:
        """Duration of a bounce off a string that is too small for the digits, or 0 [s]."""
        state, point, length = run.state, run.now[i], 1.0 / run.bodies[i].inverse_length
        if state.is_slack[i] == 0 or state.leaves[i] == 0:
            return 0.0
        inward, pull = -radial_rate(point), length * swing.tension(run, i, point)
        # The ball of a string that just went slack moves inwards by some roundings.
        if inward <= 0.0 or not pulls(run, i, point):
            return 0.0
        if inward * inward >= 2.0 * pull * SMALLEST_HOP * length:
            return 0.0
        return 2.0 * inward / pull

    @part
    def bends_beside_end(run: Run, i: int) -> bool:
        """Whether the pull on a ball changes its sign in the step near its string's end.

        Then it may run out of spare length and come back, which the ends of the step do not show.
        """
        if run.state.is_slack[i] == 0:
            return False
        if pulls(run, i, run.now[i]) == pulls(run, i, run.end[i]):
            return False
        lowest, _ = quintic_bounds(run.length, *course(run, _STRING, i))
        return lowest < -THERE / run.bodies[i].inverse_length

    @part
    def steadied(run: Run, i: int) -> float:
        """Share of the step within which quadratic drag stays smooth.

        Quadratic drag has a kink at rest: past it the velocity must change by less than the least
        speed in the step, or by a little.
        """
        b, begin, end = run.bodies[i], run.now[i], run.end[i]
        if b.quadratic == 0.0 or run.state.is_slack[i] == 0:
            return 1.0
        ax, ay = end.vx - begin.vx, end.vy - begin.vy
        change = math.hypot(ax, ay)
        least = min(math.hypot(begin.vx, begin.vy), math.hypot(end.vx, end.vy))
        if begin.vx * ax + begin.vy * ay < 0.0 < end.vx * ax + end.vy * ay:
            least = abs(begin.vx * end.vy - begin.vy * end.vx) / change
        return 1.0 if change <= least else max(least / change, _LEAST_SHARE)

    @part
    def plan(run: Run) -> None:
        """Plan a step of slack and taut balls, up to the first event in it."""
        balls.plan_length(run)
        soon, bounced = math.inf, 0
        for i in range(count):
            duration = bounce_time(run, i)
            if 0.0 < duration < soon:
                soon, bounced = duration, i
        is_brief = soon < _PARTS * run.length
        if is_brief:
            balls.shorten(run, max(soon, SHORTEST * run.t))
        balls.fly_by(run, run.length, run.end)
        for i in range(count):
            share = 1.0 if is_brief else steadied(run, i)
            if not is_brief and bends_beside_end(run, i):
                share = min(share, _PARTS)
            if share < 1.0:
                balls.shorten(run, share * run.length)
                balls.fly_by(run, run.length, run.end)
        if is_brief:
            back = max(radial_rate(run.end[bounced]), 0.0)
            place_at_end(run.end[bounced], 1.0 / run.bodies[bounced].inverse_length, back)
            run.event, run.ball = RETENSION, bounced
        for i in range(count):
            if run.state.is_slack[i] == 0:
                if run.is_nonsmooth != 0:
                    cut_at_turn(run, i)
                await_slack(run, i)
            elif not (is_brief and i == bounced):
                await_end(run, _STRING, i, run.state.leaves[i] != 0, RETENSION)
        await_end(run, _GAP, 0, run.state.touch != 0.0, CONTACT)
        if run.state.touch != 0.0 and abs(gap_of(run, run.end)[0]) <= (
            THERE / run.bodies[0].inverse_length
        ):
            run.keeps_touch = 1
        if count == 2:
            await_string_contact(run)
        sum_up(run)

    @part
    def sum_up(run: Run) -> None:
        """Add up work and loss of all balls."""
        run.work, run.loss = 0.0, 0.0
        for i in range(count):
            run.work += run.bodies[i].inertia * run.end[i].work
            run.loss += run.bodies[i].inertia * run.end[i].loss

    @part
    def evaluate_inside(run: Run, length: float) -> None:
        """Fly a part of the step."""
        balls.fly_by(run, length, run.inside)
        run.work_inside, run.loss_inside = 0.0, 0.0
        for i in range(count):
            run.work_inside += run.bodies[i].inertia * run.inside[i].work
            run.loss_inside += run.bodies[i].inertia * run.inside[i].loss

    @part
    def note(run: Run, accumulators: Accumulators) -> None:
        """Add up the time that strings are slack, and report the step."""
        state = run.state
        for i in range(count):
            begin, end = run.now[i], run.end[i]
            if state.is_slack[i] == 0:
                held = 1.0 if begin.sign == 0.0 else 0.0
                a0, a1 = (
                    acceleration_with_drag(begin, run.bodies[i]),
                    acceleration_with_drag(end, run.bodies[i]),
                )
                report.step(run, accumulators, i, a0, a1, held)
                continue
            if math.isnan(state.slack_start[i]):
                state.slack_start[i] = run.t
            state.slack_time[i] += run.t_end - run.t
            if spare_length_of(run, i, end)[0] > THERE / run.bodies[i].inverse_length:
                state.leaves[i] = 0
            a0, e0, p0 = slopes(run, i, begin)
            a1, e1, p1 = slopes(run, i, end)
            report.show(run, accumulators, i, (a0, a1), (e0, e1), (p0, p1), 0.0)
        follow_tangent_map(run)

    return Mode(SLACK, plan, evaluate_inside, note, write_tangent)
