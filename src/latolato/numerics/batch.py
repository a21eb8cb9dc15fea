"""Many trajectories, one after the other: what every executor does with one point of a sweep.

The trajectory itself is that of a single run, with the formulas of the observables folded in.
Nothing is stored but the accumulators and the state at the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.numerics import lane_rows as r
from latolato.numerics.callbacks import ON_CONTACT, Accumulators, Callbacks
from latolato.numerics.engine.loop import Timetable
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.records import (
    AT_REST,
    BODY,
    CONTACT_ROWS,
    CONVERGED,
    EVENT_LIMIT,
    FAILED,
    GRAZING,
    OUTSIDE_MODEL,
    PLANE_ROWS,
    SETTINGS,
    Floats,
    Integers,
    Records,
)
from latolato.numerics.run_record import STATE, Output, run_dtype
from latolato.observables import Outcome

_STEPS_PER_CALL = 20_000  # after so many steps a trajectory is looked at: is it finite still?
_ROWS = 60  # of the contact table that is handed on to the observables


class Points(NamedTuple):
    """The points of a sweep as arrays; the first dimension is the point unless noted.

    Attributes
    ----------
    settings, bodies : ndarray
        Records of shapes (point,) and (point, body).
    segments : ndarray, shape (segment,)
        The drives' segments of all points; those of point k begin at ``firsts[k]``.
    kick_times, kick_sizes : ndarray, shapes (kick,), (angle, kick)
        Velocity kicks of all points; those of point k begin at ``kick_firsts[k]``.
    stops : ndarray, shape (point, 2 + mark)
        Instants at which a step ends [s]: the transient's end, marks (NaN: none), the run's end.
    contact_limit : int
        Contacts after which a trajectory is given up.
    """

    settings: Records
    bodies: Records
    segments: Records
    firsts: Integers
    kick_times: Floats
    kick_sizes: Floats
    kick_firsts: Integers
    stops: Floats
    contact_limit: int


class Progress(NamedTuple):
    """What changes while points run; see `make_progress`."""

    states: Records  # records of shape (point,)
    begun: Records  # the same when the transient ended
    status: Integers  # (point,)
    acc: Floats  # (slot * column,), slot after slot; a column is a point's ball


class Scratch(NamedTuple):
    """Memory that one worker reuses."""

    runs: Records  # one record, with the stepper's weights
    contact_times: Floats
    contact_kinds: Integers
    contact_values: Floats
    no_times: Floats
    no_samples: Floats


class Weights(NamedTuple):
    """A stepper's weights."""

    kicks: Floats
    drifts: Floats
    nodes: Floats


def make_progress(states: Records, acc: Floats) -> Progress:
    """Return the points' initial states, shape (point,), and accumulators."""
    return Progress(
        states.copy(), np.zeros_like(states), np.zeros(len(states), dtype=np.int64), acc
    )


def make_scratch(segment: np.dtype[Any] | None = None) -> Scratch:
    """Return a worker's memory; `segment` is the layout of the drive's segments."""
    size = _ROWS + 4
    return Scratch(
        np.zeros(1, dtype=run_dtype(segment)),
        np.zeros(size),
        np.zeros(size, dtype=np.int64),
        np.zeros((CONTACT_ROWS, size)),
        np.zeros(0),
        np.zeros((PLANE_ROWS, 0)),
    )


class Job(NamedTuple):
    """What runs points one after the other works on."""

    order: Integers  # numbers of the points
    points: Points
    scratch: Scratch
    progress: Progress
    cancel: Integers


class LaneSpace(NamedTuple):
    """The memory of lanes, and the addresses of their kernels; see `make_lane_space`."""

    w: Floats  # rows of `lane_rows`, each LANES wide
    z: Floats  # rows of noted impacts
    table: Floats  # rows of a step's table
    acc: Floats  # (slot * LANES,)
    point: Integers  # (LANES,): which point a lane carries, -1 for none
    index: Any  # (LANES,): its next stop
    lane: Integers  # (IMPACTS,): whose impact is noted
    step: int
    locate: int
    callbacks: Integers  # see `kernels.callback_table`


class Task(NamedTuple):
    """What lanes work on."""

    order: Integers  # numbers of the points
    points: Points
    weights: Weights
    scratch: Scratch
    progress: Progress
    space: LaneSpace
    cancel: Integers


def make_lane_space(
    stages: int, slots: int, step: int, locate: int, callbacks: NDArray[np.int64]
) -> LaneSpace:
    """Return the memory of lanes whose step has so many stages, for observables with so many slots.

    `step` and `locate` are addresses of the kernels of `lane_flight` and `lane_locate`, `callbacks`
    the table of what shows steps and matrices.
    """
    return LaneSpace(
        np.zeros(r.ROWS * r.LANES),
        np.zeros(r.IMPACT_ROWS * r.IMPACTS),
        np.zeros((stages + 1) * r.TABLE_ROWS * r.LANES),
        np.zeros(r.LANES * slots),
        np.full(r.LANES, -1),
        np.zeros(r.LANES, dtype=np.int64),
        np.zeros(r.IMPACTS, dtype=np.int64),
        step,
        locate,
        callbacks,
    )


def empty_points(segment: np.dtype[Any]) -> Points:
    """Return no points, in arrays of the kinds that points have."""
    floats, numbers = np.zeros(0), np.zeros(0, dtype=np.int64)
    return Points(
        settings=np.zeros(0, dtype=SETTINGS),
        bodies=np.zeros((0, 4), dtype=BODY),
        segments=np.zeros(0, dtype=segment),
        firsts=numbers,
        kick_times=floats,
        kick_sizes=np.zeros((1, 0)),
        kick_firsts=numbers,
        stops=np.zeros((0, 2)),
        contact_limit=0,
    )


def empty_job(segment: np.dtype[Any]) -> Job:
    """Return a job without points."""
    numbers = np.zeros(0, dtype=np.int64)
    return Job(
        numbers,
        empty_points(segment),
        make_scratch(segment),
        make_progress(np.zeros(0, dtype=STATE), np.zeros(0)),
        numbers,
    )


def empty_task(segment: np.dtype[Any]) -> Task:
    """Return a task without points."""
    floats, job = np.zeros(0), empty_job(segment)
    space = make_lane_space(0, 0, 0, 0, job.order)
    weights = Weights(floats, floats, floats)
    return Task(job.order, job.points, weights, job.scratch, job.progress, space, job.cancel)


class Steering(NamedTuple):
    """What is done with one point between and at its stops; see `make_steering`."""

    start: Callable[..., None]
    carry_to: Callable[..., int]
    is_over: Callable[..., bool]
    arrive: Callable[..., None]
    time_of: Callable[..., float]


def make_steering(
    carry_on: Callable[..., int],
    callbacks: Callbacks,
    part: Part = as_it_stands,
    balls: int = 1,
) -> Steering:
    """Return the functions that steer one point of a sweep.

    Parameters
    ----------
    carry_on : callable
        The engine, or what calls it; see `callback_kernels.make_caller`.
    balls : int
        Angles of the state.

    Notes
    -----
    A point's accumulators are the columns ``column`` (and the next one, for two balls) of
    ``columns`` in ``acc``.
    """
    on_contact, on_mark, on_restart, is_wanted = (
        callbacks.contact,
        callbacks.mark,
        callbacks.restart,
        callbacks.is_wanted,
    )
    on_start, on_finish, two = callbacks.start, callbacks.finish, balls == 2

    @part
    def start(
        k: int, scratch: Scratch, progress: Progress, acc: Floats, column: int, columns: int
    ) -> None:
        """Start the observables of point k."""
        accumulators = Accumulators(acc, column, columns)
        for ball in range(balls):
            on_start(scratch.runs[0], accumulators, ball, progress.states[k].angle[ball])

    @part
    def carry_to(
        stop: float, most_steps: int, k: int, points: Points, scratch: Scratch,
        progress: Progress, acc: Floats, column: int, columns: int,
    ) -> int:  # fmt: skip
        """Carry point k on to `stop`, for at most so many steps; return the contacts' rows."""
        first, last = points.firsts[k], points.firsts[k + 1]
        kick, last_kick = points.kick_firsts[k], points.kick_firsts[k + 1]
        run = scratch.runs[0]
        run.state, run.settings = progress.states[k], points.settings[k]
        for i in range(4 if two else 1):
            run.bodies[i] = points.bodies[k, i]
        timetable = Timetable(
            points.segments[first:last], points.kick_times[kick:last_kick],
            points.kick_sizes[:, kick:last_kick],
            points.segments[:0],
        )  # fmt: skip
        output = Output(
            scratch.no_times, scratch.no_samples, scratch.contact_times, scratch.contact_kinds,
            scratch.contact_values,
        )  # fmt: skip
        accumulators = Accumulators(acc, column, columns)
        rows = carry_on(run, timetable, output, accumulators, stop, most_steps)
        progress.states[k] = run.state
        if is_wanted(run, ON_CONTACT):
            values = scratch.contact_values
            for row in range(rows):
                closing = abs(values[0, row] - values[1, row]) if two else abs(values[0, row])
                for ball in range(balls):
                    on_contact(
                        run, accumulators, ball, scratch.contact_times[row],
                        scratch.contact_kinds[row], values[ball, row], values[balls + ball, row],
                        closing,
                    )  # fmt: skip
        return rows

    @part
    def time_of(k: int, points: Points, progress: Progress) -> float:
        """Return the time that point k has reached [s]."""
        state = progress.states[k]
        reached: float = state.t_base + state.steps * points.settings[k].step
        return reached

    @part
    def is_over(k: int, points: Points, progress: Progress) -> bool:
        """Return whether point k must be given up, and write its status then."""
        state, size = progress.states[k], 0.0
        for ball in range(balls):
            size += state.angle[ball] + state.velocity[ball]
        if not math.isfinite(size):
            progress.status[k] = FAILED
            return True
        if state.contacts >= points.contact_limit:
            progress.status[k] = EVENT_LIMIT
            return True
        if state.is_outside_model != 0:
            progress.status[k] = OUTSIDE_MODEL
            return True
        return False

    @part
    def arrive(
        index: int, k: int, points: Points, scratch: Scratch, progress: Progress, acc: Floats,
        column: int, columns: int,
    ) -> None:  # fmt: skip
        """Do what is to be done at a stop of point k: forget the transient, mark, conclude."""
        state, t, run = progress.states[k], points.stops[k, index], scratch.runs[0]
        accumulators = Accumulators(acc, column, columns)
        if index == 0:
            for ball in range(balls):
                progress.states[k].slack_start[ball] = math.nan
            progress.states[k].string_impulse = 0.0
            progress.begun[k] = progress.states[k]
            for ball in range(balls):
                on_restart(run, accumulators, ball, state.angle[ball], state.velocity[ball])
        elif index < points.stops.shape[1] - 1:
            for ball in range(balls):
                angle, velocity = state.angle[ball], state.velocity[ball]
                on_mark(run, accumulators, ball, index - 1, t, angle, velocity)
        else:
            progress.status[k] = (
                GRAZING if state.grazes > 0 else AT_REST if state.rests != 0 else CONVERGED
            )
            begun, observed_time = progress.begun[k], t - points.stops[k, 0]
            for ball in range(balls):
                outcome = Outcome(
                    state.angle[ball], state.velocity[ball], observed_time,
                    points.bodies[k, ball].inertia, state.drive_work - begun.drive_work,
                    state.damping_loss - begun.damping_loss,
                    state.impact_loss - begun.impact_loss,
                    state.capture_loss - begun.capture_loss,
                    state.retension_loss - begun.retension_loss,
                    state.compression_time[ball] - begun.compression_time[ball],
                    state.slack_time[ball] - begun.slack_time[ball], state.slack_start[ball],
                    state.string_impulse, balls,
                )  # fmt: skip
                on_finish(run, accumulators, ball, outcome)

    return Steering(
        start=start,
        carry_to=carry_to,
        is_over=is_over,
        arrive=arrive,
        time_of=time_of,
    )


def make_point(steering: Steering, part: Part = as_it_stands, balls: int = 1) -> Any:
    """Return the function that carries one point of a sweep from its start to its end."""
    start, carry_to, is_over, arrive, time_of = steering

    @part
    def point(k: int, points: Points, scratch: Scratch, progress: Progress) -> None:
        acc, column, columns = progress.acc, balls * k, balls * len(progress.status)
        start(k, scratch, progress, acc, column, columns)
        for index in range(points.stops.shape[1]):
            stop = points.stops[k, index]
            if math.isnan(stop):
                continue
            t = time_of(k, points, progress)
            while not t >= stop:
                before = t
                rows = carry_to(
                    stop, _STEPS_PER_CALL, k, points, scratch, progress, acc, column, columns
                )  # fmt: skip
                t = time_of(k, points, progress)
                if is_over(k, points, progress):
                    return
                if t == before and rows == 0:  # steps too short to move the clock
                    progress.status[k] = FAILED
                    return
            arrive(index, k, points, scratch, progress, acc, column, columns)

    return point


def make_many(
    carry_on: Callable[..., int], callbacks: Callbacks, part: Part = as_it_stands, *, balls: int
) -> Callable[..., None]:
    """Return the function that runs the points of `order` one after the other."""
    steering = make_steering(carry_on, callbacks, part, balls)
    point = make_point(steering, part, balls)

    def many(
        order: NDArray[np.int64],
        points: Points,
        scratch: Scratch,
        progress: Progress,
        cancel: NDArray[np.int64],
    ) -> None:
        for k in order:
            if cancel[0] != 0:
                return
            point(k, points, scratch, progress)

    return many
