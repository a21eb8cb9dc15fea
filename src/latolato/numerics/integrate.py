"""Runs a trajectory kernel from start to end: step size, growing tables, progress, status."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.rules import sentence
from latolato.numerics import records
from latolato.numerics.abi import words_of
from latolato.numerics.callbacks import (
    NO_FORMULAS,
    ON_START,
    Accumulators,
    Formulas,
    blank_slots,
    formulas_of,
    make_callbacks,
)
from latolato.numerics.derived import Observation, empty_observation
from latolato.numerics.engine.laws import Formula
from latolato.numerics.engine.loop import (
    SPARE_IN_PLANE,
    SPARE_ROWS,
    Timetable,
    empty_arguments,
)
from latolato.numerics.kernels import (
    PREPARE,
    callback_kernels_of,
    callback_table,
    engine_spec,
    kernel_of,
    observer_spec,
)
from latolato.numerics.prepare import (
    Cases,
    cases_of,
    choose_stepper,
    empty_cases,
    make_prepare,
    write_numbers,
    write_stepper,
)
from latolato.numerics.run_record import (
    MOST_PARAMETERS,
    STATE,
    Output,
    State,
    as_objects,
    run_dtype,
    write_back,
)
from latolato.numerics.steppers import Stepper
from latolato.numerics.trajectory import make_trajectory
from latolato.observables import Observable
from latolato.physics import problems
from latolato.physics.contacts import ContactLaw, ExactContact
from latolato.physics.drives import Drive
from latolato.physics.pendulum import (
    System,
    potential_sine,
    restoring_linear,
    restoring_sine,
)

Floats = NDArray[np.float64]

# Steps after which a kernel hands back control, so that progress shows and Ctrl-C works.
STEPS_PER_CALL = 200_000

# Energies are floats up to here; only linear motion grows so far.
LARGEST = 1e100

TOLERANCES = (1e-14, 1e-2)

_EXACT = ExactContact()


@dataclass(frozen=True)
class Start:
    """Initial angles [rad] and angular velocities [rad/s], right ball first.

    Balls on slack strings also have their distances from the pivot [m]; with none, all are taut.
    """

    angles: tuple[float, ...]
    velocities: tuple[float, ...]
    distances: tuple[float, ...] = ()


@dataclass(frozen=True)
class Directions:
    """How the numbers of a run change per unit of each parameter; see `engine.sensitivity`.

    Attributes
    ----------
    changes : ndarray, shape (parameter,)
        Records of `run_record.CHANGE`.
    segments : ndarray, shape (parameter, segment)
        By how much the numbers of the drive's segments change.
    start : ndarray, shape (4, parameter)
        The derivatives of the state at time zero: angle and angular velocity of each ball.
    """

    changes: NDArray[Any]
    segments: NDArray[Any]
    start: Floats


@dataclass
class Trajectory:
    """What a kernel wrote; arrays are of shape (time,) or (contact,) unless noted.

    Attributes
    ----------
    samples : ndarray, shape (SAMPLE_ROWS, time)
        Rows as laid down in `latolato.numerics.records`.
    state : record of `latolato.numerics.run_record.STATE`
        The motion at the end.
    contact_values : ndarray, shape (CONTACT_ROWS, contact)
        Angular velocities before (one row a ball) and after; in the plane more.
    slots : ndarray, shape (slot, ball)
        What was watched, one observable's slots after the other's.
    doubt, doubted_since : int, float
        Why and since when derivatives with respect to parameters are unknown [s]; 0 if they are
        known to the end.
    """

    samples: Floats
    contact_times: Floats
    contact_kinds: NDArray[np.int64]
    contact_values: Floats
    state: State
    reached: float
    step: float
    stepper: Stepper
    status: str
    failed: bool
    slots: Floats
    doubt: int = 0
    doubted_since: float = math.inf


def choose_step(
    system: System,
    drive: Drive,
    start: Start,
    tolerance: float,
    law: ContactLaw = _EXACT,
    *,
    duration: float = 0.0,
    compiled: bool = True,
) -> float:
    """Return the step [s] for a tolerance; see `latolato.numerics.prepare`.

    Raises
    ------
    InputError
        If a run of this duration [s] would take too many.
    """
    bounds = drive.largest_acceleration, drive.fastest_frequency
    case = _case_of(system, bounds, start, duration, law, tolerance=tolerance)
    runs = prepared_runs(case, choose_stepper(system), compiled=compiled)
    return float(runs["settings"]["step"][0])


def _case_of(
    system: System, bounds: tuple[float, float], start: Start, duration: float, law: ContactLaw,
    **numbers: Any,
) -> NDArray[Any]:  # fmt: skip
    """Return cases of a run, whose start is taken as it is, with its drive's bounds."""
    return cases_of(
        system, law, angles=start.angles, velocities=start.velocities,
        bounds=bounds, duration=duration, is_exact=1, **numbers,
    )  # fmt: skip


def prepared_numbers(
    laws: Sequence[tuple[System, Drive, Start]], duration: float, law: ContactLaw, step: float
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return settings, bodies and states at time zero of runs with steps of this length [s].

    Arrays of shape (run,), (run, 4) and (run,), a row for each of the systems, drives and starts.
    They differ in numbers only; all have the bounds of the first one's drive.

    Raises
    ------
    InputError
        With what is wrong with one of the cases.
    """
    first, drive, begin = laws[0]
    bounds = drive.largest_acceleration, drive.fastest_frequency
    cases = _case_of(first, bounds, begin, duration, law, count=len(laws))
    for k, (system, _, start) in enumerate(laws):
        write_numbers(cases[k : k + 1], system, start.angles, start.velocities)
    cases["step"], none = step, empty_cases()
    settings, states = (np.zeros(len(laws), dtype=dtype) for dtype in (records.SETTINGS, STATE))
    bodies = np.zeros((len(laws), 4), dtype=records.BODY)
    reported = np.zeros(len(laws), dtype=records.PROBLEM)
    firsts = np.zeros(len(laws) + 1, dtype=np.int64)
    prepare_cases(Cases(cases, none.segments, firsts, settings, bodies, states, reported))
    for problem in reported:
        if problem["number"] != problems.FINE:
            raise problems.refusal(problem["number"], problem["values"])
    return settings, bodies, states


def laws_key(system: System) -> tuple[Formula, Formula]:
    """Return the restoring law and the potential that name the kernels of a system.

    The systems of the package share one pair: a number in the settings tells the kernel which of
    their laws to use.
    """
    if system.restoring in (restoring_sine, restoring_linear):
        return restoring_sine, potential_sine
    return system.restoring, system.potential


def moves_in_plane(system: System, drive: Drive) -> bool:
    """Return whether a motion needs the engine for the plane, which serves every other one too."""
    return drive.moves_across or system.suspension == "string" or system.drag_frame == "lab"


def motion_laws(system: System, drive: Drive, *, in_plane: bool) -> tuple[Formula, ...]:
    """Return the laws of `trajectory.make_trajectory`."""
    laws = drive.acceleration, *laws_key(system)
    if not in_plane:
        return laws
    return *laws, drive.across_acceleration, drive.velocity, drive.across_velocity


def engine_of(
    count: int,
    *laws: Formula,
    segment: np.dtype[Any] | None = None,
    motion: str = "exact",
    compiled: bool = True,
    formulas: tuple[Formulas, ...] = NO_FORMULAS,
) -> Callable[..., int]:
    """Return the engine as Python calls it, compiled or as plain Python.

    Its arguments are those of `engine.loop.make_engine`, but for the first: runs of shape (1,), as
    from `prepared_runs`. `segment` is the layout of the drive's segments, if not the usual one.
    """
    if not compiled:
        plain = make_trajectory(
            *laws, count=count, callbacks=make_callbacks(formulas), motion=motion
        )

        def carry_on_plainly(runs: NDArray[Any], timetable: Timetable, *rest: Any) -> int:
            run, segments = as_objects(runs)[0], as_objects(timetable.segments)
            changes = as_objects(timetable.segment_changes)
            timetable = timetable._replace(segments=segments, segment_changes=changes)
            written = plain(run, timetable, *rest)
            runs["doubt"], runs["doubted_since"] = run.doubt, run.doubted_since
            write_back([run.state], runs["state"])
            return written

        return carry_on_plainly
    kernel = kernel_of(engine_spec(count, segment or records.segment_dtype(), *laws, motion=motion))
    looking = callback_kernels_of(formulas)
    table = callback_table(looking)
    example = empty_arguments(segment or records.segment_dtype())

    def carry_on(
        runs: NDArray[Any], timetable: Timetable, output: Output, accumulators: Accumulators,
        stop: float, most_steps: int,
    ) -> int:  # fmt: skip
        assert looking is not None  # the code of the kernels must not go while they are called
        words = words_of((timetable, output, accumulators), example)
        runs["words"][0, : len(words)] = words
        runs["engine"], runs["callbacks"] = kernel.address, table.ctypes.data
        rows: int = kernel.call(runs.ctypes.data, stop, most_steps)
        return rows

    return carry_on


def prepared_runs(
    cases: NDArray[Any],
    stepper: Stepper,
    segment: np.dtype[Any] | None = None,
    *,
    compiled: bool = True,
) -> NDArray[Any]:
    """Return the record of a run at time zero, of shape (1,).

    Parameters
    ----------
    cases : ndarray, shape (1,)
        With its drive's bounds.
    segment : dtype, optional
        The layout of the drive's segments, if it is not the usual one.

    Raises
    ------
    InputError
        With what is wrong with the case.
    """
    runs = np.zeros(1, dtype=run_dtype(segment))
    none, reported = empty_cases(), np.zeros(1, dtype=records.PROBLEM)
    prepare_cases(
        Cases(
            cases, none.segments, np.zeros(2, dtype=np.int64), runs["settings"], runs["bodies"],
            runs["state"], reported,
        ),
        compiled=compiled,
    )  # fmt: skip
    problem = reported[0]
    if problem["number"] != problems.FINE:
        raise problems.refusal(problem["number"], problem["values"])
    write_stepper(runs, stepper)
    return runs


def _differentiated(
    runs: NDArray[Any], directions: Directions, segment: np.dtype[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return a run with room for derivatives, and how the drive's segments change, in one row."""
    count = len(directions.changes)
    result = np.zeros(1, dtype=run_dtype(segment, MOST_PARAMETERS))
    for name in runs.dtype.names or ():
        if name == "state":
            for part in runs["state"].dtype.names or ():
                if part != "tangent_map":
                    result["state"][part] = runs["state"][part]
        elif result.dtype[name] == runs.dtype[name]:
            result[name] = runs[name]
    result["parameters"] = count
    result["changes"][0, :count] = directions.changes
    result["sensitivity"][0, :, :count] = directions.start
    # The entry after the last parameter is the time: segments that begin earlier are further on.
    result["changes"]["moves_pivot"][0, count] = 1
    result["segment_changes"]["start"][0, count] = -1.0
    return result, np.ascontiguousarray(directions.segments.ravel())


def prepare_cases(work: Cases, *, compiled: bool = True) -> None:
    """Prepare cases, compiled or as plain Python."""
    if compiled:
        words = np.array(words_of(work, empty_cases()))
        kernel_of(PREPARE).call(words.ctypes.data)
        return
    records: tuple[NDArray[Any], ...] = work.settings, work.states, work.problems
    objects = [as_objects(each) for each in records]
    bodies: Any = [as_objects(row) for row in work.bodies]
    make_prepare()(work._replace(
        cases=as_objects(work.cases), segments=as_objects(work.segments),
        settings=objects[0], bodies=bodies, states=objects[1], problems=objects[2],
    ))  # fmt: skip
    for item, record in zip((*objects, *bodies), (*records, *work.bodies), strict=True):
        write_back(item, record)


def observe(observation: Observation, *laws: Formula) -> None:
    """Fill the pivot's motion and the balls' quantities of an observation.

    Laws are those of `kernels.observer_spec`.
    """
    segment = observation.segments.dtype
    words = np.array(words_of(observation, empty_observation(segment)))
    kernel_of(observer_spec(segment, *laws)).call(words.ctypes.data)


def integrate(
    system: System,
    drive: Drive,
    start: Start,
    sample_times: Floats,
    duration: float,
    *,
    step: float = 0.0,
    tolerance: float = 0.0,
    speed: float = 0.0,
    rest_speed: float = 0.0,
    contact_limit: int = 1_000_000,
    kick_times: Floats | None = None,
    kick_sizes: Floats | None = None,
    law: ContactLaw = _EXACT,
    compiled: bool = True,
    watched: Sequence[Observable] = (),
    directions: Directions | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Return the trajectory from 0 to `duration` [s], sampled at `sample_times`.

    Parameters
    ----------
    step, tolerance, speed : float
        The length of steps [s]; zero: the one of `choose_step` for `tolerance`, for all starts of
        up to this angular velocity [rad/s].
    kick_times, kick_sizes : ndarray, shapes (kick,), (angle, kick)
        Instants [s] and sizes [rad/s] of velocity kicks.
    law : ContactLaw
        What happens at the walls.
    compiled : bool
        Whether the kernel is compiled or runs as plain Python.
    watched : sequence of Observable
        What is gathered of every step and its matrix; contacts are in the table.
    directions : Directions, optional
        Of up to `run_record.MOST_PARAMETERS` parameters, under exact contact: the derivatives of
        the state with respect to each follow the other rows of the samples, and those of the
        instants of contacts the other rows of their values.
    progress : callable, optional
        Called with the fraction done, now and then.
    """
    stepper = choose_stepper(system)
    angles = system.angles
    case = _case_of(
        system, (drive.largest_acceleration, drive.fastest_frequency), start, duration, law,
        rest_speed=rest_speed, follows_ledger=1, follows_tension=not system.is_linear,
        tolerance=tolerance, speed=speed,
    )  # fmt: skip
    for i, distance in enumerate(start.distances):
        case["initial_distance"][:, i] = distance
    if step > 0.0:
        case["step"] = step
    segments = records.segment_records(drive, duration)
    formulas = formulas_of(watched)
    in_plane = moves_in_plane(system, drive)
    carry_on = engine_of(
        angles, *motion_laws(system, drive, in_plane=in_plane), segment=segments.dtype,
        motion="sensitive" if directions is not None else law.motion, compiled=compiled,
        formulas=formulas,
    )  # fmt: skip
    runs = prepared_runs(case, stepper, segments.dtype, compiled=compiled)
    step = float(runs["settings"]["step"][0])
    parameters, segment_changes = 0, segments[:0]
    if directions is not None:
        runs, segment_changes = _differentiated(runs, directions, segments.dtype)
        parameters = len(directions.changes)
    state = runs["state"].view(np.recarray)[0]
    timetable = Timetable(
        segments,
        np.empty(0) if kick_times is None else kick_times,
        np.empty((angles, 0)) if kick_sizes is None else kick_sizes,
        segment_changes,
    )
    rows = records.PLANE_ROWS if in_plane else records.SAMPLE_ROWS
    samples = np.full((rows + 2 * angles * parameters, len(sample_times)), np.nan)
    spare = SPARE_IN_PLANE if in_plane else SPARE_ROWS
    acc = blank_slots(watched, angles).ravel()
    for first, formula in formulas[ON_START]:
        for ball, angle in enumerate(start.angles):
            formula(acc, first * angles + ball, angles, angle)
    room = 256
    kinds, times, values = [], [], []
    count = 0
    status, failed, reached = "complete", False, -1.0
    while True:
        size = min(room, contact_limit - count) + spare
        buffers = (
            np.empty(size),
            np.empty(size, dtype=np.int64),
            np.zeros((records.CONTACT_ROWS + parameters, size)),
        )
        output = Output(sample_times, samples, *buffers)
        written = carry_on(
            runs, timetable, output, Accumulators(acc, 0, angles), duration, STEPS_PER_CALL
        )
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
        if not np.all(abs(np.array([state.angle, state.velocity])) <= LARGEST):
            lost = ~(np.max(abs(samples[: 2 * angles]), axis=0) <= LARGEST)
            if lost.any():
                reached = float(sample_times[np.argmax(lost)])
                samples[:, np.argmax(lost) :] = np.nan
            status = sentence("left_numbers", time=reached)
            failed = True
            break
        if state.is_outside_model != 0:
            status = sentence("left_model", time=reached)
            break
        if reached >= duration:
            break
        if count >= contact_limit:
            status = sentence("contact_limit", time=reached, limit=contact_limit)
            break
        room = min(max(room, 2 * written), 65536)
    return Trajectory(
        samples, np.concatenate(times), np.concatenate(kinds), np.concatenate(values, axis=1),
        state, float(min(reached, duration)), step, stepper, status, failed,
        acc.reshape(-1, angles), int(runs["doubt"][0]),
        float(runs["doubted_since"][0]) if runs["doubt"][0] else math.inf,
    )  # fmt: skip
