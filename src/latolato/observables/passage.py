"""When the motion first passes an angle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from latolato.observables.base import Observable, Outcome, Segment, observables
from latolato.observables.hermite import quintic
from latolato.quantities import QUANTITIES, Range, quantity_field
from latolato.scalar import formula

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# Slots: whether passed, the threshold, and the step in which it happened.
_FOUND, _LEVEL, _START, _SPAN, _STEP = 0, 1, 2, 3, 4
_SIZE = 10
# The passage is looked for at this many shares of its step, then by bisection; an angle that tops
# the threshold between two shares only is given the share next to its turn.
_SHARES = 64
_HALVINGS = 46


@formula
def _step(acc: Any, i: int, n: int, s: Segment) -> None:
    """Keep the first step that passes the threshold; the passage in it is located at the end."""
    h = s.t1 - s.t0
    passes = max(abs(s.x1), abs(s.turn)) >= acc[i + n]
    is_first = passes and acc[i] == 0.0
    acc[i + 2 * n] = s.t0 if is_first else acc[i + 2 * n]
    acc[i + 3 * n] = h if is_first else acc[i + 3 * n]
    acc[i + 4 * n] = s.x0 if is_first else acc[i + 4 * n]
    acc[i + 5 * n] = s.v0 if is_first else acc[i + 5 * n]
    acc[i + 6 * n] = s.a0 if is_first else acc[i + 6 * n]
    acc[i + 7 * n] = s.x1 if is_first else acc[i + 7 * n]
    acc[i + 8 * n] = s.v1 if is_first else acc[i + 8 * n]
    acc[i + 9 * n] = s.a1 if is_first else acc[i + 9 * n]
    acc[i] = 1.0 if passes else acc[i]


@observables.register("first_passage")
@dataclass(frozen=True, kw_only=True)
class FirstPassage(Observable):
    """Time at which the absolute angle first reaches `threshold_angle`, NaN if it never does.

    Counted from the beginning of the run, transient included; the angle is unwrapped. The passage
    is located on the quintic of its step; one whose height above the threshold is below the error
    of a step can be missed.
    """

    variables: ClassVar[Any] = {"first_passage": QUANTITIES["first_passage"]}
    needs: ClassVar[frozenset[str]] = frozenset({"turn"})
    step: ClassVar[Any] = staticmethod(_step)

    threshold_angle: float = quantity_field(
        "threshold_angle", Range(0.0, open_low=True), default=math.pi / 4.0, suggested=(0.1, 3.0)
    )

    def initial(self, angle: Any) -> list[Any]:
        """Return whether the start is beyond the threshold, the threshold, and no step."""
        beyond = (abs(angle) >= self.threshold_angle) * 1.0
        return [beyond, self.threshold_angle, *[0.0] * (_SIZE - 2)]

    def values(self, slots: Any, outcome: Outcome) -> dict[str, Any]:
        """Return the instants, by bisection of the quintic."""
        import numpy as np

        span, ends = slots[_SPAN], slots[_STEP:_SIZE]

        def height(share: Any) -> Floats:
            """Return the angle above the threshold at shares of the steps."""
            above: Floats = abs(quintic(share, span, *ends)) - slots[_LEVEL]  # plain arithmetic
            return above

        high, top = np.ones_like(span), height(1.0)
        for number in range(_SHARES - 1, 0, -1):
            above = height(number / _SHARES)
            # The earliest share beyond, or the highest where none is.
            better = (above >= 0.0) | ((top < 0.0) & (above > top))
            high, top = np.where(better, number / _SHARES, high), np.where(better, above, top)
        low = np.where(top >= 0.0, high - 1.0 / _SHARES, high)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            is_late = height(middle) >= 0.0
            low, high = np.where(is_late, low, middle), np.where(is_late, middle, high)
        time = slots[_START] + high * span
        known = 0.0 * outcome.angle  # zero, or NaN
        return {"first_passage": np.where(slots[_FOUND] == 1.0, time + known, np.nan)}
