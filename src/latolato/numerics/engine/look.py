"""Passes steps and matrices of small deviations to the observables."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from latolato.numerics.engine.compiling import Part, as_it_stands
from latolato.numerics.engine.laws import Laws
from latolato.numerics.watch import ON_STEP, ON_TANGENT, Eyes, Watch
from latolato.observables import Segment
from latolato.observables.hermite import turning_angle


class Look(NamedTuple):
    """The functions that show the observables something; see `make_look`."""

    step: Callable[..., None]
    show: Callable[..., None]
    matrix: Callable[..., None]
    sees_matrices: Callable[..., bool]


def make_look(laws: Laws, watch: Watch, part: Part = as_it_stands) -> Look:
    """Return the functions that pass on steps and matrices, if an observable needs them."""
    potential, restoring = laws.potential, laws.restoring
    push, push_potential = laws.push, laws.push_potential
    watch_step, watch_matrix, sees = watch.step, watch.tangent, watch.sees

    @part
    def show(
        run: Any, eyes: Eyes, ball: int, accelerations: tuple[float, float],
        energies: tuple[float, float], powers: tuple[float, float], held: float,
    ) -> None:  # fmt: skip
        """Show the step of one ball, of which all this is known at both ends."""
        begin, end, (a0, a1) = run.now[ball], run.end[ball], accelerations
        x0, v0, x1, v1 = begin.angle, begin.velocity, end.angle, end.velocity
        if sees(run, ON_STEP):
            watch_step(run, eyes, ball, Segment(
                run.t, run.t_end, x0, x1, v0, v1, a0, a1, *energies, *powers, held,
                turning_angle(run.t_end - run.t, x0, v0, a0, x1, v1, a1),
            ))  # fmt: skip

    @part
    def step(run: Any, eyes: Eyes, ball: int, a0: float, a1: float, held: float) -> None:
        """Show the step of one ball, whose accelerations with all drag are a0 and a1."""
        if not sees(run, ON_STEP):
            return
        b, begin, end = run.bodies[ball], run.now[ball], run.end[ball]
        stiffness, is_linear = run.settings.gravity * b.coupling, run.settings.is_linear
        x0, v0, x1, v1 = begin.angle, begin.velocity, end.angle, end.velocity
        segment = Segment(
            run.t, run.t_end, x0, x1, v0, v1, a0, a1,
            0.5 * v0 * v0 + stiffness * potential(x0, is_linear) + push_potential(x0, run),
            0.5 * v1 * v1 + stiffness * potential(x1, is_linear) + push_potential(x1, run),
            v0 * (a0 + stiffness * restoring(x0, is_linear) - push(x0, run)),
            v1 * (a1 + stiffness * restoring(x1, is_linear) - push(x1, run)),
            held, turning_angle(run.t_end - run.t, x0, v0, a0, x1, v1, a1),
        )  # fmt: skip
        watch_step(run, eyes, ball, segment)

    @part
    def matrix(run: Any, eyes: Eyes, size: int, time: float, spread: float) -> None:
        """Show the matrix in ``run.jacobian``."""
        if sees(run, ON_TANGENT):
            watch_matrix(run, eyes, 0, size, time, spread, run.jacobian)

    @part
    def sees_matrices(run: Any) -> bool:
        """Return whether anybody looks at matrices."""
        seen: bool = sees(run, ON_TANGENT)
        return seen

    return Look(step, show, matrix, sees_matrices)
