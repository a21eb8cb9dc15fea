"""Marks a scalar formula as compilable without importing a compiler.

A formula is a plain function of numbers that uses :mod:`math` only. It runs as it stands in Python;
`latolato.numerics.compiled` makes the same function callable from compiled code. Nothing here
imports numba, so that ``import latolato`` stays fast.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_formulas: list[Callable[..., Any]] = []
_listeners: list[Callable[[Callable[..., Any]], None]] = []


def formula(function: Function) -> Function:
    """Return `function` itself, known from now on as callable from compiled code."""
    _formulas.append(function)
    for listen in _listeners:
        listen(function)
    return function


def for_each_formula(action: Callable[[Callable[..., Any]], None]) -> None:
    """Apply `action` to every formula there is, and to each one that is marked later."""
    for function in _formulas:
        action(function)
    _listeners.append(action)
