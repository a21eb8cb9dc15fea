"""Many trajectories of one ball at once, in the lanes of vector registers.

All lanes take a full step together; each keeps its own time, step and laws. What a lane cannot do
in a full step is done for it alone afterwards: an ordinary impact here, everything else (start,
rest, release, grazing, stops) by one step of the trajectory of a single run. A lane whose point is
finished takes up the next one. What a lane computes depends on nothing but its point, so results
are the same in any lane, chunk and order.

The drive is ``strength cos(phase)``: its cosine is rotated from stage to stage instead of being
computed. Velocities are in radians per step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics.bounce import hop, meet_wall
from latolato.numerics.flight import Law, Part, make_flight
from latolato.numerics.many import Points, Progress, Scratch, Weights, make_steering
from latolato.numerics.records import (
    ANGLE_1,
    CAPTURED,
    CONTACT,
    DAMPED,
    FLIGHT,
    IMPACT,
    MODE,
    REST_HIGH,
    REST_LOW,
    STEPS,
    T_BASE,
    VELOCITY_1,
    WORK,
)
from latolato.numerics.watch import Hooks, make_watch
from latolato.observables import Segment
from latolato.physics.contacts import BOTTOM, REST, TOP
from latolato.physics.damping import decay_time
from latolato.scalar import cosine, formula, sine

# Lanes that step together: several vectors in flight hide the latency of the sine's polynomial.
LANES = 64

# Rows of the workspace, each LANES wide. First the motion: angle, velocity, restoring, the drive's
# pull and its quadrature, work, loss. Then its copy at the start of the step.
_X, _V, _S, _C, _D, _WORK, _LOSS = 0, 1, 2, 3, 4, 5, 6
_COPY = 7
_X0, _V0, _S0, _C0 = _X + _COPY, _V + _COPY, _S + _COPY, _C + _COPY
_G, _LOW, _HIGH = 14, 15, 16  # gravity's pull and the walls
_T, _N, _HALT = 17, 18, 19  # start of the step pattern [s], steps since, steps until a halt
_H, _PER_H, _RATE = 20, 21, 22  # step [s], its inverse, rate of the drag
_TAKEN = 23  # 1 where the full step is taken, 0 where the lane is put back
_X1, _V1, _A1 = 24, 25, 26  # end of a step that is not taken, in radians and seconds
_ROWS = 27

# Rows of the step's table: for each kick cosine and sine of the drive's turn since the start of the
# step, for each drift its reach and what it leaves of the velocity.
_REACH, _LEFT, _COS, _SIN = 0, 1, 2, 3
_TABLE_ROWS = 4

# The rotated phase is computed afresh after so many steps; until then its error is below 1e-13.
_RESYNC = 256.0

# An impact is corrected along the parabola over this share of a step, times its squared angle;
# the velocity's error is then about 1e-3 of the tolerance.
_GLIDE = 2.4e-4
_MOST_LANDINGS = 4
_MOST_TRIALS = 10

# Impacts are gathered until so many can be located together.
IMPACTS = 8
# Rows of the impacts' workspace, in units of the step: both ends of the full step, its quintic's
# coefficients, the wall, laws and the drive's phase.
_IX0, _IV0, _IA0, _IX1, _IV1, _IA1 = 0, 1, 2, 3, 4, 5
_IB, _IC2, _IC3, _IC4, _IC5 = 6, 7, 8, 9, 10
_IWALL, _IFAR, _IG, _ISCALE, _IPHASE, _ITURN, _IDRAG, _INEAR = 11, 12, 13, 14, 15, 16, 17, 18
# The search: bracket and share of the step; then the motion at that share, and what is missing.
_ILOW, _IHIGH, _IU = 19, 20, 21
_IX, _IV, _IS, _IF, _IDRIVEN, _IWORK, _ILOSS, _IMISS, _IDONE = 22, 23, 24, 25, 26, 27, 28, 29, 30
_IMPACT_ROWS = 31
# The halt of a lane that waits for its impact to be located.
_WAITS = -1.0
# With so few lanes still flying none waits.
_FEW = 3 * IMPACTS
# The largest drag per step that `reach_series` is good for.
_MOST_DRAG = 0.5


@formula
def reach_series(x: float) -> float:
    """Return (1 - exp(-x))/x for |x| < 0.2, to 1e-15; without branches, for vectors."""
    total = 1.0
    for n in range(11, 1, -1):
        total = 1.0 - x / n * total
    return total


def make_lanes(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    potential: Callable[..., float],
    rotation: Callable[..., tuple[float, float, float]],
    compile_part: Part | None = None,
    *,
    make: Callable[..., Callable[..., int]],
    hooks: tuple[Hooks, ...],
    damped: bool,
    walled: bool,
    works: bool,
) -> Callable[..., None]:
    """Return the function that runs the points of `order` in lanes.

    Parameters
    ----------
    rotation : formula of a stretch
        Strength [m/s^2], frequency [rad/s] and phase of the drive's acceleration.
    damped, walled, works : bool
        Whether any point has drag, whether any has walls, whether works are asked for.
    """
    part: Part = compile_part or (lambda function: function)
    laws = (acceleration, restoring, potential)
    carry_to, is_over, arrive, time_of = make_steering(make, laws, compile_part, hooks)
    flight = make_flight(acceleration, restoring, compile_part)
    force = flight.force
    watch = make_watch(hooks, compile_part)
    watch_step, on_contact, watches = watch.step, watch.contact, bool(hooks[0])

    copied = 7 if works else 5

    @part
    def advance_all(w: Any, table: Any, kicks: Any) -> None:
        """Take a full step in every lane, keeping what was before."""
        L = LANES
        for row in range(copied):
            for j in range(L):
                w[(row + _COPY) * L + j] = w[row * L + j]
        stages = table.shape[0] - 1
        for i in range(stages):
            b = kicks[i]
            reach, left = table[i, _REACH], table[i, _LEFT]
            cos, sin = table[i, _COS], table[i, _SIN]
            for j in range(L):
                driven = w[_C * L + j] * cos[j] - w[_D * L + j] * sin[j]
                v, s = w[_V * L + j], w[_S * L + j]
                change = b * (w[_G * L + j] + driven) * s
                if works:
                    w[_WORK * L + j] += b * driven * s * (v + 0.5 * change)
                v += change
                x = w[_X * L + j] + v * reach[j]
                w[_X * L + j] = x
                w[_S * L + j] = restoring(x)
                if damped:
                    slowed = v * left[j]
                    if works:
                        w[_LOSS * L + j] += 0.5 * (v - slowed) * (v + slowed)
                    v = slowed
                w[_V * L + j] = v
        b = kicks[stages]
        cos, sin = table[stages, _COS], table[stages, _SIN]
        for j in range(L):
            driven = w[_C * L + j] * cos[j] - w[_D * L + j] * sin[j]
            w[_D * L + j] = w[_D * L + j] * cos[j] + w[_C * L + j] * sin[j]
            w[_C * L + j] = driven
            v, s = w[_V * L + j], w[_S * L + j]
            change = b * (w[_G * L + j] + driven) * s
            if works:
                w[_WORK * L + j] += b * driven * s * (v + 0.5 * change)
            w[_V * L + j] = v + change

    @part
    def judge_all(w: Any) -> float:
        """Find the lanes whose full step must not be taken, and return how many they are.

        That is at a halt, where the end lies beyond a wall, and beside a wall where the force
        changes sign or where the ball turns round and may have been beyond in between.
        """
        L = LANES
        count = 0.0
        for j in range(L):
            stays = 1.0 if w[_N * L + j] >= w[_HALT * L + j] else 0.0
            if walled:
                x, x0 = w[_X * L + j], w[_X0 * L + j]
                v, v0 = w[_V * L + j], w[_V0 * L + j]
                g = w[_G * L + j]
                a = (g + w[_C * L + j]) * w[_S * L + j]
                a0 = (g + w[_C0 * L + j]) * w[_S0 * L + j]
                below = min(x, x0) - w[_LOW * L + j]
                above = w[_HIGH * L + j] - max(x, x0)
                beyond = (x <= w[_LOW * L + j]) | (x >= w[_HIGH * L + j])
                # Only a velocity that the forces can undo within the step may turn twice.
                slow = min(abs(v), abs(v0)) < max(abs(a), abs(a0))
                near = min(below, above) < abs(v) + abs(v0)
                bends = (a * a0 < 0.0) & slow & near
                dips = (v0 < 0.0) & (v > 0.0) & (below <= max(-v0, v))
                rises = (v0 > 0.0) & (v < 0.0) & (above <= max(v0, -v))
                stays = 1.0 if beyond | bends | dips | rises else stays
            w[_TAKEN * L + j] = 1.0 - stays
            count += stays
        return count

    @part
    def put_back(w: Any) -> None:
        """Note the ends of steps that are not taken, and put these lanes back to their start."""
        L = LANES
        for j in range(L):
            per_h = w[_PER_H * L + j]
            w[_X1 * L + j], w[_V1 * L + j] = w[_X * L + j], w[_V * L + j] * per_h
            a = (w[_G * L + j] + w[_C * L + j]) * w[_S * L + j]
            w[_A1 * L + j] = a * per_h * per_h
        for row in range(copied):
            for j in range(L):
                now, before = w[row * L + j], w[(row + _COPY) * L + j]
                w[row * L + j] = now if w[_TAKEN * L + j] > 0.0 else before

    @part
    def count_all(w: Any) -> None:
        """Count the steps that were taken."""
        for j in range(LANES):
            w[_N * LANES + j] += w[_TAKEN * LANES + j]

    @part
    def watch_all(w: Any, acc: Any) -> None:
        """Show the observables the step of every lane; one put back shows a step of no length."""
        L = LANES
        for j in range(L):
            h = w[_H * L + j]
            per_h, rate = w[_PER_H * L + j], w[_RATE * L + j]
            t0 = w[_T * L + j] + w[_N * L + j] * h
            x0, x1 = w[_X0 * L + j], w[_X * L + j]
            v0, v1 = w[_V0 * L + j] * per_h, w[_V * L + j] * per_h
            s0, s1 = w[_S0 * L + j], w[_S * L + j]
            per_h2 = per_h * per_h
            g = w[_G * L + j]
            a0 = (g + w[_C0 * L + j]) * s0 * per_h2 - rate * v0
            a1 = (g + w[_C * L + j]) * s1 * per_h2 - rate * v1
            stiffness = -g * per_h2
            segment = Segment(
                t0, t0 + w[_TAKEN * L + j] * h, x0, x1, v0, v1, a0, a1,
                0.5 * v0 * v0 + stiffness * potential(x0),
                0.5 * v1 * v1 + stiffness * potential(x1),
                v0 * (a0 + stiffness * s0), v1 * (a1 + stiffness * s1), 0.0,
            )  # fmt: skip
            watch_step(acc, j, L, segment)

    @part
    def turn_phase(j: int, k: int, w: Any, points: Points) -> None:
        """Compute the drive's phase of a lane afresh."""
        L = LANES
        strength, frequency, phase = rotation(points.stretches[points.firsts[k]])
        t = w[_T * L + j] + w[_N * L + j] * w[_H * L + j]
        turn = frequency * t + phase
        scale = -w[_H * L + j] * w[_H * L + j] * strength * points.bodies[k, 0].coupling
        w[_C * L + j] = scale * cosine(turn)
        w[_D * L + j] = scale * sine(turn)

    @part
    def last_step(j: int, stop: float, w: Any) -> float:
        """Return how many full steps a lane can take before a stop."""
        return (stop - w[_T * LANES + j]) / w[_H * LANES + j] - 1.0 - 1e-9

    @part
    def set_halt(j: int, stop: float, w: Any) -> None:
        """Write after how many steps a lane must be looked at: before the stop, or to resync."""
        w[_HALT * LANES + j] = min(last_step(j, stop, w), w[_N * LANES + j] + _RESYNC)

    @part
    def load(j: int, k: int, stop: float, w: Any, points: Points, progress: Progress) -> None:
        """Put the state of point k into lane j."""
        L = LANES
        state = progress.state
        h = w[_H * L + j]
        w[_X * L + j] = state[k, ANGLE_1]
        w[_V * L + j] = state[k, VELOCITY_1] * h
        w[_S * L + j] = restoring(state[k, ANGLE_1])
        w[_T * L + j] = state[k, T_BASE]
        w[_N * L + j] = float(progress.counters[k, STEPS])
        w[_WORK * L + j] = 0.0
        w[_LOSS * L + j] = 0.0
        turn_phase(j, k, w, points)
        set_halt(j, stop, w)

    @part
    def store(j: int, k: int, w: Any, points: Points, progress: Progress) -> None:
        """Write the state of lane j back to point k."""
        L = LANES
        state, counters = progress.state, progress.counters
        per_h = w[_PER_H * L + j]
        scale = points.bodies[k, 0].inertia * per_h * per_h
        state[k, ANGLE_1] = w[_X * L + j]
        state[k, VELOCITY_1] = w[_V * L + j] * per_h
        state[k, T_BASE] = w[_T * L + j]
        counters[k, STEPS] = int(w[_N * L + j])
        counters[k, MODE] = FLIGHT
        if works:
            state[k, WORK] += scale * w[_WORK * L + j]
            state[k, DAMPED] += scale * w[_LOSS * L + j]

    @part
    def take_up(
        j: int, k: int, w: Any, table: Any, acc: Any, points: Points, weights: Weights,
        progress: Progress,
    ) -> None:  # fmt: skip
        """Give lane j the laws and the accumulators of point k."""
        L = LANES
        settings, body = points.settings[k], points.bodies[k, 0]
        h = settings.step
        w[_H * L + j], w[_PER_H * L + j], w[_RATE * L + j] = h, 1.0 / h, body.rate
        w[_G * L + j] = -h * h * settings.gravity * body.coupling
        w[_LOW * L + j], w[_HIGH * L + j] = settings.low, settings.high
        _, frequency, _ = rotation(points.stretches[points.firsts[k]])
        table[0, _COS, j], table[0, _SIN, j] = 1.0, 0.0
        for i in range(table.shape[0] - 1):
            reach = decay_time(body.rate, weights.drifts[i] * h)
            turn = frequency * h * weights.nodes[i]
            table[i, _REACH, j] = reach / h
            table[i, _LEFT, j] = 1.0 - body.rate * reach
            table[i + 1, _COS, j] = cosine(turn)
            table[i + 1, _SIN, j] = sine(turn)
        columns = len(progress.status)
        for slot in range(len(acc) // L):
            acc[slot * L + j] = progress.acc[slot * columns + k]

    @part
    def make_idle(j: int, w: Any) -> None:
        """Let a ball hang still in lane j, far from walls and halts."""
        L = LANES
        for row in range(_ROWS):
            w[row * L + j] = 0.0
        w[_LOW * L + j], w[_HIGH * L + j], w[_HALT * L + j] = -math.inf, math.inf, math.inf
        w[_PER_H * L + j] = 1.0

    @part
    def lay_down(j: int, k: int, w: Any, acc: Any, progress: Progress) -> None:
        """Take the accumulators of a finished point out of lane j and leave the lane idle."""
        columns = len(progress.status)
        for slot in range(len(acc) // LANES):
            progress.acc[slot * columns + k] = acc[slot * LANES + j]
        make_idle(j, w)

    @part
    def go_on(
        j: int, k: int, index: int, w: Any, acc: Any, points: Points, weights: Weights,
        scratch: Scratch, progress: Progress,
    ) -> int:  # fmt: skip
        """Carry the stored point k on by single steps until it flies; return its next stop.

        The number of stops says that the point is finished.
        """
        stops = points.stops.shape[1]
        carried = False
        while True:
            t = time_of(k, points, progress)
            while index < stops and not points.stops[k, index] > t:  # reached, or none (NaN)
                if not math.isnan(points.stops[k, index]):
                    arrive(index, k, points, progress, acc, j, LANES)
                index += 1
            if index == stops or (carried and progress.counters[k, MODE] == FLIGHT):
                return index
            carry_to(
                points.stops[k, index], 1, k, points, weights, scratch, progress, acc, j, LANES
            )
            carried = True
            if is_over(k, points, progress):
                return stops

    @part
    def is_impact(j: int, k: int, w: Any, points: Points) -> bool:
        """Return whether lane j meets a wall within its step in an ordinary way.

        That is once, from inside or from the wall itself.
        """
        L = LANES
        x0, x1 = w[_X * L + j], w[_X1 * L + j]
        v0, v1 = w[_V * L + j] * w[_PER_H * L + j], w[_V1 * L + j]
        low, high = w[_LOW * L + j], w[_HIGH * L + j]
        far = -1.0 if x1 <= low else 1.0
        if low < x1 < high or v1 * far <= 0.0 or not low <= x0 <= high:
            return False
        wall = low if far < 0.0 else high
        if x0 == wall and v0 * far >= 0.0:
            return False
        per_h2 = w[_PER_H * L + j] ** 2
        a0 = (w[_G * L + j] + w[_C * L + j]) * w[_S * L + j] * per_h2
        a1 = w[_A1 * L + j]
        h = w[_H * L + j]
        if a0 * a1 < 0.0 and min(abs(v0), abs(v1)) < max(abs(a0), abs(a1)) * h:
            return False
        return w[_RATE * L + j] * h < _MOST_DRAG

    @part
    def note_impact(e: int, j: int, k: int, w: Any, z: Any, points: Points) -> None:
        """Write the impact of lane j into column e."""
        L, E = LANES, IMPACTS
        h = w[_H * L + j]
        drag = w[_RATE * L + j] * h
        x0, v0 = w[_X * L + j], w[_V * L + j]
        a0 = (w[_G * L + j] + w[_C * L + j]) * w[_S * L + j] - drag * v0
        x1, v1 = w[_X1 * L + j], w[_V1 * L + j] * h
        a1 = w[_A1 * L + j] * h * h - drag * v1
        far = -1.0 if x1 <= w[_LOW * L + j] else 1.0
        z[_IX0 * E + e], z[_IV0 * E + e], z[_IA0 * E + e] = x0, v0, a0
        z[_IX1 * E + e], z[_IV1 * E + e], z[_IA1 * E + e] = x1, v1, a1
        z[_IWALL * E + e] = w[_LOW * L + j] if far < 0.0 else w[_HIGH * L + j]
        z[_IFAR * E + e] = far
        z[_IG * E + e] = w[_G * L + j]
        strength, frequency, phase = rotation(points.stretches[points.firsts[k]])
        t = w[_T * L + j] + w[_N * L + j] * h
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

        `_IDONE` is then 1, or not if the impact is no ordinary one.
        """
        E = IMPACTS
        solve_quintics(z)
        for e in range(E):
            z[_IDONE * E + e] = 0.0
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
                z[_IDONE * E + e] = 1.0 if lands else 0.0
                rest += 1.0 if moves else 0.0
            if rest == 0.0:
                return

    @part
    def rebound(
        e: int, j: int, k: int, stop: float, w: Any, z: Any, acc: Any, points: Points,
        progress: Progress,
    ) -> None:  # fmt: skip
        """Let the ball of lane j rebound from the impact of column e; write the state of point k.

        Rebounds too small for the digits of the angle follow at once, as parabolas.
        """
        L, E = LANES, IMPACTS
        settings, body = points.settings[k], points.bodies[k, 0]
        state, counters = progress.state, progress.counters
        h, per_h = w[_H * L + j], w[_PER_H * L + j]
        far, wall = z[_IFAR * E + e], z[_IWALL * E + e]
        missing, drag = z[_IMISS * E + e], z[_IDRAG * E + e]
        v = z[_IV * E + e]
        pull = z[_IF * E + e] - drag * v
        before = (v + pull * missing) * per_h
        t0 = w[_T * L + j] + w[_N * L + j] * h
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
        while True:
            force_now, _, _ = force(t, wall, 1.0, law)
            after, impact, caught, rests = meet_wall(
                before, -force_now * far, settings.restitution, settings.rest_speed, 0.0
            )
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
            t, before = t + short, far * back
        state[k, T_BASE], state[k, ANGLE_1], state[k, VELOCITY_1] = t, wall, after
        counters[k, STEPS] = 0

    @part
    def refill(
        j: int, taken: int, point: Any, index: Any, order: Any, w: Any, table: Any, acc: Any,
        points: Points, weights: Weights, scratch: Scratch, progress: Progress,
    ) -> int:  # fmt: skip
        """Give lane j the next point that does not end at once; return how many were taken up."""
        stops = points.stops.shape[1]
        point[j] = -1
        while taken < len(order):
            k = order[taken]
            taken += 1
            take_up(j, k, w, table, acc, points, weights, progress)
            index[j] = go_on(j, k, 0, w, acc, points, weights, scratch, progress)
            if index[j] < stops:
                point[j] = k
                load(j, k, points.stops[k, index[j]], w, points, progress)
                return taken
            lay_down(j, k, w, acc, progress)
        return taken

    @part
    def carry(
        j: int, k: int, index: int, w: Any, acc: Any, points: Points, weights: Weights,
        scratch: Scratch, progress: Progress,
    ) -> int:  # fmt: skip
        """Carry the stored point k on by itself and load it again; return its next stop."""
        index = go_on(j, k, index, w, acc, points, weights, scratch, progress)
        if index < points.stops.shape[1]:
            load(j, k, points.stops[k, index], w, points, progress)
        return index

    @part
    def settle_impacts(
        noted: int, lane: Any, point: Any, index: Any, w: Any, z: Any, acc: Any, points: Points,
        weights: Weights, scratch: Scratch, progress: Progress,
    ) -> None:  # fmt: skip
        """Locate the noted impacts together and let each lane go on behind its own."""
        E = IMPACTS
        for e in range(noted, E):  # idle columns repeat the first
            for row in range(_INEAR + 1):
                z[row * E + e] = z[row * E]
        locate_all(z, weights)
        for e in range(noted):
            j = lane[e]
            k = point[j]
            w[_TAKEN * LANES + j] = 1.0  # seen to, for this turn
            if z[_IDONE * E + e] > 0.0:
                stop = points.stops[k, index[j]]
                rebound(e, j, k, stop, w, z, acc, points, progress)
                flies = progress.counters[k, MODE] == FLIGHT
                if flies and progress.counters[k, CONTACT] < points.contact_limit:
                    load(j, k, stop, w, points, progress)
                    continue
            else:
                store(j, k, w, points, progress)
            index[j] = carry(j, k, index[j], w, acc, points, weights, scratch, progress)

    def lanes(
        order: NDArray[np.int64],
        points: Points,
        weights: Weights,
        scratch: Scratch,
        progress: Progress,
        cancel: NDArray[np.int64],
    ) -> None:
        w, z = np.zeros(_ROWS * LANES), np.zeros(_IMPACT_ROWS * IMPACTS)
        table = np.zeros((len(weights.drifts) + 1, _TABLE_ROWS, LANES))
        acc = np.zeros(LANES * (len(progress.acc) // len(progress.status)))
        point, index = np.full(LANES, -1), np.zeros(LANES, dtype=np.int64)
        lane = np.zeros(IMPACTS, dtype=np.int64)
        stops = points.stops.shape[1]
        taken, busy, turns, noted = 0, 0, 0, 0
        for j in range(LANES):
            make_idle(j, w)
            taken = refill(
                j, taken, point, index, order, w, table, acc, points, weights, scratch, progress
            )
            busy += 1 if point[j] >= 0 else 0
        while busy > 0:
            turns += 1
            if turns % 1024 == 0 and cancel[0] != 0:
                return
            advance_all(w, table, weights.kicks)
            some = judge_all(w) > 0.0
            if some:
                put_back(w)
            if watches:
                watch_all(w, acc)
            count_all(w)
            if not some:
                continue
            for j in range(LANES):
                if w[_TAKEN * LANES + j] > 0.0 or w[_HALT * LANES + j] == _WAITS:
                    continue
                k = point[j]
                if w[_N * LANES + j] >= w[_HALT * LANES + j]:
                    stop = points.stops[k, index[j]]
                    if w[_N * LANES + j] < last_step(j, stop, w):
                        turn_phase(j, k, w, points)
                        set_halt(j, stop, w)
                        continue
                elif walled and is_impact(j, k, w, points):
                    note_impact(noted, j, k, w, z, points)
                    lane[noted] = j
                    noted += 1
                    w[_HALT * LANES + j] = _WAITS
                    if noted == IMPACTS:
                        settle_impacts(
                            noted, lane, point, index, w, z, acc, points, weights, scratch,
                            progress,
                        )  # fmt: skip
                        noted = 0
                    continue
                store(j, k, w, points, progress)
                index[j] = carry(j, k, index[j], w, acc, points, weights, scratch, progress)
            if noted > 0 and noted >= busy - _FEW:
                settle_impacts(
                    noted, lane, point, index, w, z, acc, points, weights, scratch, progress
                )
                noted = 0
            for j in range(LANES):
                if point[j] >= 0 and index[j] == stops:
                    lay_down(j, point[j], w, acc, progress)
                    taken = refill(
                        j, taken, point, index, order, w, table, acc, points, weights, scratch,
                        progress,
                    )  # fmt: skip
                    busy -= 1 if point[j] < 0 else 0

    return lanes
