"""Impacts in lanes: which are ordinary ones, and what they do when they are located.

An impact is noted in a column of a workspace. When enough are noted, `lane_locate` locates all at
once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics import lane_rows as r
from latolato.numerics.batch import Points, Progress, Scratch
from latolato.numerics.callbacks import ON_STEP, ON_TANGENT, Accumulators, Callbacks
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.taut_step import TautStep
from latolato.numerics.lane_locate import EXTENDABLE, MOST_DRAG
from latolato.numerics.matrices import clear_matrix, write_matrix
from latolato.numerics.parts import Part, inlined
from latolato.numerics.records import Floats
from latolato.numerics.run_record import ANY_LENGTH, REST, Run
from latolato.numerics.wall_contact import hop, wall_contact
from latolato.observables import Step
from latolato.observables.hermite import turning_angle
from latolato.physics import contacts
from latolato.physics.contacts import BOTTOM, TOP, wall_saltation


class LaneImpacts(NamedTuple):
    """The functions of impacts; see `make_lane_impacts`."""

    is_impact: Callable[..., bool]
    note_impact: Callable[..., None]
    rebound: Callable[..., None]


def make_lane_impacts(
    laws: Laws,
    rotation: Callable[..., tuple[float, float, float]],
    swing: TautStep,
    store: Callable[..., None],
    callbacks: Callbacks,
    part: Part,
) -> LaneImpacts:
    """Return the functions of impacts in lanes.

    Parameters
    ----------
    swing : Swing
        Of one ball.
    store : callable
        Writes a lane's motion back to its point.
    callbacks : Callbacks
        What observables are shown.
    """
    inline = inlined(part)
    restoring, potential = laws.restoring, laws.potential
    on_step, on_contact, on_tangent, is_wanted = (
        callbacks.step, callbacks.contact, callbacks.tangent, callbacks.is_wanted
    )  # fmt: skip

    @part
    def follow_flight(
        run: Run, accumulators: Accumulators, t: float, x: float, v: float, hs: float
    ) -> None:
        """Show the observables the matrix of a part of a step."""
        begin, run.t = run.inside[0], t
        begin.angle, begin.velocity, begin.sign = x, v, 1.0
        swing.write_forces(run, 0, t, begin)
        swing.prepare(run, 0, ANY_LENGTH, hs)
        write_matrix(run.jacobian, 0, swing.tangent(run, 0, ANY_LENGTH, begin))
        on_tangent(run, accumulators, 0, 2, hs, -run.bodies[0].damping_rate * hs, run.jacobian)

    @part
    def follow_impact(
        run: Run, accumulators: Accumulators, before: float, after: float, rests: bool, free: float
    ) -> None:
        """Show the observables the matrix of an impact; rest forgets all."""
        rate, e = run.bodies[0].damping_rate, run.settings.restitution
        clear_matrix(run.jacobian, 2)
        spread = -math.inf
        if not rests and before != 0.0:
            pulls = free - rate * before, free - rate * after
            write_matrix(run.jacobian, 0, wall_saltation(before, after, pulls[0], pulls[1]))
            spread = 2.0 * math.log(e) if e > 0.0 else -math.inf
        on_tangent(run, accumulators, 0, 2, 0.0, spread, run.jacobian)

    @inline
    def is_impact(j: int, w: Floats) -> bool:
        """Return whether lane j meets a wall within its step in an ordinary way.

        That is once, from inside or from the wall itself.
        """
        L = r.LANES
        x0, x1 = w[r.X * L + j], w[r.X1 * L + j]
        v0, v1 = w[r.V * L + j] * w[r.PER_H * L + j], w[r.V1 * L + j]
        low, high = w[r.LOW * L + j], w[r.HIGH * L + j]
        far = -1.0 if x1 <= low else 1.0
        if low < x1 < high or v1 * far <= 0.0 or not low <= x0 <= high:
            return False
        wall = low if far < 0.0 else high
        if x0 == wall and v0 * far >= 0.0:
            return False
        per_h2 = w[r.PER_H * L + j] ** 2
        a0 = (w[r.G * L + j] + w[r.C * L + j]) * w[r.S * L + j] * per_h2
        a1 = w[r.A1 * L + j]
        h = w[r.H * L + j]
        if a0 * a1 < 0.0 and min(abs(v0), abs(v1)) < max(abs(a0), abs(a1)) * h:
            return False
        return w[r.RATE * L + j] * h < MOST_DRAG

    @inline
    def note_impact(e: int, j: int, k: int, w: Floats, z: Floats, points: Points) -> None:
        """Write the impact of lane j into column e."""
        L, E = r.LANES, r.IMPACTS
        h = w[r.H * L + j]
        drag = w[r.RATE * L + j] * h
        x0, v0 = w[r.X * L + j], w[r.V * L + j]
        a0 = (w[r.G * L + j] + w[r.C * L + j]) * w[r.S * L + j] - drag * v0
        x1, v1 = w[r.X1 * L + j], w[r.V1 * L + j] * h
        a1 = w[r.A1 * L + j] * h * h - drag * v1
        far = -1.0 if x1 <= w[r.LOW * L + j] else 1.0
        z[r.IX0 * E + e], z[r.IV0 * E + e], z[r.IA0 * E + e] = x0, v0, a0
        z[r.IX1 * E + e], z[r.IV1 * E + e], z[r.IA1 * E + e] = x1, v1, a1
        z[r.IWALL * E + e] = w[r.LOW * L + j] if far < 0.0 else w[r.HIGH * L + j]
        z[r.IFAR * E + e] = far
        z[r.IG * E + e] = w[r.G * L + j]
        strength, frequency, phase = rotation(points.segments[points.firsts[k]])
        t = w[r.T * L + j] + w[r.N * L + j] * h
        z[r.ISCALE * E + e] = -h * h * strength * points.bodies[k, 0].inverse_length
        z[r.IPHASE * E + e], z[r.ITURN * E + e] = frequency * t + phase, frequency * h
        z[r.IDRAG * E + e] = drag
        z[r.INEAR * E + e] = EXTENDABLE * 2.0 * points.settings[k].tension_dip

    @inline
    def rebound(
        e: int, j: int, k: int, stop: float, w: Floats, z: Floats, accumulators: Accumulators,
        points: Points, scratch: Scratch, progress: Progress,
    ) -> None:  # fmt: skip
        """Let the ball of lane j rebound from the impact of column e; write the state of point k.

        Rebounds too small for the digits of the angle follow at once, as parabolas.
        """
        L, E = r.LANES, r.IMPACTS
        run, state = scratch.runs[0], progress.states[k]
        run.settings, run.bodies[0] = points.settings[k], points.bodies[k, 0]
        run.segment = points.segments[points.firsts[k]]
        settings, body = run.settings, run.bodies[0]
        h, per_h = w[r.H * L + j], w[r.PER_H * L + j]
        far, wall = z[r.IFAR * E + e], z[r.IWALL * E + e]
        missing, drag = z[r.IMISS * E + e], z[r.IDRAG * E + e]
        v = z[r.IV * E + e]
        a = z[r.IF * E + e] - drag * v
        before = (v + a * missing) * per_h
        t0 = w[r.T * L + j] + w[r.N * L + j] * h
        t = t0 + (z[r.IU * E + e] + missing) * h
        store(j, k, w, points, progress)
        scale = body.inertia * per_h * per_h
        driven = z[r.IDRIVEN * E + e] * z[r.IS * E + e]
        state.drive_work += scale * (z[r.IWORK * E + e] + driven * v * missing)
        state.damping_loss += scale * (z[r.ILOSS * E + e] + drag * v * v * missing)
        stiffness = settings.gravity * body.inverse_length
        s1 = restoring(wall, settings.is_linear)
        level = stiffness * potential(wall, settings.is_linear)
        watches, tangents = is_wanted(run, ON_STEP), is_wanted(run, ON_TANGENT)
        if watches:
            x0, v0 = z[r.IX0 * E + e], z[r.IV0 * E + e] * per_h
            a0 = z[r.IA0 * E + e] * per_h * per_h
            a1 = z[r.IF * E + e] * per_h * per_h - body.damping_rate * before
            segment = Step(
                t0, t, x0, wall, v0, before, a0, a1,
                0.5 * v0 * v0 + stiffness * potential(x0, settings.is_linear),
                0.5 * before * before + level,
                v0 * (a0 + stiffness * restoring(x0, settings.is_linear)),
                before * (a1 + stiffness * s1), 0.0,
                turning_angle(t - t0, x0, v0, a0, wall, before, a1),
            )  # fmt: skip
            on_step(run, accumulators, 0, segment)
        if tangents:
            x0, v0 = z[r.IX0 * E + e], z[r.IV0 * E + e] * per_h
            follow_flight(run, accumulators, t0, x0, v0, t - t0)
        while True:
            free = swing.free(run, 0, t, wall)
            after, impact, caught, rests = wall_contact(
                before, -free * far, settings.restitution, settings.rest_speed, 0.0
            )
            if tangents:
                follow_impact(run, accumulators, before, after, rests, free)
            captures = rests and impact == 0.0
            kind = contacts.REST if captures else (BOTTOM if far < 0.0 else TOP)
            on_contact(run, accumulators, 0, t, kind, before, after, abs(before))
            state.contacts += 1
            state.impact_loss += body.inertia * impact
            state.capture_loss += body.inertia * caught
            if rests:
                state.mode = REST
                if not captures:
                    on_contact(run, accumulators, 0, t, contacts.REST, 0.0, 0.0, 0.0)
                    state.contacts += 1
                break
            short, back = hop(after, abs(free), 0.0)
            if free * far <= 0.0 or short <= 0.0 or t + short >= stop or t + short <= t:
                break
            if state.contacts >= points.contact_limit:
                break
            if watches:
                p0, p1 = (
                    after * (free + stiffness * s1),
                    far * back * (free + stiffness * s1),
                )
                segment = Step(
                    t, t + short, wall, wall, after, far * back, free, free,
                    0.5 * after * after + level, 0.5 * back * back + level, p0, p1, 0.0,
                    turning_angle(short, wall, after, free, wall, far * back, free),
                )  # fmt: skip
                on_step(run, accumulators, 0, segment)
            if tangents:
                write_matrix(run.jacobian, 0, (1.0, short, 0.0, 1.0))
                on_tangent(run, accumulators, 0, 2, short, 0.0, run.jacobian)
            t, before = t + short, far * back
        state.t_base, state.steps = t, 0
        state.angle[0], state.velocity[0] = wall, after
        state.side = state.touch = far

    return LaneImpacts(
        is_impact=is_impact,
        note_impact=note_impact,
        rebound=rebound,
    )
