"""How observables are shown what happens: steps, contacts, marks, matrices, start and end.

Every observable owns a block of slots, and a trajectory, or its ball, a column of each. Plain
Python and GPUs fold the formulas of all observables into one function for each occasion. Compiled
code calls each by its address instead: see `latolato.numerics.callback_kernels`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.numerics.parts import Part, as_it_stands, inlined
from latolato.numerics.records import Floats
from latolato.numerics.run_record import Run
from latolato.observables import Observable

Formulas = tuple[tuple[int, Callable[..., None]], ...]

OCCASIONS = ("step", "contact", "mark", "restart", "tangent", "start", "finish")
ON_STEP, ON_CONTACT, ON_MARK, ON_RESTART, ON_TANGENT, ON_START, ON_FINISH = range(len(OCCASIONS))
NO_FORMULAS: tuple[Formulas, ...] = ((),) * len(OCCASIONS)


class Accumulators(NamedTuple):
    """Where observables keep what they see.

    Attributes
    ----------
    acc : ndarray
        Their slots, one after the other; each has `columns` columns.
    column : int
        The first column of this trajectory; those of further balls follow.
    columns : int
    """

    acc: Floats
    column: int
    columns: int


class Callbacks(NamedTuple):
    """The functions that show observables something.

    All but `is_wanted` take ``(run, accumulators, ball)`` and then the arguments that an
    observable's formula takes after its slots. `is_wanted` takes ``(run, occasion)``: whether any
    observable has a formula for that occasion.
    """

    step: Callable[..., None]
    contact: Callable[..., None]
    mark: Callable[..., None]
    restart: Callable[..., None]
    tangent: Callable[..., None]
    start: Callable[..., None]
    finish: Callable[..., None]
    is_wanted: Callable[..., bool]


class Slots(NamedTuple):
    """Where an observable's slots begin and how many there are."""

    first: int
    size: int


def slots_of(watched: Sequence[Observable]) -> list[Slots]:
    """Return the offsets of each observable's slots, one block after the other."""
    result, first = [], 0
    for observable in watched:
        result.append(Slots(first, observable.slots))
        first += observable.slots
    return result


def blank_slots(watched: Sequence[Observable], columns: int) -> NDArray[np.float64]:
    """Return the slots before a run, of shape (slot, column): parameters, then zeros."""
    blocks = slots_of(watched)
    acc = np.zeros((sum(block.size for block in blocks), columns))
    for observable, block in zip(watched, blocks, strict=True):
        parameters = observable.parameters
        acc[block.first : block.first + len(parameters)] = np.array(parameters)[:, None]
    return acc


def formulas_of(watched: Sequence[Observable]) -> tuple[Formulas, ...]:
    """Return for each occasion the formulas to call with their first slots."""
    blocks = slots_of(watched)
    return tuple(
        tuple(
            (block.first, getattr(observable, occasion))
            for observable, block in zip(watched, blocks, strict=True)
            if getattr(observable, occasion) is not None
        )
        for occasion in OCCASIONS
    )


def make_callbacks(formulas: tuple[Formulas, ...], part: Part = as_it_stands) -> Callbacks:
    """Return functions into which the formulas of `formulas_of` are folded."""
    inline = inlined(part)
    wanted = tuple(bool(formulas) for formulas in formulas)

    @inline
    def do_nothing(run: Run, accumulators: Accumulators, ball: int, *shown: Any) -> None:
        """Do nothing."""

    def link(first: int, formula: Any, rest: Any) -> Any:
        @inline
        def show(run: Run, accumulators: Accumulators, ball: int, *shown: Any) -> None:
            formula(
                accumulators.acc,
                first * accumulators.columns + accumulators.column + ball,
                accumulators.columns,
                *shown,
            )
            rest(run, accumulators, ball, *shown)

        return show

    @inline
    def is_wanted(run: Run, occasion: int) -> bool:
        """Return whether a callback is registered for an occasion."""
        return wanted[occasion]

    def folded(formulas: Formulas) -> Any:
        shows: Any = do_nothing
        for first, formula in reversed(formulas):
            shows = link(first, formula, shows)
        return shows

    step, contact, mark, restart, tangent, start, finish = map(folded, formulas)
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
