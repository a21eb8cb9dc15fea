"""One ball between events: the splitting step and the search for events inside a step.

`make_flight` folds a drive's acceleration and a restoring law into the functions from which all
trajectories are made. The same functions run as plain Python (``compile_part=None``) or compiled.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.contact_time import MOST_TRIALS, is_located, next_trial
from latolato.numerics.records import S_CAPTURED, S_DAMPED, S_IMPACT, S_MODE, S_NOISE, S_WORK
from latolato.physics.damping import decay_time, drift
from latolato.scalar import cosine, formula

Part = Callable[[Callable[..., Any]], Callable[..., Any]]

# Rows of a step's table.
KICK, REACH, OFFSET = 0, 1, 2

# What a search looks for.
ANGLE, VELOCITY = 0, 1


@formula
def prepare(table: Any, h: float, kicks: Any, drifts: Any, nodes: Any, rate: float) -> None:
    """Fill a table of shape (3, stages + 1) with what a step of length h [s] needs."""
    stages = len(drifts)
    for i in range(stages):
        table[KICK, i] = kicks[i] * h
        table[REACH, i] = decay_time(rate, drifts[i] * h)
        table[OFFSET, i] = nodes[i] * h
    table[KICK, stages] = kicks[stages] * h


@formula
def write_ledger(
    samples: Any,
    k: int,
    work: float,
    damped: float,
    lost: float,
    captured: float,
    noise: float,
    mode: int,
) -> None:
    """Write the ledger's rows of sample k."""
    samples[S_WORK, k] = work
    samples[S_DAMPED, k] = damped
    samples[S_IMPACT, k] = lost
    samples[S_CAPTURED, k] = captured
    samples[S_NOISE, k] = noise
    samples[S_MODE, k] = mode


@formula
def write_contact(
    times: Any, kinds: Any, values: Any, row: int, t: float, kind: int, before: float, after: float
) -> int:
    """Write one ball's row of the contact table and return the next row's number."""
    times[row] = t
    kinds[row] = kind
    values[0, row] = before
    values[1, row] = after
    return row + 1


@formula
def pull_at(angle: float, velocity: float, lift: float, gravity: float, coupling: float) -> float:
    """Return the tension in flight over mass and length [1/s^2]."""
    return velocity * velocity + (gravity + lift) * coupling * cosine(angle)


class Flight(NamedTuple):
    """The functions of one ball in flight; see `make_flight`."""

    force: Callable[..., Any]
    advance: Callable[..., Any]
    locate: Callable[..., Any]
    leave: Callable[..., Any]
    follow_slack: Callable[..., Any]


def make_flight(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    compile_part: Part | None = None,
) -> Flight:
    """Return `force`, `advance`, `locate` and `leave` of a ball under a drive and a restoring law.

    A point of the motion is passed as angle, velocity and the three values that `force` returns
    there; a step ends with the force at its end, so that no force is computed twice.
    """
    part: Part = compile_part or (lambda function: function)

    @part
    def force(
        t: float, angle: float, sign: float, gravity: float, body: Any, p: Any
    ) -> tuple[float, float, float]:
        """Return the acceleration of a kick, the drive's part of it, and pivot_acceleration."""
        lift = acceleration(t, p)
        pull = body.coupling * restoring(angle)
        return -(gravity + lift) * pull - body.coulomb * sign, -lift * pull, lift

    @part
    def advance(
        t: float,
        angle: float,
        velocity: float,
        a: float,
        driven: float,
        sign: float,
        table: Any,
        gravity: float,
        body: Any,
        p: Any,
    ) -> tuple[float, float, float, float, float, float, float]:
        """Return angle, velocity, drive work, damping loss (per inertia) and force after a step.

        Kick: ``dW = driven h (w + w')/2`` is the exact work of the drive's part; drift: the loss
        is the drop of w^2/2. Coulomb friction acts in the kicks, linear and quadratic drag in
        the drifts.
        """
        stages = table.shape[1] - 1
        coulomb = body.coulomb * sign
        work = 0.0
        loss = 0.0
        lift = 0.0
        for i in range(stages):
            h = table[KICK, i]
            change = h * a
            middle = velocity + 0.5 * change
            work += h * driven * middle
            loss += h * coulomb * middle
            velocity += change
            travelled, slowed = drift(velocity, sign, table[REACH, i], body.rate, body.quadratic)
            loss += 0.5 * (velocity - slowed) * (velocity + slowed)
            angle += travelled
            velocity = slowed
            lift = acceleration(t + table[OFFSET, i], p)
            pull = body.coupling * restoring(angle)
            driven = -lift * pull
            a = driven - gravity * pull - coulomb
        h = table[KICK, stages]
        change = h * a
        middle = velocity + 0.5 * change
        work += h * driven * middle
        loss += h * coulomb * middle
        return angle, velocity + change, work, loss, a, driven, lift

    @part
    def locate(
        what: int,
        target: float,
        low: float,
        high: float,
        guess: float,
        t: float,
        angle: float,
        velocity: float,
        a: float,
        driven: float,
        sign: float,
        table: Any,
        kicks: Any,
        drifts: Any,
        nodes: Any,
        gravity: float,
        body: Any,
        p: Any,
    ) -> float:
        """Return the step length in [low, high] at which angle or velocity reaches `target`.

        The value minus the target changes its sign between the ends; at `high` it has the sign
        of the far side. Bracketed Newton on the step itself, to rounding.
        """
        prepare(table, high, kicks, drifts, nodes, body.rate)
        x, v, _, _, f, _, _ = advance(t, angle, velocity, a, driven, sign, table, gravity, body, p)
        value = x - target if what == ANGLE else v - target
        if value == 0.0:
            return high
        far = 1.0 if value > 0.0 else -1.0
        span = high - low
        s = guess if low < guess < high else 0.5 * (low + high)
        move = span
        for _ in range(MOST_TRIALS):
            prepare(table, s, kicks, drifts, nodes, body.rate)
            x, v, _, _, f, _, _ = advance(
                t, angle, velocity, a, driven, sign, table, gravity, body, p
            )
            if what == ANGLE:
                value, slope, curvature = x - target, v, f
            else:
                # The drag's share of the slope only slows Newton; the bracket keeps it safe.
                value, slope, curvature = v - target, f - body.rate * v, f
            if value == 0.0:
                return s
            if value * far > 0.0:
                high = s
            else:
                low = s
            trial = next_trial(s, value, slope, low, high, move)
            move = trial - s
            s = trial
            if high - low <= 4e-16 * span or is_located(move, slope, curvature, span):
                return s
        return s

    @part
    def leave(
        what: int,
        target: float,
        far: float,
        high: float,
        t: float,
        angle: float,
        velocity: float,
        a: float,
        driven: float,
        sign: float,
        table: Any,
        kicks: Any,
        drifts: Any,
        nodes: Any,
        gravity: float,
        body: Any,
        p: Any,
    ) -> float:
        """Return a step length at which a motion that starts on the target is on its near side.

        `far` is the sign of the far side, where the motion is after `high`. Zero if the motion
        on the near side is too small to be seen in double precision.
        """
        s = 0.5 * high
        for _ in range(50):
            prepare(table, s, kicks, drifts, nodes, body.rate)
            x, v, _, _, _, _, _ = advance(
                t, angle, velocity, a, driven, sign, table, gravity, body, p
            )
            value = x - target if what == ANGLE else v - target
            if value * far < 0.0:
                return s
            s *= 0.5
        return 0.0

    @part
    def follow_slack(
        first: float,
        total: float,
        hs: float,
        x: float,
        v: float,
        end_lift: float,
        t: float,
        angle: float,
        velocity: float,
        a: float,
        driven: float,
        lift: float,
        sign: float,
        table: Any,
        kicks: Any,
        drifts: Any,
        nodes: Any,
        gravity: float,
        body: Any,
        p: Any,
    ) -> tuple[float, float]:
        """Return the first instant and the total time of slack, carried over a step of length hs.

        The tension's zeros are located on the step, one in each half at most. Call it only where
        an end is below what the tension can dip within a step.
        """
        k = body.coupling
        begin = pull_at(angle, velocity, lift, gravity, k)
        end = pull_at(x, v, end_lift, gravity, k)
        half = 0.5 * hs
        prepare(table, half, kicks, drifts, nodes, body.rate)
        xs, vs, _, _, _, _, ls = advance(
            t, angle, velocity, a, driven, sign, table, gravity, body, p
        )
        middle = pull_at(xs, vs, ls, gravity, k)
        if begin < 0.0 and math.isnan(first):
            first = t
        for piece in range(2):
            left, right = (begin, middle) if piece == 0 else (middle, end)
            s0 = half * piece
            s1 = s0 + half
            if left < 0.0 and right < 0.0:
                total += half
            elif left < 0.0 or right < 0.0:
                b0, b1, f0, f1, kept = s0, s1, left, right, 0
                for _ in range(MOST_TRIALS):  # regula falsi, an end kept twice is halved (Illinois)
                    s = (b0 * f1 - b1 * f0) / (f1 - f0)
                    if not b0 < s < b1 or b1 - b0 < 1e-15 * hs:
                        break
                    prepare(table, s, kicks, drifts, nodes, body.rate)
                    xs, vs, _, _, _, _, ls = advance(
                        t, angle, velocity, a, driven, sign, table, gravity, body, p
                    )
                    now = pull_at(xs, vs, ls, gravity, k)
                    if (now < 0.0) == (left < 0.0):
                        moved, b0, f0 = s - b0, s, now
                        f1, kept = (0.5 * f1 if kept == 1 else f1), 1
                    else:
                        moved, b1, f1 = b1 - s, s, now
                        f0, kept = (0.5 * f0 if kept == 2 else f0), 2
                    if moved < 1e-13 * hs:
                        break
                total += b1 - s0 if left < 0.0 else s1 - b1
                if left >= 0.0 and math.isnan(first):
                    first = t + b1
        return first, total

    return Flight(force, advance, locate, leave, follow_slack)
