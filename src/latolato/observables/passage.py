"""When the motion first passes an angle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import QUANTITIES, Range, quantity_field
from latolato.core.scalar import formula
from latolato.observables.base import Observable, Outcome, Step, observables
from latolato.observables.hermite import quintic

# Slots: the threshold, whether it was passed, and the step in which that happened.
# The passage is looked for at this many shares of its step, then by bisection; an angle that tops
# the threshold between two shares only is given the share next to its turn.
_SHARES = 64
_HALVINGS = 46


@formula
def _start(acc: Any, i: int, n: int, angle: float) -> None:
    """Note whether the start is beyond the threshold."""
    acc[i + n] = 1.0 if abs(angle) >= acc[i] else 0.0


@formula
def _step(acc: Any, i: int, n: int, s: Step) -> None:
    """Keep the first step that passes the threshold; the passage in it is located at the end."""
    h = s.t1 - s.t0
    passes = max(abs(s.x1), abs(s.turn)) >= acc[i]
    is_first = passes and acc[i + n] == 0.0
    acc[i + 2 * n] = s.t0 if is_first else acc[i + 2 * n]
    acc[i + 3 * n] = h if is_first else acc[i + 3 * n]
    acc[i + 4 * n] = s.x0 if is_first else acc[i + 4 * n]
    acc[i + 5 * n] = s.v0 if is_first else acc[i + 5 * n]
    acc[i + 6 * n] = s.a0 if is_first else acc[i + 6 * n]
    acc[i + 7 * n] = s.x1 if is_first else acc[i + 7 * n]
    acc[i + 8 * n] = s.v1 if is_first else acc[i + 8 * n]
    acc[i + 9 * n] = s.a1 if is_first else acc[i + 9 * n]
    acc[i + n] = 1.0 if passes else acc[i + n]


@formula
def _height(acc: Any, i: int, n: int, share: float) -> float:
    """Return the angle above the threshold at a share of the step that was kept [rad]."""
    x = quintic(
        share, acc[i + 3 * n], acc[i + 4 * n], acc[i + 5 * n], acc[i + 6 * n], acc[i + 7 * n],
        acc[i + 8 * n], acc[i + 9 * n],
    )  # fmt: skip
    above: float = abs(x) - acc[i]
    return above


@formula
def _finish(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the instant of the passage, by bisection of the quintic."""
    high, top = 1.0, _height(acc, i, n, 1.0)
    for number in range(_SHARES - 1, 0, -1):
        above = _height(acc, i, n, number / _SHARES)
        # The earliest share beyond, or the highest where none is.
        if above >= 0.0 or (top < 0.0 and above > top):
            high, top = number / _SHARES, above
    low = high - 1.0 / _SHARES if top >= 0.0 else high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_late = _height(acc, i, n, middle) >= 0.0
        low, high = (low, middle) if is_late else (middle, high)
    known = 0.0 * end.angle  # zero, or NaN
    instant = acc[i + 2 * n] + high * acc[i + 3 * n]
    acc[i + n] = instant + known if acc[i + n] == 1.0 else math.nan


@observables.register("first_passage")
@dataclass(frozen=True, kw_only=True)
class FirstPassage(Observable):
    """Time at which the absolute angle first reaches `threshold_angle`, NaN if it never does.

    Counted from the beginning of the run, including the transient; the angle is unwrapped. The
    passage is located on the quintic of its step. It can be missed if its height above the
    threshold is below the error of a step.
    """

    variables: ClassVar[Any] = {"first_passage": QUANTITIES["first_passage"]}
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    start: ClassVar[Any] = staticmethod(_start)
    step: ClassVar[Any] = staticmethod(_step)
    finish: ClassVar[Any] = staticmethod(_finish)

    threshold_angle: float = quantity_field(
        "threshold_angle", Range(0.0, open_low=True), default=math.pi / 4.0, suggested=(0.1, 3.0)
    )

    @property
    def memory(self) -> int:
        """Whether it was passed, and the step: instant, length, three numbers at each end."""
        return 9
