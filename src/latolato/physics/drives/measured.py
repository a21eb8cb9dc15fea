"""A pivot that follows measured heights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from latolato.core.errors import InputError
from latolato.core.quantities import ANY, NON_NEGATIVE, array_field, quantity_field
from latolato.physics.drives.base import (
    Drive,
    check_increasing,
    checked_array,
    drives,
)
from latolato.physics.drives.stretch import POLYNOMIAL, Stretch

# How often the curve is looked at between two samples, and by how many times their range it may
# leave the range of the heights; less than this share of the heights is rounding.
_LOOKS, _ROOM, _ROUNDING = 8, 2.0, 1e-9


@drives.register("measured_pivot")
@dataclass(frozen=True, kw_only=True)
class MeasuredPivot(Drive):
    """A pivot that follows measured heights: a quintic spline through, or close to, the samples.

    Parameters
    ----------
    times : sequence of float, shape (sample,)
        Strictly increasing instants [s]; the run must lie between the first and the last.
    pivot_heights : sequence of float, shape (sample,)
        Heights at these instants [m].
    height_sigma : float
        Standard deviation of the heights [m]; 0 interpolates, larger values smooth until the
        residual sum of squares is that of such noise (Dierckx's criterion, SciPy's
        ``UnivariateSpline``).
    """

    times: Sequence[float] = array_field("times", description="sample instants")
    pivot_heights: Sequence[float] = array_field(
        "pivot_height", description="height of the pivot at each instant"
    )
    height_sigma: float = quantity_field(
        "pivot_height", NON_NEGATIVE, description="standard deviation of the heights", default=0.0
    )
    _pieces: list[Stretch] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        times = checked_array("times", self.times, ANY, 6, unit="s")
        heights = checked_array("pivot_heights", self.pivot_heights, ANY, 6, unit="m")
        if len(times) != len(heights):
            raise InputError(
                "{parameter} and pivot_heights must be of one length, got "
                f"{len(times)} and {len(heights)}",
                parameter="times",
            )
        check_increasing("times", times)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "pivot_heights", heights)
        object.__setattr__(self, "_pieces", self._fit())

    def _fit(self) -> list[Stretch]:
        """Return the spline's pieces as stretches."""
        from scipy.interpolate import PPoly, UnivariateSpline, make_interp_spline
        from scipy.linalg import LinAlgError

        try:
            if self.height_sigma > 0.0:
                weights = [1.0 / self.height_sigma] * len(self.times)
                smooth = UnivariateSpline(self.times, self.pivot_heights, w=weights, k=5)
                pieces = PPoly.from_spline(smooth._eval_args)
            else:
                pieces = PPoly.from_spline(make_interp_spline(self.times, self.pivot_heights, k=5))
            is_known = all(math.isfinite(c) for row in pieces.c.tolist() for c in row)
        except (ValueError, LinAlgError):  # of a singular matrix; which one depends on SciPy
            is_known = False
        if not is_known:
            raise InputError(
                "leave too large a gap for a spline through the heights",
                parameter="times",
                way_out="leave out the samples before or after the gap",
            )
        self._check_course(pieces)
        return [
            Stretch(float(a), POLYNOMIAL, 0.0, 0.0, 0.0, *(float(c) for c in pieces.c[::-1, i]))
            for i, (a, b) in enumerate(zip(pieces.x[:-1], pieces.x[1:], strict=True))
            if b > a
        ]

    def _check_course(self, pieces: Any) -> None:
        """Raise InputError if the spline goes where the heights give no reason to expect it."""
        low, high = min(self.pivot_heights), max(self.pivot_heights)
        gaps = list(pairwise(self.times))
        looks = [a + (b - a) * i / _LOOKS for a, b in gaps for i in range(1, _LOOKS)]
        beyond = [max(low - y, y - high) for y in pieces(looks).tolist()]
        worst = max(range(len(looks)), key=beyond.__getitem__)
        if beyond[worst] > _ROOM * (high - low) + _ROUNDING * max(-low, high):
            begin, end = gaps[worst // (_LOOKS - 1)]
            raise InputError(
                f"leave a gap from {begin:g} to {end:g} s in which the curve through the heights "
                f"leaves their range by {beyond[worst]:.3g} m",
                parameter="times",
                way_out="leave out the samples before or after the gap",
            )

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the pieces between 0 and `duration`.

        Raises
        ------
        InputError
            If the samples do not cover the run.
        """
        first, last = self.times[0], self.times[-1]
        if first > 0.0 or last < duration:
            raise InputError(
                f"the pivot samples cover {first:g} to {last:g} s, but the run goes from 0 to "
                f"{duration:g} s; shorten the duration or shift the samples"
            )
        begin = max(i for i, piece in enumerate(self._pieces) if piece.start <= 0.0)
        return [piece for piece in self._pieces[begin:] if piece.start <= duration]

    def course(self) -> tuple[list[Stretch], float]:
        """Return all pieces, and the last instant [s]."""
        return self._pieces, self.times[-1]
