"""Runs chunks in a bounded number of threads and yields them as they end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice

from latolato.sweeps.chunk import Values

Result = tuple[int, tuple[Values, str]]


def run_in_threads(
    run: Callable[[int], Result],
    numbers: Iterable[int],
    count: int,
    stop: Callable[[], None],
) -> Iterator[Result]:
    """Yield ``run(number)`` of all numbers from `count` threads, in any order.

    A chunk more than there are threads waits, so that none of them does; results that wait to
    be taken are bounded the same way. `stop` is called before the threads are waited for at the
    end, also when the iterator is closed early.
    """
    waiting = iter(numbers)
    with ThreadPoolExecutor(count) as pool:
        try:
            running: set[Future[Result]] = {
                pool.submit(run, number) for number in islice(waiting, count + 1)
            }
            while running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    running |= {pool.submit(run, number) for number in islice(waiting, 1)}
                    yield future.result()
        finally:
            stop()
