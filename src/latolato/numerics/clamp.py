"""The fixed-step clamp: classical Runge-Kutta with reflection on overlap, an artefact by design.

It shows what a program without contact location does: it moves the ball back onto the wall, so
energy appears from nowhere, and rounding and step size set a ball at rest in motion.
"""

from __future__ import annotations

from collections.abc import Callable

from latolato.numerics.callbacks import ON_STEP, Accumulators, Callbacks
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.loop import Timetable
from latolato.numerics.engine.samples import follow_ledger, write_sample
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import FLIGHT, UNSETTLED, Output, Run
from latolato.observables import Step
from latolato.observables.hermite import turning_angle
from latolato.physics.contacts import BOTTOM, TOP, wall_impact
from latolato.physics.damping import drag
from latolato.physics.pendulum import swung


def make_clamped(
    laws: Laws, count: int, callbacks: Callbacks, part: Part = as_it_stands
) -> Callable[..., int]:
    """Return the function of the clamp, with the arguments of `engine.loop.make_engine`'s."""
    pivot_acceleration, restoring, potential = (
        laws.pivot_acceleration, laws.restoring, laws.potential
    )  # fmt: skip
    on_step, is_wanted = callbacks.step, callbacks.is_wanted

    @part
    def slopes(run: Run, t: float, x: float, v: float) -> tuple[float, float, float]:
        """Return acceleration, drive power and damping power per inertia."""
        b, gravity = run.bodies[0], run.settings.gravity
        restored = restoring(x, run.settings.is_linear)
        driven = swung(pivot_acceleration(t, run.segment), b.inverse_length, restored)
        sign = 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)
        slowing = drag(v, sign, b)
        a = driven + swung(gravity, b.inverse_length, restored) - slowing
        return a, driven * v, slowing * v

    @part
    def step(run: Run) -> None:
        """Take a step of classical Runge-Kutta."""
        t, h, x, v = run.t, run.length, run.now[0].angle, run.now[0].velocity
        a1, w1, d1 = slopes(run, t, x, v)
        v2 = v + 0.5 * h * a1
        a2, w2, d2 = slopes(run, t + 0.5 * h, x + 0.5 * h * v, v2)
        v3 = v + 0.5 * h * a2
        a3, w3, d3 = slopes(run, t + 0.5 * h, x + 0.5 * h * v2, v3)
        v4 = v + h * a3
        a4, w4, d4 = slopes(run, t + h, x + h * v3, v4)
        end, inertia = run.end[0], run.bodies[0].inertia
        end.angle = x + h * (v + 2.0 * (v2 + v3) + v4) / 6.0
        end.velocity = v + h * (a1 + 2.0 * (a2 + a3) + a4) / 6.0
        run.work = inertia * h * (w1 + 2.0 * (w2 + w3) + w4) / 6.0
        run.loss = inertia * h * (d1 + 2.0 * (d2 + d3) + d4) / 6.0

    @part
    def energy(run: Run, x: float, v: float) -> float:
        """Return the energy over the moment of inertia [1/s^2]."""
        stiffness = run.settings.gravity * run.bodies[0].inverse_length
        return 0.5 * v * v + stiffness * potential(x, run.settings.is_linear)

    @part
    def show(run: Run, accumulators: Accumulators) -> None:
        """Show the observables a step."""
        x0, v0 = run.now[0].angle, run.now[0].velocity
        x1, v1 = run.end[0].angle, run.end[0].velocity
        a0, w0, d0 = slopes(run, run.t, x0, v0)
        a1, w1, d1 = slopes(run, run.t_end, x1, v1)
        segment = Step(
            run.t, run.t_end, x0, x1, v0, v1, a0, a1, energy(run, x0, v0), energy(run, x1, v1),
            w0 - d0, w1 - d1, 0.0,
            turning_angle(run.t_end - run.t, x0, v0, a0, x1, v1, a1),
        )  # fmt: skip
        on_step(run, accumulators, 0, segment)

    @part
    def put_back(run: Run, output: Output) -> None:
        """Put a ball that is found beyond a wall back onto it, with its velocity reflected."""
        settings, point, row = run.settings, run.now[0], run.rows
        if settings.low <= point.angle <= settings.high:
            return
        kind, before = BOTTOM if point.angle < settings.low else TOP, point.velocity
        point.angle = settings.low if kind == BOTTOM else settings.high
        point.velocity = wall_impact(before, settings.restitution)
        output.contact_times[row], output.contact_kinds[row] = run.t, kind
        output.contact_values[0, row], output.contact_values[1, row] = before, point.velocity
        run.rows += 1
        lost = 0.5 * (before * before - point.velocity * point.velocity)
        run.state.impact_loss += run.bodies[0].inertia * lost

    def carry_on(
        run: Run,
        timetable: Timetable,
        output: Output,
        accumulators: Accumulators,
        stop: float,
        most_steps: int,
    ) -> int:
        state, segments, times = run.state, timetable.segments, output.sample_times
        h, inertia, point = run.settings.step, run.bodies[0].inertia, run.now[0]
        run.rows = run.done = 0
        run.length, run.t = h, state.steps * h
        point.angle, point.velocity = state.angle[0], state.velocity[0]
        if state.mode == UNSETTLED:
            state.mode = FLIGHT
            state.first_energy = inertia * energy(run, point.angle, point.velocity)
            state.largest_energy = state.first_energy
        while run.t < stop and run.done < most_steps and run.rows < len(output.contact_times) - 1:
            run.done += 1
            while state.segment + 1 < len(segments) and segments[state.segment + 1].start <= run.t:
                state.segment += 1
            run.segment = segments[state.segment]
            run.t_end = (state.steps + 1) * h
            step(run)
            while state.sample < len(times) and times[state.sample] < run.t_end:
                share = (times[state.sample] - run.t) / h
                inside = run.inside[0]
                inside.angle = point.angle + share * (run.end[0].angle - point.angle)
                inside.velocity = point.velocity + share * (run.end[0].velocity - point.velocity)
                write_sample(run, output, run.inside, 1, share * run.work, share * run.loss)
            if is_wanted(run, ON_STEP):
                show(run, accumulators)
            point.angle, point.velocity = run.end[0].angle, run.end[0].velocity
            state.drive_work += run.work
            state.damping_loss += run.loss
            state.steps += 1
            run.t = run.t_end
            put_back(run, output)
            if run.settings.follows_ledger != 0:
                follow_ledger(state, inertia * energy(run, point.angle, point.velocity))
        while run.t >= stop and state.sample < len(times) and times[state.sample] <= stop:
            write_sample(run, output, run.now, 1, 0.0, 0.0)
        state.angle[0], state.velocity[0] = point.angle, point.velocity
        state.contacts += run.rows
        state.total_steps += run.done
        rows: int = run.rows
        return rows

    return carry_on
