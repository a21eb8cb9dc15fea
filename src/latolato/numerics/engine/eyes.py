"""What looks on: observables, which see every step, contact and matrix of small deviations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.engine.compiling import Part, as_it_stands
from latolato.numerics.engine.laws import Laws
from latolato.numerics.watch import Watch
from latolato.observables import Segment


class Eyes(NamedTuple):
    """Where observables keep what they see: their slots, the first column, how many there are."""

    acc: Any
    column: int
    columns: int


class Look(NamedTuple):
    """The functions that show the observables something; see `make_look`."""

    step: Callable[..., None]
    matrix: Callable[..., None]
    sees_matrices: bool


def make_look(
    laws: Laws, watch: Watch, *, sees_steps: bool, sees_matrices: bool,
    compile_part: Part | None = None,
) -> Look:  # fmt: skip
    """Return the functions that hand on steps and matrices, if anybody asks for them."""
    part = compile_part or as_it_stands
    potential, restoring = laws.potential, laws.restoring
    watch_step, watch_matrix = watch.step, watch.tangent

    @part
    def step(run: Any, eyes: Eyes, ball: int, a0: float, a1: float, held: float) -> None:
        """Show the step of one ball, whose accelerations with all drag are a0 and a1."""
        if sees_steps:
            b, begin, end = run.bodies[ball], run.now[ball], run.end[ball]
            stiffness = run.settings.gravity * b.coupling
            x0, v0, x1, v1 = begin.angle, begin.velocity, end.angle, end.velocity
            segment = Segment(
                run.t, run.t_end, x0, x1, v0, v1, a0, a1,
                0.5 * v0 * v0 + stiffness * potential(x0, run),
                0.5 * v1 * v1 + stiffness * potential(x1, run),
                v0 * (a0 + stiffness * restoring(x0, run)),
                v1 * (a1 + stiffness * restoring(x1, run)),
                held,
            )  # fmt: skip
            watch_step(eyes.acc, eyes.column + ball, eyes.columns, segment)

    @part
    def matrix(run: Any, eyes: Eyes, size: int, time: float, spread: float) -> None:
        """Show the matrix in ``run.jacobian``."""
        if sees_matrices:
            watch_matrix(eyes.acc, eyes.column, eyes.columns, size, time, spread, run.jacobian)

    return Look(step, matrix, sees_matrices)
