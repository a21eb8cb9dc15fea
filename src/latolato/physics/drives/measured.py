"""A pivot that follows measured heights."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar

from latolato.core.errors import InputError
from latolato.core.quantities import NON_NEGATIVE, array_field, quantity_field
from latolato.core.registry import check_increasing, checked_array
from latolato.core.rules import broken_rule
from latolato.physics.drives.base import Drive, drives
from latolato.physics.drives.segment import POLYNOMIAL, Segment

# How often the curve is looked at between two samples, and by how many times their range it may
# leave the range of the samples; less than this share of them is rounding.
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
    pivot_across : sequence of float, shape (sample,), optional
        Horizontal positions at these instants [m], positive to the right; by default the pivot
        moves vertically only.
    across_sigma : float
        Standard deviation of the horizontal positions [m], used as `height_sigma` is.
    """

    across_parameter: ClassVar[str | None] = "pivot_across"

    times: Sequence[float] = array_field("times", description="sample instants")
    pivot_heights: Sequence[float] = array_field(
        "pivot_height", description="height of the pivot at each instant"
    )
    height_sigma: float = quantity_field(
        "pivot_height", NON_NEGATIVE, description="standard deviation of the heights", default=0.0
    )
    pivot_across: Sequence[float] | None = array_field(
        "pivot_across", description="horizontal position of the pivot at each instant", default=None
    )
    across_sigma: float = quantity_field(
        "pivot_across",
        NON_NEGATIVE,
        description="standard deviation of the horizontal positions",
        default=0.0,
    )
    _pieces: list[Segment] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        times = tuple(checked_array("times", self.times, at_least=6, unit="s"))
        object.__setattr__(self, "times", times)
        for name in ("pivot_heights", "pivot_across"):
            values = getattr(self, name)
            if values is None:
                continue
            values = tuple(checked_array(name, values, at_least=6, unit="m"))
            if len(times) != len(values):
                raise broken_rule(
                    "one_length",
                    {
                        "names": f"{{parameter}} and {name}",
                        "counts": f"{len(times)} and {len(values)}",
                    },
                    parameter="times",
                )
            object.__setattr__(self, name, values)
        if self.pivot_across is None and self.across_sigma > 0.0:
            raise InputError(
                "is that of horizontal positions, and there are none",
                parameter="across_sigma",
                value=self.across_sigma,
                way_out="give pivot_across, or leave it out",
            )
        check_increasing("times", times)
        object.__setattr__(self, "_pieces", self._fit())

    def _fit(self) -> list[Segment]:
        """Return the pieces of the splines as segments."""
        curves = [self._spline(self.pivot_heights, self.height_sigma, "heights")]
        if self.pivot_across is not None:
            across = self._spline(self.pivot_across, self.across_sigma, "horizontal positions")
            curves.append(across)
        # The last of these instants begins no piece.
        starts = sorted({instant for pieces in curves for instant in pieces.x.tolist()})[:-1]
        columns = zip(starts, *(_coefficients(pieces, starts) for pieces in curves), strict=True)
        return [
            Segment(start, POLYNOMIAL, 0.0, 0.0, 0.0, *(c for each in found for c in each))
            for start, *found in columns
        ]

    def _spline(self, values: Sequence[float], sigma: float, what: str) -> Any:
        """Return the spline through samples as polynomials (``PPoly``)."""
        from scipy.interpolate import PPoly, UnivariateSpline, make_interp_spline
        from scipy.linalg import LinAlgError

        try:
            if sigma > 0.0:
                weights = [1.0 / sigma] * len(self.times)
                smooth = UnivariateSpline(self.times, values, w=weights, k=5)
                pieces = PPoly.from_spline(smooth._eval_args)
            else:
                pieces = PPoly.from_spline(make_interp_spline(self.times, values, k=5))
            is_known = all(math.isfinite(c) for row in pieces.c.tolist() for c in row)
        except (ValueError, LinAlgError):  # of a singular matrix; which one depends on SciPy
            is_known = False
        if not is_known:
            raise InputError(
                f"leave too large a gap for a spline through the {what}",
                parameter="times",
                way_out="leave out the samples before or after the gap",
            )
        self._check_course(pieces, values, what)
        return pieces

    def _check_course(self, pieces: Any, values: Sequence[float], what: str) -> None:
        """Raise InputError if a spline goes where the samples give no reason to expect it."""
        low, high = min(values), max(values)
        gaps = list(pairwise(self.times))
        looks = [a + (b - a) * i / _LOOKS for a, b in gaps for i in range(1, _LOOKS)]
        beyond = [max(low - y, y - high) for y in pieces(looks).tolist()]
        worst = max(range(len(looks)), key=beyond.__getitem__)
        if beyond[worst] > _ROOM * (high - low) + _ROUNDING * max(-low, high):
            begin, end = gaps[worst // (_LOOKS - 1)]
            raise InputError(
                f"leave a gap from {begin:g} to {end:g} s in which the curve through the {what} "
                f"leaves their range by {beyond[worst]:.3g} m",
                parameter="times",
                way_out="leave out the samples before or after the gap",
            )

    def segments(self, duration: float) -> list[Segment]:
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

    def course(self) -> tuple[list[Segment], float]:
        """Return all pieces, and the last instant [s]."""
        return self._pieces, self.times[-1]


def _coefficients(pieces: Any, starts: Sequence[float]) -> list[list[float]]:
    """Return the coefficients of a spline about instants of its span, rising powers for each."""
    begins, rows = pieces.x.tolist(), pieces.c.T[:, ::-1].tolist()
    result = []
    for start in starts:
        place = bisect_right(begins, start) - 1
        c, s = list(rows[place]), start - begins[place]
        # Taylor's shift by Horner's rule, which changes nothing where a piece begins.
        for lowest in range(len(c) - 1):
            for k in range(len(c) - 2, lowest - 1, -1):
                c[k] += s * c[k + 1]
        result.append(c)
    return result
