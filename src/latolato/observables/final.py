"""What is known at the end of a run: the final state, works and losses, slack, the last periods."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

from latolato.errors import InputError
from latolato.observables.base import Observable, Outcome, observables
from latolato.quantities import QUANTITIES, Quantity
from latolato.scalar import formula


@observables.register("final_angle")
@dataclass(frozen=True, kw_only=True)
class FinalAngle(Observable):
    """Angle at the end, unwrapped."""

    variables: ClassVar[Any] = {"final_angle": Quantity("rad", r"\theta_{end}", "final angle")}

    def initial(self, angle: Any) -> list[Any]:
        """Return nothing: the state tells."""
        return []

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return the final angle."""
        return {"final_angle": outcome.angle}


@observables.register("final_angular_velocity")
@dataclass(frozen=True, kw_only=True)
class FinalAngularVelocity(Observable):
    """Angular velocity at the end."""

    variables: ClassVar[Any] = {
        "final_angular_velocity": Quantity("rad/s", r"\dot\theta_{end}", "final angular velocity")
    }

    def initial(self, angle: Any) -> list[Any]:
        """Return nothing: the state tells."""
        return []

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return the final angular velocity."""
        return {"final_angular_velocity": outcome.velocity}


@observables.register("works")
@dataclass(frozen=True, kw_only=True)
class Works(Observable):
    """Work of the drive and the losses after the transient, each from its own quadrature.

    Of one ball, or of both balls of a `BallPair` together.
    """

    variables: ClassVar[Any] = {
        name: QUANTITIES[name]
        for name in ("drive_work", "damping_loss", "impact_loss", "capture_loss")
    }
    needs: ClassVar[frozenset[str]] = frozenset({"works"})
    is_joint: ClassVar[bool] = True

    def initial(self, angle: Any) -> list[Any]:
        """Return nothing: the state tells."""
        return []

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return works and losses."""
        return dict(outcome.works)


@observables.register("slack_fraction")
@dataclass(frozen=True, kw_only=True)
class SlackFraction(Observable):
    """Share of the time after the transient in which the rod is pushed: a string would be slack."""

    variables: ClassVar[Any] = {"slack_fraction": QUANTITIES["slack_fraction"]}
    needs: ClassVar[frozenset[str]] = frozenset({"slack"})

    def initial(self, angle: Any) -> list[Any]:
        """Return nothing: the state tells."""
        return []

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return the time of slack over the observed time."""
        return {"slack_fraction": outcome.slack / outcome.observed}


@formula
def _mark(acc: Any, i: int, n: int, number: int, t: float, angle: float, velocity: float) -> None:
    """Note the state at the end of a drive period."""
    acc[i + 2 * number * n] = angle
    acc[i + (2 * number + 1) * n] = velocity


@observables.register("stroboscope")
@dataclass(frozen=True, kw_only=True)
class Stroboscope(Observable):
    """Angle and angular velocity at the end of each of the last `periods` drive periods.

    The instants are whole multiples of the drive period, the last not after the duration; a step
    ends at each. NaN where the run is shorter than that many periods.
    """

    variables: ClassVar[Any] = {
        "stroboscopic_angle": Quantity("rad", r"\theta(kT)", "angle once per drive period"),
        "stroboscopic_angular_velocity": Quantity(
            "rad/s", r"\dot\theta(kT)", "angular velocity once per drive period"
        ),
    }
    mark: ClassVar[Any] = staticmethod(_mark)
    dimension: ClassVar[str] = "sample"

    periods: int = field(default=32, metadata={"description": "number of drive periods"})

    def __post_init__(self) -> None:
        super().__post_init__()
        count: object = self.periods
        if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= 100_000:
            raise InputError(f"periods must be an integer in [1, 100000], got {count!r}")

    @property
    def marks(self) -> int:
        """How many drive periods are marked."""
        return self.periods

    def initial(self, angle: Any) -> list[Any]:
        """Return NaN for every sample."""
        return [float("nan")] * (2 * self.periods)

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return samples of shape (point, sample)."""
        return {
            "stroboscopic_angle": slots[0::2].T,
            "stroboscopic_angular_velocity": slots[1::2].T,
        }
