"""An NVIDIA GPU: one thread a point, in float64, from the same functions as every other executor.

numba-cuda compiles formulas that are marked for the processor, so nothing is written twice. The
processor contracts multiply-adds in other places than the device: points agree to rounding, which
chaotic motion enlarges.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import latolato.numerics.compiled  # noqa: F401 - makes formulas callable from compiled code
from latolato.errors import InputError, import_extra
from latolato.numerics.integrate import maker_of
from latolato.numerics.many import Points, Progress, Scratch, Weights, make_many, make_scratch
from latolato.numerics.steppers import Stepper
from latolato.numerics.watch import hooks_of
from latolato.registry import checked_count
from latolato.sweep.chunk import Cancelled, Values, run_chunk
from latolato.sweep.kernels import trajectory_name
from latolato.sweep.plan import Plan
from latolato.sweep.points import Batch
from latolato.sweep.pool import run_in_threads

import_extra("numba_cuda", "cuda", "executor 'cuda'", way_out="use executor='threads'")
from numba import cuda  # noqa: E402 - older releases of numba have it without the extra

# A thread needs all registers that it may have (254), so that 256 of them fill a multiprocessor.
_THREADS_PER_BLOCK = 128
# Points of a launch; a cancelled sweep waits for those of them that have begun.
_POINTS_PER_LAUNCH = 1 << 17
# A chunk of the default size fills an eighth of a large device: several run side by side.
_CHUNKS_AT_ONCE = 32

_WAY_OUT = "use executor='threads' or run where there is one"


def execute(
    plan: Plan, numbers: Iterable[int], *, workers: int | None = None
) -> Iterator[tuple[int, tuple[Values, str]]]:
    """Return an iterator over the values of chunks, computed on the first GPU.

    Parameters
    ----------
    workers : int, optional
        Chunks that are on the device at once; 32 by default.

    Raises
    ------
    InputError
        Without a device: nothing falls back to the processor.
    """
    count = _CHUNKS_AT_ONCE if workers is None else checked_count("workers", workers)
    if not cuda.is_available():
        why = " ".join(str(cuda.cuda_error() or "the driver sees none").split())
        raise InputError(f"executor 'cuda' needs an NVIDIA GPU, found none ({why}): {_WAY_OUT}")
    # A chunk alone is small for the device on purpose.
    warnings.filterwarnings("ignore", message="Grid size .* will likely result in GPU")
    return _execute(plan, numbers, count)


def _execute(
    plan: Plan, numbers: Iterable[int], count: int
) -> Iterator[tuple[int, tuple[Values, str]]]:
    """Yield the values of chunks, each launched from a thread and on a stream of its own."""
    cancel = np.zeros(1, dtype=np.int64)
    cancel_on_device = cuda.to_device(cancel)

    def run_points(
        plan: Plan, batch: Batch, stepper: Stepper, order: NDArray[np.int64], progress: Progress
    ) -> None:
        kernel = kernel_of(plan, stepper)
        stream = cuda.stream()
        arguments = kernel_arguments(batch, stepper, order, progress)
        on_device = [
            cuda.to_device(a, stream=stream) if isinstance(a, np.ndarray) else a for a in arguments
        ]
        for first in range(0, len(order), _POINTS_PER_LAUNCH):
            launched = on_device[0][first : first + _POINTS_PER_LAUNCH]
            blocks = -(-launched.shape[0] // _THREADS_PER_BLOCK)
            kernel[blocks, _THREADS_PER_BLOCK, stream](launched, *on_device[1:], cancel_on_device)
            stream.synchronize()
            if cancel[0]:
                raise Cancelled
        for host, device in zip(progress, on_device[-len(progress) :], strict=True):
            device.copy_to_host(host, stream=stream)
        stream.synchronize()

    def run(number: int) -> tuple[int, tuple[Values, str]]:
        if cancel[0]:
            raise Cancelled
        return number, run_chunk(plan, number, run_points)

    def stop() -> None:
        cancel[0] = 1
        cancel_on_device.copy_to_device(cancel, stream=cuda.stream())

    yield from run_in_threads(run, numbers, count, stop)


def kernel_of(plan: Plan, stepper: Stepper) -> Any:
    """Return the kernel for the laws and observables of a plan; it compiles when called."""
    laws = (plan.drive.acceleration, plan.system.restoring, plan.system.potential)
    return _kernel(
        trajectory_name(plan),
        plan.system.angles,
        hooks_of(plan.observables),
        len(stepper.drifts),
        *laws,
    )


@lru_cache(maxsize=64)
def _kernel(name: str, balls: int, hooks: Any, stages: int, *laws: Callable[..., Any]) -> Any:
    """Return the kernel in which every thread carries one point to its end.

    Arguments are those of `kernel_arguments`. Arrays come one by one, since the simulator sees
    records within named tuples as other things than a kernel does. No fast mathematics: it would
    reorder sums that rounding is part of, and forget that numbers may be NaN.
    """

    def part(function: Callable[..., Any], *, inline: bool = False) -> Any:
        return cuda.jit(device=True)(function)  # NVVM decides itself what it inlines

    acceleration, restoring, potential = laws
    many = part(
        make_many(
            acceleration, restoring, potential, part, make=maker_of(name), hooks=hooks, balls=balls
        )
    )
    sizes = make_scratch(stages)
    tables_shape, space_shape = sizes.tables.shape, sizes.space.shape
    rows, values_shape = len(sizes.contact_times), sizes.contact_values.shape

    def kernel(
        order: Any, settings: Any, bodies: Any, stretches: Any, starts: Any, jumps: Any,
        firsts: Any, kick_times: Any, kick_sizes: Any, kick_firsts: Any, stops: Any,
        contact_limit: int, kicks: Any, drifts: Any, nodes: Any, state: Any, counters: Any,
        begun: Any, status: Any, acc: Any, cancel: Any,
    ) -> None:  # fmt: skip
        i = cuda.grid(1)
        if i >= len(order):
            return
        # Local memory lies interleaved: what threads read in step is read at once.
        tables = cuda.local.array(tables_shape, np.float64)
        space = cuda.local.array(space_shape, np.float64)
        times = cuda.local.array(rows, np.float64)
        kinds = cuda.local.array(rows, np.int64)
        values = cuda.local.array(values_shape, np.float64)
        many(
            order[i : i + 1],
            Points(
                settings, bodies, stretches, starts, jumps, firsts, kick_times, kick_sizes,
                kick_firsts, stops, contact_limit,
            ),
            Weights(kicks, drifts, nodes),
            Scratch(tables, space, times, kinds, values, times[:0], values[:, :0]),
            Progress(state, counters, begun, status, acc),
            cancel,
        )  # fmt: skip

    return cuda.jit(kernel)


def kernel_arguments(
    batch: Batch, stepper: Stepper, order: NDArray[np.int64], progress: Progress
) -> tuple[Any, ...]:
    """Return what a kernel is called with on the host, but the flag of cancelling, its last."""
    weights = Weights(stepper.kicks, stepper.drifts, stepper.nodes)
    return (order, *map(_for_device, batch.points), *weights, *progress)


def _for_device(value: Any) -> Any:
    """Return an array as a device wants it: records that are read whole, nothing empty.

    Points find their own rows by number, so a row too many is not seen.
    """
    if not isinstance(value, np.ndarray):
        return value
    if value.dtype.names:
        value = value.view(np.dtype(value.dtype.descr, align=True))  # all fields have 8 bytes
    if not value.size:
        value = np.zeros([max(length, 1) for length in value.shape], dtype=value.dtype)
    return value
