"""Many trajectories of one ball at once, in the lanes of vector registers.

All lanes take a full step together; each keeps its own time, step and laws. Anything that a lane
cannot do in a full step is then done for it alone: an ordinary impact here, everything else (start,
rest, release, grazing, stops) by one step of the trajectory of a single run. A lane whose point is
finished takes up the next one. What a lane computes depends only on its point, so results are the
same in any lane, chunk and order.

The drive is ``strength cos(phase)``: its cosine is rotated from stage to stage instead of being
computed. Velocities are in radians per step. Parts: `lane_rows` (where numbers lie), `lane_flight`
(what all lanes do), `lane_impacts`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from latolato.core.scalar import cosine, sine
from latolato.numerics import lane_rows as r
from latolato.numerics.abi import LANE_LOCATE, LANE_REPORT, LANE_STEP
from latolato.numerics.batch import LaneSpace, Points, Progress, Task, empty_task, make_steering
from latolato.numerics.callback_kernels import make_address_callbacks, make_caller
from latolato.numerics.callbacks import Accumulators
from latolato.numerics.engine.laws import Formula, laws_of
from latolato.numerics.engine.taut_step import make_taut_step
from latolato.numerics.lane_flight import width_of
from latolato.numerics.lane_impacts import make_lane_impacts
from latolato.numerics.parts import Part, inlined
from latolato.numerics.pointers import address_of, bundle_at, caller_of, kind_of
from latolato.numerics.records import Floats, Integers
from latolato.numerics.run_record import FLIGHT, Run
from latolato.physics.damping import effective_time

# The rotated phase is computed afresh after so many steps; until then its error is below 1e-13.
_RESYNC = 256.0

# With so few lanes still flying none waits for the impacts of others.
_FEW = 3 * r.IMPACTS


# What is shown to observables, in the table of `LaneSpace`.
_STEPS, _MATRICES = 0, 1


def make_lanes(
    acceleration: Formula,
    restoring_of: Formula,
    potential_of: Formula,
    rotation: Callable[..., tuple[float, float, float]],
    part: Part,
    *,
    segment: np.dtype[Any],
) -> Callable[[int], None]:
    """Return the function ``(address)`` that runs the points of a `Task` in lanes.

    Parameters
    ----------
    rotation : formula of a segment
        Strength [m/s^2], frequency [rad/s] and phase of the drive's acceleration.
    segment : dtype
        The layout of the drive's segments.
    """
    # What every impact needs is inlined.
    inline = inlined(part)
    callbacks, task_at = make_address_callbacks(part), bundle_at(kind_of(empty_task(segment)))
    steering = make_steering(make_caller(part), callbacks, part)
    start, carry_to, is_over, arrive, time_of = steering
    laws = laws_of(acceleration, restoring_of, potential_of, part=part)
    restoring, potential = laws.restoring, laws.potential
    take_step, locate_impacts = caller_of(LANE_STEP), caller_of(LANE_LOCATE)
    report = caller_of(LANE_REPORT)

    @part
    def show_all(occasion: int, run: Run, space: LaneSpace) -> None:
        """Show the observables the step of every lane, or its matrix."""
        callbacks, slots, w = space.callbacks, address_of(space.acc), address_of(space.w)
        matrix, row = address_of(run.jacobian), 8 * r.LANES
        at = callbacks[occasion]
        while callbacks[at] != 0:
            report(
                callbacks[at], (slots + row * callbacks[at + 1], w, matrix, run.settings.is_linear)
            )
            at += 2

    @part
    def count_all(w: Floats) -> None:
        """Count the steps that were taken."""
        for j in range(width_of(w)):
            w[r.N * r.LANES + j] += w[r.TAKEN * r.LANES + j]

    @inline
    def turn_phase(j: int, k: int, w: Floats, points: Points) -> None:
        """Compute the drive's phase of a lane afresh."""
        L = r.LANES
        strength, frequency, phase = rotation(points.segments[points.firsts[k]])
        t = w[r.T * L + j] + w[r.N * L + j] * w[r.H * L + j]
        turn = frequency * t + phase
        scale = -w[r.H * L + j] * w[r.H * L + j] * strength * points.bodies[k, 0].inverse_length
        w[r.C * L + j] = scale * cosine(turn)
        w[r.D * L + j] = scale * sine(turn)

    @inline
    def last_step(j: int, stop: float, w: Floats) -> float:
        """Return how many full steps a lane can take before a stop."""
        return (stop - w[r.T * r.LANES + j]) / w[r.H * r.LANES + j] - 1.0 - 1e-9

    @inline
    def set_halt(j: int, stop: float, w: Floats) -> None:
        """Write after how many steps a lane must be looked at: before the stop, or to resync."""
        w[r.HALT * r.LANES + j] = min(last_step(j, stop, w), w[r.N * r.LANES + j] + _RESYNC)

    @inline
    def load(j: int, k: int, stop: float, w: Floats, points: Points, progress: Progress) -> None:
        """Put the state of point k into lane j."""
        L = r.LANES
        state = progress.states[k]
        h = w[r.H * L + j]
        w[r.X * L + j] = state.angle[0]
        w[r.V * L + j] = state.velocity[0] * h
        w[r.S * L + j] = restoring(state.angle[0], points.settings[k].is_linear)
        w[r.P1 * L + j] = potential(state.angle[0], points.settings[k].is_linear)
        w[r.T * L + j] = state.t_base
        w[r.N * L + j] = float(state.steps)
        w[r.WORK * L + j] = 0.0
        w[r.LOSS * L + j] = 0.0
        turn_phase(j, k, w, points)
        set_halt(j, stop, w)

    @inline
    def store(j: int, k: int, w: Floats, points: Points, progress: Progress) -> None:
        """Write the state of lane j back to point k."""
        L = r.LANES
        state = progress.states[k]
        per_h = w[r.PER_H * L + j]
        scale = points.bodies[k, 0].inertia * per_h * per_h
        x = w[r.X * L + j]
        state.touch = -1.0 if x <= w[r.LOW * L + j] else (1.0 if x >= w[r.HIGH * L + j] else 0.0)
        state.angle[0] = x
        state.velocity[0] = w[r.V * L + j] * per_h
        state.t_base = w[r.T * L + j]
        state.steps = int(w[r.N * L + j])
        state.mode = FLIGHT
        state.drive_work += scale * w[r.WORK * L + j]
        state.damping_loss += scale * w[r.LOSS * L + j]

    is_impact, note_impact, rebound = make_lane_impacts(
        laws, rotation, make_taut_step(laws, part), store, callbacks, part
    )

    @part
    def take_up(j: int, k: int, task: Task) -> None:
        """Give lane j the laws and the accumulators of point k."""
        L, points, weights = r.LANES, task.points, task.weights
        progress, space = task.progress, task.space
        w, table, acc = space.w, space.table, space.acc
        settings, body = points.settings[k], points.bodies[k, 0]
        h = settings.step
        w[r.H * L + j], w[r.PER_H * L + j], w[r.RATE * L + j] = h, 1.0 / h, body.damping_rate
        w[r.G * L + j] = -h * h * settings.gravity * body.inverse_length
        w[r.LOW * L + j], w[r.HIGH * L + j] = settings.low, settings.high
        _, frequency, _ = rotation(points.segments[points.firsts[k]])
        table[r.COS * L + j], table[r.SIN * L + j] = 1.0, 0.0
        for i in range(len(weights.drifts)):
            at, following = i * r.TABLE_ROWS * L + j, (i + 1) * r.TABLE_ROWS * L + j
            reach = effective_time(body.damping_rate, weights.drifts[i] * h)
            turn = frequency * h * weights.nodes[i]
            table[at + r.DRIFT_TIME * L] = reach / h
            table[at + r.LEFT * L] = 1.0 - body.damping_rate * reach
            table[following + r.COS * L] = cosine(turn)
            table[following + r.SIN * L] = sine(turn)
        columns = len(progress.status)
        for slot in range(len(acc) // L):
            acc[slot * L + j] = progress.acc[slot * columns + k]
        start(k, task.scratch, progress, acc, j, L)

    @part
    def make_idle(j: int, w: Floats) -> None:
        """Fill lane j with a ball at rest, far from walls and halts."""
        L = r.LANES
        for row in range(r.BLOCKS):
            w[row * L + j] = 0.0
        w[r.LOW * L + j], w[r.HIGH * L + j], w[r.HALT * L + j] = -math.inf, math.inf, math.inf
        w[r.PER_H * L + j] = 1.0

    @part
    def leave_out(w: Floats, point: Integers) -> None:
        """Use the blocks up to the last lane that has a point."""
        used = 0
        for j in range(r.LANES):
            used = j // r.BLOCK + 1 if point[j] >= 0 else used
        w[r.BLOCKS * r.LANES] = float(max(used, 1))

    @part
    def lay_down(j: int, k: int, space: LaneSpace, progress: Progress) -> None:
        """Take the accumulators of a finished point out of lane j and leave the lane idle."""
        columns = len(progress.status)
        for slot in range(len(space.acc) // r.LANES):
            progress.acc[slot * columns + k] = space.acc[slot * r.LANES + j]
        make_idle(j, space.w)

    @part
    def go_on(j: int, k: int, index: int, task: Task) -> int:
        """Carry the stored point k on by single steps until it flies; return its next stop.

        The number of stops says that the point is finished.
        """
        points, scratch, progress, space = task.points, task.scratch, task.progress, task.space
        stops = points.stops.shape[1]
        carried = False
        while True:
            t = time_of(k, points, progress)
            while index < stops and not points.stops[k, index] > t:  # reached, or none (NaN)
                if not math.isnan(points.stops[k, index]):
                    arrive(index, k, points, scratch, progress, space.acc, j, r.LANES)
                index += 1
            if index == stops or (carried and progress.states[k].mode == FLIGHT):
                return index
            carry_to(points.stops[k, index], 1, k, points, scratch, progress, space.acc, j, r.LANES)
            carried = True
            if is_over(k, points, progress):
                return stops

    @part
    def refill(j: int, taken: int, order: Integers, task: Task) -> int:
        """Give lane j the next point that does not end at once; return how many were taken up."""
        points, progress, space = task.points, task.progress, task.space
        stops = points.stops.shape[1]
        space.point[j] = -1
        while taken < len(order):
            k = order[taken]
            taken += 1
            take_up(j, k, task)
            space.index[j] = go_on(j, k, 0, task)
            if space.index[j] < stops:
                space.point[j] = k
                load(j, k, points.stops[k, space.index[j]], space.w, points, progress)
                return taken
            lay_down(j, k, space, progress)
        return taken

    @part
    def carry(j: int, k: int, task: Task) -> None:
        """Carry the stored point k on by itself and load it again."""
        points, index = task.points, task.space.index
        index[j] = go_on(j, k, index[j], task)
        if index[j] < points.stops.shape[1]:
            load(j, k, points.stops[k, index[j]], task.space.w, points, task.progress)

    @part
    def settle_impacts(noted: int, task: Task) -> None:
        """Locate the noted impacts together and let each lane go on behind its own."""
        points, weights, scratch = task.points, task.weights, task.scratch
        progress, space = task.progress, task.space
        E, z, w = r.IMPACTS, space.z, space.w
        for e in range(noted, E):  # idle columns repeat the first
            for row in range(r.NOTED_ROWS):
                z[row * E + e] = z[row * E]
        locate_impacts(
            space.locate,
            (
                address_of(z), address_of(weights.kicks), address_of(weights.drifts),
                address_of(weights.nodes), len(weights.drifts),
            ),
        )  # fmt: skip
        for e in range(noted):
            j = space.lane[e]
            k = space.point[j]
            w[r.TAKEN * r.LANES + j] = 1.0  # seen to, for this turn
            if z[r.DONE * E + e] > 0.0:
                stop = points.stops[k, space.index[j]]
                accumulators = Accumulators(space.acc, j, r.LANES)
                rebound(e, j, k, stop, w, z, accumulators, points, scratch, progress)
                state = progress.states[k]
                if state.mode == FLIGHT and state.contacts < points.contact_limit:
                    load(j, k, stop, w, points, progress)
                    continue
            else:
                store(j, k, w, points, progress)
            carry(j, k, task)

    def lanes(address: int) -> None:
        task = task_at(address)
        points, weights, progress, space = task.points, task.weights, task.progress, task.space
        order, run, cancel = task.order, task.scratch.runs[0], task.cancel
        w, z, point, index, L = space.w, space.z, space.point, space.index, r.LANES
        step = (
            address_of(w), address_of(space.table), address_of(weights.kicks), len(weights.drifts)
        )  # fmt: skip
        stops = points.stops.shape[1]
        taken, busy, turns, noted = 0, 0, 0, 0
        for j in range(L):
            make_idle(j, w)
            taken = refill(j, taken, order, task)
            busy += 1 if point[j] >= 0 else 0
        leave_out(w, point)
        while busy > 0:
            turns += 1
            if turns % 1024 == 0 and cancel[0] != 0:
                return
            some = take_step(space.step, step) > 0.0
            show_all(_STEPS, run, space)
            show_all(_MATRICES, run, space)
            count_all(w)
            if not some:
                continue
            for j in range(width_of(w)):
                if w[r.TAKEN * L + j] > 0.0 or w[r.HALT * L + j] == r.WAITS:
                    continue
                k = point[j]
                if w[r.N * L + j] >= w[r.HALT * L + j]:
                    stop = points.stops[k, index[j]]
                    if w[r.N * L + j] < last_step(j, stop, w):
                        turn_phase(j, k, w, points)
                        set_halt(j, stop, w)
                        continue
                elif is_impact(j, w):
                    note_impact(noted, j, k, w, z, points)
                    space.lane[noted] = j
                    noted += 1
                    w[r.HALT * L + j] = r.WAITS
                    if noted == r.IMPACTS:
                        settle_impacts(noted, task)
                        noted = 0
                    continue
                store(j, k, w, points, progress)
                carry(j, k, task)
            if noted > 0 and noted >= busy - _FEW:
                settle_impacts(noted, task)
                noted = 0
            flying = busy
            for j in range(width_of(w)):
                if point[j] >= 0 and index[j] == stops:
                    lay_down(j, point[j], space, progress)
                    taken = refill(j, taken, order, task)
                    busy -= 1 if point[j] < 0 else 0
            if busy < flying:
                leave_out(w, point)

    return lanes
