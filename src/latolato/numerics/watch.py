"""Folds the formulas of several observables into one function for each occasion.

Every observable owns a block of slots; the folded functions call each formula with the index of
its own first slot. The column of a trajectory is its number, or that of its ball.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from latolato.numerics.flight import Part
from latolato.observables import Observable

Hooks = tuple[tuple[int, Callable[..., None]], ...]


class Watch(NamedTuple):
    """What is called with ``(acc, column, n, ...)``; the rest as in `Observable`."""

    step: Callable[..., None]
    contact: Callable[..., None]
    mark: Callable[..., None]
    restart: Callable[..., None]
    tangent: Callable[..., None]


class Slots(NamedTuple):
    """Where an observable's slots begin and how many there are."""

    first: int
    size: int


BLIND: tuple[Hooks, ...] = ((), (), (), (), ())
_OCCASIONS = ("step", "contact", "mark", "restart", "tangent")


def slots_of(watched: Sequence[Observable]) -> list[Slots]:
    """Return where each observable's slots lie, one block after the other."""
    found, first = [], 0
    for observable in watched:
        count = len(observable.initial(0.0))  # type: ignore[arg-type]
        found.append(Slots(first, count))
        first += count
    return found


def hooks_of(watched: Sequence[Observable]) -> tuple[Hooks, ...]:
    """Return for each occasion the formulas to call with their first slots, for `make_watch`."""
    blocks = slots_of(watched)
    return tuple(
        tuple(
            (block.first, getattr(observable, occasion))
            for observable, block in zip(watched, blocks, strict=True)
            if getattr(observable, occasion) is not None
        )
        for occasion in _OCCASIONS
    )


def make_watch(hooks: tuple[Hooks, ...], compile_part: Part | None = None) -> Watch:
    """Return the folded functions of `hooks_of`."""
    # Lanes become vectors only if nothing in their loop is called.
    part: Part = partial(compile_part, inline=True) if compile_part else (lambda function: function)
    steps, contacts, marks, restarts, tangents = hooks

    @part
    def no_step(acc: Any, column: int, n: int, segment: Any) -> None:
        """Do nothing."""

    @part
    def no_contact(
        acc: Any, column: int, n: int, t: float, kind: int, v0: float, v1: float, closing: float
    ) -> None:
        """Do nothing."""

    @part
    def no_mark(acc: Any, column: int, n: int, number: int, t: float, x: float, v: float) -> None:
        """Do nothing."""

    @part
    def no_restart(acc: Any, column: int, n: int, x: float, v: float) -> None:
        """Do nothing."""

    @part
    def no_tangent(
        acc: Any, column: int, n: int, size: int, time: float, spread: float, jacobian: Any
    ) -> None:
        """Do nothing."""

    def on_step(first: int, formula: Any, rest: Any) -> Any:
        @part
        def step(acc: Any, column: int, n: int, segment: Any) -> None:
            formula(acc, first * n + column, n, segment)
            rest(acc, column, n, segment)

        return step

    def on_contact(first: int, formula: Any, rest: Any) -> Any:
        @part
        def contact(
            acc: Any, column: int, n: int, t: float, kind: int, v0: float, v1: float, closing: float
        ) -> None:
            formula(acc, first * n + column, n, t, kind, v0, v1, closing)
            rest(acc, column, n, t, kind, v0, v1, closing)

        return contact

    def on_mark(first: int, formula: Any, rest: Any) -> Any:
        @part
        def mark(acc: Any, column: int, n: int, number: int, t: float, x: float, v: float) -> None:
            formula(acc, first * n + column, n, number, t, x, v)
            rest(acc, column, n, number, t, x, v)

        return mark

    def on_restart(first: int, formula: Any, rest: Any) -> Any:
        @part
        def restart(acc: Any, column: int, n: int, x: float, v: float) -> None:
            formula(acc, first * n + column, n, x, v)
            rest(acc, column, n, x, v)

        return restart

    def on_tangent(first: int, formula: Any, rest: Any) -> Any:
        @part
        def tangent(
            acc: Any, column: int, n: int, size: int, time: float, spread: float, jacobian: Any
        ) -> None:
            formula(acc, first * n + column, n, size, time, spread, jacobian)
            rest(acc, column, n, size, time, spread, jacobian)

        return tangent

    def folded(hooks: Hooks, nothing: Any, link: Any) -> Any:
        rest = nothing
        for first, formula in reversed(hooks):
            rest = link(first, formula, rest)
        return rest

    return Watch(
        folded(steps, no_step, on_step),
        folded(contacts, no_contact, on_contact),
        folded(marks, no_mark, on_mark),
        folded(restarts, no_restart, on_restart),
        folded(tangents, no_tangent, on_tangent),
    )
