"""Chooses and calls the kernels that run a batch of points on the processor."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics.abi import words_of
from latolato.numerics.batch import (
    Job,
    Progress,
    Scratch,
    Task,
    Weights,
    empty_job,
    empty_task,
    make_lane_space,
    make_many,
    make_scratch,
)
from latolato.numerics.callbacks import ON_TANGENT, formulas_of, make_callbacks
from latolato.numerics.integrate import laws_key
from latolato.numerics.kernels import (
    batch_spec,
    callback_kernels_of,
    callback_table,
    engine_spec,
    kernel_of,
    lane_locate_spec,
    lane_reports,
    lane_step_spec,
    lanes_spec,
)
from latolato.numerics.prepare import write_stepper
from latolato.numerics.run_record import as_objects, write_back
from latolato.numerics.steppers import Stepper
from latolato.numerics.trajectory import make_trajectory
from latolato.sweeps.plan import Plan
from latolato.sweeps.points import Batch, is_planar, is_smooth, laws_of_points


@lru_cache(maxsize=16)
def _reference(plan_key: tuple[Any, ...], *laws: Any) -> Any:
    """Return the same as plain Python, with everything folded in."""
    balls, motion, formulas = plan_key
    callbacks = make_callbacks(formulas)
    carry_on = make_trajectory(*laws, count=balls, callbacks=callbacks, motion=motion)
    return make_many(carry_on, callbacks, balls=balls)


def _prepared(plan: Plan, batch: Batch, stepper: Stepper) -> tuple[Scratch, tuple[Any, ...]]:
    """Return a worker's memory that knows the engine's and the observables' kernels, and these."""
    segment = batch.points.segments.dtype
    engine = kernel_of(engine_spec(
        plan.system.angles, segment, *laws_of_points(plan), motion=plan.contact.motion,
    ))  # fmt: skip
    looking = callback_kernels_of(formulas_of(plan.observables))
    table = callback_table(looking)
    scratch = make_scratch(segment)
    write_stepper(scratch.runs, stepper)
    scratch.runs["settings"]["is_linear"] = plan.system.is_linear
    scratch.runs["engine"] = engine.address
    scratch.runs["callbacks"] = table.ctypes.data
    return scratch, (engine, looking, table)


def run_reference(
    plan: Plan, batch: Batch, stepper: Stepper, order: NDArray[np.int64], progress: Progress
) -> None:
    """Run points one after the other as plain Python."""
    key = plan.system.angles, plan.contact.motion, formulas_of(plan.observables)
    many = _reference(key, *laws_of_points(plan))
    scratch = make_scratch(batch.points.segments.dtype)
    write_stepper(scratch.runs, stepper)
    points = batch.points._replace(
        settings=as_objects(batch.points.settings), bodies=as_objects(batch.points.bodies),
        segments=as_objects(batch.points.segments),
    )  # fmt: skip
    states = progress._replace(states=as_objects(progress.states), begun=as_objects(progress.begun))
    with np.errstate(all="ignore"):
        never = np.zeros(1, dtype=np.int64)
        many(order, points, scratch._replace(runs=as_objects(scratch.runs)), states, never)
    write_back(states.states, progress.states)
    write_back(states.begun, progress.begun)


def run_scalar(
    plan: Plan,
    batch: Batch,
    stepper: Stepper,
    order: NDArray[np.int64],
    progress: Progress,
    *,
    cancel: NDArray[np.int64] | None = None,
) -> None:
    """Run points one after the other, compiled."""
    scratch, kernels = _prepared(plan, batch, stepper)
    never = np.zeros(1, dtype=np.int64)
    job = Job(order, batch.points, scratch, progress, never if cancel is None else cancel)
    many = kernel_of(batch_spec(plan.system.angles, batch.points.segments.dtype))
    words = np.array(words_of(job, empty_job(batch.points.segments.dtype)))
    many.call(words.ctypes.data)
    del kernels  # keeps the compiled code until here


def run_fastest(
    plan: Plan,
    batch: Batch,
    stepper: Stepper,
    order: NDArray[np.int64],
    progress: Progress,
    *,
    cancel: NDArray[np.int64] | None = None,
) -> None:
    """Run points with the fastest kernel that knows their laws."""
    if not has_lanes(plan):
        run_scalar(plan, batch, stepper, order, progress, cancel=cancel)
        return
    system, drive, formulas = plan.system, plan.drive, formulas_of(plan.observables)
    damped = bool(np.any(batch.points.bodies[order]["damping_rate"] > 0.0))
    works = any("works" in o.needs for o in plan.observables)
    walled = system.has_contacts and plan.contact.meets
    fly = kernel_of(lane_step_spec(
        system.restoring, damped=damped, walled=walled, works=works,
        tangents=bool(formulas[ON_TANGENT]),
    ))  # fmt: skip
    locate = None
    if walled:
        locate = kernel_of(lane_locate_spec(system.restoring, damped=damped, works=works))
    looking = lane_reports(plan.observables, *laws_key(system))
    scratch, kernels = _prepared(plan, batch, stepper)
    space = make_lane_space(
        len(stepper.drifts), len(progress.acc) // len(progress.status), fly.address,
        0 if locate is None else locate.address, callback_table(looking),
    )  # fmt: skip
    weights = Weights(stepper.kicks, stepper.drifts, stepper.nodes)
    never = np.zeros(1, dtype=np.int64)
    stop = never if cancel is None else cancel
    task = Task(order, batch.points, weights, scratch, progress, space, stop)
    laws = drive.acceleration, *laws_key(system), drive.rotation
    lanes = kernel_of(lanes_spec(batch.points.segments.dtype, *laws))
    words = np.array(words_of(task, empty_task(batch.points.segments.dtype)))
    lanes.call(words.ctypes.data)
    del kernels, looking, fly, locate, lanes  # keep the compiled code until here


def has_lanes(plan: Plan) -> bool:
    """Return whether the plan's points can run in SIMD lanes.

    One ball with linear drag under a drive whose phase rotates, without noise; compression
    is followed by single trajectories only.
    """
    return (
        plan.system.angles == 1
        and not is_planar(plan)
        and plan.noise is None
        and is_smooth(plan)
        and plan.drive.rotation is not None
        and plan.contact.motion == "exact"
        and not any("compression" in o.needs for o in plan.observables)
    )
