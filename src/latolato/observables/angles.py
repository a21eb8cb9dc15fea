"""Largest angles, what follows from them, and whether motion started by itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.observables.base import Observable, Outcome, Segment, observables
from latolato.quantities import QUANTITIES, Quantity, Range, quantity_field
from latolato.scalar import formula


@formula
def largest_angle(s: Segment) -> float:
    """Return the largest |angle| of a step [rad]."""
    return max(abs(s.x0), abs(s.x1), abs(s.turn))


@formula
def _step(acc: Any, i: int, n: int, s: Segment) -> None:
    """Keep the largest |angle|."""
    acc[i] = max(acc[i], largest_angle(s))


@formula
def _restart(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient."""
    acc[i] = abs(angle)


@observables.register("largest_angle")
@dataclass(frozen=True, kw_only=True)
class LargestAngle(Observable):
    """Largest absolute angle at any time, transient included; unwrapped if the ball rotates."""

    variables: ClassVar[Any] = {"largest_angle": QUANTITIES["largest_angle"]}
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_step)

    def initial(self, angle: Any) -> list[Any]:
        """Return the initial |angle|."""
        return [abs(angle)]

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return the largest |angle|."""
        return {"largest_angle": slots[0]}


@observables.register("largest_angle_after_transient")
@dataclass(frozen=True, kw_only=True)
class LargestAngleAfterTransient(Observable):
    """Largest absolute angle after the transient."""

    variables: ClassVar[Any] = {
        "largest_angle_after_transient": Quantity(
            "rad", r"\theta_{max,late}", "largest angle after the transient"
        )
    }
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_step)
    restart: ClassVar[Any] = staticmethod(_restart)

    def initial(self, angle: Any) -> list[Any]:
        """Return the initial |angle|."""
        return [abs(angle)]

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return the largest |angle|."""
        return {"largest_angle_after_transient": slots[0]}


@formula
def _both_step(acc: Any, i: int, n: int, s: Segment) -> None:
    """Keep the largest |angle| overall and after the transient."""
    now = largest_angle(s)
    acc[i] = max(acc[i], now)
    acc[i + n] = max(acc[i + n], now)


@formula
def _both_restart(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient in the second slot."""
    acc[i + n] = abs(angle)


@observables.register("motion_class")
@dataclass(frozen=True, kw_only=True)
class MotionClass(Observable):
    """How strongly the ball moves: 2 strong, 1 weak, 0 none (Paper, trials of Fig. 9).

    Strong if the largest angle reaches `strong_angle` at any time, weak if it reaches
    `weak_angle` after the transient.
    """

    variables: ClassVar[Any] = {
        "motion_class": Quantity("1", "", "class of motion (0 none, 1 weak, 2 strong)")
    }
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_both_step)
    restart: ClassVar[Any] = staticmethod(_both_restart)

    strong_angle: float = quantity_field(
        "largest_angle", Range(0.0, open_low=True), default=math.pi / 2.0
    )
    weak_angle: float = quantity_field(
        "largest_angle", Range(0.0, open_low=True), default=math.pi / 4.0
    )

    def initial(self, angle: Any) -> list[Any]:
        """Return the initial |angle| twice."""
        return [abs(angle), abs(angle)]

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return 2 where strong, 1 where weak, else 0, and NaN where the angle is."""
        strong, weak = slots[0] >= self.strong_angle, slots[1] >= self.weak_angle
        known = 0.0 * slots[0] + 0.0 * slots[1]  # zero, or NaN
        return {"motion_class": known + strong * 2.0 + (weak & ~strong) * 1.0}


@formula
def _moved_step(acc: Any, i: int, n: int, s: Segment) -> None:
    """Keep the largest distance from the start."""
    acc[i] = max(acc[i], abs(s.x1 - acc[i + n]))


@observables.register("self_start")
@dataclass(frozen=True, kw_only=True)
class SelfStart(Observable):
    """Whether the ball ever moves by more than `least_motion` from where it starts (1 or 0)."""

    variables: ClassVar[Any] = {"self_start": Quantity("1", "", "motion starts (1) or not (0)")}
    step: ClassVar[Any] = staticmethod(_moved_step)

    least_motion: float = quantity_field(
        "initial_offset",
        Range(0.0, open_low=True),
        default=0.01,
        description="angle from the start that counts as motion",
    )

    def initial(self, angle: Any) -> list[Any]:
        """Return no distance, and the start."""
        return [0.0, angle]

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return 1 where the ball moved."""
        return {"self_start": slots[0] - slots[0] + (slots[0] > self.least_motion)}
