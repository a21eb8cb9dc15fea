"""Kernels called by address: observables, each formula compiled on its own, and the engine.

Where points run in lanes, one call shows a step of all lanes: see `lane_flight`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from latolato.numerics.abi import CALLBACK, ENGINE
from latolato.numerics.callbacks import OCCASIONS, Accumulators, Callbacks
from latolato.numerics.engine.loop import Timetable, empty_arguments
from latolato.numerics.parts import Part
from latolato.numerics.pointers import (
    ANY_SIZE,
    address_of,
    array_at,
    caller_of,
    kind_of,
    value_at,
    writer_of,
)
from latolato.numerics.records import segment_dtype
from latolato.numerics.run_record import MATRIX_SHAPE, Output, Run
from latolato.observables import Outcome, Step

# What observables are shown on each occasion, behind their slots: see `Observable`.
_SHOWN = tuple(map(kind_of, (
    (Step(*[0.0] * len(Step._fields)),),
    (0.0, 0, 0.0, 0.0, 0.0),
    (0, 0.0, 0.0, 0.0),
    (0.0, 0.0),
    (0, 0.0, 0.0, np.empty(MATRIX_SHAPE)),
    (0.0,),
    (Outcome._make([*[0.0] * 13, 0]),),
)))  # fmt: skip


def make_callback(formula: Any, part: Part, *, occasion: int) -> Callable[..., None]:
    """Return the callback of an observable on an occasion."""
    numbers_at, shown_at = array_at(), value_at(_SHOWN[occasion])

    def show(acc: int, i: int, n: int, shown: int) -> None:
        formula(numbers_at(acc, ANY_SIZE), i, n, *shown_at(shown))

    return show


def make_address_callbacks(part: Part) -> Callbacks:
    """Return functions that call the kernels whose table lies at ``run.callbacks``."""
    call, numbers_at = caller_of(CALLBACK), array_at(np.dtype(np.int64))

    @part
    def call_all(run: Run, accumulators: Accumulators, ball: int, occasion: int) -> None:
        """Call all kernels of an occasion; what they are shown lies in the run."""
        acc, shown, column = (
            address_of(accumulators.acc),
            address_of(run.shown),
            accumulators.column + ball,
        )
        callbacks = numbers_at(run.callbacks, ANY_SIZE)
        at = callbacks[occasion]
        while callbacks[at] != 0:
            first = callbacks[at + 1] * accumulators.columns + column
            call(callbacks[at], (acc, first, accumulators.columns, shown))
            at += 2

    @part
    def is_wanted(run: Run, occasion: int) -> bool:
        """Return whether a callback is registered for an occasion."""
        callbacks = numbers_at(run.callbacks, ANY_SIZE)
        result: bool = callbacks[callbacks[occasion]] != 0
        return result

    def make(occasion: int) -> Any:
        write = writer_of(_SHOWN[occasion])

        @part
        def show(run: Run, accumulators: Accumulators, ball: int, *shown: Any) -> None:
            write(address_of(run.shown), shown)
            call_all(run, accumulators, ball, occasion)

        return show

    step, contact, mark, restart, tangent, start, finish = map(make, range(len(OCCASIONS)))
    return Callbacks(
        step=step,
        contact=contact,
        mark=mark,
        restart=restart,
        tangent=tangent,
        start=start,
        finish=finish,
        is_wanted=is_wanted,
    )


def make_caller(part: Part) -> Callable[..., int]:
    """Return a stand-in for the engine whose address is ``run.engine``: it calls it."""
    call = caller_of(ENGINE)
    write = writer_of(kind_of(empty_arguments(segment_dtype())))

    @part
    def carry_on(
        run: Run,
        timetable: Timetable,
        output: Output,
        accumulators: Accumulators,
        stop: float,
        most_steps: int,
    ) -> int:
        write(address_of(run.words), (timetable, output, accumulators))
        rows: int = call(run.engine, (address_of(run), stop, most_steps))
        return rows

    return carry_on
