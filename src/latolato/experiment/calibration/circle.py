"""The circle on which balls move about a pivot at rest that the picture does not show."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from latolato.core.errors import Sentence
from latolato.experiment.calibration.circle_fit import CircleFit, fit_circle
from latolato.experiment.calibration.deviations import scatter_of
from latolato.experiment.calibration.hinge import UNROUND, sigma_of_pivot
from latolato.experiment.calibration.lens import UNKNOWN_LENS, undistorted
from latolato.experiment.calibration.orbit import (
    drive_of,
    most_unexplained,
    rate_values,
    unexplained,
)
from latolato.experiment.rules import place_text, said

# Fewest places that make a circle, and the distance from which one is a mistake of the tracker
# [standard deviations].
_FEWEST, _MISTAKEN = 20, 4.0
# Pieces of the clip whose errors count as independent.
_PIECES = 12
# How far off the arc's centre a declared place may be [standard deviations].
_AGREES = 4.0
# Relative error of the arm from which a path is too straight.
_STRAIGHT = 1.0 / 3.0
# Largest residual of a circle: pixels, share of the arm.
_ROUND, _ROUND_SHARE = 3.0, 0.02
# By how much a motion of the pivot must lessen what angles leave of the distances.
_BETTER = 0.5
# By which factor the scatter that a moving pivot leaves may exceed that from frame to frame.
_NOISY = 1.5


@dataclass(frozen=True)
class Circle:
    """A circle fitted to places in the picture.

    Attributes
    ----------
    centre : numpy.ndarray, shape (2,)
        The pivot, column and row [pixels].
    arm : float
        Radius of the circle [pixels].
    covariance : numpy.ndarray, shape (3, 3)
        Of column, row and arm [pixels^2].
    residual : float
        Robust standard deviation of the distances from it [pixels].
    is_declared : bool
        Whether it uses a position that the user declared.
    warnings : list of Sentence
        What the user should know.
    """

    centre: np.ndarray
    arm: float
    covariance: np.ndarray
    residual: float
    is_declared: bool = False
    warnings: list[Sentence] = field(default_factory=list)

    @property
    def scale_sigma(self) -> float:
        """Relative standard deviation of the arm, and so of all angles."""
        return math.sqrt(float(self.covariance[2, 2])) / self.arm


def unseen_circle(
    places: np.ndarray, size: tuple[int, int], *, declared: np.ndarray | None, has_lens: bool
) -> Circle | None:
    """Return the circle of places about a pivot at rest, None for too few.

    Parameters
    ----------
    places : numpy.ndarray, shape (frame, ball, 2)
        Where balls are without the lens's distortion [pixels], NaN where unknown.
    size : tuple of int
        Width and height of the picture [pixels].
    declared : numpy.ndarray, shape (2,), or None
        Where the pivot is according to the user: to 2 % of the arm, unless the arc says otherwise.
    has_lens : bool
        Whether the lens was declared.

    Notes
    -----
    The covariance includes what is seen: the scatter of the distances, or the differences between
    the arms of 12 pieces of the clip if these are larger. It also includes what no scatter shows:
    0.15 pixels that all samples share, and a lens of ``k1 = 0.01`` if none is declared.
    """
    known = np.isfinite(places).all(axis=-1)
    frames, _ = np.nonzero(known)
    points = places[known]
    if len(points) < _FEWEST:
        return None
    fit = fit_circle(lambda: points, 1.0)
    for _ in range(3):
        off = fit.bow.distances(points)
        keep = np.abs(off) <= _MISTAKEN * max(1.4826 * float(np.median(np.abs(off))), 1e-3)
        fit = fit_circle(lambda keep=keep: points[keep], 1.0)
    kept = points[keep]
    sigma = _shared_sigma(fit, frames[keep] * _PIECES // len(places))
    bent = np.zeros_like(kept) if has_lens else undistorted(kept, size, UNKNOWN_LENS) - kept
    fit = fit_circle(lambda: kept, sigma, bent=bent)
    warnings, is_declared = [], False
    if declared is not None:
        about = fit.bow.about(declared)
        arm = float(about.circle[2])
        error = sigma_of_pivot(arm, is_clicked=False)
        # Directions and curvatures have errors that are alike on both sides; far centres have not.
        apart = (about.shape - fit.bow.shape)[1:]
        both = fit.spread[1:, 1:] + np.diag([1.0, about.shape[2]]) ** 2 * (error / arm) ** 2
        is_declared = bool(apart @ np.linalg.solve(both, apart) <= _AGREES**2)
        if is_declared:
            fit = fit_circle(lambda: kept, sigma, bent=bent, belief=(declared, error))
        else:
            centre, away = fit.centre, np.sqrt(np.diag(fit.covariance))
            warnings = [
                said(
                    "declared_pivot", declared=place_text(declared), centre=place_text(centre),
                    away=place_text(away[:2]),
                )
            ]  # fmt: skip
    return Circle(fit.centre, fit.arm, fit.covariance, fit.residual, is_declared, warnings)


def _shared_sigma(fit: CircleFit, piece: np.ndarray) -> float:
    """Return the error of one place [pixels] with which a fit to all has the right covariance.

    Errors of neighbours go together: the curvatures of pieces of the clip differ by more than the
    scatter inside each explains. Of `UNROUND` all places together are worth one.
    """
    bends = np.linalg.pinv(fit.slopes)[2]
    plain = float(np.mean(fit.distances**2))
    said = np.bincount(piece, bends * fit.distances, minlength=_PIECES)
    factor = float(said @ said) * _PIECES / (_PIECES - 3) / max(plain * float(bends @ bends), 1e-30)
    return math.sqrt(max(factor, 1.0) * plain + len(piece) * UNROUND**2)


def doubt_about(times: np.ndarray, places: np.ndarray, circle: Circle | None) -> Sentence | None:
    """Return why a circle does not show a pivot at rest, None if it does.

    Parameters
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    places : numpy.ndarray, shape (frame, ball, 2)
        Where balls are [pixels], NaN where unknown.
    circle : Circle or None
        What was fitted to them.

    Notes
    -----
    A pivot that moves outside the picture shows in distances from the circle that depend on time
    instead of position and speed; one harmonic of the pivot's motion describes them. What it does
    not describe, as where a string goes slack or a hand holds the ball, is no circle. It can miss a
    motion locked to the swing at exactly twice its frequency, which bends the path like a
    different arm.
    """
    if circle is None:
        return said("rarely_seen")
    if circle.scale_sigma > _STRAIGHT:
        least = circle.arm / (1.0 + 2.0 * circle.scale_sigma)
        return said("straight_path", pixels=f"{least:.0f}")
    for ball in range(places.shape[1]):
        doubt = _doubt_of_rest(times, places[:, ball], circle)
        if doubt is not None:
            return doubt
    if circle.residual > max(_ROUND, _ROUND_SHARE * circle.arm):
        return said("no_circle", pixels=f"{circle.residual:.1f}")
    return None


def _doubt_of_rest(times: np.ndarray, places: np.ndarray, circle: Circle) -> Sentence | None:
    """Return how distances of places (frame, 2) from a circle's centre depend on time.

    None if its pivot rests.
    """
    ok = np.flatnonzero(np.isfinite(places).all(axis=1))
    if len(ok) < _FEWEST:
        return None
    times, away = times[ok], places[ok] - circle.centre
    angle = np.unwrap(np.arctan2(away[:, 0], away[:, 1]))
    rest = unexplained(away, np.gradient(angle, times))
    scatter = 1.4826 * float(np.median(np.abs(rest)))
    still = most_unexplained(circle.arm)
    if scatter <= still:
        return None
    noise = scatter_of(times, np.hypot(*away.T))
    is_usual = (np.abs(rest) <= _MISTAKEN * scatter)[:, None]
    driven = drive_of(times, np.where(is_usual, places[ok], np.nan)[:, None], circle.centre)
    if driven is None or driven.residual > _BETTER * scatter:
        return None
    if driven.residual > np.fmax(still, _NOISY * noise):
        return said("no_circle", pixels=f"{circle.residual:.1f}")
    pixels = f"{driven.amplitude:.1f}"
    return said("outside_pivot_moves", pixels=pixels, **rate_values(driven.frequency, times))
