"""Threads of this machine: compiled kernels that release Python's lock."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from latolato.core.registry import checked_count
from latolato.numerics.batch import Progress
from latolato.numerics.steppers import Stepper
from latolato.sweeps.batches import run_fastest
from latolato.sweeps.chunk import Cancelled, Values, run_chunk
from latolato.sweeps.plan import Plan
from latolato.sweeps.points import Batch
from latolato.sweeps.pool import run_in_threads


def execute(
    plan: Plan, numbers: Iterable[int], *, workers: int | None = None
) -> Iterator[tuple[int, tuple[Values, str]]]:
    """Yield the values of chunks, each computed by one of `workers` threads.

    Parameters
    ----------
    workers : int, optional
        Number of threads; by default one for each processor that this process may use.
    """
    count = available_processors() if workers is None else checked_count("workers", workers)
    yield from run_cancellable(plan, numbers, count, make_cancel())


def run_cancellable(
    plan: Plan, numbers: Iterable[int], count: int, cancel: NDArray[np.int64]
) -> Iterator[tuple[int, tuple[Values, str]]]:
    """Yield the values of chunks from `count` threads until a flag is set.

    Parameters
    ----------
    cancel : ndarray
        The flag, from `make_cancel`: ``cancel[0] = 1`` from any thread stops the kernels, and the
        iterator raises `Cancelled`. It is set at the end, so it serves once.

    Raises
    ------
    Cancelled
        If the flag was set.
    """

    def run_points(
        plan: Plan, batch: Batch, stepper: Stepper, order: NDArray[np.int64], progress: Progress
    ) -> None:
        run_fastest(plan, batch, stepper, order, progress, cancel=cancel)
        if cancel[0]:
            raise Cancelled

    def run(number: int) -> tuple[int, tuple[Values, str]]:
        if cancel[0]:
            raise Cancelled
        return number, run_chunk(plan, number, run_points)

    def stop() -> None:
        cancel[0] = 1

    yield from run_in_threads(run, numbers, count, stop)


def make_cancel() -> NDArray[np.int64]:
    """Return a flag that is not set."""
    return np.zeros(1, dtype=np.int64)


def available_processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
