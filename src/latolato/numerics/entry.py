"""The engine as a compiled piece: its argument is one record, in which arrays are addresses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import types

from latolato.numerics.compiled import Piece, compile_piece, compiled_once, law_key
from latolato.numerics.engine.compiling import Part
from latolato.numerics.engine.events import Output
from latolato.numerics.engine.laws import Formula
from latolato.numerics.engine.loop import Timetable
from latolato.numerics.engine.record import STATE, run_dtype
from latolato.numerics.hooks import make_calling_watch
from latolato.numerics.many import Points, Progress, Scratch, make_many
from latolato.numerics.pieces import (
    address_of,
    array_kind,
    bundle_at,
    caller_of,
    named_kind,
    record_at,
    write_words,
)
from latolato.numerics.records import BODY, SETTINGS
from latolato.numerics.trajectory import make_trajectory, motion_of
from latolato.numerics.watch import Eyes

# ``rows(run, stop, most_steps)``; see `latolato.numerics.engine.loop`.
ENGINE = types.int64(types.int64, types.float64, types.int64)


class Given(NamedTuple):
    """What an engine is given besides the run."""

    timetable: Timetable
    output: Output
    eyes: Eyes


class Job(NamedTuple):
    """What `numerics.many` works on."""

    order: Any
    points: Points
    scratch: Scratch
    progress: Progress
    cancel: Any


# ``(words)`` of what `numerics.many` and `numerics.lanes` work on.
SWEEP = types.void(types.int64)


_FLOATS, _TABLE, _NUMBERS = array_kind(), array_kind(dimensions=2), array_kind(np.int64)


def given_kind(stretch: np.dtype[Any]) -> Any:
    """Return the type of what an engine is given: timetable, output and eyes."""
    kicks = array_kind(dimensions=2, order="A")
    timetable = [array_kind(stretch), _FLOATS, _FLOATS, _FLOATS, kicks]
    output, eyes = [_FLOATS, _TABLE, _FLOATS, _NUMBERS, _TABLE], [_FLOATS, types.int64, types.int64]
    return named_kind(
        Given, named_kind(Timetable, *timetable), named_kind(Output, *output),
        named_kind(Eyes, *eyes),
    )  # fmt: skip


def points_kind(stretch: np.dtype[Any]) -> Any:
    """Return the type of the points of a sweep."""
    return named_kind(
        Points, array_kind(SETTINGS), array_kind(BODY, 2), array_kind(stretch), _FLOATS, _FLOATS,
        _NUMBERS, _FLOATS, _TABLE, _NUMBERS, _TABLE, types.int64,
    )  # fmt: skip


def scratch_kind(stretch: np.dtype[Any]) -> Any:
    """Return the type of a worker's memory."""
    runs = array_kind(run_dtype(stretch))
    return named_kind(Scratch, runs, _FLOATS, _NUMBERS, _TABLE, _FLOATS, _TABLE)


def progress_kind() -> Any:
    """Return the type of what changes while points run."""
    states = array_kind(STATE)
    return named_kind(Progress, states, states, _NUMBERS, _FLOATS)


@compiled_once
def many_piece(balls: int, stretch: np.dtype[Any]) -> Piece:
    """Return what runs points of `balls` balls one after the other, by calling pieces."""
    kinds = _NUMBERS, points_kind(stretch), scratch_kind(stretch), progress_kind(), _NUMBERS
    given_at = bundle_at(named_kind(Job, *kinds))

    def make(compile_part: Part) -> Callable[..., None]:
        watch = make_calling_watch(compile_part)
        many = compile_part(make_many(make_caller(compile_part), watch, compile_part, balls=balls))

        def run_points(address: int) -> None:
            job = given_at(address)
            many(job.order, job.points, job.scratch, job.progress, job.cancel)

        return run_points

    return compile_piece(make, f"many {balls} {stretch}", SWEEP)


@compiled_once
def engine_piece(
    count: int, stretch: np.dtype[Any], *laws: Formula, motion: str = "exact"
) -> Piece:
    """Return the compiled engine of `count` balls.

    Parameters
    ----------
    stretch : dtype
        The layout of the drive's stretches.
    laws : formulas
        Pivot acceleration, restoring factor and its potential.
    motion : str
        One of `trajectory.MOTIONS`.
    """

    def make(*laws_and_part: Any) -> Callable[..., int]:
        *found, compile_part = laws_and_part
        watch = make_calling_watch(compile_part)
        carry_on = make_trajectory(
            *found, count=count, watch=watch, motion=motion, compile_part=compile_part
        )
        return make_entry(compile_part(carry_on), count, stretch)

    name = f"engine {motion} {law_key(motion_of(motion))} {count} {stretch}"
    return compile_piece(make, name, ENGINE, *laws)


def make_entry(
    carry_on: Callable[..., int], balls: int, stretch: np.dtype[Any]
) -> Callable[..., int]:
    """Return the engine ``(run, stop, most_steps)``; `run` is an address.

    `stretch` is the layout of the drive's stretches.
    """
    run_at, given_at = record_at(run_dtype(stretch)), bundle_at(given_kind(stretch))

    def engine(address: int, stop: float, most_steps: int) -> int:
        run = run_at(address)
        given = given_at(address_of(run.words))
        return carry_on(run, given.timetable, given.output, given.eyes, stop, most_steps)

    return engine


def make_caller(compile_part: Part) -> Callable[..., int]:
    """Return what calls the engine whose address is ``run.engine``, as if it were it."""
    call = caller_of(ENGINE)

    @compile_part
    def carry_on(
        run: Any, timetable: Timetable, output: Output, eyes: Eyes, stop: float, most_steps: int
    ) -> int:
        write_words(address_of(run.words), (timetable, output, eyes))
        rows: int = call(run.engine, (address_of(run), stop, most_steps))
        return rows

    return carry_on
