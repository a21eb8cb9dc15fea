"""What the balls of a clip turn about: a pivot at rest or driven, and how obliquely it is seen."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from latolato.experiment.calibration.hinge import sigma_of_pivot
from latolato.experiment.calibration.lens import Optics, distorted, undistorted
from latolato.experiment.calibration.orbit import (
    DrivenCircle,
    drive_of,
    most_unexplained,
    unexplained,
)
from latolato.experiment.calibration.tilt import Tilt, fit_tilt
from latolato.experiment.tracking.pivot import PivotTracker, Strings, learn_pivot
from latolato.experiment.tracking.route import Route
from latolato.experiment.tracking.sample import Sample

# Fewest places that tell whether a pivot rests, and how much less distances from it must then vary.
_FEWEST, _CLEARER = 12, 0.7
# Way of a pivot to the side that makes distances vary by as much as its product with the sine of a
# ball's angle varies, how much distances vary by accident [pixels], and the least of these sines.
_SWAYS, _UNSURE, _LEAST_SINE = 5.0, 0.1, 1e-3
# Share of what angles leave of the distances from a pivot in the picture that one harmonic may
# leave for the picture not to show the pivot; how far off where it was taken to be that may be
# [standard deviations]. Share of the most that angles may leave up to which the picture is
# believed, and share of the way by which the pivot in the picture may move otherwise than the balls
# say and still be that pivot.
_BETTER, _AGREES, _CLOSE, _SAME = 0.5, 4.0, 0.5, 0.15
# By how much distances from the pivot must vary to make an oval of a circle [radii].
_OVAL = 0.4


@dataclass
class Geometry:
    """The pivot in the frames of a sample, and the oval on which balls are seen about it.

    Attributes
    ----------
    tracker : PivotTracker
        Follows the pivot.
    shifts : numpy.ndarray, shape (frame, 2)
        How far it is from where it is first, in the frames of the sample [pixels].
    tilt : Tilt
        How obliquely the camera looks at the swing.
    driven : DrivenCircle or None
        How it moves by the paths of the balls, if the picture does not show it.
    """

    tracker: PivotTracker
    shifts: np.ndarray
    tilt: Tilt = field(default_factory=Tilt)
    driven: DrivenCircle | None = None

    @classmethod
    def at_rest(cls, place: np.ndarray, count: int) -> Geometry:
        """Return that of a pivot that rests in all frames of a sample and is not looked for."""
        return cls(PivotTracker.unseen(place), np.zeros((count, 2)))

    @property
    def pivots(self) -> np.ndarray:
        """Where the pivot is in the frames of the sample, shape (frame, 2) [pixels]."""
        return self.tracker.place(self.shifts)

    def arm(self, places: list[np.ndarray]) -> float:
        """Return the mean distance of places (2,) in the first frame from the pivot [pixels]."""
        pivot = self.pivots[0]
        return float(np.mean([np.hypot(*self.tilt.flat(place - pivot)) for place in places]))


def fit_geometry(
    sample: Sample,
    pivot: np.ndarray,
    balls: list[np.ndarray],
    route: Route,
    size: tuple[int, int],
    optics: Optics,
) -> Geometry:
    """Return whether the pivot rests, where it is in the sample, and how obliquely it is seen.

    Parameters
    ----------
    sample : Sample
        The frames to look at.
    pivot : numpy.ndarray, shape (2,)
        Where it is pointed at, in the first of them [pixels].
    balls : list of numpy.ndarray, shape (2,)
        Centre of each ball there [pixels].
    route : Route
        Where the balls roughly are in all frames.
    size : tuple of int
        Width and height of the picture [pixels].
    optics : Optics
        What is declared of the camera.

    Notes
    -----
    Balls keep their distance from the pivot: that tells whether it rests and what moves is
    something else. A pivot that sways makes them vary by the product of its way and the sine of a
    ball's angle, which limits how far to the side it may move. Where nothing shows the pivot, one
    harmonic of it keeps the distances, and the picture does not.
    """
    shown = _shown_geometry(sample, pivot, balls, route, size, optics)
    return _unseen_drive(shown, sample, pivot, route, size, optics) or shown


def _shown_geometry(
    sample: Sample,
    pivot: np.ndarray,
    balls: list[np.ndarray],
    route: Route,
    size: tuple[int, int],
    optics: Optics,
) -> Geometry:
    """Return the geometry as the picture shows it."""
    frames = sample.from_click
    in_sample, shown_in = route.seen_in(frames)
    resting = Geometry.at_rest(pivot, len(frames))
    own, at = route.places[route.is_seen], np.broadcast_to(pivot, (int(route.is_seen.sum()), 2))
    resting.tilt = _oval(own, at, route.radius, size, optics)
    arm = resting.arm(balls)
    shown = np.concatenate([balls, in_sample])
    about_click = _spread(np.hypot(*resting.tilt.flat(shown - pivot).T))
    strings = Strings.between(pivot, shown, route.radius)
    sines = max(_spread(strings.directions[:, 0]), _LEAST_SINE)
    aside = _SWAYS * (about_click + _UNSURE) / sines
    tracker, shifts = learn_pivot(frames, sample.medians[0], pivot, arm, aside, strings)
    if tracker.is_still:
        return Geometry(tracker, shifts, resting.tilt)
    moving = Geometry(tracker, shifts)
    at = moving.pivots[shown_in]
    moving.tilt = _oval(in_sample, at, route.radius, size, optics)
    varies = _spread(np.hypot(*moving.tilt.flat(in_sample - at).T))
    if len(in_sample) >= _FEWEST and varies > _UNSURE and about_click < _CLEARER * varies:
        return resting
    return moving


def _unseen_drive(
    shown: Geometry,
    sample: Sample,
    pivot: np.ndarray,
    route: Route,
    size: tuple[int, int],
    optics: Optics,
) -> Geometry | None:
    """Return the geometry of a pivot that moves as the balls tell, None if the picture shows it."""
    frames = sample.from_click
    in_sample, shown_in = route.seen_in(frames)
    if len(in_sample) < _FEWEST:
        return None
    numbers = [frame.number for frame in frames if 0 <= frame.number < len(route.times)]
    seen, at = (undistorted(each, size, optics) for each in (in_sample, shown.pivots[shown_in]))
    away = shown.tilt.flat(seen - at)
    paces = np.nan_to_num(route.velocities[0][numbers][route.is_seen[numbers]])
    speeds = (paces[:, 0] * away[:, 1] - paces[:, 1] * away[:, 0]) / np.sum(away**2, axis=1)
    left = 1.4826 * float(np.median(np.abs(unexplained(away, speeds))))
    if left <= _CLOSE * most_unexplained(float(np.median(np.hypot(*away.T)))):
        return None
    click = undistorted(np.asarray(pivot, float), size, optics)
    places = undistorted(route.places, size, optics)
    driven = drive_of(route.times, np.where(route.is_seen[..., None], places, np.nan), click)
    if driven is None or driven.residual > _BETTER * left:
        return None
    last = len(route.times)
    times = np.array([route.times[f.number] if 0 <= f.number < last else f.time for f in frames])
    apart = float(np.hypot(*(driven.pivots(times[:1])[0] - click)))
    if apart > _AGREES * sigma_of_pivot(driven.arm, is_clicked=False):
        return None
    tracker = PivotTracker.unseen(
        np.asarray(pivot, float), lambda times: distorted(driven.pivots(times), size, optics)
    )
    told = tracker.place_at(times) - tracker.origin
    if not shown.tracker.is_still:  # its distances may vary because of a shutter or a lens
        own, way = (each - np.median(each, axis=0) for each in (shown.shifts, told))
        differ, goes = (float(np.median(np.hypot(*each.T))) for each in (own - way, way))
        if differ < _SAME * goes:
            return None
    return Geometry(tracker, told, driven=driven)


def _oval(
    places: np.ndarray, pivots: np.ndarray, radius: float, size: tuple[int, int], optics: Optics
) -> Tilt:
    """Return how obliquely the camera looks if balls (place, 2) run on an oval about a pivot."""
    places, pivots = (undistorted(each, size, optics) for each in (places, pivots))
    distances = np.hypot(*(places - pivots).T)
    if len(places) < _FEWEST or np.ptp(np.quantile(distances, [0.05, 0.95])) < _OVAL * radius:
        return Tilt()
    return fit_tilt(places, pivots, size=size) or Tilt()


def _spread(values: np.ndarray) -> float:
    """Return how far values typically are from their median."""
    return float(np.median(np.abs(values - np.median(values))))
