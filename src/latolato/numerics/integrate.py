"""Runs a trajectory kernel from start to end: step size, growing tables, progress, status."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics import records
from latolato.numerics.records import (
    ANGLE_1,
    ANGLE_2,
    MODE,
    SETTINGS,
    SIGN_1,
    SIGN_2,
    SLACK_FIRST,
    STEPS,
    T_BASE,
    VELOCITY_1,
    VELOCITY_2,
)
from latolato.numerics.steppers import BLANES_MOAN_GENERAL, BLANES_MOAN_RKN, Stepper
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System, restoring_linear

Floats = NDArray[np.float64]

# Step in units of 1/(fastest angular rate) at tolerance 1; the error goes as step^6. Measured in
# benchmarks/steps.py: of the regular, undamped 300 s runs over the paper's map 90 percent have an
# error below a third of `tolerance`, half of them below a thirtieth.
_STEP_AT_UNIT_TOLERANCE = 5.0
# Steps after which a kernel hands back control, so that progress shows and Ctrl-C works.
_STEPS_PER_CALL = 200_000

TOLERANCES = (1e-14, 1e-2)


@dataclass(frozen=True)
class Start:
    """Initial angles [rad] and angular velocities [rad/s], right ball first."""

    angles: tuple[float, ...]
    velocities: tuple[float, ...]


@dataclass
class Trajectory:
    """What a kernel wrote; arrays are of shape (time,) or (contact,) unless noted.

    Attributes
    ----------
    samples : ndarray, shape (SAMPLE_ROWS, time)
        Rows as laid down in `latolato.numerics.records`.
    contact_values : ndarray, shape (4, contact)
        Angular velocities before (one row a ball) and after.
    """

    samples: Floats
    contact_times: Floats
    contact_kinds: NDArray[np.int64]
    contact_values: Floats
    state: Floats
    counters: NDArray[np.int64]
    reached: float
    step: float
    stepper: Stepper
    status: str


def choose_stepper(system: System) -> Stepper:
    """Return the splitting whose order holds for the motion and the works of this system."""
    smooth = all(b.quadratic_damping == b.coulomb_damping == 0.0 for b in system.balls)
    return BLANES_MOAN_RKN if smooth else BLANES_MOAN_GENERAL


def choose_step(
    system: System, drive: Drive, start: Start, tolerance: float, stepper: Stepper
) -> float:
    """Return the step [s] for a tolerance: ``tolerance^(1/order)`` over the fastest rate.

    The fastest rate is the largest of the drive's frequency, the swing's under the strongest
    pull ``sqrt((g + |y0''|)/l)``, and the initial angular velocity.
    """
    unit = _STEP_AT_UNIT_TOLERANCE * stepper.step_factor
    return unit * tolerance ** (1.0 / stepper.order) / fastest_rate(system, drive, start)


def fastest_rate(system: System, drive: Drive, start: Start) -> float:
    """Return the fastest angular rate of a run that is known beforehand [rad/s]."""
    length = min(ball.length for ball in system.balls)
    swing = math.sqrt((system.gravity + drive.largest_acceleration) / length)
    return max(swing, drive.fastest_frequency, *(abs(v) for v in start.velocities))


def _maker(name: str) -> Callable[..., Callable[..., Any]]:
    """Return the factory of a kernel; imported on use, so that start-up pays for one only."""
    if name == "clamp":
        from latolato.numerics.clamp import make_clamped

        return make_clamped
    if name == "pair":
        from latolato.numerics.fold_pair import make_pair_trajectory

        return make_pair_trajectory
    if name == "observe":
        from latolato.numerics.observe import make_observer

        return make_observer
    from latolato.numerics.fold import make_trajectory

    return make_trajectory


@lru_cache(maxsize=64)
def kernel(name: str, *laws: Callable[..., float], compiled: bool = True) -> Callable[..., Any]:
    """Return a kernel made of these laws, compiled (and kept on disk) or as plain Python.

    `name` is ``one``, ``pair``, ``clamp`` or ``observe``.
    """
    make = _maker(name)
    if not compiled:
        return make(*laws)
    from latolato.numerics.compiled import compile_kernel

    return compile_kernel(make, name, *laws)


def integrate(
    system: System,
    drive: Drive,
    start: Start,
    sample_times: Floats,
    duration: float,
    *,
    walls: tuple[float, float],
    step: float,
    rest_speed: float = 0.0,
    contact_limit: int = 1_000_000,
    kick_times: Floats | None = None,
    kick_sizes: Floats | None = None,
    clamped: bool = False,
    compiled: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Return the trajectory from 0 to `duration` [s], sampled at `sample_times`.

    Parameters
    ----------
    walls : tuple of float
        Contact angles (one ball) or separations (two) [rad]; infinite where there is none.
    kick_times, kick_sizes : ndarray, shapes (kick,), (angle, kick)
        Instants [s] and sizes [rad/s] of velocity kicks.
    clamped : bool
        Whether contact is the fixed-step artefact of `latolato.numerics.clamp`.
    compiled : bool
        Whether the kernel is compiled or runs as plain Python.
    progress : callable, optional
        Called with the fraction done, now and then.
    """
    stepper = choose_stepper(system)
    angles = system.angles
    name = "clamp" if clamped else ("pair" if angles == 2 else "one")
    carry_on = kernel(name, drive.acceleration, system.restoring, compiled=compiled)
    state, counters = _initial(start, walls, sample_times)
    rows = [records.body_record(ball) for ball in system.balls]
    offsets = (0.0, 0.0)
    if angles == 2:
        joint = [
            records.joint_record(rows[0], rows[1], gap if math.isfinite(gap) else 0.0)
            for gap in walls
        ]
        rows += [record for record, _ in joint]
        offsets = (joint[0][1], joint[1][1])
    bodies = records.bodies(*rows)
    settings = np.zeros(1, dtype=SETTINGS)
    settings[0] = (
        system.gravity,
        *walls,
        getattr(system, "restitution", 1.0),
        rest_speed,
        step,
        drive.largest_acceleration,
        *offsets,
        0.5 * (step * fastest_rate(system, drive, start)) ** 2,
        int(system.restoring is not restoring_linear),
    )
    stretches, starts = records.stretch_records(drive, duration)
    jumps = np.array(drive.velocity_jumps(duration))
    kick_times = np.empty(0) if kick_times is None else kick_times
    kick_sizes = np.empty((angles, 0)) if kick_sizes is None else kick_sizes
    tables = np.zeros((6 if angles == 2 else 2, 3, len(stepper.kicks)))
    samples = np.full((records.SAMPLE_ROWS, len(sample_times)), np.nan)
    room = 256
    kinds, times, values = [], [], []
    count = 0
    if not compiled:
        settings, bodies, stretches = map(records.python_view, (settings, bodies, stretches))
    status, reached = "complete", -1.0
    while True:
        size = min(room, contact_limit - count) + 4  # an event may need several rows
        buffers = np.empty(size), np.empty(size, dtype=np.int64), np.zeros((4, size))
        written = carry_on(
            state, counters, settings, bodies, stretches, starts, jumps, kick_times, kick_sizes,
            tables, stepper.kicks, stepper.drifts, stepper.nodes, sample_times, samples,
            *buffers, duration, _STEPS_PER_CALL,
        )  # fmt: skip
        times.append(buffers[0][:written])
        kinds.append(buffers[1][:written])
        values.append(buffers[2][:, :written])
        count += written
        before, reached = reached, state[T_BASE] + counters[STEPS] * step
        if reached <= before and not written and math.isfinite(reached):
            raise RuntimeError(f"the integration came to a halt at t = {reached:.17g} s")
        if progress is not None:
            progress(min(reached / duration, 1.0))
        if not np.all(np.isfinite(state[ANGLE_1 : VELOCITY_2 + 1])):
            lost = ~np.isfinite(samples[0] + samples[1])
            reached = float(sample_times[np.argmax(lost)]) if lost.any() else reached
            status = f"failed at t = {reached:.9g} s: the motion left the range of numbers"
            samples[:, np.argmax(lost) :] = np.nan
            break
        if reached >= duration:
            break
        if count >= contact_limit:
            status = f"stopped at t = {reached:.9g} s by contact_limit = {contact_limit}"
            break
        room = min(max(room, 2 * written), 65536)
    return Trajectory(
        samples, np.concatenate(times), np.concatenate(kinds), np.concatenate(values, axis=1),
        state, counters, float(min(reached, duration)), step, stepper, status,
    )  # fmt: skip


def _initial(
    start: Start, walls: tuple[float, float], sample_times: Floats
) -> tuple[Floats, NDArray[np.int64]]:
    """Return state and counters at time zero; modes are settled by the kernel's first call."""
    state = np.zeros(records.STATE_SIZE)
    counters = np.zeros(records.COUNTERS_SIZE, dtype=np.int64)
    state[SLACK_FIRST] = state[records.SLACK_FIRST_2] = np.nan
    state[ANGLE_1], state[VELOCITY_1] = start.angles[0], start.velocities[0]
    if len(start.angles) == 2:
        state[ANGLE_2], state[VELOCITY_2] = start.angles[1], start.velocities[1]
    counters[MODE] = records.UNSETTLED
    counters[SIGN_1] = -1 if start.velocities[0] < 0 else 1
    counters[SIGN_2] = -1 if start.velocities[-1] < 0 else 1
    return state, counters
