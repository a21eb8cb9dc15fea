"""Passages through angles: the paper's second criterion, and rotations over the top."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

from latolato.observables.base import Observable, Outcome, Segment, observables
from latolato.quantities import QUANTITIES, Quantity, Range, quantity_field
from latolato.scalar import floor, formula

# One over a period that no angle reaches: counts only the two levels themselves.
_UNWRAPPED = 1e-200


@formula
def _level(x: float, angle: float, per_period: float) -> float:
    """Return how many of the levels ``+-angle + k period`` lie at or below x, from some zero."""
    return floor((x - angle) * per_period) + floor((x + angle) * per_period)


@formula
def _step(acc: Any, i: int, n: int, s: Segment) -> None:
    """Count the levels passed on the way to a turning point in the step, and from there on."""
    angle, per_period = acc[i + n], acc[i + 2 * n]
    middle = _level(s.turn, angle, per_period)
    there = abs(middle - _level(s.x0, angle, per_period))
    acc[i] += there + abs(_level(s.x1, angle, per_period) - middle)


@formula
def _restart(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient."""
    acc[i] = 0.0


@observables.register("crossings")
@dataclass(frozen=True, kw_only=True)
class Crossings(Observable):
    """Passages of a ball through the positions +-`crossing_angle` (Paper, criterion 2).

    Angles count modulo 2 pi, so a rotating pendulum keeps counting; with ``unwrapped=True`` only
    the two angles themselves count. Turns within a step are located on its quintic; a passage and
    a return whose depth is below the error of a step can be missed, both at once.
    """

    variables: ClassVar[Any] = {"crossings": QUANTITIES["crossings"]}
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_step)
    restart: ClassVar[Any] = staticmethod(_restart)

    crossing_angle: float = quantity_field(
        "crossing_angle", Range(0.0, math.pi, open_low=True), default=2.0, suggested=(0.1, 3.1)
    )
    unwrapped: bool = field(
        default=False, metadata={"description": "count the unwrapped angle instead"}
    )

    def initial(self, angle: Any) -> list[Any]:
        """Return the count, the level and one over the period of the levels."""
        return [0.0, self.crossing_angle, _UNWRAPPED if self.unwrapped else 1.0 / math.tau]

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return the count."""
        return {"crossings": slots[0]}


@observables.register("rotations")
@dataclass(frozen=True, kw_only=True)
class Rotations(Observable):
    """Passages of the ball over the top position, in either direction."""

    variables: ClassVar[Any] = {
        "rotations": Quantity("1", r"N_{rot}", "passages over the top position")
    }
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_step)
    restart: ClassVar[Any] = staticmethod(_restart)

    def initial(self, angle: Any) -> list[Any]:
        """Return the count, the level pi, and a period that makes +pi and -pi one position."""
        return [0.0, math.pi, 1.0 / math.tau]

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return half the count: +pi and -pi were both passed."""
        return {"rotations": 0.5 * slots[0]}
