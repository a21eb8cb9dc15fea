"""Many trajectories, one after the other: what every executor does with one point of a sweep.

The trajectory itself is that of a single run (`fold`, `fold_pair` or `clamp`), with the formulas of
the observables folded in. Nothing is stored but the accumulators and the state at the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.numerics import records
from latolato.numerics.flight import Part
from latolato.numerics.records import (
    ANGLE_1,
    ANGLE_2,
    AT_REST,
    BEGUN,
    CONTACT,
    CONVERGED,
    EVENT_LIMIT,
    FAILED,
    FLIGHT,
    GRAZES,
    GRAZING,
    MODE,
    STEPS,
    T_BASE,
    VELOCITY_1,
    VELOCITY_2,
)
from latolato.numerics.watch import BLIND, Hooks, make_watch

_STEPS_PER_CALL = 20_000  # after so many steps a trajectory is looked at: is it finite still?
_ROWS = 60  # of the contact table that is handed on to the observables


class Points(NamedTuple):
    """The points of a sweep as arrays; the first dimension is the point unless noted.

    Attributes
    ----------
    settings, bodies : ndarray
        Records of shapes (point,) and (point, body).
    stretches, starts, jumps : ndarray, shape (stretch,)
        The drives' stretches of all points; those of point k begin at ``firsts[k]``.
    kick_times, kick_sizes : ndarray, shapes (kick,), (angle, kick)
        Velocity kicks of all points; those of point k begin at ``kick_firsts[k]``.
    stops : ndarray, shape (point, 2 + mark)
        Instants at which a step ends [s]: the transient's end, marks (NaN: none), the run's end.
    contact_limit : int
        Contacts after which a trajectory is given up.
    """

    settings: Any
    bodies: Any
    stretches: Any
    starts: Any
    jumps: Any
    firsts: Any
    kick_times: Any
    kick_sizes: Any
    kick_firsts: Any
    stops: Any
    contact_limit: Any


class Progress(NamedTuple):
    """What changes while points run; see `make_progress`."""

    state: Any  # (point, STATE_SIZE)
    counters: Any  # (point, COUNTERS_SIZE)
    begun: Any  # (point, len(BEGUN)): the ledger when the transient ended
    status: Any  # (point,)
    acc: Any  # (slot * column,), slot after slot; a column is a point's ball


class Scratch(NamedTuple):
    """Memory that one worker reuses."""

    tables: Any
    space: Any
    contact_times: Any
    contact_kinds: Any
    contact_values: Any
    no_times: Any
    no_samples: Any


class Weights(NamedTuple):
    """A stepper's weights."""

    kicks: Any
    drifts: Any
    nodes: Any


def make_progress(count: int, slots: int, balls: int) -> Progress:
    """Return the arrays that `count` points of `balls` angles write to."""
    return Progress(
        np.zeros((count, records.STATE_SIZE)),
        np.zeros((count, records.COUNTERS_SIZE), dtype=np.int64),
        np.zeros((count, len(BEGUN))),
        np.zeros(count, dtype=np.int64),
        np.zeros(max(slots, 1) * count * balls),
    )


def make_scratch(stages: int, copies: tuple[int, ...] = ()) -> Scratch:
    """Return a worker's memory; `copies` is a leading shape for several workers at once."""
    size = _ROWS + 4
    return Scratch(
        np.zeros((*copies, 6, 3, stages + 1)),
        np.zeros((*copies, *records.SPACE)),
        np.zeros((*copies, size)),
        np.zeros((*copies, size), dtype=np.int64),
        np.zeros((*copies, 4, size)),
        np.zeros((*copies, 0)),
        np.zeros((*copies, records.SAMPLE_ROWS, 0)),
    )


class Steering(NamedTuple):
    """What is done with one point between and at its stops; see `make_steering`."""

    carry_to: Callable[..., int]
    is_over: Callable[..., bool]
    arrive: Callable[..., None]
    time_of: Callable[..., float]


def make_steering(
    make: Callable[..., Callable[..., int]],
    laws: tuple[Callable[..., float], ...],
    compile_part: Part | None = None,
    hooks: tuple[Hooks, ...] = BLIND,
    balls: int = 1,
) -> Steering:
    """Return the functions that steer one point of a sweep.

    Parameters
    ----------
    make : callable
        `fold.make_trajectory` or its like.
    laws : tuple of formulas
        The drive's acceleration, the restoring law and its potential.
    hooks : tuple
        The observables' formulas, from `watch.hooks_of`.
    balls : int
        Angles of the state.

    Notes
    -----
    A point's accumulators are the columns ``column`` (and the next one, for two balls) of
    ``columns`` in ``acc``.
    """
    part: Part = compile_part or (lambda function: function)
    carry_on = part(make(*laws, compile_part, hooks))
    watch = make_watch(hooks, compile_part)
    on_contact, on_mark, on_restart = watch.contact, watch.mark, watch.restart
    watches_contacts = bool(hooks[1])
    two = balls == 2
    x2 = ANGLE_2 if two else ANGLE_1
    v2 = VELOCITY_2 if two else VELOCITY_1

    @part
    def carry_to(
        stop: float,
        most_steps: int,
        k: int,
        points: Points,
        weights: Weights,
        scratch: Scratch,
        progress: Progress,
        acc: Any,
        column: int,
        columns: int,
    ) -> int:
        """Carry point k on to `stop`, for at most so many steps; return the contacts' rows."""
        first, last = points.firsts[k], points.firsts[k + 1]
        kick, last_kick = points.kick_firsts[k], points.kick_firsts[k + 1]
        rows = carry_on(
            progress.state[k], progress.counters[k], points.settings[k : k + 1], points.bodies[k],
            points.stretches[first:last], points.starts[first:last], points.jumps[first:last],
            points.kick_times[kick:last_kick], points.kick_sizes[:, kick:last_kick],
            scratch.tables, scratch.space, weights.kicks, weights.drifts, weights.nodes,
            scratch.no_times, scratch.no_samples, scratch.contact_times, scratch.contact_kinds,
            scratch.contact_values, stop, most_steps, acc, column, columns,
        )  # fmt: skip
        if watches_contacts:
            values = scratch.contact_values
            for row in range(rows):
                closing = abs(values[0, row] - values[1, row]) if two else abs(values[0, row])
                for ball in range(balls):
                    on_contact(
                        acc, column + ball, columns, scratch.contact_times[row],
                        scratch.contact_kinds[row], values[ball, row], values[balls + ball, row],
                        closing,
                    )  # fmt: skip
        return rows

    @part
    def time_of(k: int, points: Points, progress: Progress) -> float:
        """Return the time that point k has reached [s]."""
        n = progress.counters[k, STEPS]
        reached: float = progress.state[k, T_BASE] + n * points.settings[k].step
        return reached

    @part
    def is_over(k: int, points: Points, progress: Progress) -> bool:
        """Return whether point k must be given up, and write its status then."""
        state = progress.state
        size = state[k, ANGLE_1] + state[k, VELOCITY_1] + state[k, x2] + state[k, v2]
        if not math.isfinite(size):
            progress.status[k] = FAILED
            return True
        if progress.counters[k, CONTACT] >= points.contact_limit:
            progress.status[k] = EVENT_LIMIT
            return True
        return False

    @part
    def arrive(
        index: int, k: int, points: Points, progress: Progress, acc: Any, column: int, columns: int
    ) -> None:
        """Do what is to be done at a stop of point k: forget the transient, mark, conclude."""
        state = progress.state
        if index == 0:
            for i in range(len(BEGUN)):
                progress.begun[k, i] = state[k, BEGUN[i]]
            on_restart(acc, column, columns, state[k, ANGLE_1], state[k, VELOCITY_1])
            if two:
                on_restart(acc, column + 1, columns, state[k, x2], state[k, v2])
        elif index < points.stops.shape[1] - 1:
            t = points.stops[k, index]
            on_mark(acc, column, columns, index - 1, t, state[k, ANGLE_1], state[k, VELOCITY_1])
            if two:
                on_mark(acc, column + 1, columns, index - 1, t, state[k, x2], state[k, v2])
        elif progress.counters[k, GRAZES] > 0:
            progress.status[k] = GRAZING
        elif progress.counters[k, MODE] != FLIGHT:
            progress.status[k] = AT_REST
        else:
            progress.status[k] = CONVERGED

    return Steering(carry_to, is_over, arrive, time_of)


def make_point(steering: Steering, compile_part: Part | None = None, balls: int = 1) -> Any:
    """Return the function that carries one point of a sweep from its start to its end."""
    part: Part = compile_part or (lambda function: function)
    carry_to, is_over, arrive, time_of = steering

    @part
    def point(
        k: int, points: Points, weights: Weights, scratch: Scratch, progress: Progress
    ) -> None:
        acc, column, columns = progress.acc, balls * k, balls * len(progress.status)
        for index in range(points.stops.shape[1]):
            stop = points.stops[k, index]
            if math.isnan(stop):
                continue
            t = time_of(k, points, progress)
            while not t >= stop:
                before = t
                rows = carry_to(
                    stop, _STEPS_PER_CALL, k, points, weights, scratch, progress, acc, column,
                    columns,
                )  # fmt: skip
                t = time_of(k, points, progress)
                if is_over(k, points, progress):
                    return
                if t == before and rows == 0:  # steps too short to move the clock
                    progress.status[k] = FAILED
                    return
            arrive(index, k, points, progress, acc, column, columns)

    return point


def make_many(
    acceleration: Callable[..., float],
    restoring: Callable[..., float],
    potential: Callable[..., float],
    compile_part: Part | None = None,
    *,
    make: Callable[..., Callable[..., int]],
    hooks: tuple[Hooks, ...],
    balls: int,
) -> Callable[..., None]:
    """Return the function that runs the points of `order` one after the other."""
    laws = (acceleration, restoring, potential)
    point = make_point(make_steering(make, laws, compile_part, hooks, balls), compile_part, balls)

    def many(
        order: NDArray[np.int64],
        points: Points,
        weights: Weights,
        scratch: Scratch,
        progress: Progress,
        cancel: NDArray[np.int64],
    ) -> None:
        for k in order:
            if cancel[0] != 0:
                return
            point(k, points, weights, scratch, progress)

    return many
