"""Runs a trajectory kernel from start to end: step size, growing tables, progress, status."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics import records
from latolato.numerics.engine.events import Output
from latolato.numerics.engine.loop import Timetable, empty_arguments
from latolato.numerics.engine.record import STATE, UNSETTLED, as_objects, run_dtype, write_back
from latolato.numerics.observe import Observation, empty_observation
from latolato.numerics.steppers import BLANES_MOAN_GENERAL, BLANES_MOAN_RKN, Stepper
from latolato.numerics.trajectory import make_trajectory
from latolato.numerics.watch import BLIND, Eyes, Hooks, hooks_of, make_watch
from latolato.observables import Observable
from latolato.physics.contacts import ContactLaw, Exact
from latolato.physics.drives import Drive
from latolato.physics.pendulum import (
    System,
    potential_sine,
    restoring_linear,
    restoring_sine,
)

Floats = NDArray[np.float64]
Law = Callable[..., float]

# Step in units of 1/(fastest angular rate) at tolerance 1; the error goes as step^6. Measured in
# benchmarks/steps.py: of the regular, undamped 300 s runs over the paper's map 90 percent have an
# error below a third of `tolerance`, half of them below a thirtieth.
_STEP_AT_UNIT_TOLERANCE = 5.0
# How much the drag's own rate counts. Measured with m l = 1 kg m and C, C2 from 30 to 1e4: ledger
# and angle keep all tolerances from 1e-4 to 1e-12 at 0.2 to 0.35, whatever the drag; the rest is
# left to the repetition with half the step.
_DRAG_WEIGHT = 0.3
# Steps after which a kernel hands back control, so that progress shows and Ctrl-C works.
_STEPS_PER_CALL = 200_000

# Energies are floats up to here; only linear motion grows so far.
_LARGEST = 1e100

TOLERANCES = (1e-14, 1e-2)

_EXACT = Exact()


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
    state : record of `latolato.numerics.engine.record.STATE`
        The motion at the end.
    contact_values : ndarray, shape (4, contact)
        Angular velocities before (one row a ball) and after.
    slots : ndarray, shape (slot, ball)
        What was watched, one observable's slots after the other's.
    """

    samples: Floats
    contact_times: Floats
    contact_kinds: NDArray[np.int64]
    contact_values: Floats
    state: Any
    reached: float
    step: float
    stepper: Stepper
    status: str
    failed: bool
    slots: Floats


def choose_stepper(system: System) -> Stepper:
    """Return the splitting whose order holds for the motion and the works of this system."""
    smooth = all(b.quadratic_damping == b.coulomb_damping == 0.0 for b in system.balls)
    return BLANES_MOAN_RKN if smooth else BLANES_MOAN_GENERAL


def choose_step(
    system: System,
    drive: Drive,
    start: Start,
    tolerance: float,
    stepper: Stepper,
    law: ContactLaw = _EXACT,
) -> float:
    """Return the step [s] for a tolerance; see `step_for`."""
    return float(step_for(fastest_rate(system, drive, start, law), tolerance, stepper))


def step_for(rate: Any, tolerance: float, stepper: Stepper) -> Any:
    """Return the step [s] at which the fastest rates allow `tolerance`, numbers or arrays.

    ``5 step_factor tolerance^(1/order)`` over the rate.
    """
    unit = _STEP_AT_UNIT_TOLERANCE * stepper.step_factor
    return unit * tolerance ** (1.0 / stepper.order) / rate


def fastest_rate(system: System, drive: Drive, start: Start, law: ContactLaw = _EXACT) -> float:
    """Return the fastest angular rate of a run that is known beforehand [rad/s]."""
    speed = max(abs(v) for v in start.velocities)
    bounds = drive.largest_acceleration, drive.fastest_frequency
    rates = [law.fastest_rate]
    for ball in system.balls:
        _, rate, quadratic, _, _ = records.body_record(ball)
        rates.append(rate_of(system.gravity, ball.length, *bounds, speed, (rate, quadratic)))
    return float(max(rates))


def rate_of(
    gravity: Any,
    length: Any,
    acceleration: Any,
    frequency: Any,
    speed: Any,
    drags: tuple[Any, Any] = (0.0, 0.0),
) -> Any:
    """Return the fastest angular rate [rad/s], numbers or arrays.

    The largest of the drive's frequency, the swing's under the strongest pull
    ``sqrt((g + |y0''|)/l)``, the initial angular velocity, and 0.3 times the rate of the drag:
    with `drags` (c1 [1/s], c2 [1]) that is c1 and the larger of c2 times the initial speed and
    ``2 sqrt(c2 (g + |y0''|)/l)``, the rate at which quadratic drag settles under that pull.
    """
    stiffness = (gravity + acceleration) / length
    linear, quadratic = drags
    settling = linear + np.maximum(2.0 * np.sqrt(quadratic * stiffness), quadratic * speed)
    free = np.maximum(np.maximum(np.sqrt(stiffness), frequency), speed)
    return np.maximum(free, _DRAG_WEIGHT * settling)


def settings_values(
    *,
    gravity: Any,
    walls: tuple[Any, Any],
    restitution: Any,
    rest_speed: Any,
    step: Any,
    pivot_bound: Any,
    rate: Any,
    offsets: tuple[float, float] = (0.0, 0.0),
    follows_tension: bool,
    follows_ledger: bool = False,
    mirrored: bool = False,
    is_linear: bool = False,
    law: tuple[float, float] = (0.0, 0.0),
) -> tuple[Any, ...]:
    """Return the content of a `SETTINGS` record, numbers or arrays."""
    sag = 0.5 * (step * rate) ** 2
    return (
        gravity, *walls, restitution, rest_speed, step, pivot_bound, *offsets, sag,
        int(follows_tension), int(follows_ledger), int(mirrored), int(is_linear), law,
    )  # fmt: skip


def body_rows(
    system: System, walls: tuple[float, float]
) -> tuple[list[tuple[float, ...]], tuple[float, float]]:
    """Return the records of the bodies that can swing, and the offsets of those in contact."""
    rows = [records.body_record(ball) for ball in system.balls]
    if system.angles == 1:
        return rows, (0.0, 0.0)
    joint = [
        records.joint_record(rows[0], rows[1], gap if math.isfinite(gap) else 0.0) for gap in walls
    ]
    return [*rows, *(record for record, _ in joint)], (joint[0][1], joint[1][1])


def laws_key(system: System) -> tuple[Law, Law]:
    """Return the restoring law and the potential that name the kernels of a system.

    The systems of the package share one pair: a number in the settings tells the kernel which of
    their laws to use.
    """
    if system.restoring in (restoring_sine, restoring_linear):
        return restoring_sine, potential_sine
    return system.restoring, system.potential


def engine_of(
    count: int,
    *laws: Law,
    stretch: np.dtype[Any] | None = None,
    motion: str = "exact",
    compiled: bool = True,
    hooks: tuple[Hooks, ...] = BLIND,
) -> Callable[..., int]:
    """Return the engine as Python calls it, compiled or as plain Python.

    Its arguments are those of `engine.loop.make_engine`, but for the first: runs of shape (1,), as
    from `make_runs`. `stretch` is the layout of the drive's stretches, if it is not the usual one.
    """
    if not compiled:
        plain = make_trajectory(*laws, count=count, watch=make_watch(hooks), motion=motion)

        def carry_on_plainly(runs: NDArray[Any], timetable: Timetable, *rest: Any) -> int:
            run, stretches = as_objects(runs)[0], as_objects(timetable.stretches)
            written = plain(run, timetable._replace(stretches=stretches), *rest)
            write_back([run.state], runs["state"])
            return written

        return carry_on_plainly
    from latolato.numerics.pieces import engine_recipe, hook_table, piece_of, pieces_of, words_of

    piece = piece_of(engine_recipe(count, stretch or records.stretch_dtype(), *laws, motion=motion))
    looking = pieces_of(hooks)
    table = hook_table(looking)
    example = empty_arguments(stretch or records.stretch_dtype())

    def carry_on(
        runs: NDArray[Any], timetable: Timetable, output: Output, eyes: Eyes, stop: float,
        most_steps: int,
    ) -> int:  # fmt: skip
        assert looking is not None  # the code of the pieces must not go while they are called
        words = words_of((timetable, output, eyes), example)
        runs["words"][0, : len(words)] = words
        runs["engine"], runs["hooks"] = piece.address, table.ctypes.data
        rows: int = piece.call(runs.ctypes.data, stop, most_steps)
        return rows

    return carry_on


def observe(observation: Observation, *laws: Law) -> None:
    """Fill the pivot's motion and the balls' quantities of an observation.

    Laws are those of `observe.make_observer`.
    """
    from latolato.numerics.pieces import observer_recipe, piece_of, words_of

    stretch = observation.stretches.dtype
    words = np.array(words_of(observation, empty_observation(stretch)))
    piece_of(observer_recipe(stretch, *laws)).call(words.ctypes.data)


def make_runs(
    system: System,
    start: Start,
    walls: tuple[float, float],
    stepper: Stepper,
    settings: tuple[Any, ...],
    stretch: np.dtype[Any] | None = None,
) -> NDArray[Any]:
    """Return the record of a trajectory at time zero, of shape (1,).

    Parameters
    ----------
    settings : tuple
        What `settings_values` returned.
    stretch : dtype, optional
        The layout of the drive's stretches, if it is not the usual one.
    """
    runs = np.zeros(1, dtype=run_dtype(stretch))
    rows, _ = body_rows(system, walls)
    runs["bodies"][0, : len(rows)] = records.bodies(*rows)
    runs["settings"][0] = settings
    write_stepper(runs, stepper)
    runs["state"] = initial_states(start.angles, start.velocities)
    return runs


def write_stepper(runs: NDArray[Any], stepper: Stepper) -> None:
    """Write a stepper's weights into runs."""
    stages = len(stepper.drifts)
    runs["stages"] = stages
    runs["kicks"][..., : stages + 1] = stepper.kicks
    runs["drifts"][..., :stages], runs["nodes"][..., :stages] = stepper.drifts, stepper.nodes


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
    law: ContactLaw = _EXACT,
    compiled: bool = True,
    watched: Sequence[Observable] = (),
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Return the trajectory from 0 to `duration` [s], sampled at `sample_times`.

    Parameters
    ----------
    walls : tuple of float
        Contact angles (one ball) or separations (two) [rad]; infinite where there is none.
    kick_times, kick_sizes : ndarray, shapes (kick,), (angle, kick)
        Instants [s] and sizes [rad/s] of velocity kicks.
    law : ContactLaw
        What happens at the walls.
    compiled : bool
        Whether the kernel is compiled or runs as plain Python.
    watched : sequence of Observable
        What is gathered of every step and its matrix; contacts are in the table.
    progress : callable, optional
        Called with the fraction done, now and then.
    """
    stepper = choose_stepper(system)
    angles = system.angles
    _, offsets = body_rows(system, walls)
    settings = settings_values(
        gravity=system.gravity,
        walls=walls,
        restitution=getattr(system, "restitution", 1.0),
        rest_speed=rest_speed,
        step=step,
        pivot_bound=drive.largest_acceleration,
        rate=fastest_rate(system, drive, start, law),
        offsets=offsets,
        follows_tension=system.restoring is not restoring_linear,
        follows_ledger=True,
        is_linear=system.restoring is restoring_linear,
        law=law.numbers,
    )
    stretches, starts = records.stretch_records(drive, duration)
    carry_on = engine_of(
        angles, drive.acceleration, *laws_key(system), stretch=stretches.dtype,
        motion=law.motion, compiled=compiled, hooks=hooks_of(watched),
    )  # fmt: skip
    runs = make_runs(system, start, walls, stepper, settings, stretches.dtype)
    state = runs["state"].view(np.recarray)[0]
    timetable = Timetable(
        stretches,
        starts,
        np.array(drive.velocity_jumps(duration)),
        np.empty(0) if kick_times is None else kick_times,
        np.empty((angles, 0)) if kick_sizes is None else kick_sizes,
    )
    samples = np.full((records.SAMPLE_ROWS, len(sample_times)), np.nan)
    columns = [[v for o in watched for v in o.initial(np.array(x))] for x in start.angles]
    acc = np.array(columns, dtype=np.float64).T.ravel() if watched else np.zeros(1)
    room = 256
    kinds, times, values = [], [], []
    count = 0
    status, failed, reached = "complete", False, -1.0
    while True:
        size = min(room, contact_limit - count) + 4  # an event may need several rows
        buffers = np.empty(size), np.empty(size, dtype=np.int64), np.zeros((4, size))
        output = Output(sample_times, samples, *buffers)
        written = carry_on(runs, timetable, output, Eyes(acc, 0, angles), duration, _STEPS_PER_CALL)
        times.append(buffers[0][:written])
        kinds.append(buffers[1][:written])
        values.append(buffers[2][:, :written])
        count += written
        before, reached = reached, float(state.t_base + state.steps * step)
        # A fault: the steps that are admitted are far above the spacing of floats at their end.
        if reached <= before and not written and math.isfinite(reached):
            raise RuntimeError(f"the integration came to a halt at t = {reached:.17g} s")
        if progress is not None:
            progress(min(reached / duration, 1.0))
        if not np.all(abs(np.array([state.angle, state.velocity])) <= _LARGEST):
            lost = ~(np.max(abs(samples[: 2 * angles]), axis=0) <= _LARGEST)
            reached = float(sample_times[np.argmax(lost)]) if lost.any() else reached
            status = f"failed at t = {reached:.9g} s: the motion left the range of numbers"
            failed = True
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
        state, float(min(reached, duration)), step, stepper, status, failed,
        acc.reshape(-1, angles) if watched else np.zeros((0, angles)),
    )  # fmt: skip


def initial_states(angles: Sequence[Any], velocities: Sequence[Any], count: int = 1) -> Any:
    """Return states at time zero, of shape (count,); the engine settles their modes."""
    states = np.zeros(count, dtype=STATE)
    states["mode"], states["slack_start"] = UNSETTLED, np.nan
    for ball, (angle, velocity) in enumerate(zip(angles, velocities, strict=True)):
        states["angle"][:, ball], states["velocity"][:, ball] = angle, velocity
    return states
