"""Plain Python, one point after the other: the reference for tiny grids, readable and slow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from latolato.numerics.many import Progress
from latolato.numerics.steppers import Stepper
from latolato.sweeps.batches import run_reference
from latolato.sweeps.chunk import Values, run_chunk
from latolato.sweeps.plan import Plan
from latolato.sweeps.points import Batch


def execute(plan: Plan, numbers: Iterable[int]) -> Iterator[tuple[int, tuple[Values, str]]]:
    """Yield the values of chunks, computed without any compiler."""
    for number in numbers:
        yield number, run_chunk(plan, number, _run_points)


def _run_points(
    plan: Plan, batch: Batch, stepper: Stepper, order: NDArray[np.int64], progress: Progress
) -> None:
    """Run points as plain Python."""
    run_reference(plan, batch, stepper, order, progress)
