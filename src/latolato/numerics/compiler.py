"""Runs actions once numba is imported, which the first kernel that it compiles does."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_waiting: list[Callable[[], None]] = []


@contextmanager
def with_compiler(action: Callable[[], None]) -> Iterator[None]:
    """Call an action within a ``with`` block as soon as numba is there, which may be never."""
    if "numba" in sys.modules:
        action()
        yield
        return
    _waiting.append(action)
    try:
        yield
    finally:
        if action in _waiting:
            _waiting.remove(action)


def tell_it_is_there() -> None:
    """Call what waits for the compiler."""
    while _waiting:
        _waiting.pop()()
