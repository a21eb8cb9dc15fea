"""Many trajectories of one ball at once, in the lanes of vector registers.

All lanes take a full step together; each keeps its own time, step and laws. What a lane cannot do
in a full step is done for it alone afterwards: an ordinary impact here, everything else (start,
rest, release, grazing, stops) by one step of the trajectory of a single run. A lane whose point is
finished takes up the next one. What a lane computes depends on nothing but its point, so results
are the same in any lane, chunk and order.

The drive is ``strength cos(phase)``: its cosine is rotated from stage to stage instead of being
computed. Velocities are in radians per step. Parts: `lane_rows` (where numbers lie), `lane_flight`
(what all lanes do), `lane_impacts`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics import lane_rows as r
from latolato.numerics.flight import Part, make_flight
from latolato.numerics.lane_flight import make_lane_flight
from latolato.numerics.lane_impacts import (
    DONE,
    IMPACT_ROWS,
    IMPACTS,
    NOTED_ROWS,
    make_lane_impacts,
)
from latolato.numerics.many import Points, Progress, Scratch, Weights, make_steering
from latolato.numerics.records import (
    ANGLE_1,
    CONTACT,
    DAMPED,
    FLIGHT,
    MATRIX,
    MODE,
    STEPS,
    T_BASE,
    VELOCITY_1,
    WORK,
)
from latolato.numerics.tangent import make_tangent
from latolato.numerics.watch import Hooks, make_watch
from latolato.physics.damping import decay_time
from latolato.scalar import cosine, sine

# The rotated phase is computed afresh after so many steps; until then its error is below 1e-13.
_RESYNC = 256.0

# With so few lanes still flying none waits for the impacts of others.
_FEW = 3 * IMPACTS


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
    # What every impact needs: passing the arrays of all points to a call costs more than the rest.
    inlined: Part = partial(compile_part, inline=True) if compile_part else part
    laws = (acceleration, restoring, potential)
    carry_to, is_over, arrive, time_of = make_steering(make, laws, compile_part, hooks)
    watch, watches, tangents = make_watch(hooks, compile_part), bool(hooks[0]), bool(hooks[4])
    advance_all, judge_all, put_back, count_all, watch_all, follow_all = make_lane_flight(
        restoring, potential, watch, compile_part,
        damped=damped, walled=walled, works=works, tangents=tangents,
    )  # fmt: skip

    @inlined
    def turn_phase(j: int, k: int, w: Any, points: Points) -> None:
        """Compute the drive's phase of a lane afresh."""
        L = r.LANES
        strength, frequency, phase = rotation(points.stretches[points.firsts[k]])
        t = w[r.T * L + j] + w[r.N * L + j] * w[r.H * L + j]
        turn = frequency * t + phase
        scale = -w[r.H * L + j] * w[r.H * L + j] * strength * points.bodies[k, 0].coupling
        w[r.C * L + j] = scale * cosine(turn)
        w[r.D * L + j] = scale * sine(turn)

    @inlined
    def last_step(j: int, stop: float, w: Any) -> float:
        """Return how many full steps a lane can take before a stop."""
        return (stop - w[r.T * r.LANES + j]) / w[r.H * r.LANES + j] - 1.0 - 1e-9

    @inlined
    def set_halt(j: int, stop: float, w: Any) -> None:
        """Write after how many steps a lane must be looked at: before the stop, or to resync."""
        w[r.HALT * r.LANES + j] = min(last_step(j, stop, w), w[r.N * r.LANES + j] + _RESYNC)

    @inlined
    def load(j: int, k: int, stop: float, w: Any, points: Points, progress: Progress) -> None:
        """Put the state of point k into lane j."""
        L = r.LANES
        state = progress.state
        h = w[r.H * L + j]
        w[r.X * L + j] = state[k, ANGLE_1]
        w[r.V * L + j] = state[k, VELOCITY_1] * h
        w[r.S * L + j] = restoring(state[k, ANGLE_1])
        w[r.T * L + j] = state[k, T_BASE]
        w[r.N * L + j] = float(progress.counters[k, STEPS])
        w[r.WORK * L + j] = 0.0
        w[r.LOSS * L + j] = 0.0
        turn_phase(j, k, w, points)
        set_halt(j, stop, w)

    @inlined
    def store(j: int, k: int, w: Any, points: Points, progress: Progress) -> None:
        """Write the state of lane j back to point k."""
        L = r.LANES
        state, counters = progress.state, progress.counters
        per_h = w[r.PER_H * L + j]
        scale = points.bodies[k, 0].inertia * per_h * per_h
        state[k, ANGLE_1] = w[r.X * L + j]
        state[k, VELOCITY_1] = w[r.V * L + j] * per_h
        state[k, T_BASE] = w[r.T * L + j]
        counters[k, STEPS] = int(w[r.N * L + j])
        counters[k, MODE] = FLIGHT
        if works:
            state[k, WORK] += scale * w[r.WORK * L + j]
            state[k, DAMPED] += scale * w[r.LOSS * L + j]

    is_impact, note_impact, locate_all, rebound = make_lane_impacts(
        restoring,
        potential,
        rotation,
        make_flight(acceleration, restoring, compile_part).force,
        store,
        make_tangent(acceleration, restoring, compile_part),
        watch,
        compile_part,
        damped=damped,
        works=works,
        watches=watches,
        tangents=tangents,
    )

    @part
    def take_up(
        j: int, k: int, w: Any, table: Any, acc: Any, points: Points, weights: Weights,
        progress: Progress,
    ) -> None:  # fmt: skip
        """Give lane j the laws and the accumulators of point k."""
        L = r.LANES
        settings, body = points.settings[k], points.bodies[k, 0]
        h = settings.step
        w[r.H * L + j], w[r.PER_H * L + j], w[r.RATE * L + j] = h, 1.0 / h, body.rate
        w[r.G * L + j] = -h * h * settings.gravity * body.coupling
        w[r.LOW * L + j], w[r.HIGH * L + j] = settings.low, settings.high
        _, frequency, _ = rotation(points.stretches[points.firsts[k]])
        table[0, r.COS, j], table[0, r.SIN, j] = 1.0, 0.0
        for i in range(table.shape[0] - 1):
            reach = decay_time(body.rate, weights.drifts[i] * h)
            turn = frequency * h * weights.nodes[i]
            table[i, r.REACH, j] = reach / h
            table[i, r.LEFT, j] = 1.0 - body.rate * reach
            table[i + 1, r.COS, j] = cosine(turn)
            table[i + 1, r.SIN, j] = sine(turn)
        columns = len(progress.status)
        for slot in range(len(acc) // L):
            acc[slot * L + j] = progress.acc[slot * columns + k]

    @part
    def make_idle(j: int, w: Any) -> None:
        """Let a ball hang still in lane j, far from walls and halts."""
        L = r.LANES
        for row in range(r.ROWS):
            w[row * L + j] = 0.0
        w[r.LOW * L + j], w[r.HIGH * L + j], w[r.HALT * L + j] = -math.inf, math.inf, math.inf
        w[r.PER_H * L + j] = 1.0

    @part
    def lay_down(j: int, k: int, w: Any, acc: Any, progress: Progress) -> None:
        """Take the accumulators of a finished point out of lane j and leave the lane idle."""
        columns = len(progress.status)
        for slot in range(len(acc) // r.LANES):
            progress.acc[slot * columns + k] = acc[slot * r.LANES + j]
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
                    arrive(index, k, points, progress, acc, j, r.LANES)
                index += 1
            if index == stops or (carried and progress.counters[k, MODE] == FLIGHT):
                return index
            carry_to(
                points.stops[k, index], 1, k, points, weights, scratch, progress, acc, j, r.LANES
            )
            carried = True
            if is_over(k, points, progress):
                return stops

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
            for row in range(NOTED_ROWS):
                z[row * E + e] = z[row * E]
        locate_all(z, weights)
        for e in range(noted):
            j = lane[e]
            k = point[j]
            w[r.TAKEN * r.LANES + j] = 1.0  # seen to, for this turn
            if z[DONE * E + e] > 0.0:
                stop = points.stops[k, index[j]]
                rebound(e, j, k, stop, w, z, acc, points, weights, scratch, progress)
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
        w, z = np.zeros(r.ROWS * r.LANES), np.zeros(IMPACT_ROWS * IMPACTS)
        table = np.zeros((len(weights.drifts) + 1, r.TABLE_ROWS, r.LANES))
        acc = np.zeros(r.LANES * (len(progress.acc) // len(progress.status)))
        point, index = np.full(r.LANES, -1), np.zeros(r.LANES, dtype=np.int64)
        lane = np.zeros(IMPACTS, dtype=np.int64)
        stops = points.stops.shape[1]
        taken, busy, turns, noted = 0, 0, 0, 0
        for j in range(r.LANES):
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
            if tangents:
                follow_all(w, acc, scratch.space[MATRIX])
            count_all(w)
            if not some:
                continue
            for j in range(r.LANES):
                if w[r.TAKEN * r.LANES + j] > 0.0 or w[r.HALT * r.LANES + j] == r.WAITS:
                    continue
                k = point[j]
                if w[r.N * r.LANES + j] >= w[r.HALT * r.LANES + j]:
                    stop = points.stops[k, index[j]]
                    if w[r.N * r.LANES + j] < last_step(j, stop, w):
                        turn_phase(j, k, w, points)
                        set_halt(j, stop, w)
                        continue
                elif walled and is_impact(j, w):
                    note_impact(noted, j, k, w, z, points)
                    lane[noted] = j
                    noted += 1
                    w[r.HALT * r.LANES + j] = r.WAITS
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
            for j in range(r.LANES):
                if point[j] >= 0 and index[j] == stops:
                    lay_down(j, point[j], w, acc, progress)
                    taken = refill(
                        j, taken, point, index, order, w, table, acc, points, weights, scratch,
                        progress,
                    )  # fmt: skip
                    busy -= 1 if point[j] < 0 else 0

    return lanes
