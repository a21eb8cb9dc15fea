"""Reports steps and tangent maps to the observables."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics.callbacks import ON_STEP, ON_TANGENT, Accumulators, Callbacks
from latolato.numerics.engine.laws import Laws
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import Run
from latolato.observables import Step
from latolato.observables.hermite import turning_angle


class Report(NamedTuple):
    """The functions that report to the observables; see `make_report`."""

    step: Callable[..., None]
    show: Callable[..., None]
    matrix: Callable[..., None]
    wants_tangent_map: Callable[..., bool]


def make_report(laws: Laws, callbacks: Callbacks, part: Part = as_it_stands) -> Report:
    """Make the functions that report steps and tangent maps, if an observable wants them."""
    potential, restoring, sensitive = laws.potential, laws.restoring, len(laws.changes) > 0
    push, push_potential = laws.push, laws.push_potential
    on_step, on_tangent, is_wanted = callbacks.step, callbacks.tangent, callbacks.is_wanted

    @part
    def show(
        run: Run, accumulators: Accumulators, ball: int, accelerations: tuple[float, float],
        energies: tuple[float, float], powers: tuple[float, float], held: float,
    ) -> None:  # fmt: skip
        """Report the step of one ball, of which all this is known at both ends."""
        begin, end, (a0, a1) = run.now[ball], run.end[ball], accelerations
        x0, v0, x1, v1 = begin.angle, begin.velocity, end.angle, end.velocity
        if is_wanted(run, ON_STEP):
            on_step(run, accumulators, ball, Step(
                run.t, run.t_end, x0, x1, v0, v1, a0, a1, *energies, *powers, held,
                turning_angle(run.t_end - run.t, x0, v0, a0, x1, v1, a1),
            ))  # fmt: skip

    @part
    def step(
        run: Run, accumulators: Accumulators, ball: int, a0: float, a1: float, held: float
    ) -> None:
        """Report the step of one ball, whose accelerations with all drag are a0 and a1."""
        if not is_wanted(run, ON_STEP):
            return
        b, begin, end = run.bodies[ball], run.now[ball], run.end[ball]
        stiffness, is_linear = run.settings.gravity * b.inverse_length, run.settings.is_linear
        x0, v0, x1, v1 = begin.angle, begin.velocity, end.angle, end.velocity
        segment = Step(
            run.t, run.t_end, x0, x1, v0, v1, a0, a1,
            0.5 * v0 * v0 + stiffness * potential(x0, is_linear) + push_potential(x0, run),
            0.5 * v1 * v1 + stiffness * potential(x1, is_linear) + push_potential(x1, run),
            v0 * (a0 + stiffness * restoring(x0, is_linear) - push(x0, run)),
            v1 * (a1 + stiffness * restoring(x1, is_linear) - push(x1, run)),
            held, turning_angle(run.t_end - run.t, x0, v0, a0, x1, v1, a1),
        )  # fmt: skip
        on_step(run, accumulators, ball, segment)

    @part
    def carry_on(run: Run, size: int) -> None:
        """Carry the derivatives with respect to parameters through a step or an event."""
        for p in range(run.parameters):
            for row in range(size):
                for column in range(size):
                    carried = run.jacobian[row, column] * run.sensitivity[column, p]
                    run.forcing[row, p] += carried
            for row in range(size):
                run.sensitivity[row, p], run.forcing[row, p] = run.forcing[row, p], 0.0

    @part
    def matrix(run: Run, accumulators: Accumulators, size: int, time: float, spread: float) -> None:
        """Report the tangent map in ``run.jacobian``; the forcing goes with it."""
        if sensitive:
            carry_on(run, size)
        if is_wanted(run, ON_TANGENT):
            on_tangent(run, accumulators, 0, size, time, spread, run.jacobian)

    @part
    def wants_tangent_map(run: Run) -> bool:
        """Whether an observable or a derivative wants tangent maps."""
        seen: bool = is_wanted(run, ON_TANGENT)
        return seen or sensitive

    return Report(
        step=step,
        show=show,
        matrix=matrix,
        wants_tangent_map=wants_tangent_map,
    )
