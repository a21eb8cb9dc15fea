"""Entries to the engine and to sweeps as compiled pieces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from latolato.numerics.abi import (
    address_of,
    bundle_at,
    caller_of,
    kind_of,
    record_at,
    writer_of,
)
from latolato.numerics.batch import empty_job, make_many
from latolato.numerics.callback_kernels import make_address_callbacks
from latolato.numerics.callbacks import Accumulators
from latolato.numerics.derived import empty_observation, make_observer
from latolato.numerics.derived_plane import make_plane_observer
from latolato.numerics.engine.compiling import Part
from latolato.numerics.engine.events import Output
from latolato.numerics.engine.laws import Formula, laws_of
from latolato.numerics.engine.loop import Timetable, empty_arguments
from latolato.numerics.engine.record import run_dtype
from latolato.numerics.engine.samples import allowed_error
from latolato.numerics.host_entry import empty_beginning, empty_shaking, make_begin, make_shake
from latolato.numerics.pieces import ENGINE
from latolato.numerics.prepare import empty_cases, make_prepare
from latolato.numerics.records import segment_dtype


def make_many_entry(part: Part, *, balls: int, segment: np.dtype[Any]) -> Callable[[int], None]:
    """Return the function ``(address)`` that runs the points of a `Job` one after the other."""
    job_at, callbacks = bundle_at(kind_of(empty_job(segment))), make_address_callbacks(part)
    many = part(make_many(make_caller(part), callbacks, part, balls=balls))

    def run_points(address: int) -> None:
        job = job_at(address)
        many(job.order, job.points, job.scratch, job.progress, job.cancel)

    return run_points


def make_entry(
    make_motion: Callable[..., Callable[..., int]],
    *laws_and_part: Any,
    count: int,
    segment: np.dtype[Any],
) -> Callable[..., int]:
    """Return the engine ``(run, stop, most_steps)`` of a motion; `run` is an address.

    Laws are those of `trajectory.make_trajectory`.
    """
    *formulas, part = laws_and_part
    run_at, arguments_at = (
        record_at(run_dtype(segment)),
        bundle_at(kind_of(empty_arguments(segment))),
    )
    laws = laws_of(*formulas, part=part)
    carry_on = part(make_motion(laws, count, make_address_callbacks(part), part))

    def engine(address: int, stop: float, most_steps: int) -> int:
        run = run_at(address)
        rest = arguments_at(address_of(run.words))
        rows: int = carry_on(run, rest.timetable, rest.output, rest.accumulators, stop, most_steps)
        return rows

    return engine


def make_observer_entry(
    height: Formula,
    velocity: Formula,
    acceleration: Formula,
    restoring: Formula,
    potential: Formula,
    part: Part,
    *,
    segment: np.dtype[Any],
) -> Callable[[int], None]:
    """Return the function ``(address)`` that fills an `Observation`."""
    observe = part(make_observer(height, velocity, acceleration, restoring, potential, part))
    return _by_address(empty_observation(segment), observe)


def make_plane_observer_entry(*laws_and_part: Any, segment: np.dtype[Any]) -> Callable[[int], None]:
    """Return the function ``(address)`` that fills an `Observation` of a motion in the plane."""
    observe = laws_and_part[-1](make_plane_observer(*laws_and_part))
    return _by_address(empty_observation(segment), observe)


def make_prepare_entry(part: Part) -> Callable[[int], None]:
    """Return the function ``(address)`` that prepares `Cases`."""
    return _by_address(empty_cases(), make_prepare(part))


def make_shake_entry(part: Part) -> Callable[[int], None]:
    """Return the function ``(address)`` that writes the segments of a `Shaking`."""
    return _by_address(empty_shaking(), make_shake(part))


def make_begin_entry(part: Part) -> Callable[[int], None]:
    """Return the function ``(address)`` that makes the record of a `Beginning`."""
    return _by_address(empty_beginning(), make_begin(part))


def _by_address(example: Any, work: Callable[[Any], None]) -> Callable[[int], None]:
    """Return the function ``(address)`` that calls another with the tuple whose words lie there."""
    bundle = bundle_at(kind_of(example))

    def work_at(address: int) -> None:
        work(bundle(address))

    return work_at


def make_allowed_entry(part: Part) -> Callable[[int, float], float]:
    """Return `allowed_error` of the run at an address, for a tolerance."""
    run_at = record_at(run_dtype())

    def allowed_at(address: int, tolerance: float) -> float:
        result: float = allowed_error(run_at(address).state, tolerance)
        return result

    return allowed_at


def make_caller(part: Part) -> Callable[..., int]:
    """Return a stand-in for the engine whose address is ``run.engine``: it calls it."""
    call = caller_of(ENGINE)
    write = writer_of(kind_of(empty_arguments(segment_dtype())))

    @part
    def carry_on(
        run: Any,
        timetable: Timetable,
        output: Output,
        accumulators: Accumulators,
        stop: float,
        most_steps: int,
    ) -> int:
        write(address_of(run.words), (timetable, output, accumulators))
        rows: int = call(run.engine, (address_of(run), stop, most_steps))
        return rows

    return carry_on
