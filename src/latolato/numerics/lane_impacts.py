"""Impacts in lanes: found on the quintic of the step, then located on the step itself, together.

An impact is noted in a column of a workspace. When enough are noted, all are located at once: the
quintic through both ends of a step gives the share of it at which a wall is met, a step of that
share is taken, and what is missing to the wall is a short glide.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from latolato.numerics import lane_rows as r
from latolato.numerics.bounce import hop, meet_wall
from latolato.numerics.flight import Law, Method, Part, Point, prepare
from latolato.numerics.many import Points, Progress, Scratch, Weights
from latolato.numerics.records import (
    ANGLE_1,
    CAPTURED,
    CONTACT,
    DAMPED,
    IMPACT,
    MATRIX,
    MODE,
    REST_HIGH,
    REST_LOW,
    STEPS,
    T_BASE,
    VELOCITY_1,
    WORK,
)
from latolato.numerics.tangent import clear_matrix, write_matrix
from latolato.numerics.watch import Watch
from latolato.observables import Segment
from latolato.physics.contacts import BOTTOM, REST, TOP, wall_saltation
from latolato.scalar import cosine, formula

# An impact is corrected along the parabola over this share of a step, times its squared angle;
# the velocity's error is then about 1e-3 of the tolerance.
_GLIDE = 2.4e-4
_MOST_LANDINGS = 4
_MOST_TRIALS = 5

# Impacts are gathered until so many can be located together.
IMPACTS = 16
# Rows of the impacts' workspace, in units of the step: both ends of the full step, its quintic's
# coefficients, the wall, laws and the drive's phase.
_IX0, _IV0, _IA0, _IX1, _IV1, _IA1 = 0, 1, 2, 3, 4, 5
_IB, _IC2, _IC3, _IC4, _IC5 = 6, 7, 8, 9, 10
_IWALL, _IFAR, _IG, _ISCALE, _IPHASE, _ITURN, _IDRAG, _INEAR = 11, 12, 13, 14, 15, 16, 17, 18
# The search: bracket and share of the step; then the motion at that share, and what is missing.
_ILOW, _IHIGH, _IU = 19, 20, 21
_IX, _IV, _IS, _IF, _IDRIVEN, _IWORK, _ILOSS, _IMISS, DONE = 22, 23, 24, 25, 26, 27, 28, 29, 30
IMPACT_ROWS = 31
# What is noted of an impact; the rest is found.
NOTED_ROWS = _INEAR + 1
# The largest drag per step that `reach_series` is good for.
_MOST_DRAG = 0.5


@formula
def reach_series(x: float) -> float:
    """Return (1 - exp(-x))/x for |x| < 0.2, to 1e-15; without branches, for vectors."""
    total = 1.0
    for n in range(11, 1, -1):
        total = 1.0 - x / n * total
    return total


class LaneImpacts(NamedTuple):
    """The functions of impacts; see `make_lane_impacts`."""

    is_impact: Callable[..., bool]
    note_impact: Callable[..., None]
    locate_all: Callable[..., None]
    rebound: Callable[..., None]


def make_lane_impacts(
    restoring: Callable[..., float],
    potential: Callable[..., float],
    rotation: Callable[..., tuple[float, float, float]],
    force: Callable[..., Any],
    store: Callable[..., None],
    tangent: Callable[..., Any],
    watch: Watch,
    compile_part: Part | None = None,
    *,
    damped: bool,
    works: bool,
    watches: bool,
    tangents: bool,
) -> LaneImpacts:
    """Return the functions of impacts in lanes.

    Parameters
    ----------
    force : callable
        Of `flight.Flight`.
    store : callable
        Writes a lane's motion back to its point.
    tangent : callable
        Of `tangent.make_tangent`.
    watch : Watch
        What observables are shown.

    Other parameters are those of `lanes.make_lanes`.
    """
    part: Part = compile_part or (lambda function: function)
    inlined: Part = partial(compile_part, inline=True) if compile_part else part
    watch_step, on_contact, watch_tangent = watch.step, watch.contact, watch.tangent

    @part
    def follow_flight(
        acc: Any, j: int, t: float, x: float, v: float, hs: float, law: Law, weights: Weights,
        scratch: Scratch,
    ) -> None:  # fmt: skip
        """Show the observables the matrix of a part of a step."""
        jacobian = scratch.space[MATRIX]
        method = Method(scratch.tables[1], weights.kicks, weights.drifts, weights.nodes)
        prepare(method, hs, law.body.rate)
        a, driven, lift = force(t, x, 1.0, law)
        point = Point(t, x, v, a, driven, lift)
        write_matrix(jacobian, 0, tangent(point, 1.0, method.table, law))
        watch_tangent(acc, j, r.LANES, 2, hs, -law.body.rate * hs, jacobian)

    @part
    def follow_impact(
        acc: Any, j: int, before: float, after: float, rests: bool, free: float, rate: float,
        restitution: float, scratch: Scratch,
    ) -> None:  # fmt: skip
        """Show the observables the matrix of an impact; rest forgets all."""
        jacobian = scratch.space[MATRIX]
        clear_matrix(jacobian, 2)
        spread = -math.inf
        if not rests and before != 0.0:
            pulls = free - rate * before, free - rate * after
            write_matrix(jacobian, 0, wall_saltation(before, after, pulls[0], pulls[1]))
            spread = 2.0 * math.log(restitution) if restitution > 0.0 else -math.inf
        watch_tangent(acc, j, r.LANES, 2, 0.0, spread, jacobian)

    @inlined
    def is_impact(j: int, w: Any) -> bool:
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
        return w[r.RATE * L + j] * h < _MOST_DRAG

    @inlined
    def note_impact(e: int, j: int, k: int, w: Any, z: Any, points: Points) -> None:
        """Write the impact of lane j into column e."""
        L, E = r.LANES, IMPACTS
        h = w[r.H * L + j]
        drag = w[r.RATE * L + j] * h
        x0, v0 = w[r.X * L + j], w[r.V * L + j]
        a0 = (w[r.G * L + j] + w[r.C * L + j]) * w[r.S * L + j] - drag * v0
        x1, v1 = w[r.X1 * L + j], w[r.V1 * L + j] * h
        a1 = w[r.A1 * L + j] * h * h - drag * v1
        far = -1.0 if x1 <= w[r.LOW * L + j] else 1.0
        z[_IX0 * E + e], z[_IV0 * E + e], z[_IA0 * E + e] = x0, v0, a0
        z[_IX1 * E + e], z[_IV1 * E + e], z[_IA1 * E + e] = x1, v1, a1
        z[_IWALL * E + e] = w[r.LOW * L + j] if far < 0.0 else w[r.HIGH * L + j]
        z[_IFAR * E + e] = far
        z[_IG * E + e] = w[r.G * L + j]
        strength, frequency, phase = rotation(points.stretches[points.firsts[k]])
        t = w[r.T * L + j] + w[r.N * L + j] * h
        z[_ISCALE * E + e] = -h * h * strength * points.bodies[k, 0].coupling
        z[_IPHASE * E + e], z[_ITURN * E + e] = frequency * t + phase, frequency * h
        z[_IDRAG * E + e] = drag
        z[_INEAR * E + e] = _GLIDE * 2.0 * points.settings[k].sag

    @part
    def solve_quintics(z: Any) -> None:
        """Find the shares of the step at which the quintics through both ends meet the walls.

        A ball that starts on the wall meets it again where the quintic over the share vanishes.
        """
        E = IMPACTS
        for e in range(E):
            d = z[_IX1 * E + e] - z[_IX0 * E + e]
            b1, c1 = z[_IV0 * E + e], 0.5 * z[_IA0 * E + e]
            r0, r1 = d - b1 - c1, z[_IV1 * E + e] - b1 - 2.0 * c1
            r2 = 0.5 * z[_IA1 * E + e] - c1
            z[_IB * E + e], z[_IC2 * E + e] = b1, c1
            z[_IC3 * E + e] = 10.0 * r0 - 4.0 * r1 + r2
            z[_IC4 * E + e] = -15.0 * r0 + 7.0 * r1 - 2.0 * r2
            z[_IC5 * E + e] = 6.0 * r0 - 3.0 * r1 + r2
            gap = z[_IWALL * E + e] - z[_IX0 * E + e]
            on_wall = -2.0 * b1 / (z[_IA0 * E + e] if z[_IA0 * E + e] != 0.0 else 1.0)
            guess = on_wall if gap == 0.0 else gap / d
            z[_ILOW * E + e], z[_IHIGH * E + e] = 0.0, 1.0
            z[_IU * E + e] = guess if (guess > 0.0) & (guess < 1.0) else 0.5
        for _ in range(_MOST_TRIALS):
            for e in range(E):
                u, far = z[_IU * E + e], z[_IFAR * E + e]
                c2, c3, c4 = z[_IC2 * E + e], z[_IC3 * E + e], z[_IC4 * E + e]
                c5, b1 = z[_IC5 * E + e], z[_IB * E + e]
                gap = z[_IWALL * E + e] - z[_IX0 * E + e]
                q = b1 + u * (c2 + u * (c3 + u * (c4 + u * c5)))
                dq = c2 + u * (2.0 * c3 + u * (3.0 * c4 + u * 4.0 * c5))
                on_wall = gap == 0.0
                value = q if on_wall else u * q - gap
                slope = dq if on_wall else q + u * dq
                beyond = value * far >= 0.0
                low = z[_ILOW * E + e] if beyond else u
                high = u if beyond else z[_IHIGH * E + e]
                trial = u - value / (slope if slope != 0.0 else 1.0)
                inside = (trial >= low) & (trial <= high)
                z[_ILOW * E + e], z[_IHIGH * E + e] = low, high
                z[_IU * E + e] = trial if inside else 0.5 * (low + high)

    @part
    def fly_to_shares(z: Any, kicks: Any, drifts: Any, nodes: Any) -> None:
        """Take from every start the step of the share that was found."""
        E = IMPACTS
        for e in range(E):
            z[_IX * E + e], z[_IV * E + e] = z[_IX0 * E + e], z[_IV0 * E + e]
            z[_IS * E + e] = restoring(z[_IX0 * E + e])
            driven = z[_ISCALE * E + e] * cosine(z[_IPHASE * E + e])
            z[_IDRIVEN * E + e] = driven
            z[_IWORK * E + e] = 0.0
            z[_ILOSS * E + e] = 0.0
        stages = len(drifts)
        for i in range(stages):
            b, a, c = kicks[i], drifts[i], nodes[i]
            for e in range(E):
                u = z[_IU * E + e]
                s, driven = z[_IS * E + e], z[_IDRIVEN * E + e]
                v = z[_IV * E + e]
                change = b * u * (z[_IG * E + e] + driven) * s
                if works:
                    z[_IWORK * E + e] += b * u * driven * s * (v + 0.5 * change)
                v += change
                reach = a * u
                if damped:
                    reach *= reach_series(z[_IDRAG * E + e] * reach)
                    slowed = v - v * (z[_IDRAG * E + e] * reach)
                    if works:
                        z[_ILOSS * E + e] += 0.5 * (v - slowed) * (v + slowed)
                    x = z[_IX * E + e] + v * reach
                    v = slowed
                else:
                    x = z[_IX * E + e] + v * reach
                z[_IX * E + e], z[_IV * E + e] = x, v
                z[_IS * E + e] = restoring(x)
                turn = z[_IPHASE * E + e] + z[_ITURN * E + e] * (c * u)
                z[_IDRIVEN * E + e] = z[_ISCALE * E + e] * cosine(turn)
        b = kicks[stages]
        for e in range(E):
            driven, s, v = z[_IDRIVEN * E + e], z[_IS * E + e], z[_IV * E + e]
            u = z[_IU * E + e]
            force = (z[_IG * E + e] + driven) * s
            change = b * u * force
            if works:
                z[_IWORK * E + e] += b * u * driven * s * (v + 0.5 * change)
            z[_IV * E + e] = v + change
            z[_IF * E + e] = force

    @part
    def locate_all(z: Any, weights: Weights) -> None:
        """Locate the impacts: each share is corrected until what is missing is a short glide.

        `DONE` is then 1, or not if the impact is no ordinary one.
        """
        E = IMPACTS
        solve_quintics(z)
        for e in range(E):
            z[DONE * E + e] = 0.0
        for _ in range(_MOST_LANDINGS):
            fly_to_shares(z, weights.kicks, weights.drifts, weights.nodes)
            rest = 0.0
            for e in range(E):
                v, far, u = z[_IV * E + e], z[_IFAR * E + e], z[_IU * E + e]
                a = z[_IF * E + e] - z[_IDRAG * E + e] * v
                comes = v * far > 0.0
                missing = (z[_IWALL * E + e] - z[_IX * E + e]) / (v if comes else 1.0)
                missing -= 0.5 * a * missing * missing / (v if comes else 1.0)
                z[_IMISS * E + e] = missing
                lands = comes & (abs(missing) <= z[_INEAR * E + e])
                moved = u + missing
                moves = comes & (not lands) & (moved > 0.0) & (moved < 1.0)
                z[_IU * E + e] = moved if moves else u
                z[DONE * E + e] = 1.0 if lands else 0.0
                rest += 1.0 if moves else 0.0
            if rest == 0.0:
                return

    @inlined
    def rebound(
        e: int, j: int, k: int, stop: float, w: Any, z: Any, acc: Any, points: Points,
        weights: Weights, scratch: Scratch, progress: Progress,
    ) -> None:  # fmt: skip
        """Let the ball of lane j rebound from the impact of column e; write the state of point k.

        Rebounds too small for the digits of the angle follow at once, as parabolas.
        """
        L, E = r.LANES, IMPACTS
        settings, body = points.settings[k], points.bodies[k, 0]
        state, counters = progress.state, progress.counters
        h, per_h = w[r.H * L + j], w[r.PER_H * L + j]
        far, wall = z[_IFAR * E + e], z[_IWALL * E + e]
        missing, drag = z[_IMISS * E + e], z[_IDRAG * E + e]
        v = z[_IV * E + e]
        pull = z[_IF * E + e] - drag * v
        before = (v + pull * missing) * per_h
        t0 = w[r.T * L + j] + w[r.N * L + j] * h
        t = t0 + (z[_IU * E + e] + missing) * h
        store(j, k, w, points, progress)
        if works:
            scale = body.inertia * per_h * per_h
            driven = z[_IDRIVEN * E + e] * z[_IS * E + e]
            state[k, WORK] += scale * (z[_IWORK * E + e] + driven * v * missing)
            state[k, DAMPED] += scale * (z[_ILOSS * E + e] + drag * v * v * missing)
        stiffness = settings.gravity * body.coupling
        s1 = restoring(wall)
        level = stiffness * potential(wall)
        if watches:
            x0, v0 = z[_IX0 * E + e], z[_IV0 * E + e] * per_h
            a0 = z[_IA0 * E + e] * per_h * per_h
            a1 = z[_IF * E + e] * per_h * per_h - body.rate * before
            segment = Segment(
                t0, t, x0, wall, v0, before, a0, a1,
                0.5 * v0 * v0 + stiffness * potential(x0), 0.5 * before * before + level,
                v0 * (a0 + stiffness * restoring(x0)), before * (a1 + stiffness * s1), 0.0,
            )  # fmt: skip
            watch_step(acc, j, L, segment)
        law = Law(settings.gravity, body, points.stretches[points.firsts[k]])
        if tangents:
            x0, v0 = z[_IX0 * E + e], z[_IV0 * E + e] * per_h
            follow_flight(acc, j, t0, x0, v0, t - t0, law, weights, scratch)
        while True:
            force_now, _, _ = force(t, wall, 1.0, law)
            after, impact, caught, rests = meet_wall(
                before, -force_now * far, settings.restitution, settings.rest_speed, 0.0
            )
            if tangents:
                e_now = settings.restitution
                follow_impact(acc, j, before, after, rests, force_now, body.rate, e_now, scratch)
            captures = rests and impact == 0.0
            kind = REST if captures else (BOTTOM if far < 0.0 else TOP)
            on_contact(acc, j, L, t, kind, before, after, abs(before))
            counters[k, CONTACT] += 1
            state[k, IMPACT] += body.inertia * impact
            state[k, CAPTURED] += body.inertia * caught
            if rests:
                counters[k, MODE] = REST_LOW if far < 0.0 else REST_HIGH
                if not captures:
                    on_contact(acc, j, L, t, REST, 0.0, 0.0, 0.0)
                    counters[k, CONTACT] += 1
                break
            short, back = hop(after, abs(force_now), 0.0)
            if force_now * far <= 0.0 or short <= 0.0 or t + short >= stop or t + short <= t:
                break
            if counters[k, CONTACT] >= points.contact_limit:
                break
            if watches:
                p0, p1 = (
                    after * (force_now + stiffness * s1),
                    far * back * (force_now + stiffness * s1),
                )
                segment = Segment(
                    t, t + short, wall, wall, after, far * back, force_now, force_now,
                    0.5 * after * after + level, 0.5 * back * back + level, p0, p1, 0.0,
                )  # fmt: skip
                watch_step(acc, j, L, segment)
            if tangents:
                jacobian = scratch.space[MATRIX]
                write_matrix(jacobian, 0, (1.0, short, 0.0, 1.0))
                watch_tangent(acc, j, L, 2, short, 0.0, jacobian)
            t, before = t + short, far * back
        state[k, T_BASE], state[k, ANGLE_1], state[k, VELOCITY_1] = t, wall, after
        counters[k, STEPS] = 0

    return LaneImpacts(is_impact, note_impact, locate_all, rebound)
