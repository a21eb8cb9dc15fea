"""What cuts a step of two balls, what changes their velocities at once, what is noted of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.contact_time import MOST_TRIALS
from latolato.numerics.engine.swing import SHORTEST, tension_at
from latolato.numerics.flight import Flight, Law, Method, Part, write_ledger
from latolato.numerics.pair_flight import (
    GAIN,
    JOINT,
    LIFT,
    LOSS,
    STUCK,
    Pair,
    PairFlight,
    V,
    X,
    add_slack,
    point_of,
)
from latolato.numerics.records import FLIGHT, SLACK_FIRST, SLACK_TOTAL
from latolato.observables import Segment
from latolato.physics.contacts import pair_impact
from latolato.physics.damping import drag


class PairStep(NamedTuple):
    """The functions of a step of two balls; see `make_pair_step`."""

    notice: Callable[..., Any]
    slowed: Callable[..., Any]
    energy_of: Callable[..., Any]
    laws_of: Callable[..., Any]
    part_at: Callable[..., Any]
    first_turning: Callable[..., Any]
    wall_met: Callable[..., Any]
    sample_flight: Callable[..., Any]
    sample_joint: Callable[..., Any]
    note_slack: Callable[..., Any]
    shove: Callable[..., Any]
    halt: Callable[..., Any]


def make_pair_step(
    flight: Flight,
    pair_flight: PairFlight,
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    potential: Callable[..., float],
    watch_step: Callable[..., Any],
    compile_part: Part | None = None,
) -> PairStep:
    """Return the functions of a step of two balls; arrays are those of `make_pair_flight`."""
    part: Part = compile_part or (lambda function: function)
    turn, follow_slack = flight.turn, flight.follow_slack
    free_force, both, go_by = pair_flight.free_force, pair_flight.both, pair_flight.go_by
    split, joint_margin = pair_flight.split, pair_flight.joint_margin

    @part
    def notice(
        acc: Any, column: int, columns: int, t: float, end: float, q: Any, r: Any, a0: float,
        a1: float, ball: int, law: Law, held: float,
    ) -> None:  # fmt: skip
        """Show the observables a step of one ball, whose rates of energy follow from a and v."""
        stiffness = law.gravity * law.body.coupling
        x0, v0, x1, v1 = q[ball, X], q[ball, V], r[ball, X], r[ball, V]
        segment = Segment(
            t, end, x0, x1, v0, v1, a0, a1,
            0.5 * v0 * v0 + stiffness * potential(x0), 0.5 * v1 * v1 + stiffness * potential(x1),
            v0 * (a0 + stiffness * restoring(x0)), v1 * (a1 + stiffness * restoring(x1)), held,
        )  # fmt: skip
        watch_step(acc, column + ball, columns, segment)

    @part
    def slowed(a: float, v: float, sign: float, body: Any) -> float:
        """Return the acceleration with all drag from that of a kick."""
        return 0.0 if sign == STUCK else a - drag(v, sign, body.rate, body.quadratic, 0.0)

    @part
    def energy_of(q: Any, bodies: Any, gravity: float) -> float:
        """Return the energy of both balls."""
        energy = 0.0
        for i in range(2):
            speed, lifted = q[i, V], gravity * bodies[i].coupling * potential(q[i, X])
            energy += bodies[i].inertia * (0.5 * speed * speed + lifted)
        return energy

    @part
    def laws_of(gravity: float, bodies: Any, p: Any) -> tuple[Law, Law, Law, Law]:
        """Return the laws of both balls and of the bodies that they form."""
        return (
            Law(gravity, bodies[0], p),
            Law(gravity, bodies[1], p),
            Law(gravity, bodies[2], p),
            Law(gravity, bodies[3], p),
        )

    @part
    def part_at(
        end: float, far: float, offset: float, gap: float, t: float, q: Any, r: Any, w: Any,
        law: Law, pair: Pair,
    ) -> float:  # fmt: skip
        """Return when within a step, before `end`, balls that rest on each other part."""
        begin = 0.0
        for _ in range(MOST_TRIALS):
            s = 0.5 * (begin + end)
            if s <= begin or s >= end:
                break
            if joint_margin(s, far, offset, gap, t, q, r, w, law, pair) < 0.0:
                end = s
            else:
                begin = s
        return end

    @part
    def first_turning(hs: float, t: float, q: Any, r: Any, pair: Pair) -> tuple[float, int]:
        """Return when a ball first turns or friction lets go of it, and which; else hs and -1."""
        turning = -1
        for i in range(2):
            s = hs
            if pair.signs[i] == STUCK:
                c = pair.laws[i].body.coulomb
                x = q[i, X]
                if abs(free_force(t + hs, x, pair.laws[i])) <= c:
                    continue
                begin = 0.0
                for _ in range(MOST_TRIALS):
                    middle = 0.5 * (begin + s)
                    if middle <= begin or middle >= s:
                        break
                    if abs(free_force(t + middle, x, pair.laws[i])) > c:
                        s = middle
                    else:
                        begin = middle
            elif r[i, V] * pair.signs[i] < 0.0:
                s = turn(hs, point_of(t, q, i), pair.signs[i], pair.methods[i], pair.laws[i])
            else:
                continue
            s = max(s, SHORTEST * t)
            if turning < 0 or s < hs:
                hs, turning = s, i
            both(hs, t, q, r, pair)
        return hs, turning

    @part
    def wall_met(
        leaving: float, gap: float, rate: float, end_gap: float, end_rate: float, hs: float,
        low: float, high: float,
    ) -> tuple[float, float]:  # fmt: skip
        """Return the separation of the contact that a step reaches or may dip into, and its side.

        The side is -1 at the bottom, 1 at the top and 0 for none. `leaving` is that of balls whose
        next contact is known beforehand.
        """
        if leaving != 0.0:
            return (low, -1.0) if leaving < 0.0 else (high, 1.0)
        if end_gap <= low:
            return low, -1.0
        if end_gap >= high:
            return high, 1.0
        if rate < 0.0 < end_rate and min(gap, end_gap) - max(-rate, end_rate) * hs <= low:
            return low, -1.0
        if end_rate < 0.0 < rate and max(gap, end_gap) + max(rate, -end_rate) * hs >= high:
            return high, 1.0
        return 0.0, 0.0

    @part
    def sample_flight(
        sample: int, sample_times: Any, samples: Any, t: float, t_new: float, q: Any, w: Any,
        pair: Pair, ledger: tuple[float, float, float, float, float],
    ) -> int:  # fmt: skip
        """Write the samples that fall into a step in flight and return the number of the next."""
        work, damped, lost, captured, noise = ledger
        while sample < len(sample_times) and sample_times[sample] < t_new:
            both(sample_times[sample] - t, t, q, w, pair)
            gain = loss = 0.0
            for i in range(2):
                samples[2 * i, sample] = w[i, X]
                samples[2 * i + 1, sample] = w[i, V]
                gain += pair.laws[i].body.inertia * w[i, GAIN]
                loss += pair.laws[i].body.inertia * w[i, LOSS]
            write_ledger(samples, sample, work + gain, damped + loss, lost, captured, noise, FLIGHT)
            sample += 1
        return sample

    @part
    def sample_joint(
        sample: int, sample_times: Any, samples: Any, t: float, t_new: float, q: Any, r: Any,
        w: Any, offset: float, gap: float, law: Law, pair: Pair,
        ledger: tuple[float, float, float, float, float], mode: int,
    ) -> int:  # fmt: skip
        """Write the samples that fall into a step in lasting contact, as `sample_flight`."""
        work, damped, lost, captured, noise = ledger
        inertia = law.body.inertia
        while sample < len(sample_times) and sample_times[sample] < t_new:
            s = sample_times[sample] - t
            go_by(s, JOINT, t, q, r, pair.signs[JOINT], pair.methods[JOINT], law)
            split(r[JOINT, X], r[JOINT, V], offset, gap, w)
            samples[0, sample], samples[1, sample] = w[0, X], w[0, V]
            samples[2, sample], samples[3, sample] = w[1, X], w[1, V]
            gain, loss = inertia * r[JOINT, GAIN], inertia * r[JOINT, LOSS]
            write_ledger(samples, sample, work + gain, damped + loss, lost, captured, noise, mode)
            sample += 1
        return sample

    @part
    def note_slack(
        state: Any, i: int, t: float, t_new: float, q: Any, r: Any, end_pull: float, sign: float,
        method: Method, law: Law,
    ) -> None:  # fmt: skip
        """Add the slack of the rod of one ball in a step in flight."""
        if sign == STUCK:
            g, k = law.gravity, law.body.coupling
            lift = acceleration(t_new, law.p)
            begin_pull = tension_at(q[i, X], 0.0, q[i, LIFT], g, k)
            end_pull = tension_at(q[i, X], 0.0, lift, g, k)
            r[i, LIFT] = lift
            add_slack(state, i, begin_pull, end_pull, t, t_new)
        else:
            first, total = follow_slack(
                state[SLACK_FIRST + 2 * i], state[SLACK_TOTAL + 2 * i], t_new - t, end_pull,
                point_of(t, q, i), sign, method, law,
            )  # fmt: skip
            state[SLACK_FIRST + 2 * i], state[SLACK_TOTAL + 2 * i] = first, total

    @part
    def shove(
        i: int, q: Any, pushed: float, thrown: float, bodies: Any
    ) -> tuple[float, float, bool]:
        """Let a jump of the pivot's velocity and a kick change one ball's angular velocity.

        Returns the work of the drive and of the kick, and whether the velocity changed.
        """
        more = -pushed * bodies[i].coupling * restoring(q[i, X])
        work = bodies[i].inertia * more * (q[i, V] + 0.5 * more)
        noise = bodies[i].inertia * thrown * (q[i, V] + more + 0.5 * thrown)
        q[i, V] += more + thrown
        return work, noise, more + thrown != 0.0

    @part
    def halt(q: Any, bodies: Any) -> float:
        """Let the balls move on with one velocity and return the energy lost by it."""
        i1, i2 = bodies[0].inertia, bodies[1].inertia
        loss: float = 0.5 * i1 * i2 / (i1 + i2) * (q[0, V] - q[1, V]) ** 2
        q[0, V], _ = pair_impact(q[0, V], q[1, V], i1, i2, 0.0)
        q[1, V] = q[0, V]
        return loss

    return PairStep(
        notice,
        slowed,
        energy_of,
        laws_of,
        part_at,
        first_turning,
        wall_met,
        sample_flight,
        sample_joint,
        note_slack,
        shove,
        halt,
    )
