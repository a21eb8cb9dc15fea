"""Largest angles, quantities that follow from them, and whether motion started by itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import QUANTITIES, Quantity, Range, quantity_field
from latolato.core.scalar import formula
from latolato.observables.base import Observable, Outcome, Step, observables


@formula
def largest_angle(s: Step) -> float:
    """Return the largest |angle| of a step [rad]."""
    return max(abs(s.x0), abs(s.x1), abs(s.turn))


@formula
def _step(acc: Any, i: int, n: int, s: Step) -> None:
    """Keep the largest |angle|."""
    acc[i] = max(acc[i], largest_angle(s))


@formula
def _restart(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient."""
    acc[i] = abs(angle)


@formula
def _start(acc: Any, i: int, n: int, angle: float) -> None:
    """Note the initial |angle|."""
    acc[i] = abs(angle)


@observables.register("largest_angle")
@dataclass(frozen=True, kw_only=True)
class LargestAngle(Observable):
    """Largest absolute angle at any time, with the transient; unwrapped if the ball rotates."""

    variables: ClassVar[Any] = {"largest_angle": QUANTITIES["largest_angle"]}
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    start: ClassVar[Any] = staticmethod(_start)
    step: ClassVar[Any] = staticmethod(_step)


@observables.register("largest_angle_after_transient")
@dataclass(frozen=True, kw_only=True)
class LargestAngleAfterTransient(Observable):
    """Largest absolute angle after the transient."""

    variables: ClassVar[Any] = {
        "largest_angle_after_transient": QUANTITIES["largest_angle_after_transient"]
    }
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    start: ClassVar[Any] = staticmethod(_start)
    step: ClassVar[Any] = staticmethod(_step)
    restart: ClassVar[Any] = staticmethod(_restart)


# Slots of `MotionClass`: its two angles, then the largest overall and after the transient.
@formula
def _class_start(acc: Any, i: int, n: int, angle: float) -> None:
    """Note the initial |angle|."""
    acc[i + 2 * n] = abs(angle)
    acc[i + 3 * n] = abs(angle)


@formula
def _class_step(acc: Any, i: int, n: int, s: Step) -> None:
    """Keep the largest |angle| overall and after the transient."""
    now = largest_angle(s)
    acc[i + 2 * n] = max(acc[i + 2 * n], now)
    acc[i + 3 * n] = max(acc[i + 3 * n], now)


@formula
def _class_restart(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient in the last slot."""
    acc[i + 3 * n] = abs(angle)


@formula
def _class_finish(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write 2 where strong, 1 where weak, else 0, and NaN where the angle is."""
    overall, late = acc[i + 2 * n], acc[i + 3 * n]
    known = 0.0 * overall + 0.0 * late  # zero, or NaN
    acc[i + 2 * n] = known + (2.0 if overall >= acc[i] else 1.0 if late >= acc[i + n] else 0.0)


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
    start: ClassVar[Any] = staticmethod(_class_start)
    step: ClassVar[Any] = staticmethod(_class_step)
    restart: ClassVar[Any] = staticmethod(_class_restart)
    finish: ClassVar[Any] = staticmethod(_class_finish)

    strong_angle: float = quantity_field(
        "largest_angle", Range(0.0, open_low=True), default=math.pi / 2.0
    )
    weak_angle: float = quantity_field(
        "largest_angle", Range(0.0, open_low=True), default=math.pi / 4.0
    )

    @property
    def memory(self) -> int:
        """Both largest angles."""
        return 2


# Slots of `SelfStart`: the angle that counts, the largest distance from the start, the start.
@formula
def _moved_start(acc: Any, i: int, n: int, angle: float) -> None:
    """Note the start."""
    acc[i + 2 * n] = angle


@formula
def _moved_step(acc: Any, i: int, n: int, s: Step) -> None:
    """Keep the largest distance from the start."""
    acc[i + n] = max(acc[i + n], abs(s.x1 - acc[i + 2 * n]))


@formula
def _moved_finish(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write 1 where the ball moved, else 0, and NaN where the distance is."""
    moved = acc[i + n]
    acc[i + n] = moved - moved + (1.0 if moved > acc[i] else 0.0)


@observables.register("self_start")
@dataclass(frozen=True, kw_only=True)
class SelfStart(Observable):
    """Whether the ball ever moves by more than `least_motion` from where it starts (1 or 0)."""

    variables: ClassVar[Any] = {"self_start": Quantity("1", "", "motion starts (1) or not (0)")}
    start: ClassVar[Any] = staticmethod(_moved_start)
    step: ClassVar[Any] = staticmethod(_moved_step)
    finish: ClassVar[Any] = staticmethod(_moved_finish)

    least_motion: float = quantity_field(
        "initial_offset",
        Range(0.0, open_low=True),
        default=0.01,
        description="angle from the start that counts as motion",
    )

    @property
    def memory(self) -> int:
        """The distance and the start."""
        return 2
