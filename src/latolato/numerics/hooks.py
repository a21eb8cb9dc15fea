"""Observables as compiled pieces: each formula is compiled for itself and called by its address.

A piece is called with addresses of the slots, of the numbers that describe what is shown, and of
the matrix of small deviations. Where points run in lanes, one
call shows a step of all lanes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from latolato.numerics.compiled import Piece, compile_piece, compiled_once
from latolato.numerics.engine.compiling import Part
from latolato.numerics.engine.record import MATRIX_SHAPE
from latolato.numerics.pieces import address_of, array_at, caller_of
from latolato.numerics.watch import (
    OCCASIONS,
    ON_CONTACT,
    ON_MARK,
    ON_RESTART,
    ON_STEP,
    ON_TANGENT,
    Eyes,
    Hooks,
    Watch,
)
from latolato.observables import Segment

# ``(slots, index of the first one, distance of slots, numbers, matrix)``
_KIND = types.void(*[types.int64] * 5)
_ANY_SIZE = 1 << 40  # of arrays whose end a piece does not look for


@compiled_once
def hook_piece(occasion: int, formula: Callable[..., None]) -> Piece:
    """Return the compiled piece of a formula that is called on an occasion."""
    return compile_piece(_MAKERS[occasion], f"on {OCCASIONS[occasion]}", _KIND, formula)


def hook_table(pieces: Sequence[Sequence[tuple[int, Piece]]]) -> NDArray[np.int64]:
    """Return the table of pieces that compiled code walks through, with their first slots.

    For each occasion it says where its pieces begin: pairs of address and first slot, up to an
    address of zero.
    """
    begins: list[int] = []
    pairs: list[int] = []
    for found in pieces:
        begins.append(len(pieces) + len(pairs))
        for first, piece in found:
            pairs += [piece.address, first]
        pairs += [0]
    return np.array(begins + pairs, dtype=np.int64)


def pieces_of(hooks: tuple[Hooks, ...]) -> list[list[tuple[int, Piece]]]:
    """Return for each occasion the pieces of `watch.hooks_of` with their first slots."""
    return [
        [(first, hook_piece(occasion, formula)) for first, formula in found]
        for occasion, found in enumerate(hooks)
    ]


def make_calling_watch(part: Part) -> Watch:
    """Return functions that call the pieces whose table lies at ``run.hooks``."""
    call, numbers_at = caller_of(_KIND), array_at(np.dtype(np.int64))

    @part
    def call_all(run: Any, eyes: Eyes, ball: int, occasion: int) -> None:
        """Call all pieces of an occasion; what they are shown lies in the run."""
        acc, shown, matrix = address_of(eyes.acc), address_of(run.shown), address_of(run.jacobian)
        hooks = numbers_at(run.hooks, _ANY_SIZE)
        at, column = hooks[occasion], eyes.column + ball
        while hooks[at] != 0:
            first = hooks[at + 1] * eyes.columns + column
            call(hooks[at], (acc, first, eyes.columns, shown, matrix))
            at += 2

    @part
    def sees(run: Any, occasion: int) -> bool:
        """Return whether anybody looks on then."""
        hooks = numbers_at(run.hooks, _ANY_SIZE)
        found: bool = hooks[hooks[occasion]] != 0
        return found

    @part
    def step(run: Any, eyes: Eyes, ball: int, segment: Segment) -> None:
        for i in range(len(segment)):
            run.shown[i] = segment[i]
        call_all(run, eyes, ball, ON_STEP)

    @part
    def contact(
        run: Any, eyes: Eyes, ball: int, t: float, kind: int, v0: float, v1: float, closing: float
    ) -> None:
        shown = run.shown
        shown[0], shown[1], shown[2], shown[3], shown[4] = t, kind, v0, v1, closing
        call_all(run, eyes, ball, ON_CONTACT)

    @part
    def mark(run: Any, eyes: Eyes, ball: int, number: int, t: float, x: float, v: float) -> None:
        shown = run.shown
        shown[0], shown[1], shown[2], shown[3] = number, t, x, v
        call_all(run, eyes, ball, ON_MARK)

    @part
    def restart(run: Any, eyes: Eyes, ball: int, x: float, v: float) -> None:
        run.shown[0], run.shown[1] = x, v
        call_all(run, eyes, ball, ON_RESTART)

    @part
    def tangent(
        run: Any, eyes: Eyes, ball: int, size: int, time: float, spread: float, jacobian: Any
    ) -> None:
        run.shown[0], run.shown[1], run.shown[2] = size, time, spread
        call_all(run, eyes, ball, ON_TANGENT)

    return Watch(step, contact, mark, restart, tangent, sees)


def _on_step(formula: Any, part: Part) -> Any:
    numbers_at = array_at()

    def show(acc: int, i: int, n: int, shown: int, matrix: int) -> None:
        s = numbers_at(shown, 13)
        segment = Segment(
            s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], s[9], s[10], s[11], s[12]
        )
        formula(numbers_at(acc, _ANY_SIZE), i, n, segment)

    return show


def _on_contact(formula: Any, part: Part) -> Any:
    numbers_at = array_at()

    def show(acc: int, i: int, n: int, shown: int, matrix: int) -> None:
        s = numbers_at(shown, 5)
        formula(numbers_at(acc, _ANY_SIZE), i, n, s[0], int(s[1]), s[2], s[3], s[4])

    return show


def _on_mark(formula: Any, part: Part) -> Any:
    numbers_at = array_at()

    def show(acc: int, i: int, n: int, shown: int, matrix: int) -> None:
        s = numbers_at(shown, 4)
        formula(numbers_at(acc, _ANY_SIZE), i, n, int(s[0]), s[1], s[2], s[3])

    return show


def _on_restart(formula: Any, part: Part) -> Any:
    numbers_at = array_at()

    def show(acc: int, i: int, n: int, shown: int, matrix: int) -> None:
        s = numbers_at(shown, 2)
        formula(numbers_at(acc, _ANY_SIZE), i, n, s[0], s[1])

    return show


def _on_tangent(formula: Any, part: Part) -> Any:
    numbers_at, (rows, columns) = array_at(), MATRIX_SHAPE
    matrix_at = array_at(np.dtype(np.float64), columns)

    def show(acc: int, i: int, n: int, shown: int, matrix: int) -> None:
        s, jacobian = numbers_at(shown, 3), matrix_at(matrix, rows)
        formula(numbers_at(acc, _ANY_SIZE), i, n, int(s[0]), s[1], s[2], jacobian)

    return show


_MAKERS = (_on_step, _on_contact, _on_mark, _on_restart, _on_tangent)
