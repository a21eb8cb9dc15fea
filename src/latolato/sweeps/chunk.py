"""Runs one chunk of a plan: points, generations of a continuation, values of the observables."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics import records
from latolato.numerics.batch import Progress, make_progress
from latolato.numerics.callbacks import blank_slots, slots_of
from latolato.numerics.records import INVALID, STATUS_NAMES
from latolato.numerics.steppers import Stepper
from latolato.sweeps.plan import Plan
from latolato.sweeps.points import Batch, Previous, make_batch, stepper_of

# How an executor runs the points `order` of a batch, writing into the progress.
RunPoints = Callable[[Plan, Batch, Stepper, NDArray[np.int64], Progress], None]

# Values of a chunk: arrays of the chunk's shape, with further dimensions behind.
Values = dict[str, NDArray[Any]]

STATUS = "status"


class Cancelled(Exception):  # noqa: N818 - not an error
    """A chunk was given up because the sweep is being cancelled."""


def run_chunk(plan: Plan, number: int, run_points: RunPoints) -> tuple[Values, str]:
    """Return the values of chunk `number`, and what is wrong with its first invalid point.

    With a continuation the points along its axis run one generation after the other, each
    starting where the one before ended.
    """
    block = plan.block(number)
    shape = tuple(part.stop - part.start for part in block)
    places = np.meshgrid(*(np.arange(part.start, part.stop) for part in block), indexing="ij")
    index = np.ravel_multi_index(tuple(places), plan.shape)
    stepper = stepper_of(plan)
    if not plan.continuation:
        result, reason = _run(plan, index.ravel(), stepper, run_points, None)[:2]
        return {name: a.reshape(shape + a.shape[1:]) for name, a in result.items()}, reason
    axis = plan.dims.index(plan.continuation)
    lines = np.moveaxis(index, axis, 0).reshape(shape[axis], -1)
    downwards = plan.direction == "down" or (plan.direction == "both" and block[0].start == 1)
    along = next(a for a in plan.axes if a.name == plan.continuation).values[0]
    if along[0] > along[-1]:  # up is towards larger values, in whatever order they stand
        downwards = not downwards
    order = range(len(lines))[::-1] if downwards else range(len(lines))
    generations: dict[int, Values] = {}
    previous, reason = None, ""
    for g in order:
        generations[g], why, previous = _run(plan, lines[g], stepper, run_points, previous)
        reason = reason or why
    first = generations[0]
    values: Values = {}
    for name in first:
        stacked = np.stack([generations[g][name] for g in range(len(lines))])
        rest = shape[:axis] + shape[axis + 1 :]
        extra = first[name].shape[1:]
        values[name] = np.moveaxis(stacked.reshape(shape[axis], *rest, *extra), 0, axis)
    return values, reason


def _run(
    plan: Plan,
    index: NDArray[np.int64],
    stepper: Stepper,
    run_points: RunPoints,
    previous: Previous | None,
) -> tuple[Values, str, Previous]:
    """Return the values of these points, what is wrong with the first invalid one, their ends."""
    batch = make_batch(plan, index, previous)
    balls, count = plan.system.angles, len(index)
    acc = blank_slots(plan.observables, balls * count).ravel()
    progress = make_progress(batch.states, acc)
    # Longest first: the last points of a worker then are short ones.
    steps = plan.duration / np.where(batch.valid, batch.points.settings["step"], math.inf)
    order = np.argsort(-steps, kind="stable")
    order = order[batch.valid[order]]
    if len(order):
        run_points(plan, batch, stepper, order, progress)
    progress.status[~batch.valid] = INVALID
    values = _values(plan, batch, progress)
    return values, batch.reason, _ends(plan, batch, progress)


def _values(plan: Plan, batch: Batch, progress: Progress) -> Values:
    """Return the observables' variables, status and NaN where a point has no answer."""
    balls, count = plan.system.angles, len(batch.valid)
    acc = progress.acc.reshape(-1, count, balls)
    bad = progress.status >= records.EVENT_LIMIT
    values: Values = {}
    for observable, block in zip(plan.observables, slots_of(plan.observables), strict=True):
        slots = acc[block.first : block.first + block.size]
        result = [observable.read(slots[:, :, ball], balls) for ball in range(balls)]
        one = balls == 1 or observable.is_joint
        for name in observable.variables:
            joined = result[0][name].copy() if one else np.stack([f[name] for f in result], axis=1)
            joined[bad] = math.nan
            values[name] = joined
    values[STATUS] = progress.status.astype(np.int8)
    return values


def _ends(plan: Plan, batch: Batch, progress: Progress) -> Previous:
    """Return the final states of the points, for the next generation of a continuation.

    A point that failed passes its start on.
    """
    balls = plan.system.angles
    usable = progress.status < records.EVENT_LIMIT
    ends, starts = progress.states, batch.states
    angles, velocities = (
        [np.where(usable, ends[name][:, i], starts[name][:, i]) for i in range(balls)]
        for name in ("angle", "velocity")
    )
    phase = None
    if plan.continuation and "drive_frequency" in batch.columns:
        turned = batch.columns["drive_frequency"] * plan.duration
        phase = np.where(
            usable,
            np.remainder(batch.columns["drive_phase"] + turned, math.tau),
            batch.columns["drive_phase"],
        )
    return Previous(np.array(angles), np.array(velocities), phase)


def status_counts(status: NDArray[np.int8]) -> dict[str, int]:
    """Return how many points have each status, those that occur only."""
    counts = np.bincount(status.ravel(), minlength=len(STATUS_NAMES))
    return {name: int(n) for name, n in zip(STATUS_NAMES, counts, strict=True) if n}
