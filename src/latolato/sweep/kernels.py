"""Chooses and calls the kernels that run a batch of points on the processor."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics.compiled import compile_kernel, hooks_key
from latolato.numerics.integrate import maker_of
from latolato.numerics.many import Points, Progress, Weights, make_many, make_scratch
from latolato.numerics.records import python_view
from latolato.numerics.steppers import Stepper
from latolato.numerics.watch import Hooks, hooks_of
from latolato.physics.contacts import Clamp, NoContact
from latolato.sweep.plan import Plan
from latolato.sweep.points import Batch, is_arithmetic, is_smooth


def trajectory_name(plan: Plan) -> str:
    """Return which trajectory the plan's points follow, as `integrate.maker_of` names it."""
    if isinstance(plan.contact, Clamp):
        return "clamp"
    return "pair" if plan.system.angles == 2 else "one"


@lru_cache(maxsize=64)
def _many(name: str, balls: int, hooks: tuple[Hooks, ...], compiled: bool, *laws: Any) -> Any:
    """Return the kernel that runs points one after the other."""
    make = partial(make_many, make=maker_of(name), hooks=hooks, balls=balls)
    if not compiled:
        return make(*laws)
    return compile_kernel(make, f"many {name} {balls} {hooks_key(hooks)}", *laws)


def run_scalar(
    plan: Plan,
    batch: Batch,
    stepper: Stepper,
    order: NDArray[np.int64],
    progress: Progress,
    *,
    compiled: bool = True,
    cancel: NDArray[np.int64] | None = None,
) -> None:
    """Run points one after the other, compiled or as plain Python."""
    system, drive = plan.system, plan.drive
    laws = (drive.acceleration, system.restoring, system.potential)
    name = trajectory_name(plan)
    many = _many(name, system.angles, hooks_of(plan.observables), compiled, *laws)
    points: Points = batch.points
    if not compiled:
        settings, bodies, stretches = map(
            python_view, (points.settings, points.bodies, points.stretches)
        )
        points = points._replace(settings=settings, bodies=bodies, stretches=stretches)
    weights = Weights(stepper.kicks, stepper.drifts, stepper.nodes)
    never = np.zeros(1, dtype=np.int64)
    with np.errstate(all="ignore"):
        many(
            order, points, weights, make_scratch(len(stepper.drifts)), progress,
            never if cancel is None else cancel,
        )  # fmt: skip


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
    system, drive = plan.system, plan.drive
    bodies = batch.points.bodies[order]
    lanes = _lanes(
        hooks_of(plan.observables),
        bool(np.any(bodies["rate"] > 0.0)),
        system.has_contacts and not isinstance(plan.contact, NoContact),
        any("works" in o.needs for o in plan.observables),
        drive.acceleration,
        system.restoring,
        system.potential,
        drive.rotation,
    )
    weights = Weights(stepper.kicks, stepper.drifts, stepper.nodes)
    never = np.zeros(1, dtype=np.int64)
    lanes(
        order, batch.points, weights, make_scratch(len(stepper.drifts)), progress,
        never if cancel is None else cancel,
    )  # fmt: skip


def has_lanes(plan: Plan) -> bool:
    """Return whether the plan's points can run in SIMD lanes.

    One ball with linear drag under a drive whose phase rotates, without noise; slack is followed
    by single trajectories only.
    """
    return (
        is_arithmetic(plan)
        and is_smooth(plan)
        and plan.drive.rotation is not None
        and not isinstance(plan.contact, Clamp)
        and not any("slack" in o.needs for o in plan.observables)
    )


@lru_cache(maxsize=64)
def _lanes(hooks: tuple[Hooks, ...], damped: bool, walled: bool, works: bool, *laws: Any) -> Any:
    """Return the kernel that runs points in lanes."""
    from latolato.numerics.lanes import make_lanes

    make = partial(
        make_lanes, make=maker_of("one"), hooks=hooks, damped=damped, walled=walled, works=works
    )
    name = f"lanes {damped} {walled} {works} {hooks_key(hooks)}"
    return compile_kernel(make, name, *laws)
