"""Plain Python, one point after the other: the reference for tiny grids, readable and slow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from latolato.sweeps.batches import run_reference
from latolato.sweeps.chunk import Values, run_chunk
from latolato.sweeps.plan import Plan


def execute(plan: Plan, numbers: Iterable[int]) -> Iterator[tuple[int, tuple[Values, str]]]:
    """Yield the values of chunks, computed without any compiler."""
    for number in numbers:
        yield number, run_chunk(plan, number, run_reference)
