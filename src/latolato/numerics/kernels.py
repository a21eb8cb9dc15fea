"""The table of kernels: which there are, what makes each, and how to get one compiled.

A sweep with other observables only needs new kernels for these: every formula is compiled on its
own and called by its address. Plain Python and GPUs call the same functions directly.

Kernels that come with the package are loaded without a compiler (`latolato.numerics.shipped`);
others are compiled here (`latolato.numerics.jit`). So what makes a kernel is imported where it is
made, with the compiler that it needs.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics import shipped
from latolato.numerics.abi import (
    ALLOWED,
    BUNDLE,
    CALLBACK,
    ENGINE,
    LANE_LOCATE,
    LANE_REPORT,
    LANE_STEP,
    Formula,
    Kernel,
    KernelSpec,
)
from latolato.numerics.callbacks import (
    OCCASIONS,
    ON_STEP,
    ON_TANGENT,
    Formulas,
    formulas_of,
    slots_of,
)
from latolato.numerics.derived_plane import PLANE_OBSERVED
from latolato.numerics.parts import Part
from latolato.numerics.records import segment_dtype
from latolato.numerics.run_record import MOST_PARAMETERS
from latolato.numerics.trajectory import motion_of
from latolato.observables import Observable

_lock = threading.RLock()


def kernel_of(spec: KernelSpec) -> Kernel:
    """The kernel of a specification; threads that want the same one wait for it."""
    with _lock:
        return _kernel(spec)


@functools.lru_cache(maxsize=512)
def _kernel(spec: KernelSpec) -> Kernel:
    ready = shipped.load(spec)
    if ready is not None:
        return ready
    from latolato.numerics.jit import compile_spec

    return compile_spec(spec)


# What makes each kernel; see `abi.KernelSpec.make`. Those of one named tuple of arguments read it
# from its words.


def engine(
    make_motion: Callable[..., Callable[..., int]],
    *laws_and_part: Any,
    count: int,
    segment: np.dtype[Any],
    parameters: int = 0,
) -> Callable[..., int]:
    """The engine ``(run, stop, most_steps)`` of a motion.

    Its runs have room for derivatives with respect to so many `parameters`.
    """
    from latolato.numerics.callback_kernels import make_address_callbacks
    from latolato.numerics.engine.laws import laws_of
    from latolato.numerics.engine.loop import empty_arguments
    from latolato.numerics.pointers import address_of, bundle_at, kind_of, record_at
    from latolato.numerics.run_record import run_dtype

    *formulas, part = laws_and_part
    run_at = record_at(run_dtype(segment, parameters))
    arguments_at = bundle_at(kind_of(empty_arguments(segment)))
    laws = laws_of(*formulas, part=part)
    carry_on = part(make_motion(laws, count, make_address_callbacks(part), part))

    def engine(address: int, stop: float, most_steps: int) -> int:
        run = run_at(address)
        rest = arguments_at(address_of(run.words))
        rows: int = carry_on(run, rest.timetable, rest.output, rest.accumulators, stop, most_steps)
        return rows

    return engine


def batch(part: Part, *, balls: int, segment: np.dtype[Any]) -> Callable[[int], None]:
    """The function that runs the points of a `batch.Job` one after the other."""
    from latolato.numerics.batch import empty_job, make_many
    from latolato.numerics.callback_kernels import make_address_callbacks, make_caller

    many = part(make_many(make_caller(part), make_address_callbacks(part), part, balls=balls))

    def run_points(job: Any) -> None:
        many(job.order, job.points, job.scratch, job.progress, job.cancel)

    return _from_words(empty_job(segment), part(run_points))


def lanes(*laws_and_part: Any, segment: np.dtype[Any]) -> Callable[[int], None]:
    """The function that runs the points of a `batch.Task` in lanes."""
    from latolato.numerics.lanes import make_lanes

    return make_lanes(*laws_and_part, segment=segment)


def observer(*laws_and_part: Any, segment: np.dtype[Any]) -> Callable[[int], None]:
    """The function that fills a `derived.Observation` of a motion at a vertical pivot."""
    from latolato.numerics.derived import empty_observation, make_observer

    part = laws_and_part[-1]
    return _from_words(empty_observation(segment), part(make_observer(*laws_and_part)))


def plane_observer(*laws_and_part: Any, segment: np.dtype[Any]) -> Callable[[int], None]:
    """The function that fills a `derived.Observation` of a motion in the plane."""
    from latolato.numerics.derived import empty_observation
    from latolato.numerics.derived_plane import make_plane_observer

    part = laws_and_part[-1]
    return _from_words(empty_observation(segment), part(make_plane_observer(*laws_and_part)))


def prepare(part: Part) -> Callable[[int], None]:
    """The function that prepares `prepare.Cases`."""
    from latolato.numerics.prepare import empty_cases, make_prepare

    return _from_words(empty_cases(), make_prepare(part))


def shake(part: Part) -> Callable[[int], None]:
    """The function that writes the segments of a `host_entry.Shaking`."""
    from latolato.numerics.host_entry import empty_shaking, make_shake

    return _from_words(empty_shaking(), make_shake(part))


def begin(part: Part) -> Callable[[int], None]:
    """The function that makes the record of a `host_entry.Beginning`."""
    from latolato.numerics.host_entry import empty_beginning, make_begin

    return _from_words(empty_beginning(), make_begin(part))


def allowed(part: Part) -> Callable[[int, float], float]:
    """The function ``(run, tolerance)`` of the error that the ledger may have."""
    from latolato.numerics.engine.samples import allowed_error
    from latolato.numerics.pointers import record_at
    from latolato.numerics.run_record import run_dtype

    run_at = record_at(run_dtype())

    def allowed_at(address: int, tolerance: float) -> float:
        result: float = allowed_error(run_at(address).state, tolerance)
        return result

    return allowed_at


def lane_step(*law_and_part: Any, **flags: Any) -> Callable[..., float]:
    """The step of all lanes."""
    from latolato.numerics.lane_flight import make_lane_step

    return make_lane_step(*law_and_part, **flags)


def lane_locate(*law_and_part: Any, **flags: Any) -> Callable[..., None]:
    """The function that locates impacts of lanes."""
    from latolato.numerics.lane_locate import make_lane_locate

    return make_lane_locate(*law_and_part, **flags)


def shared_values(*laws_and_part: Any, **flags: Any) -> Callable[..., None]:
    """The function that finds what several observables need of every lane's step."""
    from latolato.numerics.lane_flight import make_shared_values

    return make_shared_values(*laws_and_part, **flags)


def step_report(*formulas_and_part: Any, **flags: Any) -> Callable[..., None]:
    """The function that reports every lane's step to an observable."""
    from latolato.numerics.lane_flight import make_step_report

    return make_step_report(*formulas_and_part, **flags)


def jacobian_report(formula: Formula, part: Part) -> Callable[..., None]:
    """The function that reports every lane's Jacobian to an observable."""
    from latolato.numerics.lane_flight import make_jacobian_report

    return make_jacobian_report(formula, part)


def callback(formula: Formula, part: Part, *, occasion: int) -> Callable[..., None]:
    """The callback of an observable on an occasion."""
    from latolato.numerics.callback_kernels import make_callback

    return make_callback(formula, part, occasion=occasion)


def _from_words(example: Any, work: Callable[[Any], None]) -> Callable[[int], None]:
    """The function ``(address)`` that calls another with the tuple whose words lie there."""
    from latolato.numerics.pointers import bundle_at, kind_of

    bundle = bundle_at(kind_of(example))

    def work_at(address: int) -> None:
        work(bundle(address))

    return work_at


def engine_spec(
    count: int, segment: np.dtype[Any], *laws: Formula, motion: str = "exact"
) -> KernelSpec:
    """The engine of `count` balls.

    Parameters
    ----------
    segment : dtype
        The layout of the drive's segments.
    laws : formulas
        Those of `trajectory.make_trajectory`.
    motion : str
        One of `trajectory.MOTIONS`.
    """
    settings: tuple[tuple[str, Any], ...] = ("count", count), ("segment", segment)
    if motion == "sensitive":
        settings += (("parameters", MOST_PARAMETERS),)
    return KernelSpec(engine, ENGINE, (motion_of(motion), *laws), settings)


PREPARE = KernelSpec(prepare, BUNDLE)
SHAKE = KernelSpec(shake, BUNDLE)
BEGIN = KernelSpec(begin, BUNDLE)
ALLOWED_ERROR = KernelSpec(allowed, ALLOWED)


def batch_spec(balls: int, segment: np.dtype[Any]) -> KernelSpec:
    """The kernel that runs points of `balls` balls one after the other."""
    return KernelSpec(batch, BUNDLE, (), (("balls", balls), ("segment", segment)))


def lanes_spec(segment: np.dtype[Any], *laws: Formula) -> KernelSpec:
    """The kernel that runs points in lanes; laws as for `lanes.make_lanes`."""
    return KernelSpec(lanes, BUNDLE, laws, (("segment", segment),))


def observer_spec(segment: np.dtype[Any], *laws: Formula) -> KernelSpec:
    """The kernel that fills a `derived.Observation`.

    Laws are those of `derived.make_observer`, or all those of `derived_plane.make_plane_observer`.
    """
    in_plane = len(laws) == PLANE_OBSERVED
    return KernelSpec(
        plane_observer if in_plane else observer, BUNDLE, laws, (("segment", segment),)
    )


def lane_step_spec(
    restoring: Formula, *, damped: bool, walled: bool, works: bool, tangents: bool
) -> KernelSpec:
    """The step of all lanes.

    Parameters
    ----------
    damped, walled, works, tangents : bool
        Whether any point has drag, whether any has walls, whether works and matrices are asked for.
    """
    settings = ("damped", damped), ("walled", walled), ("works", works), ("tangents", tangents)
    return KernelSpec(lane_step, LANE_STEP, (restoring,), settings, for_lanes=True)


def lane_locate_spec(restoring: Formula, *, damped: bool, works: bool) -> KernelSpec:
    """The kernel that locates impacts of lanes; flags as for `lane_step_spec`."""
    settings = ("damped", damped), ("works", works)
    return KernelSpec(lane_locate, LANE_LOCATE, (restoring,), settings, for_lanes=True)


# What observables may name among their needs that is found for all of them together.
SHARED = ("energy", "turn")


def shared_values_spec(needs: frozenset[str], restoring: Formula, potential: Formula) -> KernelSpec:
    """The kernel for values that observables share of every lane's step."""
    laws, settings = (restoring, potential), _shared(needs)
    return KernelSpec(shared_values, LANE_REPORT, laws, settings, for_lanes=True)


def step_report_spec(
    formula: Formula, needs: frozenset[str], restoring: Formula, potential: Formula
) -> KernelSpec:
    """The kernel that reports every lane's step to an observable."""
    laws, settings = (formula, restoring, potential), _shared(needs)
    return KernelSpec(step_report, LANE_REPORT, laws, settings, for_lanes=True)


def _shared(needs: frozenset[str]) -> tuple[tuple[str, bool], ...]:
    """Settings that say which shared values an observable needs."""
    return tuple((name, name in needs) for name in SHARED)


def jacobian_report_spec(formula: Formula) -> KernelSpec:
    """The kernel that reports every lane's Jacobian to an observable."""
    return KernelSpec(jacobian_report, LANE_REPORT, (formula,), for_lanes=True)


def callback_spec(occasion: int, formula: Formula) -> KernelSpec:
    """The callback of an observable on an occasion."""
    return KernelSpec(callback, CALLBACK, (formula,), (("occasion", occasion),))


# For each occasion, or each report of lanes: kernels with the first of their observables' slots.
Called = list[list[tuple[int, Kernel]]]


def callback_table(kernels: Called) -> NDArray[np.int64]:
    """The table of kernels that compiled code walks through, with their first slots.

    For each occasion it says where its kernels begin: pairs of address and first slot, up to an
    address of zero.
    """
    begins: list[int] = []
    pairs: list[int] = []
    for on_occasion in kernels:
        begins.append(len(kernels) + len(pairs))
        for first, kernel in on_occasion:
            pairs += [kernel.address, first]
        pairs += [0]
    return np.array(begins + pairs, dtype=np.int64)


def callback_kernels_of(formulas: tuple[Formulas, ...]) -> Called:
    """The callbacks of `callbacks.formulas_of` for each occasion."""
    return [
        [(first, kernel_of(callback_spec(occasion, formula))) for first, formula in formulas]
        for occasion, formulas in enumerate(formulas)
    ]


def lane_reports(watched: Sequence[Observable], *laws: Formula) -> Called:
    """The kernels that report the lanes' steps, and those that report their Jacobians.

    Laws are the restoring factor and its potential. What several observables need comes first.
    """
    watching = [
        (block.first, observable.step, observable.needs)
        for block, observable in zip(slots_of(watched), watched, strict=True)
        if observable.step is not None
    ]
    needs = frozenset[str]().union(*(needs for _, _, needs in watching)) & frozenset(SHARED)
    shared = [(0, kernel_of(shared_values_spec(needs, *laws)))] if needs else []
    steps = [
        (first, kernel_of(step_report_spec(step, own, *laws))) for first, step, own in watching
    ]
    matrices = formulas_of(watched)[ON_TANGENT]
    return [
        [*shared, *steps],
        [(first, kernel_of(jacobian_report_spec(formula))) for first, formula in matrices],
    ]


def every_spec(observables: Iterable[type[Observable]]) -> Iterator[KernelSpec]:
    """Yield each kernel that the package's laws and these kinds of observables need."""
    from latolato.physics.drives.segment import (
        pivot_acceleration,
        pivot_across,
        pivot_across_acceleration,
        pivot_across_velocity,
        pivot_height,
        pivot_velocity,
        rotation,
    )
    from latolato.physics.pendulum import (
        potential_sine,
        restoring_linear,
        restoring_sine,
    )

    usual, laws = segment_dtype(), (restoring_sine, potential_sine)
    for count, motion in ((1, "exact"), (2, "exact"), (1, "clamp")):
        yield engine_spec(count, usual, pivot_acceleration, *laws, motion=motion)
    yield from (PREPARE, SHAKE, BEGIN, ALLOWED_ERROR)
    for balls in (1, 2):
        yield batch_spec(balls, usual)
    yield lanes_spec(usual, pivot_acceleration, *laws, rotation)
    yield observer_spec(usual, pivot_height, pivot_velocity, pivot_acceleration, *laws)
    across = pivot_across_acceleration, pivot_velocity, pivot_across_velocity
    for count in (1, 2):
        yield engine_spec(count, usual, pivot_acceleration, *laws, *across)
        yield engine_spec(count, usual, pivot_acceleration, *laws, motion="sensitive")
        yield engine_spec(count, usual, pivot_acceleration, *laws, *across, motion="sensitive")
    yield observer_spec(
        usual, pivot_height, pivot_velocity, pivot_acceleration, pivot_across,
        pivot_across_velocity, pivot_across_acceleration,
    )  # fmt: skip
    answers = (False, True)
    for damped, works in product(answers, answers):
        yield lane_locate_spec(restoring_sine, damped=damped, works=works)
        for restoring, walled in (
            (restoring_sine, True), (restoring_sine, False), (restoring_linear, False),
        ):  # fmt: skip
            for tangents in answers:
                yield lane_step_spec(
                    restoring, damped=damped, works=works, walled=walled, tangents=tangents
                )
    for shared in ({"energy"}, {"turn"}, {"energy", "turn"}):
        yield shared_values_spec(frozenset(shared), *laws)
    for observable in observables:
        for occasion, name in enumerate(OCCASIONS):
            formula = getattr(observable, name)
            if formula is None:
                continue
            yield callback_spec(occasion, formula)
            if occasion == ON_STEP:
                yield step_report_spec(formula, observable.needs, *laws)
            if occasion == ON_TANGENT:
                yield jacobian_report_spec(formula)
