"""What carries a trajectory on: the engine, or the clamp."""

from __future__ import annotations

from collections.abc import Callable

from latolato.numerics.clamp import make_clamped
from latolato.numerics.engine.compiling import Part
from latolato.numerics.engine.laws import Formula, laws_of
from latolato.numerics.engine.loop import make_engine
from latolato.numerics.watch import Watch


def make_trajectory(
    *laws: Formula,
    count: int,
    watch: Watch,
    clamped: bool = False,
    compile_part: Part | None = None,
) -> Callable[..., int]:
    """Return the engine of `count` balls, or the clamp.

    `laws` are the pivot's acceleration, the restoring factor and its potential.
    """
    pivot_acceleration, restoring, potential = laws
    found = laws_of(pivot_acceleration, restoring, potential, compile_part)
    if clamped:
        return make_clamped(found, watch, compile_part)
    return make_engine(found, count, watch, compile_part=compile_part)
