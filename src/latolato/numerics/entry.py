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
from latolato.numerics.engine.record import run_dtype
from latolato.numerics.hooks import make_calling_watch
from latolato.numerics.many import Points, Progress, Scratch, make_many
from latolato.numerics.pieces import (
    address_of,
    bundle_at,
    caller_of,
    kind_of,
    record_at,
    writer_of,
)
from latolato.numerics.records import stretch_dtype
from latolato.numerics.trajectory import make_trajectory, motion_of
from latolato.numerics.watch import Eyes

# ``rows(run, stop, most_steps)``, where `run` is an address; see `latolato.numerics.engine.loop`.
ENGINE = types.int64(types.int64, types.float64, types.int64)


class Arguments(NamedTuple):
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


def example_of(stretch: np.dtype[Any]) -> Arguments:
    """Return arrays of the kinds that an engine is given, without content."""
    floats, table, numbers = np.empty(0), np.empty((1, 0)), np.empty(0, dtype=np.int64)
    kicks = np.empty((2, 2))[:, :1]  # those of one point among many are not contiguous
    return Arguments(
        Timetable(np.empty(0, dtype=stretch), floats, floats, floats, kicks),
        Output(floats, table, floats, numbers, table),
        Eyes(floats, 0, 0),
    )


@compiled_once
def many_piece(balls: int, job: types.Type) -> Piece:
    """Return what runs points of `balls` balls one after the other; `job` is the type of a `Job`.

    It is called with the address of a job's words.
    """
    job_at = bundle_at(job)

    def make(part: Part) -> Callable[..., None]:
        watch = make_calling_watch(part)
        many = part(make_many(make_caller(part), watch, part, balls=balls))

        def run_points(address: int) -> None:
            given = job_at(address)
            many(given.order, given.points, given.scratch, given.progress, given.cancel)

        return run_points

    return compile_piece(make, f"many {balls} {job}", SWEEP)


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
    run_at, arguments_at = record_at(run_dtype(stretch)), bundle_at(kind_of(example_of(stretch)))

    def make(*laws_and_part: Any) -> Callable[..., int]:
        *found, part = laws_and_part
        watch = make_calling_watch(part)
        carry_on = part(make_trajectory(*found, count=count, watch=watch, motion=motion, part=part))

        def engine(address: int, stop: float, most_steps: int) -> int:
            run = run_at(address)
            given = arguments_at(address_of(run.words))
            rows: int = carry_on(run, given.timetable, given.output, given.eyes, stop, most_steps)
            return rows

        return engine

    name = f"engine {motion} {law_key(motion_of(motion))} {count} {stretch}"
    return compile_piece(make, name, ENGINE, *laws)


def make_caller(part: Part) -> Callable[..., int]:
    """Return what calls the engine whose address is ``run.engine``, as if it were it."""
    call = caller_of(ENGINE)
    write = writer_of(kind_of(example_of(stretch_dtype())))

    @part
    def carry_on(
        run: Any, timetable: Timetable, output: Output, eyes: Eyes, stop: float, most_steps: int
    ) -> int:
        write(address_of(run.words), (timetable, output, eyes))
        rows: int = call(run.engine, (address_of(run), stop, most_steps))
        return rows

    return carry_on
