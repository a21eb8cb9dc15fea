"""The engine as a compiled piece: its argument is one record, in which arrays are addresses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types

from latolato.numerics.compiled import Piece, compile_piece, compiled_once, law_key
from latolato.numerics.engine.compiling import Part
from latolato.numerics.engine.events import Output
from latolato.numerics.engine.laws import Formula
from latolato.numerics.engine.loop import Timetable
from latolato.numerics.engine.record import run_dtype
from latolato.numerics.hooks import make_calling_watch
from latolato.numerics.pieces import address_of, array_at, caller_of, record_at, table_at
from latolato.numerics.records import SAMPLE_ROWS
from latolato.numerics.trajectory import MOTIONS, make_trajectory
from latolato.numerics.watch import Eyes
from latolato.scalar import formula

# ``rows(run, stop, most_steps)``; see `latolato.numerics.engine.loop`.
ENGINE = types.int64(types.int64, types.float64, types.int64)
_CONTACT_ROWS = 4


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

    name = f"engine {motion} {law_key(MOTIONS[motion])} {count} {stretch}"
    return compile_piece(make, name, ENGINE, *laws)


@formula
def write_memory(memory: Any, timetable: Timetable, output: Output, eyes: Eyes) -> None:
    """Write where the arrays lie."""
    memory.stretches = timetable.stretches.ctypes.data
    memory.starts = timetable.starts.ctypes.data
    memory.jumps = timetable.jumps.ctypes.data
    memory.stretch_count = len(timetable.starts)
    memory.kick_times = timetable.kick_times.ctypes.data
    memory.kick_sizes = timetable.kick_sizes.ctypes.data
    memory.kick_stride = timetable.kick_sizes.strides[0]
    memory.kick_count = len(timetable.kick_times)
    memory.sample_times = output.sample_times.ctypes.data
    memory.samples = output.samples.ctypes.data
    memory.sample_count = len(output.sample_times)
    memory.contact_times = output.contact_times.ctypes.data
    memory.contact_kinds = output.contact_kinds.ctypes.data
    memory.contact_values = output.contact_values.ctypes.data
    memory.contact_count = len(output.contact_times)
    memory.acc = eyes.acc.ctypes.data
    memory.acc_size = len(eyes.acc)
    memory.column = eyes.column
    memory.columns = eyes.columns


def make_entry(
    carry_on: Callable[..., int], balls: int, stretch: np.dtype[Any]
) -> Callable[..., int]:
    """Return the engine ``(run, stop, most_steps)`` of `balls` balls; `run` is an address.

    `stretch` is the layout of the drive's stretches.
    """
    run_at, floats_at = record_at(run_dtype(stretch)), array_at()
    stretches_at, numbers_at = array_at(stretch), array_at(np.dtype(np.int64))

    def engine(address: int, stop: float, most_steps: int) -> int:
        run = run_at(address)
        m = run.memory
        timetable = Timetable(
            stretches_at(m.stretches, m.stretch_count),
            floats_at(m.starts, m.stretch_count),
            floats_at(m.jumps, m.stretch_count),
            floats_at(m.kick_times, m.kick_count),
            table_at(m.kick_sizes, balls, m.kick_count, m.kick_stride),
        )
        output = Output(
            floats_at(m.sample_times, m.sample_count),
            table_at(m.samples, SAMPLE_ROWS, m.sample_count, 8 * m.sample_count),
            floats_at(m.contact_times, m.contact_count),
            numbers_at(m.contact_kinds, m.contact_count),
            table_at(m.contact_values, _CONTACT_ROWS, m.contact_count, 8 * m.contact_count),
        )
        eyes = Eyes(floats_at(m.acc, m.acc_size), m.column, m.columns)
        return carry_on(run, timetable, output, eyes, stop, most_steps)

    return engine


def make_caller(compile_part: Part) -> Callable[..., int]:
    """Return what calls the engine whose address is ``run.memory.engine``, as if it were it."""
    call = caller_of(ENGINE)

    @compile_part
    def carry_on(
        run: Any, timetable: Timetable, output: Output, eyes: Eyes, stop: float, most_steps: int
    ) -> int:
        write_memory(run.memory, timetable, output, eyes)
        rows: int = call(run.memory.engine, (address_of(run), stop, most_steps))
        return rows

    return carry_on
