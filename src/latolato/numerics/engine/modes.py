"""What a mode of motion is."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Mode(NamedTuple):
    """A mode of motion: how it steps, and what is seen of a step.

    Attributes
    ----------
    number : int
        What ``run.state.mode`` is then.
    plan : callable ``(run)``
        Fill ``run.end`` for a step from ``run.t``, up to the goal or to the first event in it.
    evaluate_inside : callable ``(run, length)``
        Fill ``run.inside``, with works and losses, for that part of the planned step [s].
    note : callable ``(run, accumulators)``
        Add up compression, and report the step and its tangent map.
    write_tangent : callable ``(run, length)``, optional
        Write the tangent map of the part of the planned step [s] that `evaluate_inside` has just
        filled, and the forcing of parameters; runs that are differentiated need it.
    """

    number: int
    plan: Callable[..., None]
    evaluate_inside: Callable[..., None]
    note: Callable[..., None]
    write_tangent: Callable[..., None] | None = None
