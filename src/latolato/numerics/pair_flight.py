"""Two balls between events: steps of both, searches on their separation, impact, joint motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.contact_time import MOST_TRIALS, is_located, next_trial
from latolato.numerics.flight import ANGLE, Flight, Part, prepare
from latolato.physics.contacts import pair_impact
from latolato.physics.damping import drag
from latolato.scalar import formula

# Columns of a point of the motion and of a step's result; rows are ball 1, ball 2, both as one.
X, V, FORCE, DRIVEN, LIFT, GAIN, LOSS = range(7)
JOINT = 2
STUCK = 0.0


@formula
def freed(free: float, velocity: float, body: Any) -> float:
    """Return the angular acceleration of a ball with all its drag, static friction included."""
    if velocity == 0.0:
        if abs(free) <= body.coulomb:
            return 0.0
        return free - math.copysign(body.coulomb, free)
    sign = math.copysign(1.0, velocity)
    return free - drag(velocity, sign, body.rate, body.quadratic, body.coulomb)


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


class PairFlight(NamedTuple):
    """The functions of two balls; see `make_pair_flight`."""

    free_force: Callable[..., Any]
    refresh: Callable[..., Any]
    go: Callable[..., Any]
    both: Callable[..., Any]
    locate_gap: Callable[..., Any]
    leave_gap: Callable[..., Any]
    parting: Callable[..., Any]
    strike: Callable[..., Any]
    settle_signs: Callable[..., Any]
    join: Callable[..., Any]
    split: Callable[..., Any]
    joint_margin: Callable[..., Any]


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
    def free_force(t: float, angle: float, gravity: float, body: Any, p: Any) -> float:
        """Return the angular acceleration without drag."""
        return -(gravity + acceleration(t, p)) * body.coupling * restoring(angle)

    @part
    def refresh(row: int, t: float, q: Any, sign: float, gravity: float, body: Any, p: Any) -> None:
        """Write the force at a point into its row."""
        q[row, FORCE], q[row, DRIVEN], q[row, LIFT] = force(t, q[row, X], sign, gravity, body, p)

    @part
    def go(
        row: int, t: float, q: Any, r: Any, sign: float, table: Any, gravity: float, body: Any,
        p: Any,
    ) -> None:  # fmt: skip
        """Advance one row of `q` by a prepared step into `r`."""
        if sign == STUCK:
            r[row, X], r[row, V], r[row, GAIN], r[row, LOSS] = q[row, X], 0.0, 0.0, 0.0
            return
        x, v, gain, loss, a, driven, lift = advance(
            t, q[row, X], q[row, V], q[row, FORCE], q[row, DRIVEN], sign, table, gravity, body, p
        )
        r[row, X], r[row, V], r[row, FORCE], r[row, DRIVEN] = x, v, a, driven
        r[row, LIFT], r[row, GAIN], r[row, LOSS] = lift, gain, loss

    @part
    def both(
        s: float, t: float, q: Any, r: Any, signs: Any, tables: Any, kicks: Any, drifts: Any,
        nodes: Any, gravity: float, bodies: Any, p: Any,
    ) -> None:  # fmt: skip
        """Advance both balls by a step of length s, with the trial tables."""
        for i in range(2):
            prepare(tables[3 + i], s, kicks, drifts, nodes, bodies[i].rate)
            go(i, t, q, r, signs[i], tables[3 + i], gravity, bodies[i], p)

    @part
    def locate_gap(
        what: int, target: float, low: float, high: float, t: float, q: Any, r: Any, signs: Any,
        tables: Any, kicks: Any, drifts: Any, nodes: Any, gravity: float, bodies: Any, p: Any,
    ) -> float:  # fmt: skip
        """Return the step length at which the separation, or its rate, reaches `target`."""
        column, next_column = (X, V) if what == ANGLE else (V, FORCE)
        both(high, t, q, r, signs, tables, kicks, drifts, nodes, gravity, bodies, p)
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
            both(s, t, q, r, signs, tables, kicks, drifts, nodes, gravity, bodies, p)
            value = r[0, column] - r[1, column] - target
            slope = r[0, next_column] - r[1, next_column]
            if value == 0.0:
                return s
            if value * far > 0.0:
                high = s
            else:
                low = s
            trial = next_trial(s, value, slope, low, high, move)
            move = trial - s
            s = trial
            curvature = r[0, FORCE] - r[1, FORCE]
            if high - low <= 4e-16 * span or is_located(move, slope, curvature, span):
                return s
        return s

    @part
    def leave_gap(
        target: float, far: float, high: float, t: float, q: Any, r: Any, signs: Any,
        tables: Any, kicks: Any, drifts: Any, nodes: Any, gravity: float, bodies: Any, p: Any,
    ) -> float:  # fmt: skip
        """Return a step length at which balls that start in contact are apart, or zero."""
        s = 0.5 * high
        for _ in range(50):
            both(s, t, q, r, signs, tables, kicks, drifts, nodes, gravity, bodies, p)
            if (r[0, X] - r[1, X] - target) * far < 0.0:
                return s
            s *= 0.5
        return 0.0

    @part
    def parting(far: float, t: float, q: Any, gravity: float, bodies: Any, p: Any) -> float:
        """Return the separation's acceleration away from contact at the balls' own velocities."""
        apart = 0.0
        for i in range(2):
            pull = freed(free_force(t, q[i, X], gravity, bodies[i], p), q[i, V], bodies[i])
            apart += pull if i == 0 else -pull
        return -far * apart

    @part
    def strike(
        far: float, t: float, q: Any, settings: Any, bodies: Any, p: Any
    ) -> tuple[float, float, bool]:
        """Let the balls collide; return impact loss, capture loss and whether rest begins.

        The capture speed counts for each of two mirrored balls, so twice it for the separation.
        """
        i1, i2 = bodies[0].inertia, bodies[1].inertia
        rate = q[0, V] - q[1, V]
        presses = parting(far, t, q, settings.gravity, bodies, p) <= 0.0
        reduced = 0.5 * i1 * i2 / (i1 + i2)
        slow = settings.restitution < 1.0 and abs(rate) <= 2.0 * settings.rest_speed
        if presses and (rate == 0.0 or slow):
            q[0, V], q[1, V] = pair_impact(q[0, V], q[1, V], i1, i2, 0.0)
            q[1, V] = q[0, V]
            return 0.0, reduced * rate * rate, True
        e = settings.restitution
        q[0, V], q[1, V] = pair_impact(q[0, V], q[1, V], i1, i2, e)
        if e == 0.0:
            q[1, V] = q[0, V]
        return reduced * rate * rate * (1.0 - e * e), 0.0, presses and e == 0.0

    @part
    def settle_signs(t: float, q: Any, signs: Any, gravity: float, bodies: Any, p: Any) -> None:
        """Give each ball the sign of its velocity, or of what sets it moving, or none."""
        for i in range(2):
            if q[i, V] != 0.0:
                signs[i] = math.copysign(1.0, q[i, V])
            else:
                free = free_force(t, q[i, X], gravity, bodies[i], p)
                if bodies[i].coulomb > 0.0 and abs(free) <= bodies[i].coulomb:
                    signs[i] = STUCK
                else:
                    signs[i] = math.copysign(1.0, free)
            refresh(i, t, q, signs[i], gravity, bodies[i], p)

    @part
    def join(
        t: float, q: Any, signs: Any, offset: float, gravity: float, body: Any, p: Any
    ) -> None:
        """Make the joint row from the balls' rows."""
        q[JOINT, X], q[JOINT, V] = q[1, X] + offset, q[1, V]
        free = free_force(t, q[JOINT, X], gravity, body, p)
        if q[JOINT, V] != 0.0:
            signs[JOINT] = math.copysign(1.0, q[JOINT, V])
        elif body.coulomb > 0.0 and abs(free) <= body.coulomb:
            signs[JOINT] = STUCK
        else:
            signs[JOINT] = math.copysign(1.0, free)
        refresh(JOINT, t, q, signs[JOINT], gravity, body, p)

    @part
    def split(x: float, v: float, offset: float, gap: float, q: Any) -> None:
        """Write the balls' rows from the joint angle and velocity."""
        q[1, X] = x - offset
        q[0, X] = q[1, X] + gap
        q[0, V] = q[1, V] = v

    @part
    def joint_margin(
        s: float, far: float, offset: float, gap: float, t: float, q: Any, r: Any, w: Any,
        signs: Any, table: Any, kicks: Any, drifts: Any, nodes: Any, gravity: float, bodies: Any,
        p: Any,
    ) -> float:  # fmt: skip
        """Return how far the joint motion, s later, is from its end; negative beyond it.

        It ends when the balls would part, or when friction no longer holds both at once.
        """
        body = bodies[2 if far < 0.0 else 3]
        prepare(table, s, kicks, drifts, nodes, body.rate)
        go(JOINT, t, q, r, signs[JOINT], table, gravity, body, p)
        split(r[JOINT, X], r[JOINT, V], offset, gap, w)
        margin = -parting(far, t + s, w, gravity, bodies, p)
        if signs[JOINT] == STUCK:
            slip = abs(free_force(t + s, r[JOINT, X], gravity, body, p))
            margin = min(margin, body.coulomb - slip)
        return margin

    return PairFlight(
        free_force,
        refresh,
        go,
        both,
        locate_gap,
        leave_gap,
        parting,
        strike,
        settle_signs,
        join,
        split,
        joint_margin,
    )
