"""How the engine's functions become parts of a kernel, or stay plain Python."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

# Makes a function callable from a kernel; with ``inline=True`` it is taken in where it is called.
Part = Callable[..., Callable[..., Any]]


def as_it_stands(function: Callable[..., Any], *, inline: bool = False) -> Callable[..., Any]:
    """Return the function: as plain Python it is its own part."""
    return function


def inlined(part: Part) -> Part:
    """Return a part that is taken in where it is called."""
    return partial(part, inline=True)
