"""Bobs that are not discs: a patch around the click turns with the pendulum and is correlated.

Lewis, Vision Interface (1995) 120, for the coefficient; Baker and Matthews, Int. J. Comput. Vis. 56
(2004) 221, for its peak between pixels, with gain and bias free as in Evangelidis and Psarakis,
IEEE Trans. Pattern Anal. Mach. Intell. 30 (2008) 1858.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import map_coordinates, spline_filter

from latolato.experiment.tracking.appearance import BallFit, Colours

# Steps below this are the last, and longer ones than this share of the half width are cut [pixels].
_CONVERGED, _LONGEST = 0.005, 0.5
# First steps take residuals this much larger for what they are, to be drawn from farther away.
_TOLERANT = 4.0
# Brightness over that of the template that a bob may have: a plain wall is a template without any.
_DIMMEST, _BRIGHTEST = 0.6, 1.6
# Least share of the weight that must lie inside the picture.
_INSIDE = 0.5
# Share of the body that is explained where nothing hides it.
_WHOLE = 0.85
# Standard deviation of a coded value that is not below rounding, as a share of white.
_ROUNDING = 0.004


@dataclass
class Template:
    """A patch of the bob as it looks when it hangs straight down.

    Attributes
    ----------
    colours : Colours
        Turns coded planes into light.
    picture : numpy.ndarray, shape (row, column, 3)
        Root of the linear colours about the clicked point.
    variance : numpy.ndarray, shape (row, column)
        Mean square over the colours of what it does not explain; infinite where it is not compared.
    body : numpy.ndarray of bool, shape (row, column)
        Where it shows the bob, not the wall.
    limit : float
        Residual beyond which a pixel belongs to something else.
    radius, radius_sigma : float
        Half the bob's width across the rod, and its standard deviation [pixels].
    exposure : float
        Share of the frame interval in which light is collected: it is not learned, 0.
    is_spinning : bool
        Whether colours of a disc turn with the rod: not for a template, which always turns.
    """

    colours: Colours
    picture: np.ndarray
    variance: np.ndarray
    body: np.ndarray
    limit: float
    radius: float
    radius_sigma: float = 1.0
    exposure: float = 0.0
    is_spinning: bool = False
    weight: np.ndarray = field(init=False)
    offsets: np.ndarray = field(init=False)
    slopes: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.weighed()

    def weighed(self) -> None:
        """Bring weights and slopes into step with picture and variance."""
        self.weight = 1.0 / (self.variance + _ROUNDING**2)
        rows, columns = np.indices(self.weight.shape) - self.half
        self.offsets = np.stack([columns, rows], axis=-1).astype(float)
        self.slopes = np.stack(np.gradient(self.picture, axis=(1, 0)))

    @property
    def half(self) -> int:
        """Half the patch's side [pixels]."""
        return (int(self.picture.shape[0]) - 1) // 2

    def seen(self, planes: tuple[np.ndarray, ...], centre: np.ndarray, angle: float) -> np.ndarray:
        """Return the patch about a centre of a frame, turned back; NaN outside the picture."""
        window = _Window(self.colours, planes, centre, math.ceil(1.5 * self.half) + 3)
        return window.at(centre + _turned(self.offsets, angle))

    def fit(
        self,
        planes: tuple[np.ndarray, ...],
        paths: list[np.ndarray],
        pivot: np.ndarray,
        rounds: int = 6,
        tolerant: int = 1,
    ) -> BallFit:
        """Move bobs from where they are expected to the peak of their correlation.

        Parameters and result are those of `latolato.experiment.tracking.appearance.fit_balls`;
        each bob is fitted by itself, and it is not known how much of it looks like the wall.
        """
        fits = [self._settle(planes, path.mean(axis=0), pivot, rounds, tolerant) for path in paths]
        covariance = np.zeros((2 * len(paths), 2 * len(paths)))
        for b, (_, own, _, _) in enumerate(fits):
            covariance[2 * b : 2 * b + 2, 2 * b : 2 * b + 2] = own
        shifts, _, explained, costs = zip(*fits, strict=True)
        return BallFit(
            np.array(shifts), covariance, np.array(explained), np.zeros(len(paths)),
            float(np.mean(costs)),
        )  # fmt: skip

    def _settle(
        self,
        planes: tuple[np.ndarray, ...],
        start: np.ndarray,
        pivot: np.ndarray,
        rounds: int,
        tolerant: int,
    ) -> tuple[np.ndarray, np.ndarray, float, float]:
        """Return shift, covariance, share of the body explained, and cost (Gauss-Newton)."""
        reach = math.ceil((1.5 + _LONGEST) * self.half) + 3
        window, centre = _Window(self.colours, planes, start, reach), start.copy()
        used = self.weight > 0.0
        model, weight = self.picture[used], self.weight[used]
        slopes, offsets = self.slopes[:, used], self.offsets[used]
        # Gain, bias of each colour, and the shift across and along the rod.
        design = np.zeros((*model.shape, 6))
        design[..., 0] = model
        design[..., 1:4] = np.eye(3)
        design[..., 4:] = -np.moveaxis(slopes, 0, -1)
        design = design.reshape(-1, 6)
        for round_ in range(2 * rounds):
            angle = math.atan2(*(centre - pivot))
            limit = self.limit * (_TOLERANT if round_ < tolerant else 1.0)
            seen = window.at(centre + _turned(offsets, angle))
            is_inside = np.isfinite(seen[:, 0])
            if weight[is_inside].sum() < _INSIDE * weight.sum():
                return centre - start, np.eye(2) * self.radius**2, 0.0, math.inf
            seen = np.nan_to_num(seen)
            trust = np.where(is_inside, weight, 0.0)
            gain = 1.0
            for _ in range(2):  # weights follow residuals, residuals the gain
                rest = seen - gain * model
                rest -= trust @ rest / trust.sum()
                square = np.einsum("nc,nc->n", rest, rest) / 3.0
                robust = limit**2 / (limit**2 + square)
                trust = np.where(is_inside, weight, 0.0) * robust**2
                weighted = design * np.repeat(trust, 3)[:, None]
                matrix = weighted.T @ design + 1e-9 * np.eye(6)
                values = np.linalg.solve(matrix, weighted.T @ seen.ravel())
                gain = float(np.clip(values[0], _DIMMEST, _BRIGHTEST))
            step = values[4:] / gain
            longest = _LONGEST * self.radius
            step *= min(1.0, longest / max(float(np.hypot(*step)), 1e-12))
            if round_ == 2 * rounds - 1 or (np.hypot(*step) < _CONVERGED and round_ >= tolerant):
                break
            centre = centre + _turned(step, angle)
        turn = np.array([_turned(axis, angle) for axis in np.eye(2)]).T
        own = np.linalg.inv(matrix)[4:, 4:] / gain**2
        # Three colours from planes of which two are coarse: one residual a pixel.
        noise = 3.0 * max(1.0, float(np.average(square * weight, weights=robust)))
        body = self.body[used] & is_inside
        explained = float(np.mean(square[body] < self.limit**2)) if body.any() else 0.0
        cost = float(np.mean(square * weight * robust))
        # What hides a part of it draws it aside by as large a part of its width.
        drawn = self.radius * max(0.0, 1.0 - explained / _WHOLE)
        covariance = noise * turn @ own @ turn.T + np.eye(2) * drawn**2
        return centre - start, covariance, explained, cost


class _Window:
    """The part of a frame about a centre, in the root of linear colours, between its pixels."""

    def __init__(
        self,
        colours: Colours,
        planes: tuple[np.ndarray, ...],
        centre: np.ndarray,
        reach: int,
        order: int = 3,
    ) -> None:
        self.size = np.array(planes[0].shape[::-1])
        corner = np.maximum(np.rint(centre).astype(int) - reach, 0)
        beyond = np.minimum(np.rint(centre).astype(int) + reach + 1, self.size)
        self.corner, self.order = corner, order
        width, height = (int(n) for n in np.maximum(beyond - corner, 1))
        image = np.sqrt(np.nan_to_num(colours.window(planes, corner, (height, width))))
        self.planes = [
            spline_filter(image[..., c]) if order > 1 else image[..., c] for c in range(3)
        ]

    def at(self, places: np.ndarray) -> np.ndarray:
        """Return colours at places (..., 2) of column and row, NaN outside the picture."""
        u, v = np.moveaxis(places - self.corner, -1, 0)
        colours = np.stack(
            [
                map_coordinates(plane, (v, u), order=self.order, mode="nearest", prefilter=False)
                for plane in self.planes
            ],
            axis=-1,
        )
        outside = ((places < 0.0) | (places > self.size - 1.0)).any(axis=-1)
        colours[outside] = np.nan
        return colours


def _turned(offsets: np.ndarray, angle: float) -> np.ndarray:
    """Return offsets (..., 2) from the click, which hang straight down, turned to an angle."""
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y = offsets[..., 0], offsets[..., 1]
    return np.stack([x * cosine + y * sine, y * cosine - x * sine], axis=-1)
