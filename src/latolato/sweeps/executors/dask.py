"""A Dask cluster: one task a chunk, on workers of this machine or of many."""

from __future__ import annotations

import asyncio
import logging
import signal
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import lru_cache
from itertools import islice
from typing import Any

from latolato.core.errors import InputError, import_extra
from latolato.core.registry import checked_count
from latolato.numerics.abi import sources_hash
from latolato.sweeps.batches import run_fastest
from latolato.sweeps.chunk import Values, run_chunk
from latolato.sweeps.executors.threads import available_processors
from latolato.sweeps.plan import Plan

distributed = import_extra("distributed", "dask", "executor 'dask'")
cloudpickle = import_extra("cloudpickle", "dask", "executor 'dask'")

_PATIENCE = 5.0  # s that a scheduler may take to answer
_WORKERLESS = 30.0  # s that a cluster may be without any worker
_RETRIES = 3
# Chunks for each of the cluster's threads: one runs, one waits.
_CHUNKS_A_THREAD = 2


def execute(
    plan: Plan, numbers: Iterable[int], *, client: Any = None, workers: int | None = None
) -> Iterator[tuple[int, tuple[Values, str]]]:
    """Yield the values of chunks, each computed by a task of a Dask cluster.

    Parameters
    ----------
    client : distributed.Client or str, optional
        The cluster or its scheduler's address. By default one is started on this machine, which
        needs the usual ``if __name__ == "__main__":`` around a script's calls.
    workers : int, optional
        Processes of the cluster that is started; one for each processor by default.

    Raises
    ------
    ConnectionError
        If no scheduler answers at the address.
    InputError
        If the cluster is lost, has no workers, or its workers run another latolato.

    Notes
    -----
    A chunk whose worker dies is computed by another one. When the sweep is cancelled, chunks that
    wait are dropped; on a cluster of your own those that have begun run to their end unseen.
    """
    if client is not None and workers is not None:
        raise InputError("give only one of workers and client: a given cluster has its workers")
    count = available_processors() if workers is None else checked_count("workers", workers)
    with ExitStack() as opened:
        cluster = _connect(client, opened) if client is not None else _start(count, opened)
        yield from _run_all(plan, numbers, cluster)


def _connect(client: Any, opened: ExitStack) -> Any:
    """Return the given client, or one for the given address."""
    if isinstance(client, distributed.Client):
        if client.asynchronous:
            raise InputError(
                "must be synchronous: create it without asynchronous=True", parameter="client"
            )
        return client
    if not isinstance(client, str):
        raise InputError(
            "must be a distributed.Client or an address", parameter="client", value=client
        )
    try:
        # In a thread: the caller may have an event loop, as notebooks do.
        with ThreadPoolExecutor(1) as thread:
            thread.submit(asyncio.run, _knock(client)).result()
        connected = distributed.Client(client, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        why = str(error).split(";")[0].split("\n")[0] or type(error).__name__
        raise ConnectionError(
            f"no Dask scheduler answers at {client!r} ({why}); the address looks like "
            "tcp://192.168.0.5:8786"
        ) from None
    return opened.enter_context(connected)


async def _knock(address: str) -> None:
    """Raise OSError or InputError unless something answers; a `Client` in vain is hard to close."""
    if not address.startswith("tls://"):  # which needs certificates, that a `Client` knows to find
        comm = await distributed.connect(address, timeout=_PATIENCE)
        await comm.close()


def _start(workers: int, opened: ExitStack) -> Any:
    """Return a client of a new cluster of processes that only this machine can reach."""
    try:
        cluster = distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",  # any free port; without a page it still listens
            scheduler_kwargs={"dashboard": False},
            silence_logs=logging.ERROR,
        )
    except RuntimeError as error:
        raise InputError(
            "the workers did not start: a script that calls for them needs "
            "`if __name__ == '__main__':` around its calls, since each of them imports it"
        ) from error
    opened.enter_context(cluster)
    client = opened.enter_context(distributed.Client(cluster, set_as_default=False))
    client.register_worker_callbacks(setup=_ignore_interrupts)
    return client


def _ignore_interrupts() -> None:
    """Leave Ctrl-C, which reaches all processes of a terminal, to the one that closes them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _run_all(
    plan: Plan, numbers: Iterable[int], client: Any
) -> Iterator[tuple[int, tuple[Values, str]]]:
    """Yield the values of chunks as tasks complete, with a bounded number of tasks in flight."""
    packed, sources = cloudpickle.dumps(plan), sources_hash()
    waiting = iter(numbers)
    running: dict[Any, int] = {}
    try:
        while True:
            room = _CHUNKS_A_THREAD * _threads_of(client) - len(running)
            for number in islice(waiting, max(room, 0)):
                future = client.submit(_run, packed, number, sources, pure=False, retries=_RETRIES)
                running[future] = number
            if not running:
                return
            for future in _completed(client, list(running)):
                number = running.pop(future)
                try:
                    result = _result(future, number, client)
                finally:
                    future.release()  # a wait in vain before may still hold it
                yield number, result
    finally:
        if running and client.status == "running":
            client.cancel(list(running), force=True)


def _run(packed: bytes, number: int, sources: str) -> tuple[Values, str]:
    """Return the values of a chunk, on a worker."""
    if sources_hash() != sources:
        raise InputError(
            "this worker's latolato, numba or Python differs from the sweep's: its numbers would "
            "differ too; install the same versions"
        )
    return run_chunk(_unpacked(packed), number, run_fastest)


@lru_cache(maxsize=4)
def _unpacked(packed: bytes) -> Plan:
    """Return the plan; the same object for all its chunks, so that kernels compile once."""
    plan: Plan = cloudpickle.loads(packed)
    return plan


def _threads_of(client: Any) -> int:
    """Return how many threads the cluster has now; waits a while for the first one."""
    try:
        threads = sum(client.nthreads().values())
        if not threads:
            client.wait_for_workers(1, timeout=_WORKERLESS)
            threads = sum(client.nthreads().values())
    except TimeoutError:
        raise InputError(
            f"the Dask cluster at {_address(client)} has no workers: start some with "
            f"`dask worker {_address(client)}`"
        ) from None
    except OSError as error:
        raise _lost(client) from error
    return max(int(threads), 1)


def _completed(client: Any, futures: list[Any]) -> list[Any]:
    """Return the futures that are done, at least one; wait as long as there are workers."""
    while True:
        try:
            with client.as_current():
                result = distributed.wait(futures, timeout=_PATIENCE, return_when="FIRST_COMPLETED")
        except TimeoutError:
            _threads_of(client)
        except distributed.CancelledError as error:
            raise _lost(client) from error
        else:
            return list(result.done)


def _result(future: Any, number: int, client: Any) -> tuple[Values, str]:
    """Return a task's result, with errors that explain what happened to the cluster."""
    while True:
        try:
            result: tuple[Values, str] = future.result(timeout=_PATIENCE)
        except TimeoutError:  # its worker died before it was asked: another one computes it again
            _threads_of(client)
        except distributed.KilledWorker:
            raise InputError(
                f"chunk {number} lost every worker that tried it (out of memory?): "
                "use smaller chunks or workers with more memory"
            ) from None
        except (distributed.CancelledError, distributed.comm.CommClosedError) as error:
            raise _lost(client) from error
        else:
            return result


def _lost(client: Any) -> ConnectionError:
    """Return the error for a cluster that went away."""
    return ConnectionError(
        f"the Dask cluster at {_address(client)} was lost or dropped the sweep's tasks; "
        "with a store, run the sweep again to go on"
    )


def _address(client: Any) -> str:
    return str(client.scheduler.address) if client.scheduler else "an unknown address"
