"""Passages through angles: the paper's second criterion, and rotations over the top."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

from latolato.core.quantities import QUANTITIES, Quantity, Range, quantity_field
from latolato.core.scalar import floor, formula
from latolato.observables.base import Observable, Step, observables

# One over a period that no angle reaches: counts only the two levels themselves.
_UNWRAPPED = 1e-200


@formula
def _level(x: float, angle: float, per_period: float) -> float:
    """Return how many of the levels ``+-angle + k period`` lie at or below x, from some zero."""
    return floor((x - angle) * per_period) + floor((x + angle) * per_period)


@formula
def _passages(s: Step, angle: float, per_period: float) -> float:
    """Return how many levels are passed up to a turning point in the step, and from there on."""
    middle = _level(s.turn, angle, per_period)
    there = abs(middle - _level(s.x0, angle, per_period))
    return there + abs(_level(s.x1, angle, per_period) - middle)


# Slots of `Crossings`: its angle, whether that is unwrapped, the count, one over the period.
@formula
def _start(acc: Any, i: int, n: int, angle: float) -> None:
    """Note one over the period of the levels."""
    acc[i + 3 * n] = 1.0 / math.tau if acc[i + n] == 0.0 else _UNWRAPPED


@formula
def _step(acc: Any, i: int, n: int, s: Step) -> None:
    """Count the passages of a step."""
    acc[i + 2 * n] += _passages(s, acc[i], acc[i + 3 * n])


@formula
def _restart(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient."""
    acc[i + 2 * n] = 0.0


@observables.register("crossings")
@dataclass(frozen=True, kw_only=True)
class Crossings(Observable):
    """Passages of a ball through the crossing angle on either side (Paper, criterion 2).

    The positions are ``+-crossing_angle``. Angles count modulo 2 pi, so a rotating pendulum keeps
    counting; with ``unwrapped=True`` only the two angles themselves count. Turning points within a
    step are located on its quintic. A passage and its return can both be missed if their depth is
    below the error of a step.
    """

    variables: ClassVar[Any] = {"crossings": QUANTITIES["crossings"]}
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    start: ClassVar[Any] = staticmethod(_start)
    step: ClassVar[Any] = staticmethod(_step)
    restart: ClassVar[Any] = staticmethod(_restart)

    crossing_angle: float = quantity_field(
        "crossing_angle", Range(0.0, math.pi, open_low=True), default=2.0, suggested=(0.1, 3.1)
    )
    unwrapped: bool = field(
        default=False, metadata={"description": "count the unwrapped angle instead"}
    )

    @property
    def memory(self) -> int:
        """The count and the period."""
        return 2


@formula
def _top_step(acc: Any, i: int, n: int, s: Step) -> None:
    """Count half a passage for each of +pi and -pi, whose levels are one position."""
    acc[i] += 0.5 * _passages(s, math.pi, 1.0 / math.tau)


@formula
def _top_restart(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the transient."""
    acc[i] = 0.0


@observables.register("rotations")
@dataclass(frozen=True, kw_only=True)
class Rotations(Observable):
    """Passages of the ball over the top position, in either direction."""

    variables: ClassVar[Any] = {
        "rotations": Quantity("1", r"N_{rot}", "passages over the top position")
    }
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_top_step)
    restart: ClassVar[Any] = staticmethod(_top_restart)
