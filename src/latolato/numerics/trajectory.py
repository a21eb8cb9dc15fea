"""What carries trajectories on, by name: the engine under exact contact, and the clamp."""

from __future__ import annotations

from collections.abc import Callable

from latolato.core.errors import InputError
from latolato.core.registry import suggest
from latolato.numerics.callbacks import Callbacks
from latolato.numerics.clamp import make_clamped
from latolato.numerics.engine.laws import Formula, Laws, laws_of, with_changes
from latolato.numerics.engine.loop import make_engine
from latolato.numerics.parts import Part, as_it_stands


def make_sensitive(
    laws: Laws, count: int, callbacks: Callbacks, part: Part = as_it_stands
) -> Callable[..., int]:
    """Return the engine of exact contact that carries derivatives with respect to parameters."""
    return make_engine(with_changes(laws), count, callbacks, part)


# What a contact law names: called with laws, the number of balls, the functions that observables
# are shown by and what makes parts. Others may add their own, built by `make_engine` of their own
# modes.
MOTIONS: dict[str, Callable[[Laws, int, Callbacks, Part], Callable[..., int]]] = {
    "exact": make_engine,
    "sensitive": make_sensitive,
    "clamp": make_clamped,
}


def motion_of(name: str) -> Callable[..., Callable[..., int]]:
    """Return the motion of that name.

    Raises
    ------
    InputError
        If there is none.
    """
    if name not in MOTIONS:
        raise InputError(f"unknown motion {name!r}; {suggest(name, list(MOTIONS))}")
    return MOTIONS[name]


def make_trajectory(
    *laws: Formula,
    count: int,
    callbacks: Callbacks,
    motion: str = "exact",
    part: Part = as_it_stands,
) -> Callable[..., int]:
    """Return the function that carries `count` balls on.

    `laws` are the pivot's acceleration, the restoring factor, its potential and, in the plane, the
    formulas of `PlaneLaws`.
    """
    return motion_of(motion)(laws_of(*laws, part=part), count, callbacks, part)
