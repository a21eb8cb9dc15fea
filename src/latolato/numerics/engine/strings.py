"""Strings: when they go slack and taut again, and what balls on them do when they meet.

A string pulls and never pushes. One that tightens throws its ball back with the restitution of the
string, or holds it; one that is taut when a ball is hit allows no motion outwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.core.scalar import formula
from latolato.numerics.callbacks import Accumulators
from latolato.numerics.engine.balls import Balls
from latolato.numerics.engine.doubts import CAPTURED, TOGETHER
from latolato.numerics.engine.events import Event
from latolato.numerics.engine.gaps import ROUNDING, THERE, Gaps
from latolato.numerics.engine.sensitivity import Sensitivity
from latolato.numerics.engine.slack_step import place_taut, radial_rate
from latolato.numerics.engine.tangent_map import TangentMap
from latolato.numerics.engine.taut_step import SHORTEST, STILL, TautStep
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.records import C_BALL, C_RADIAL, CONTACT_ROWS
from latolato.numerics.run_record import (
    CONTACT,
    FLIGHT,
    GO_SLACK,
    NOTHING,
    RELEASE,
    RETENSION,
    SETTLE,
    SLACK,
    Output,
    Point,
    Run,
)
from latolato.physics import contacts
from latolato.physics.pair import runs_through

# A tension this small is at the brink; then the motion a little later decides. Shares of the
# largest tension, and of the step.
_BRINK, _LITTLE = 1e-11, 1.0 / 64.0
# Strides in which a step is searched for a taut string in the other ball, and how precisely the
# time is found at which it gets there, as a share of the step.
_STRIDES, _SHARP = 8, 1e-12
# More impacts at one instant than string and ball can need; also the rows that they may fill.
MOST_AT_ONCE = 6
# Balls that part more slowly than this at the end of sticking contact press [rad/s^2].
_PRESS = 1e-6


class Strings(NamedTuple):
    """The functions of strings; see `make_strings`."""

    await_slack: Callable[..., None]
    stop_at_once: Callable[..., None]
    await_string_contact: Callable[..., None]
    release_string: Callable[..., None]
    resolve_contacts: Callable[..., None]
    follow_tangent_map: Callable[..., None]
    write_tangent: Callable[..., None]
    kick_tangent_map: Callable[..., None]
    events: tuple[Event, ...]


@formula
def _nothing(run: Run, *rest: Any) -> None:
    """Do nothing."""


# Of balls on rods.
NO_STRINGS = Strings(*(_nothing,) * 8, ())


def make_strings(
    swing: TautStep, balls: Balls, gaps: Gaps, tangent_map: TangentMap, sensitivity: Sensitivity,
    usual: tuple[Event, ...], count: int, part: Part = as_it_stands,
) -> Strings:  # fmt: skip
    """Make the functions of the strings of `count` balls; `usual` are the events on rods."""
    two = count == 2
    apply_impact = next(event.apply for event in usual if event.number == CONTACT)
    release = next(event.apply for event in usual if event.number == RELEASE)
    tension = balls.tension

    @part
    def stop_at_once(run: Run, event: int, i: int) -> None:
        """End the step where it begins, with an event."""
        balls.shorten(run, 0.0)
        run.event, run.ball, run.keeps_touch = event, i, 1
        for ball in range(count):
            run.end[ball] = run.now[ball]
            run.end[ball].work = run.end[ball].loss = 0.0

    @part
    def brink(run: Run, i: int) -> float:
        """Tension below which rounding decides its sign, over mass and length [1/s^2]."""
        result: float = _BRINK * (tension.margin(run, i) / run.settings.tension_dip)
        return result

    @part
    def await_slack(run: Run, i: int) -> None:
        """End the step where a taut string would have to push."""
        is_over = run.length == 0.0 and run.event != SETTLE
        if is_over or run.t < run.state.taut_until[i]:
            return
        left, low, high = swing.tension(run, i, run.now[i]), 0.0, run.length
        margin, least = tension.margin(run, i), brink(run, i)
        if left <= least:
            low = _LITTLE * high
            little = tension.seen(run, i, low)
            if left < -least or little <= 0.0:
                stop_at_once(run, GO_SLACK, i)
                return
            left = little
        right = swing.tension(run, i, run.end[i])
        if min(left, right) >= margin:
            return
        half = 0.5 * high
        middle = tension.seen(run, i, half)
        if middle < 0.0:
            right, high = middle, half
        elif right < 0.0:
            left, low = middle, half
        else:  # the lowest point of the parabola through all three
            curvature, s = left - 2.0 * middle + right, half
            if curvature > 0.0:
                s += 0.5 * half * (left - right) / curvature
            if not low < s < high:
                return
            right, high = tension.seen(run, i, s), s
            if right >= 0.0:
                return
        s = tension.zero(run, i, low, high, left, right)
        balls.shorten(run, max(s, SHORTEST * run.t))
        run.event, run.ball = GO_SLACK, i
        balls.fly_by(run, run.length, run.end)

    @part
    def place_beside(run: Run, points: list[Point], i: int) -> tuple[float, float]:
        """Place of the other ball's centre along a string and across it [m]."""
        one, other, length = points[i], points[1 - i], 1.0 / run.bodies[i].inverse_length
        along = (one.x * other.x + one.y * other.y) / length
        return along, (one.x * other.y - one.y * other.x) / length

    @part
    def runs_through_ball(run: Run, points: list[Point]) -> bool:
        """Whether a taut string runs through the other ball."""
        for i in range(2):
            if run.state.is_slack[i] == 0:
                along, tangential_part = place_beside(run, points, i)
                length, radius = 1.0 / run.bodies[i].inverse_length, run.settings.radius[1 - i]
                if runs_through(length, along, tangential_part, radius):
                    return True
        return False

    @part
    def clearance(run: Run, points: list[Point], i: int) -> tuple[float, float]:
        """Distance of a taut string from the other ball [m], and a bound of its rate [m/s]."""
        one, other, length = points[i], points[1 - i], 1.0 / run.bodies[i].inverse_length
        along, tangential_part = place_beside(run, points, i)
        distance = math.hypot(tangential_part, max(-along, along - length, 0.0))
        speed = abs(one.velocity) * math.hypot(other.x, other.y)
        return distance - run.settings.radius[1 - i], speed + math.hypot(other.vx, other.vy)

    @part
    def string_may_touch_ball(run: Run) -> bool:
        """Whether a taut string may touch the other ball in the step: most are too far.

        The way there and back is not longer than the path, which is taken as twice what the speeds
        at both ends make it, in case they are larger in between.
        """
        for i in range(2):
            if run.state.is_slack[i] == 0:
                begin, first = clearance(run, run.now, i)
                end, last = clearance(run, run.end, i)
                if begin + end <= (first + last) * run.length:
                    return True
        return False

    @part
    def await_string_contact(run: Run) -> None:
        """End the step where a taut string meets the other ball, which is not described.

        A ball that only brushes the string may be past it at the end of the step, so the step is
        looked at in strides, and from the first that shows the string in the ball on halved ones.
        """
        passes = run.settings.high == math.inf  # all through all
        if passes or not string_may_touch_ball(run):
            return
        low, stride, collides = 0.0, run.length / _STRIDES, False
        least = max(SHORTEST * run.t, _SHARP * run.length)
        while stride > least and low < run.length - 0.5 * stride:
            balls.fly_by(run, low + stride, run.inside)
            if runs_through_ball(run, run.inside):
                collides = True
            else:
                low += stride
            if collides:
                stride *= 0.5
        if not collides:
            return
        balls.shorten(run, max(low + 2.0 * stride, SHORTEST * run.t))
        balls.fly_by(run, run.length, run.end)
        run.event, run.state.is_outside_model = NOTHING, 1

    @part
    def write_row(run: Run, output: Output, kind: int, ball: int, before: Any) -> None:
        """Write a row of the contact table; `before` has velocities around and along."""
        row, values = run.rows, output.contact_values
        output.contact_times[row], output.contact_kinds[row] = run.t, kind
        for i in range(count):
            values[i, row], values[count + i, row] = before[i], run.now[i].velocity
            values[C_RADIAL + i, row] = before[2 + i]
            outward = radial_rate(run.now[i]) if run.state.is_slack[i] != 0 else 0.0
            values[C_RADIAL + count + i, row] = outward
        values[C_BALL, row] = ball
        sensitivity.write_delays(run, output, CONTACT_ROWS)
        run.rows += 1

    @part
    def velocities(run: Run) -> tuple[float, float, float, float]:
        """Angular velocities [rad/s] and velocities along the strings [m/s], of both balls."""
        other = count - 1
        one_out = radial_rate(run.now[0]) if run.state.is_slack[0] != 0 else 0.0
        other_out = radial_rate(run.now[other]) if run.state.is_slack[other] != 0 else 0.0
        return run.now[0].velocity, run.now[other].velocity, one_out, other_out

    @part
    def release_string(run: Run, i: int) -> None:
        """Make a taut string slack; its ball stays where it is."""
        tangent_map.begin(run)
        run.state.is_slack[i] = run.state.leaves[i] = 1
        place_taut(run.now[i], 1.0 / run.bodies[i].inverse_length)

    @part
    def tighten(run: Run, output: Output, i: int, holds: bool) -> None:
        """Apply the impulse of a string that tightens.

        The velocity along the string is reversed times the string's restitution, that around the
        pivot stays. The ball is kept at the string's length if it is so slow that a pull ends the
        bounce within rounding, or in any case if `holds`.
        """
        state, settings, point, b = run.state, run.settings, run.now[i], run.bodies[i]
        before, length = velocities(run), 1.0 / b.inverse_length
        outward, e = radial_rate(point), settings.string_restitution
        pulls = swing.tension(run, i, point) > 0.0
        slow = settings.rest_speed if pulls else STILL
        if holds or outward <= slow * length:
            e = 0.0
        tangent_map.tighten(run, i, e)
        mass = b.inertia * b.inverse_length * b.inverse_length
        state.retension_loss += 0.5 * mass * outward * outward * (1.0 - e * e)
        state.string_impulse = max(state.string_impulse, mass * outward * (1.0 + e))
        around = length * point.velocity
        place_taut(point, length)
        point.velocity = around / length
        state.leaves[i] = 1
        if e > 0.0:
            point.vx -= e * outward * point.x / length
            point.vy -= e * outward * point.y / length
        else:
            state.is_slack[i] = state.leaves[i] = 0
        write_row(run, output, contacts.TAUT, i + 1 if two else 0, before)

    @part
    def collide_in_plane(run: Run, output: Output, closing: float, captures: bool) -> None:
        """Apply the impulse of a collision that involves a slack string.

        A ball on a taut string that the impulse would push inwards loses its string at once and
        counts as free. With the unit vector n along the line of centres each ball then yields by
        ``(1 - (n r)^2)/m`` per impulse, r the unit vector along a taut string (zero if slack):
        the string takes the component along itself. The impulse is ``(1 + e) closing / yields``.
        """
        state, settings, before = run.state, run.settings, velocities(run)
        e = 0.0 if captures else settings.restitution
        nx, ny, _ = gaps.line_of_centres(run.now)
        mobility, loosened = 0.0, -1  # the gap's rate per impulse [1/kg]
        for i in range(count):
            point, b = run.now[i], run.bodies[i]
            mass, sign = b.inertia * b.inverse_length * b.inverse_length, 1.0 - 2.0 * i
            outward = sign * (nx * point.x + ny * point.y) * b.inverse_length
            if state.is_slack[i] == 0 and outward < 0.0:
                release_string(run, i)
                loosened = i
            share = 1.0 if state.is_slack[i] != 0 else 1.0 - outward * outward
            mobility += share / mass
        tangent_map.collide(run, e)
        impulse = (1.0 + e) * closing / mobility
        for i in range(count):
            point, b = run.now[i], run.bodies[i]
            mass, sign = b.inertia * b.inverse_length * b.inverse_length, 1.0 - 2.0 * i
            px, py = sign * impulse * nx, sign * impulse * ny
            if state.is_slack[i] != 0:
                point.vx += px / mass
                point.vy += py / mass
                # Seen from the pivot, what lies beside the string turns the ball.
                squared = max(point.x * point.x + point.y * point.y, 1e-300)
                point.velocity = (point.x * point.vy - point.y * point.vx) / squared
            else:
                point.velocity += (px * -point.y + py * point.x) / b.inertia
                pulled = (px * point.x + py * point.y) * b.inverse_length
                state.string_impulse = max(state.string_impulse, pulled)
                place_taut(point, 1.0 / b.inverse_length)
        lost = 0.5 * closing * closing / mobility * (1.0 - e * e)
        if captures:
            state.capture_loss += lost
            sensitivity.doubt(run, CAPTURED)
        else:
            state.impact_loss += lost
        kind = contacts.TOP if gaps.side(run.now) > 0.0 else contacts.BOTTOM
        write_row(run, output, contacts.REST if captures else kind, 0, before)
        if loosened >= 0:
            write_row(run, output, contacts.SLACK, loosened + 1 if two else 0, velocities(run))

    @part
    def still_presses(run: Run) -> bool:
        """Whether balls after a capture press against each other."""
        length = 1e-3 * run.settings.step
        balls.fly_by(run, length, run.inside)
        gap, _ = gaps.gap(run, run.inside)
        return gap < -ROUNDING / run.bodies[0].inverse_length

    @part
    def is_simultaneous(run: Run) -> bool:
        """Whether balls meet just where a string tightens: rounding decides which is first."""
        gap, rate = gaps.gap(run, run.now)
        slow = -run.settings.rest_speed / run.bodies[0].inverse_length
        if gap > THERE / run.bodies[0].inverse_length or not (two or rate < slow):
            return False
        for i in range(count):
            spare_length, slower = gaps.spare_length(run, i, run.now[i])
            is_there = spare_length <= THERE / run.bodies[i].inverse_length
            if run.state.is_slack[i] != 0 and is_there and slower < slow:
                return True
        return False

    @part
    def resolve_instant(run: Run, output: Output) -> None:
        """Do what happens where a string tightens or balls meet: strings first, then balls.

        What two balls on taut strings do that a push would only tighten is left to the rods' rule.
        """
        state, length = run.state, 1.0 / run.bodies[0].inverse_length
        state.touch = 0.0
        balls.settle(run)
        if state.has_tangent_map != 0 and is_simultaneous(run):
            tangent_map.mark_undefined(run)
            sensitivity.doubt(run, TOGETHER)
        for _ in range(MOST_AT_ONCE):
            is_over = True
            for i in range(count):
                spare_length, slower = gaps.spare_length(run, i, run.now[i])
                is_there = spare_length <= THERE / run.bodies[i].inverse_length
                if state.is_slack[i] != 0 and is_there and slower < 0.0:
                    tighten(run, output, i, False)
                    is_over = False
            gap, rate = gaps.gap(run, run.now)
            if gap <= THERE * length:
                state.touch = state.side = gaps.side(run.now)
                is_slack = state.is_slack[0] != 0 or state.is_slack[count - 1] != 0
                if rate < 0.0 and (is_slack or not gaps.is_tensile(run, run.now)):
                    slow = -rate <= 2.0 * run.settings.rest_speed * length
                    captures = slow and run.settings.restitution < 1.0
                    collide_in_plane(run, output, -rate, captures)
                    balls.settle(run)
                    if captures and still_presses(run):
                        state.is_outside_model = 1
                    is_over = False
            if is_over:
                break
        is_slack = state.is_slack[0] != 0 or state.is_slack[count - 1] != 0
        state.mode = SLACK if is_slack else FLIGHT
        balls.settle(run)

    @part
    def let_slack(run: Run, output: Output, i: int) -> None:
        """Make the string of a ball slack in flight, with its row of the table."""
        before = velocities(run)
        tangent_map.reach_slack(run, i)
        release_string(run, i)
        write_row(run, output, contacts.SLACK, i + 1 if two else 0, before)
        run.state.mode = SLACK
        balls.settle(run)

    @part
    def go_slack(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Event: a string goes slack at the end of a step."""
        let_slack(run, output, run.ball)

    @part
    def apply_impact_taut(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Apply an impact as on rods, and keep the largest impulse that it pulls at the strings."""
        before = run.now[0].velocity
        apply_impact(run, output, accumulators)
        nx, ny, _ = gaps.line_of_centres(run.now)
        one, b = run.now[0], run.bodies[0]
        around = abs(ny * one.x - nx * one.y)
        if run.settings.is_string != 0 and around > 0.0:
            impulse = b.inertia * abs(one.velocity - before) / around
            for i in range(count):
                point, inverse_length = run.now[i], run.bodies[i].inverse_length
                pulled = impulse * abs(nx * point.x + ny * point.y) * inverse_length
                run.state.string_impulse = max(run.state.string_impulse, pulled)

    @part
    def continue_as_on_rods(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Go on as on rods once all strings are taut, with an impact if the balls still touch."""
        state, settings = run.state, run.settings
        gap = balls.gap(run.now)
        if two and not settings.low - THERE <= gap <= settings.high + THERE:
            state.is_outside_model = 1  # they have changed places
        elif state.touch != 0.0 and balls.gap_rate(run.now) * state.touch >= 0.0:
            wall = settings.low if state.touch < 0.0 else settings.high
            balls.place(run, run.now, wall, balls.gap_rate(run.now))
            run.side = state.touch
            apply_impact_taut(run, output, accumulators)

    @part
    def resolve_contacts(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Resolve all contacts of strings and balls that a change of velocities brings about."""
        state = run.state
        resolve_instant(run, output)
        if state.touch == 0.0 or balls.gap_rate(run.now) * state.touch < 0.0:
            for i in range(count):
                pushes = swing.tension(run, i, run.now[i]) < -brink(run, i)
                if state.is_slack[i] == 0 and pushes and run.t >= state.taut_until[i]:
                    let_slack(run, output, i)
        tangent_map.leave_event(run)
        if state.mode == FLIGHT:
            tangent_map.finish(run, accumulators)
            continue_as_on_rods(run, output, accumulators)

    @part
    def retension(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Event: a string reaches its full length, perhaps where its ball meets the other one."""
        balls.settle(run)
        tangent_map.reach_full_length(run)
        tangent_map.find_delays(run, run.ball)
        _, slower = gaps.spare_length(run, run.ball, run.now[run.ball])
        if slower >= 0.0:
            tighten(run, output, run.ball, True)
        resolve_contacts(run, output, accumulators)

    @part
    def apply_impact_in_plane(run: Run, output: Output, accumulators: Accumulators) -> None:
        """Event: balls meet, as on rods if the impulse only pulls at taut strings."""
        balls.settle(run)
        taut = run.state.mode != SLACK and gaps.is_tensile(run, run.now)
        if taut or run.settings.is_string == 0:
            apply_impact_taut(run, output, accumulators)
            return
        rows = run.rows
        tangent_map.reach_contact(run)
        tangent_map.find_delays(run, 0)
        resolve_contacts(run, output, accumulators)
        if run.state.mode == SLACK and run.rows == rows:
            # They press against each other, which slack strings allow.
            run.state.is_outside_model = 1

    @part
    def release_sticking(run: Run, output: Output, accumulators: Accumulators) -> None:
        """End sticking contact. Where balls still press, a string let go: that is not described."""
        presses = run.settings.is_string != 0 and two
        if presses and balls.separation_acceleration(run, run.state.side, run.t, run.now) < -_PRESS:
            run.state.is_outside_model = 1
        release(run, output, accumulators)

    kept = tuple(e for e in usual if e.number not in (CONTACT, RELEASE))
    events = (
        Event(CONTACT, apply_impact_in_plane), Event(RELEASE, release_sticking), *kept,
        Event(GO_SLACK, go_slack), Event(RETENSION, retension),
    )  # fmt: skip
    return Strings(
        await_slack=await_slack,
        stop_at_once=stop_at_once,
        await_string_contact=await_string_contact,
        release_string=release_string,
        resolve_contacts=resolve_contacts,
        follow_tangent_map=tangent_map.step,
        write_tangent=tangent_map.write_tangent,
        kick_tangent_map=tangent_map.kick,
        events=events,
    )
