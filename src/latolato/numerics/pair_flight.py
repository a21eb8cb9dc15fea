"""Two balls between events: steps of both, searches on their separation, impact, joint motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.contact_time import MOST_TRIALS, is_located, next_trial
from latolato.numerics.engine.held import slack_share
from latolato.numerics.engine.swing import STILL, freed, tension_at
from latolato.numerics.flight import (
    ANGLE,
    Flight,
    Law,
    Method,
    Part,
    Point,
    prepare,
)
from latolato.numerics.records import SLACK_FIRST, SLACK_TOTAL
from latolato.physics.contacts import pair_impact
from latolato.physics.pair import contact_torque, radial_push
from latolato.scalar import formula

# Columns of a point of the motion and of a step's result; rows are ball 1, ball 2, both as one.
X, V, FORCE, DRIVEN, LIFT, GAIN, LOSS = range(7)
JOINT = 2
STUCK = 0.0


@formula
def write_pair_contact(
    times: Any, kinds: Any, values: Any, row: int, t: float, kind: int, before: Any, after: Any
) -> int:
    """Write one row of the contact table and return the next row's number."""
    times[row] = t
    kinds[row] = kind
    values[0, row], values[1, row] = before
    values[2, row], values[3, row] = after
    return row + 1


@formula
def add_slack(state: Any, ball: int, left: float, right: float, t: float, end: float) -> None:
    """Add the slack of an interval in which the tension is nearly linear."""
    share = slack_share(left, right)
    state[SLACK_TOTAL + 2 * ball] += share * (end - t)
    if share > 0.0 and math.isnan(state[SLACK_FIRST + 2 * ball]):
        state[SLACK_FIRST + 2 * ball] = t if left < 0.0 else end - share * (end - t)


class Pair(NamedTuple):
    """What two balls obey: signs of ball 1, ball 2 and both as one; laws and methods likewise.

    The fourth law is that of the body which both form at the top, the third at the bottom.
    """

    signs: Any
    laws: tuple[Law, Law, Law, Law]
    methods: tuple[Method, Method, Method]


class PairFlight(NamedTuple):
    """The functions of two balls; see `make_pair_flight`."""

    free_force: Callable[..., Any]
    go: Callable[..., Any]
    go_by: Callable[..., Any]
    both: Callable[..., Any]
    locate_gap: Callable[..., Any]
    leave_gap: Callable[..., Any]
    parting: Callable[..., Any]
    strike: Callable[..., Any]
    settle_signs: Callable[..., Any]
    join: Callable[..., Any]
    split: Callable[..., Any]
    joint_margin: Callable[..., Any]
    joint_pulls: Callable[..., Any]
    dip: Callable[..., Any]


@formula
def point_of(t: float, q: Any, row: int) -> Point:
    """Return a row of the motion as the point of one ball."""
    return Point(t, q[row, X], q[row, V], q[row, FORCE], q[row, DRIVEN], q[row, LIFT])


def make_pair_flight(
    flight: Flight,
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    compile_part: Part | None = None,
) -> PairFlight:
    """Return the functions of two balls whose single flights are `flight`.

    Points of the motion are rows of an array ``q`` (ball 1, ball 2, both as one body) with the
    columns above; steps write into an array ``r`` of the same shape.
    """
    part: Part = compile_part or (lambda function: function)
    force, advance = flight.force, flight.advance

    @part
    def free_force(t: float, angle: float, law: Law) -> float:
        """Return the angular acceleration without drag."""
        lift = acceleration(t, law.p)
        return -(law.gravity + lift) * law.body.coupling * restoring(angle)

    @part
    def go(row: int, t: float, q: Any, r: Any, sign: float, table: Any, law: Law) -> None:
        """Advance one row of `q` by a prepared step into `r`."""
        if sign == STUCK:
            r[row, X] = q[row, X]
            r[row, LIFT] = q[row, LIFT]
            r[row, V] = r[row, FORCE] = r[row, DRIVEN] = r[row, GAIN] = r[row, LOSS] = 0.0
            return
        x, v, gain, loss, a, driven, lift = advance(point_of(t, q, row), sign, table, law)
        r[row, X], r[row, V], r[row, FORCE], r[row, DRIVEN] = x, v, a, driven
        r[row, LIFT], r[row, GAIN], r[row, LOSS] = lift, gain, loss

    @part
    def go_by(
        s: float, row: int, t: float, q: Any, r: Any, sign: float, method: Method, law: Law
    ) -> None:
        """Advance one row of `q` by a step of any length s into `r`."""
        prepare(method, s, law.body.rate)
        go(row, t, q, r, sign, method.table, law)

    @part
    def both(s: float, t: float, q: Any, r: Any, pair: Pair) -> None:
        """Advance both balls by a step of length s."""
        for i in range(2):
            go_by(s, i, t, q, r, pair.signs[i], pair.methods[i], pair.laws[i])

    @part
    def locate_gap(
        what: int, target: float, low: float, high: float, t: float, q: Any, r: Any, pair: Pair
    ) -> float:
        """Return the step length at which the separation, or its rate, reaches `target`."""
        column, next_column = (X, V) if what == ANGLE else (V, FORCE)
        both(high, t, q, r, pair)
        value = r[0, column] - r[1, column] - target
        if value == 0.0:
            return high
        far = 1.0 if value > 0.0 else -1.0
        span = high - low
        slope = r[0, next_column] - r[1, next_column]
        s = high - value / slope if slope != 0.0 else 0.5 * (low + high)
        if not low < s < high:
            s = 0.5 * (low + high)
        move = span
        for _ in range(MOST_TRIALS):
            both(s, t, q, r, pair)
            value = r[0, column] - r[1, column] - target
            slope = r[0, next_column] - r[1, next_column]
            if value == 0.0:
                return s
            if value * far > 0.0:
                high = s
            else:
                low = s
            trial, newton = next_trial(s, value, slope, low, high, move)
            move = trial - s
            s = trial
            curvature = r[0, FORCE] - r[1, FORCE]
            if newton and is_located(move, slope, curvature, span):
                return s
            if high - low <= 4e-16 * span:
                return s
        return s

    @part
    def leave_gap(
        target: float, far: float, high: float, t: float, q: Any, r: Any, pair: Pair
    ) -> float:
        """Return a step length at which balls that start in contact are apart, or zero."""
        s = 0.5 * high
        for _ in range(50):
            both(s, t, q, r, pair)
            if (r[0, X] - r[1, X] - target) * far < 0.0:
                return s
            s *= 0.5
        return 0.0

    @part
    def parting(far: float, t: float, q: Any, pair: Pair) -> float:
        """Return the separation's acceleration away from contact at the balls' own velocities."""
        apart = 0.0
        for i in range(2):
            law = pair.laws[i]
            pull = freed(free_force(t, q[i, X], law), q[i, V], law.body)
            apart += pull if i == 0 else -pull
        return -far * apart

    @part
    def strike(
        far: float, t: float, q: Any, settings: Any, pair: Pair
    ) -> tuple[float, float, bool]:
        """Let the balls collide; return impact loss, capture loss and whether rest begins.

        The capture speed counts for each of two mirrored balls, so twice it for the separation.
        """
        i1, i2 = pair.laws[0].body.inertia, pair.laws[1].body.inertia
        rate = q[0, V] - q[1, V]
        presses = parting(far, t, q, pair) <= 0.0
        energy = 0.5 * i1 * i2 / (i1 + i2) * rate * rate
        e = settings.restitution
        captures = presses and (rate == 0.0 or (e < 1.0 and abs(rate) <= 2.0 * settings.rest_speed))
        if captures:
            e = 0.0
        q[0, V], q[1, V] = pair_impact(q[0, V], q[1, V], i1, i2, e)
        joins = (q[0, V] - q[1, V]) * far >= 0.0  # a tiny rebound may be lost in rounding
        if joins:
            q[1, V] = q[0, V]  # equal to the last bit: they move as one from here on
        if captures:
            return 0.0, energy, True
        return energy * (1.0 - e * e), 0.0, presses and joins

    @part
    def sign_of(velocity: float, free: float, coulomb: float) -> float:
        """Return the sign of the velocity, or of what sets the ball moving, or `STUCK`."""
        if velocity != 0.0:
            return math.copysign(1.0, velocity)
        if coulomb > 0.0 and abs(free) <= coulomb:
            return STUCK
        return math.copysign(1.0, free)

    @part
    def settle_row(row: int, t: float, q: Any, signs: Any, law: Law) -> None:
        """Write the sign and the force of a row; friction stops what hardly moves."""
        if law.body.coulomb > 0.0 and abs(q[row, V]) < STILL:
            q[row, V] = 0.0
        signs[row] = sign_of(q[row, V], free_force(t, q[row, X], law), law.body.coulomb)
        q[row, FORCE], q[row, DRIVEN], q[row, LIFT] = force(t, q[row, X], signs[row], law)

    @part
    def settle_signs(t: float, q: Any, pair: Pair) -> None:
        """Write the signs and the forces of both balls."""
        for i in range(2):
            settle_row(i, t, q, pair.signs, pair.laws[i])

    @part
    def join(t: float, q: Any, offset: float, law: Law, pair: Pair) -> None:
        """Make the joint row from the balls' rows."""
        q[JOINT, X], q[JOINT, V] = q[1, X] + offset, q[1, V]
        settle_row(JOINT, t, q, pair.signs, law)

    @part
    def split(x: float, v: float, offset: float, gap: float, q: Any) -> None:
        """Write the balls' rows from the joint angle and velocity."""
        q[1, X] = x - offset
        q[0, X] = q[1, X] + gap
        q[0, V] = q[1, V] = v

    @part
    def joint_margin(
        s: float, far: float, offset: float, gap: float, t: float, q: Any, r: Any, w: Any,
        law: Law, pair: Pair,
    ) -> float:  # fmt: skip
        """Return how far the joint motion, s later, is from its end; negative beyond it.

        It ends when the balls would part, or when friction no longer holds both at once.
        """
        sign = pair.signs[JOINT]
        go_by(s, JOINT, t, q, r, sign, pair.methods[JOINT], law)
        # A velocity beyond its zero belongs to the frozen sign only: friction sees it as zero.
        seen = 0.0 if r[JOINT, V] * sign < 0.0 else r[JOINT, V]
        split(r[JOINT, X], seen, offset, gap, w)
        margin = -parting(far, t + s, w, pair)
        if sign == STUCK:
            slip = abs(free_force(t + s, r[JOINT, X], law))
            margin = min(margin, law.body.coulomb - slip)
        return margin

    @part
    def joint_pulls(t: float, q: Any, gap: float, pair: Pair) -> tuple[float, float]:
        """Return both tensions in lasting contact, each over mass and length."""
        one, two = pair.laws[0], pair.laws[1]
        lift = acceleration(t, one.p)
        torque = contact_torque(
            freed(free_force(t, q[0, X], one), q[0, V], one.body),
            freed(free_force(t, q[1, X], two), q[1, V], two.body),
            one.body.inertia,
            two.body.inertia,
        )
        l1, l2 = 1.0 / one.body.coupling, 1.0 / two.body.coupling
        push_1 = radial_push(torque, l1, l2, gap) * l1 / one.body.inertia
        push_2 = radial_push(torque, l2, l1, gap) * l2 / two.body.inertia
        return (
            tension_at(q[0, X], q[0, V], lift, one.gravity, one.body.coupling) + push_1,
            tension_at(q[1, X], q[1, V], lift, two.gravity, two.body.coupling) + push_2,
        )

    @part
    def dip(
        h: float, last: float, far: float, offset: float, gap: float, t: float, q: Any, r: Any,
        w: Any, law: Law, pair: Pair,
    ) -> float:  # fmt: skip
        """Return when within a step the margin is negative though it is not at the ends, or h.

        The parabola through both ends and the middle tells whether the bottom is worth a look.
        """
        first = joint_margin(0.0, far, offset, gap, t, q, r, w, law, pair)
        middle = joint_margin(0.5 * h, far, offset, gap, t, q, r, w, law, pair)
        bend = first - 2.0 * middle + last
        lowest = middle
        if bend > 0.0 and abs(last - first) < 2.0 * bend:
            lowest = middle - 0.125 * (last - first) ** 2 / bend
        if lowest > 0.02 * (first + last):
            return h
        a, b = 0.0, h
        for _ in range(80):  # golden section
            left, right = a + 0.382 * (b - a), a + 0.618 * (b - a)
            if joint_margin(left, far, offset, gap, t, q, r, w, law, pair) < joint_margin(
                right, far, offset, gap, t, q, r, w, law, pair
            ):
                b = right
            else:
                a = left
        s = 0.5 * (a + b)
        return s if joint_margin(s, far, offset, gap, t, q, r, w, law, pair) < 0.0 else h

    return PairFlight(
        free_force,
        go,
        go_by,
        both,
        locate_gap,
        leave_gap,
        parting,
        strike,
        settle_signs,
        join,
        split,
        joint_margin,
        joint_pulls,
        dip,
    )
