"""Observables as compiled pieces: each formula is compiled on its own and called by its address.

Where points run in lanes, one call shows a step of all lanes: see `lane_flight`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from latolato.numerics.addresses import (
    ANY_SIZE,
    address_of,
    array_at,
    caller_of,
    kind_of,
    value_at,
    writer_of,
)
from latolato.numerics.engine.compiling import Part
from latolato.numerics.engine.record import MATRIX_SHAPE
from latolato.numerics.pieces import HOOK
from latolato.numerics.watch import OCCASIONS, Eyes, Watch
from latolato.observables import Outcome, Segment

# What observables are shown on each occasion, behind their slots: see `Observable`.
_SHOWN = tuple(map(kind_of, (
    (Segment(*[0.0] * len(Segment._fields)),),
    (0.0, 0, 0.0, 0.0, 0.0),
    (0, 0.0, 0.0, 0.0),
    (0.0, 0.0),
    (0, 0.0, 0.0, np.empty(MATRIX_SHAPE)),
    (0.0,),
    (Outcome._make([*[0.0] * 13, 0]),),
)))  # fmt: skip


def make_hook(formula: Any, part: Part, *, occasion: int) -> Callable[..., None]:
    """Return the callback of an observable on an occasion."""
    numbers_at, shown_at = array_at(), value_at(_SHOWN[occasion])

    def show(acc: int, i: int, n: int, shown: int) -> None:
        formula(numbers_at(acc, ANY_SIZE), i, n, *shown_at(shown))

    return show


def make_calling_watch(part: Part) -> Watch:
    """Return functions that call the pieces whose table lies at ``run.hooks``."""
    call, numbers_at = caller_of(HOOK), array_at(np.dtype(np.int64))

    @part
    def call_all(run: Any, eyes: Eyes, ball: int, occasion: int) -> None:
        """Call all pieces of an occasion; what they are shown lies in the run."""
        acc, shown, column = address_of(eyes.acc), address_of(run.shown), eyes.column + ball
        hooks = numbers_at(run.hooks, ANY_SIZE)
        at = hooks[occasion]
        while hooks[at] != 0:
            first = hooks[at + 1] * eyes.columns + column
            call(hooks[at], (acc, first, eyes.columns, shown))
            at += 2

    @part
    def sees(run: Any, occasion: int) -> bool:
        """Return whether anybody looks on then."""
        hooks = numbers_at(run.hooks, ANY_SIZE)
        result: bool = hooks[hooks[occasion]] != 0
        return result

    def make(occasion: int) -> Any:
        write = writer_of(_SHOWN[occasion])

        @part
        def show(run: Any, eyes: Eyes, ball: int, *shown: Any) -> None:
            write(address_of(run.shown), shown)
            call_all(run, eyes, ball, occasion)

        return show

    step, contact, mark, restart, tangent, start, finish = map(make, range(len(OCCASIONS)))
    return Watch(step, contact, mark, restart, tangent, start, finish, sees)
