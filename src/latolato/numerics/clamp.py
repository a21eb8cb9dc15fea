"""The fixed-step clamp: classical Runge-Kutta with reflection on overlap, an artefact by design.

It shows what a program without contact location does: the ball is moved back onto the wall, so
energy appears from nowhere and a ball at rest is set in motion by rounding and step size.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from latolato.numerics.flight import Part, follow_ledger, write_contact, write_ledger
from latolato.numerics.records import (
    ANGLE_1,
    CONTACT,
    DAMPED,
    FIRST_ENERGY,
    FLIGHT,
    IMPACT,
    LARGEST_ENERGY,
    MODE,
    SAMPLE,
    STEPS,
    STRETCH,
    TOTAL_STEPS,
    UNSETTLED,
    VELOCITY_1,
    WORK,
)
from latolato.numerics.watch import BLIND, Hooks, make_watch
from latolato.observables import Segment
from latolato.physics.contacts import BOTTOM, TOP, wall_impact
from latolato.physics.damping import drag


def make_clamped(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    potential: Callable[..., float],
    compile_part: Part | None = None,
    hooks: tuple[Hooks, ...] = BLIND,
) -> Callable[..., int]:
    """Return the clamped trajectory function, with the arguments of `fold.make_trajectory`."""
    part: Part = compile_part or (lambda function: function)
    watch_step = make_watch(hooks, compile_part).step
    watches = bool(hooks[0])

    @part
    def slopes(
        t: float, x: float, v: float, gravity: float, body: Any, p: Any
    ) -> tuple[float, float, float]:
        """Return acceleration, drive power and damping power per inertia."""
        lift = acceleration(t, p)
        pull = body.coupling * restoring(x)
        sign = 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)
        lost = drag(v, sign, body.rate, body.quadratic, body.coulomb)
        return -(gravity + lift) * pull - lost, -lift * pull * v, lost * v

    def trajectory(
        state: Any,
        counters: Any,
        settings_row: Any,
        bodies: Any,
        stretches: Any,
        starts: Any,
        jumps: Any,
        kick_times: Any,
        kicks_given: Any,
        tables: Any,
        space: Any,
        kicks: Any,
        drifts: Any,
        nodes: Any,
        sample_times: Any,
        samples: Any,
        contact_times: Any,
        contact_kinds: Any,
        contact_values: Any,
        stop: float,
        most_steps: int,
        acc: Any,
        column: int,
        columns: int,
    ) -> int:
        settings = settings_row[0]
        body = bodies[0]
        g, h = settings.gravity, settings.step
        x, v = state[ANGLE_1], state[VELOCITY_1]
        work, damped, lost = state[WORK], state[DAMPED], state[IMPACT]
        n, stretch, sample = counters[STEPS], counters[STRETCH], counters[SAMPLE]
        rows, room, done = 0, len(contact_times) - 1, 0
        inertia = body.inertia
        stiffness = g * body.coupling
        if counters[MODE] == UNSETTLED:
            energy = inertia * (0.5 * v * v + stiffness * potential(x))
            state[FIRST_ENERGY] = state[LARGEST_ENERGY] = energy
        while n * h < stop and done < most_steps and rows < room:
            done += 1
            t = n * h
            while stretch + 1 < len(starts) and starts[stretch + 1] <= t:
                stretch += 1
            p = stretches[stretch]
            a1, w1, d1 = slopes(t, x, v, g, body, p)
            v2 = v + 0.5 * h * a1
            a2, w2, d2 = slopes(t + 0.5 * h, x + 0.5 * h * v, v2, g, body, p)
            v3 = v + 0.5 * h * a2
            a3, w3, d3 = slopes(t + 0.5 * h, x + 0.5 * h * v2, v3, g, body, p)
            v4 = v + h * a3
            a4, w4, d4 = slopes(t + h, x + h * v3, v4, g, body, p)
            new_x = x + h * (v + 2.0 * (v2 + v3) + v4) / 6.0
            new_v = v + h * (a1 + 2.0 * (a2 + a3) + a4) / 6.0
            new_work = work + inertia * h * (w1 + 2.0 * (w2 + w3) + w4) / 6.0
            new_damped = damped + inertia * h * (d1 + 2.0 * (d2 + d3) + d4) / 6.0
            while sample < len(sample_times) and sample_times[sample] < t + h:
                s = (sample_times[sample] - t) / h
                samples[0, sample] = x + s * (new_x - x)
                samples[1, sample] = v + s * (new_v - v)
                write_ledger(
                    samples, sample, work + s * (new_work - work),
                    damped + s * (new_damped - damped), lost, 0.0, 0.0, FLIGHT,
                )  # fmt: skip
                sample += 1
            if watches:
                end_a, end_w, end_d = slopes(t + h, new_x, new_v, g, body, p)
                segment = Segment(
                    t, t + h, x, new_x, v, new_v, a1, end_a,
                    0.5 * v * v + stiffness * potential(x),
                    0.5 * new_v * new_v + stiffness * potential(new_x),
                    w1 - d1, end_w - end_d, 0.0,
                )  # fmt: skip
                watch_step(acc, column, columns, segment)
            x, v, work, damped = new_x, new_v, new_work, new_damped
            if x < settings.low or x > settings.high:
                kind = BOTTOM if x < settings.low else TOP
                x = settings.low if kind == BOTTOM else settings.high
                after = wall_impact(v, settings.restitution)
                rows = write_contact(
                    contact_times, contact_kinds, contact_values, rows, t + h, kind, v, after
                )
                lost += 0.5 * inertia * (v * v - after * after)
                v = after
            if settings.follows_ledger != 0:
                energy = inertia * (0.5 * v * v + stiffness * potential(x))
                follow_ledger(state, energy, work - damped - lost)
            n += 1
        if n * h >= stop:
            while sample < len(sample_times) and sample_times[sample] <= stop:
                samples[0, sample], samples[1, sample] = x, v
                write_ledger(samples, sample, work, damped, lost, 0.0, 0.0, FLIGHT)
                sample += 1
        state[ANGLE_1], state[VELOCITY_1] = x, v
        state[WORK], state[DAMPED], state[IMPACT] = work, damped, lost
        counters[STEPS], counters[STRETCH], counters[SAMPLE] = n, stretch, sample
        counters[MODE] = FLIGHT
        counters[CONTACT] += rows
        counters[TOTAL_STEPS] += done
        return rows

    return trajectory
