"""Mean energy: the paper's first criterion for resonance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import QUANTITIES
from latolato.core.scalar import formula
from latolato.observables.base import Observable, Outcome, Step, observables


@formula
def _step(acc: Any, i: int, n: int, s: Step) -> None:
    """Add the integral of the energy, by the trapezoid with its end correction (order 4)."""
    h = s.t1 - s.t0
    acc[i] += 0.5 * h * (s.e0 + s.e1) + h * h / 12.0 * (s.p0 - s.p1)


@formula
def _restart(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient."""
    acc[i] = 0.0


@formula
def _finish(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Turn the integral into the mean of the ball's energy."""
    acc[i] *= end.inertia / end.observed_time


@observables.register("mean_energy")
@dataclass(frozen=True, kw_only=True)
class MeanEnergy(Observable):
    """Time mean of the total energy after the transient (Paper, criterion 1), per ball."""

    variables: ClassVar[Any] = {"mean_energy": QUANTITIES["mean_energy"]}
    needs: ClassVar[frozenset[str]] = frozenset({"energy"})
    step: ClassVar[Any] = staticmethod(_step)
    restart: ClassVar[Any] = staticmethod(_restart)
    finish: ClassVar[Any] = staticmethod(_finish)
