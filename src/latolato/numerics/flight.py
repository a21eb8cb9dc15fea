"""One ball between events: the splitting step and the search for events inside a step.

`make_flight` folds a drive's acceleration and a restoring law into the functions from which all
trajectories are made. The same functions run as plain Python (``compile_part=None``) or compiled.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from latolato.numerics.contact_time import MOST_TRIALS, is_located, next_trial
from latolato.numerics.engine.swing import KICK, OFFSET, REACH, tension_at
from latolato.numerics.records import (
    FIRST_ENERGY,
    LARGEST_ENERGY,
    RESIDUAL,
    S_CAPTURED,
    S_DAMPED,
    S_IMPACT,
    S_MODE,
    S_NOISE,
    S_WORK,
)
from latolato.physics.damping import decay_time, drift
from latolato.scalar import formula

Part = Callable[..., Callable[..., Any]]

# The shortest rest, per step, after a release that leads nowhere; without a limit the times before
# a stop would become shorter and shorter.
SHORTEST_REST = 1e-3

# What a search looks for.
ANGLE, VELOCITY = 0, 1


class Point(NamedTuple):
    """A point of one ball's motion, with what `force` returns there."""

    t: float
    angle: float
    velocity: float
    a: float  # acceleration of a kick [rad/s^2]
    driven: float  # the drive's part of it
    lift: float  # pivot_acceleration [m/s^2]


class Law(NamedTuple):
    """What a ball obeys: gravity, its body record, and the drive's present stretch."""

    gravity: float
    body: Any
    p: Any


class Method(NamedTuple):
    """A stepper's weights and a table for steps of any length, of shape (3, stages + 1)."""

    table: Any
    kicks: Any
    drifts: Any
    nodes: Any


@formula
def prepare(method: Method, h: float, rate: float) -> None:
    """Fill the method's table with what a step of length h [s] needs."""
    table, kicks, drifts, nodes = method
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
def follow_ledger(state: Any, energy: float, gained: float) -> None:
    """Note the largest energy and the largest error of the ledger at the end of a step [J]."""
    if energy > state[LARGEST_ENERGY]:
        state[LARGEST_ENERGY] = energy
    error = abs(energy - state[FIRST_ENERGY] - gained)
    if error > state[RESIDUAL]:
        state[RESIDUAL] = error


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


class Flight(NamedTuple):
    """The functions of one ball in flight; see `make_flight`."""

    force: Callable[..., Any]
    advance: Callable[..., Any]
    step_by: Callable[..., Any]
    locate: Callable[..., Any]
    leave: Callable[..., Any]
    turn: Callable[..., Any]
    follow_slack: Callable[..., Any]


def make_flight(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    compile_part: Part | None = None,
) -> Flight:
    """Return the functions of a ball under a drive and a restoring law.

    A step begins and ends with the force at its `Point`, so that no force is computed twice.
    """
    part: Part = compile_part or (lambda function: function)
    inlined: Part = partial(compile_part, inline=True) if compile_part else part

    @part
    def force(t: float, angle: float, sign: float, law: Law) -> tuple[float, float, float]:
        """Return the acceleration of a kick, the drive's part of it, and pivot_acceleration."""
        lift = acceleration(t, law.p)
        pull = law.body.coupling * restoring(angle)
        return -(law.gravity + lift) * pull - law.body.coulomb * sign, -lift * pull, lift

    @inlined
    def advance(
        point: Point, sign: float, table: Any, law: Law
    ) -> tuple[float, float, float, float, float, float, float]:
        """Return angle, velocity, drive work, damping loss (per inertia) and force after a step.

        Kick: ``dW = driven h (w + w')/2`` is the exact work of the drive's part; drift: the loss
        is the drop of w^2/2. Coulomb friction acts in the kicks, linear and quadratic drag in
        the drifts.
        """
        gravity, body, p = law
        t, angle, velocity, a, driven, lift = point
        stages = table.shape[1] - 1
        coulomb = body.coulomb * sign
        work = 0.0
        loss = 0.0
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
    def step_by(
        h: float, point: Point, sign: float, method: Method, law: Law
    ) -> tuple[float, float, float, float, float, float, float]:
        """Return what `advance` returns for a step of any length h."""
        prepare(method, h, law.body.rate)
        return advance(point, sign, method.table, law)

    @part
    def locate(
        what: int,
        target: float,
        low: float,
        high: float,
        guess: float,
        point: Point,
        sign: float,
        method: Method,
        law: Law,
    ) -> float:
        """Return the step length in [low, high] at which angle or velocity reaches `target`.

        The value minus the target changes its sign between the ends; at `high` it has the sign
        of the far side. Bracketed Newton on the step itself, to rounding.
        """
        x, v, _, _, f, _, _ = step_by(high, point, sign, method, law)
        value = x - target if what == ANGLE else v - target
        if value == 0.0:
            return high
        far = 1.0 if value > 0.0 else -1.0
        span = high - low
        s = guess if low < guess < high else 0.5 * (low + high)
        move = span
        for _ in range(MOST_TRIALS):
            x, v, _, _, f, _, _ = step_by(s, point, sign, method, law)
            if what == ANGLE:
                value, slope, curvature = x - target, v, f
            else:
                # The drag's share of the slope only slows Newton; the bracket keeps it safe.
                value, slope, curvature = v - target, f - law.body.rate * v, f
            if value == 0.0:
                return s
            if value * far > 0.0:
                high = s
            else:
                low = s
            trial, newton = next_trial(s, value, slope, low, high, move)
            move = trial - s
            s = trial
            if newton and is_located(move, slope, curvature, span):
                return s
            if high - low <= 4e-16 * span:
                return s
        return s

    @part
    def leave(
        what: int,
        target: float,
        far: float,
        high: float,
        point: Point,
        sign: float,
        method: Method,
        law: Law,
    ) -> float:
        """Return a step length at which a motion that starts on the target is on its near side.

        `far` is the sign of the far side, where the motion is after `high`. Zero if the motion
        on the near side is too small to be seen in double precision.
        """
        s = 0.5 * high
        for _ in range(50):
            x, v, _, _, _, _, _ = step_by(s, point, sign, method, law)
            value = x - target if what == ANGLE else v - target
            if value * far < 0.0:
                return s
            s *= 0.5
        return 0.0

    @part
    def turn(h: float, point: Point, sign: float, method: Method, law: Law) -> float:
        """Return when, within a step of length h, the velocity returns to zero; h if unseen."""
        begin = 0.0
        if point.velocity == 0.0:
            begin = leave(VELOCITY, 0.0, -sign, h, point, sign, method, law)
            if begin == 0.0:
                return h
        return locate(VELOCITY, 0.0, begin, h, 0.5 * (begin + h), point, sign, method, law)

    @part
    def follow_slack(
        first: float,
        total: float,
        h: float,
        end_pull: float,
        point: Point,
        sign: float,
        method: Method,
        law: Law,
    ) -> tuple[float, float]:
        """Return the first instant and the total time of slack, carried over a step of length h.

        The tension's zeros are located on the step, one in each half at most. Call it only where
        an end is below what the tension can dip within a step.
        """
        g, k = law.gravity, law.body.coupling
        begin_pull = tension_at(point.angle, point.velocity, point.lift, g, k)
        half = 0.5 * h
        x, v, _, _, _, _, lift = step_by(half, point, sign, method, law)
        middle_pull = tension_at(x, v, lift, g, k)
        if begin_pull < 0.0 and math.isnan(first):
            first = point.t
        for piece in range(2):
            left, right = (begin_pull, middle_pull) if piece == 0 else (middle_pull, end_pull)
            s0 = half * piece
            s1 = s0 + half
            if left < 0.0 and right < 0.0:
                total += half
            elif left < 0.0 or right < 0.0:
                b0, b1, f0, f1, kept, root = s0, s1, left, right, 0, s1
                for _ in range(MOST_TRIALS):  # regula falsi, an end kept twice is halved (Illinois)
                    s = (b0 * f1 - b1 * f0) / (f1 - f0)
                    if not b0 < s < b1:
                        break
                    x, v, _, _, _, _, lift = step_by(s, point, sign, method, law)
                    now = tension_at(x, v, lift, g, k)
                    moved, root = abs(s - root), s
                    if (now < 0.0) == (left < 0.0):
                        b0, f0 = s, now
                        f1, kept = (0.5 * f1 if kept == 1 else f1), 1
                    else:
                        b1, f1 = s, now
                        f0, kept = (0.5 * f0 if kept == 2 else f0), 2
                    if moved < 1e-14 * h or now == 0.0:
                        break
                total += root - s0 if left < 0.0 else s1 - root
                if left >= 0.0 and math.isnan(first):
                    first = point.t + root
        return first, total

    return Flight(force, advance, step_by, locate, leave, turn, follow_slack)
