"""What is known at the end of a run: the final state, works, losses, compression, last periods."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES, Quantity
from latolato.core.scalar import formula
from latolato.observables.base import Observable, Outcome, observables


@formula
def _finish_angle(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the final angle."""
    acc[i] = end.angle


@observables.register("final_angle")
@dataclass(frozen=True, kw_only=True)
class FinalAngle(Observable):
    """Angle at the end, unwrapped."""

    variables: ClassVar[Any] = {"final_angle": Quantity("rad", r"\theta_{end}", "final angle")}
    finish: ClassVar[Any] = staticmethod(_finish_angle)


@formula
def _finish_velocity(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the final angular velocity."""
    acc[i] = end.velocity


@observables.register("final_angular_velocity")
@dataclass(frozen=True, kw_only=True)
class FinalAngularVelocity(Observable):
    """Angular velocity at the end."""

    variables: ClassVar[Any] = {
        "final_angular_velocity": Quantity("rad/s", r"\dot\theta_{end}", "final angular velocity")
    }
    finish: ClassVar[Any] = staticmethod(_finish_velocity)


@formula
def _finish_works(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write works and losses."""
    acc[i], acc[i + n] = end.drive_work, end.damping_loss
    acc[i + 2 * n], acc[i + 3 * n] = end.impact_loss, end.capture_loss


@observables.register("energy_ledger")
@dataclass(frozen=True, kw_only=True)
class EnergyLedger(Observable):
    """Work of the drive and losses after the transient, each from its own quadrature.

    For one ball, or for both balls of a `BallPair` together.
    """

    variables: ClassVar[Any] = {
        name: QUANTITIES[name]
        for name in ("drive_work", "damping_loss", "impact_loss", "capture_loss")
    }
    needs: ClassVar[frozenset[str]] = frozenset({"works"})
    is_joint: ClassVar[bool] = True
    finish: ClassVar[Any] = staticmethod(_finish_works)


@formula
def _finish_compression(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the time of compression over the observed time."""
    acc[i] = end.compression_time / end.observed_time


@observables.register("compression_fraction")
@dataclass(frozen=True, kw_only=True)
class CompressionFraction(Observable):
    """Share of the time after the transient in which the rod is pushed: a string would be slack."""

    variables: ClassVar[Any] = {"compression_fraction": QUANTITIES["compression_fraction"]}
    needs: ClassVar[frozenset[str]] = frozenset({"compression"})
    finish: ClassVar[Any] = staticmethod(_finish_compression)


# Slots of `PoincareSection`: how many drive periods, the angles at their ends, the velocities.
@formula
def _start(acc: Any, i: int, n: int, angle: float) -> None:
    """Note that there are no samples yet."""
    for m in range(2 * int(acc[i])):
        acc[i + (m + 1) * n] = math.nan


@formula
def _mark(acc: Any, i: int, n: int, number: int, t: float, angle: float, velocity: float) -> None:
    """Note the state at the end of a drive period."""
    acc[i + (number + 1) * n] = angle
    acc[i + (number + 1 + int(acc[i])) * n] = velocity


@observables.register("poincare_section")
@dataclass(frozen=True, kw_only=True)
class PoincareSection(Observable):
    """Angle and angular velocity at the end of each of the last drive periods.

    The instants, `periods` in number, are whole multiples of the drive period, the last one not
    later than the duration; a step ends at each. NaN if the run is shorter than that many periods.
    """

    variables: ClassVar[Any] = {
        "section_angle": Quantity("rad", r"\theta(kT)", "angle once per drive period"),
        "section_angular_velocity": Quantity(
            "rad/s", r"\dot\theta(kT)", "angular velocity once per drive period"
        ),
    }
    start: ClassVar[Any] = staticmethod(_start)
    mark: ClassVar[Any] = staticmethod(_mark)
    dimension: ClassVar[str] = "sample"

    periods: int = field(default=32, metadata={"description": "number of drive periods"})

    def __post_init__(self) -> None:
        super().__post_init__()
        count: object = self.periods
        if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= 100_000:
            raise InputError("must be an integer in [1, 100000]", parameter="periods", value=count)

    @property
    def marks(self) -> int:
        """How many drive periods are marked."""
        return self.periods
