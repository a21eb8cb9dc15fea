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

import latolato.numerics.jit  # noqa: F401 - makes formulas callable from compiled code
from latolato.core.errors import InputError, import_extra
from latolato.core.registry import checked_count
from latolato.numerics.batch import Points, Progress, Scratch, make_many, make_scratch
from latolato.numerics.callbacks import formulas_of, make_callbacks
from latolato.numerics.prepare import write_stepper
from latolato.numerics.records import segment_dtype
from latolato.numerics.run_record import STATE, as_objects, run_dtype, write_back
from latolato.numerics.steppers import Stepper
from latolato.numerics.trajectory import make_trajectory
from latolato.sweeps.chunk import Cancelled, Values, run_chunk
from latolato.sweeps.plan import Plan
from latolato.sweeps.points import Batch, laws_of_points
from latolato.sweeps.pool import run_in_threads

import_extra("numba_cuda", "cuda", "executor 'cuda'", way_out="use executor='threads'")
from numba import config, cuda  # noqa: E402 - older releases of numba have it without the extra
from numba.np.numpy_support import from_dtype  # noqa: E402

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
    # A chunk alone is small for the device on purpose; numba colours its warnings.
    warnings.filterwarnings("ignore", message=".*Grid size .* will likely result in GPU")
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
        kernel = device_kernel_of(plan)
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


def device_kernel_of(plan: Plan) -> Any:
    """Return the kernel for the laws and observables of a plan; it compiles when called."""
    return _kernel(
        plan.system.angles,
        plan.contact.motion,
        formulas_of(plan.observables),
        segment_dtype(type(plan.drive.segments(plan.duration)[0])),
        *laws_of_points(plan),
    )


@lru_cache(maxsize=64)
def _kernel(balls: int, motion: str, formulas: Any, segment: Any, *laws: Callable[..., Any]) -> Any:
    """Return the kernel in which every thread carries one point to its end.

    Arguments are those of `kernel_arguments`. Arrays come one by one, since the simulator sees
    records within named tuples as other things than a kernel does. No fast mathematics: it would
    reorder sums that rounding is part of, and forget that numbers may be NaN.
    """

    def part(function: Callable[..., Any], *, inline: bool = False) -> Any:
        return cuda.jit(device=True)(function)  # NVVM decides itself what it inlines

    callbacks = make_callbacks(formulas, part)
    carry_on = make_trajectory(*laws, count=balls, callbacks=callbacks, motion=motion, part=part)
    many = part(make_many(part(carry_on), callbacks, part, balls=balls))
    sizes = make_scratch()
    rows, values_shape = len(sizes.contact_times), sizes.contact_values.shape
    run_type = from_dtype(run_dtype(segment))

    def kernel(
        order: Any, settings: Any, bodies: Any, segments: Any, firsts: Any, kick_times: Any,
        kick_sizes: Any, kick_firsts: Any, stops: Any,
        contact_limit: int, template: Any, states: Any, begun: Any, status: Any, acc: Any,
        cancel: Any,
    ) -> None:  # fmt: skip
        i = cuda.grid(1)
        if i >= len(order):
            return
        # Local memory lies interleaved: what threads read in step is read at once.
        runs = cuda.local.array(1, run_type)
        times = cuda.local.array(rows, np.float64)
        kinds = cuda.local.array(rows, np.int64)
        values = cuda.local.array(values_shape, np.float64)
        runs[0] = template[0]
        many(
            order[i : i + 1],
            Points(
                settings, bodies, segments, firsts, kick_times, kick_sizes, kick_firsts, stops,
                contact_limit,
            ),
            Scratch(runs, times, kinds, values, times[:0], values[:, :0]),
            Progress(states, begun, status, acc),
            cancel,
        )  # fmt: skip

    return cuda.jit(_simulated(many) if config.ENABLE_CUDASIM else kernel)  # type: ignore[attr-defined]


def _simulated(many: Callable[..., None]) -> Callable[..., None]:
    """Return the kernel as numba's simulator runs it, whose records have no nested ones."""

    def kernel(order: Any, settings: Any, bodies: Any, segments: Any, *others: Any) -> None:
        i = cuda.grid(1)
        if i >= len(order):
            return
        *rest, template, states, begun, status, acc, cancel = others
        scratch = make_scratch()._replace(runs=as_objects(template.copy_to_host()))
        moved = as_objects(states.copy_to_host()), as_objects(begun.copy_to_host())
        laws = (as_objects(a.copy_to_host()) for a in (settings, bodies, segments))
        points, progress = Points(*laws, *rest), Progress(*moved, status, acc)
        many(order[i : i + 1], points, scratch, progress, cancel)
        k, row = order[i], np.zeros(1, dtype=STATE)
        for objects, records in zip(moved, (states, begun), strict=True):
            write_back([objects[k]], row)
            records[k] = row[0]

    return kernel


def kernel_arguments(
    batch: Batch, stepper: Stepper, order: NDArray[np.int64], progress: Progress
) -> tuple[Any, ...]:
    """Return a kernel's arguments on the host, all but the last, the flag of cancelling."""
    template = make_scratch(batch.points.segments.dtype).runs
    write_stepper(template, stepper)
    return (order, *map(_for_device, batch.points), template, *progress)


def _for_device(value: Any) -> Any:
    """Return an array as a device wants it, nothing empty.

    Points find their own rows by number, so a row too many is not seen.
    """
    if not isinstance(value, np.ndarray):
        return value
    if not value.size:
        value = np.zeros([max(length, 1) for length in value.shape], dtype=value.dtype)
    return value
