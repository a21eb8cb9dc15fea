"""How much motion the sweeps of a longer piece of work have computed, for whoever shows it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_WATCHER: ContextVar[Callable[[float], None] | None] = ContextVar("watcher", default=None)


@contextmanager
def watched(tell: Callable[[float], None]) -> Iterator[None]:
    """Tell a function, after each chunk of every sweep in this block, how much motion is computed.

    Parameters
    ----------
    tell : callable
        Called with the duration of all points together since the block began [s].
    """
    total = 0.0

    def add(motion: float) -> None:
        nonlocal total
        total += motion
        tell(total)

    token = _WATCHER.set(add)
    try:
        yield
    finally:
        _WATCHER.reset(token)


def add_motion(motion: float) -> None:
    """Count motion that a sweep has computed [s]."""
    add = _WATCHER.get()
    if add is not None:
        add(motion)
