"""The circle on which balls run about a pivot that may move: fitted to places in the picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from latolato.experiment.calibration.circle_fit import CircleFit, fit_circle

# Frequencies of a drive that are tried [Hz], finely enough for half a radian over the clip.
_SLOWEST, _FASTEST, _FINENESS = 0.3, 12.0, 8
_MOST_TRIALS, _POLISHED = 3000, 4
# Fewest places that make a circle, and a circle about a driven pivot.
_FEWEST, _FEWEST_DRIVEN = 12, 24
# How much smaller residuals must be for a pivot to be driven, or to the side too, and how sure its
# amplitude must be [standard deviations]; most frames that tell.
_BETTER, _SURE, _MOST = 0.5, 5.0, 800
# Distance beyond which places are mistakes [pixels].
_MISTAKEN = 1.0
# Least error of a place [pixels].
_LEAST = 0.15
# Distance from which one is another thing's, in typical ones.
_UNUSUAL = 6.0
# What angles may leave of distances from a pivot that is where it is taken to be: pixels, arm.
_LEFT, _LEFT_SHARE = 0.5, 0.002

# Returns how far off places are with a harmonic's best amplitudes, for its cosine and sine.
_Trial = Callable[[np.ndarray, np.ndarray], tuple[float, np.ndarray]]


@dataclass(frozen=True)
class DrivenCircle(CircleFit):
    """A circle about a pivot that moves as one harmonic; its centre is the pivot at the first time.

    `extra` holds the turns of the phase over the clip [rad], and the amplitudes of its cosine and
    sine downwards and to the right [pixels], of which the last two may be missing.

    Attributes
    ----------
    began, span : float
        The first time and how long after it the last one is [s].
    """

    began: float
    span: float

    @property
    def amplitude(self) -> float:
        """How far the pivot moves up and down from its middle [pixels]."""
        return math.hypot(*self.extra[1:3])

    @property
    def amplitude_sigma(self) -> float:
        """Standard deviation of that, of places with errors as large as the residual [pixels]."""
        along = self.extra[1:3] / self.amplitude
        return self.residual * math.sqrt(float(along @ self.spread[4:6, 4:6] @ along))

    @property
    def frequency(self) -> float:
        """How often it moves [Hz]."""
        return float(abs(self.extra[0])) / (math.tau * self.span)

    def pivots(self, times: np.ndarray) -> np.ndarray:
        """Return where the pivot is, shape (time, 2) [pixels]."""
        return np.asarray(self.centre + _shifts(self.extra, (times - self.began) / self.span))

    def unsure(self, times: np.ndarray) -> np.ndarray:
        """Return the deviations of its shifts, shape (time, 2) [pixels].

        They are those of places with errors as large as the residual, without the centre's.
        """
        share, step = (times - self.began) / self.span, 1e-4
        at = _shifts(self.extra, share)
        slopes = np.array(
            [
                (_shifts(self.extra + step * one, share) - at) / step
                for one in np.eye(len(self.extra))
            ]
        )
        variances = np.einsum("iab,ij,jab->ab", slopes, self.spread[3:, 3:], slopes)
        return np.asarray(max(self.residual, _LEAST) * np.sqrt(variances))


def _shifts(extra: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return how far a driven pivot is from where it is first at shares of its span, (time, 2)."""
    turns, *waves = extra
    phase = np.stack([np.cos(turns * share) - 1.0, np.sin(turns * share)], axis=-1)
    down = phase @ waves[:2]
    return np.stack([phase @ waves[2:] if waves[2:] else np.zeros_like(down), down], axis=-1)


def circle(places: list[np.ndarray], shifts: np.ndarray) -> CircleFit | None:
    """Return the circle of places about a pivot whose shifts are known, None for too few.

    Parameters
    ----------
    places : list of numpy.ndarray, shape (ball, 2)
        Centres of the balls at each time [pixels].
    shifts : numpy.ndarray, shape (time, 2)
        Of the pivot from where it is first [pixels].
    """
    points = np.concatenate([group - shifts[k] for k, group in enumerate(places)])
    if len(points) < _FEWEST:
        return None
    return fit_circle(lambda: points, 1.0, robust=_MISTAKEN)


def drive_of(times: np.ndarray, places: np.ndarray, pivot: np.ndarray) -> DrivenCircle | None:
    """Return the circle of balls about a driven pivot, None if they do not show one.

    Parameters
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    places : numpy.ndarray, shape (frame, ball, 2)
        Centres of balls [pixels], NaN where unknown.
    pivot : numpy.ndarray, shape (2,)
        Roughly where it is [pixels].

    Notes
    -----
    Its amplitude must be sure. An arm whose length varies, as of a rubber band, makes distances
    vary alike at all angles, a pivot that moves up and down by their cosine: where the first
    explains them far better it is no drive. It can miss that of small swings.
    """
    is_known = np.isfinite(places).all(axis=-1)
    some = np.flatnonzero(is_known.any(axis=1))
    # Uneven steps: even ones would make fast motions look like slower ones.
    some = some[(0.6180339887498949 * np.arange(len(some))) % 1.0 < _MOST / max(len(some), 1)]
    groups = [places[k][is_known[k]] for k in some]
    driven = driven_circle(groups, times[some], float(np.median(np.diff(times))), pivot)
    if driven is None or driven.amplitude <= _SURE * driven.amplitude_sigma:
        return None
    return None if _has_elastic_arm(driven, groups, times[some]) else driven


def rate_values(rate: float, times: np.ndarray) -> dict[str, float]:
    """Return a rate and that of frames at `times` [s], in which others look the same [Hz]."""
    return {"rate": rate, "frames": 1.0 / float(np.median(np.diff(times)))}


def _has_elastic_arm(driven: DrivenCircle, places: list[np.ndarray], times: np.ndarray) -> bool:
    """Return whether a length that varies as often explains places far better than a drive."""
    middle = driven.pivots(driven.began + np.linspace(0.0, driven.span, _MOST)).mean(axis=0)
    phase = math.tau * driven.frequency * np.repeat(times, [len(group) for group in places])
    trial = _distance_equation(np.concatenate(places) - middle, is_elastic=True)
    left, _ = trial(np.cos(phase), np.sin(phase))
    return 1.4826 * left < _BETTER * driven.residual


def driven_circle(
    places: list[np.ndarray], times: np.ndarray, interval: float, about: np.ndarray | None = None
) -> DrivenCircle | None:
    """Return the circle of places about a pivot that moves as one harmonic, None for too few.

    Parameters
    ----------
    places : list of numpy.ndarray, shape (ball, 2)
        Centres of the balls at each time [pixels].
    times : numpy.ndarray, shape (time,)
        Some of the times of frames [s].
    interval : float
        Between frames [s]: faster motions than one in two of them look like slower ones.
    about : numpy.ndarray, shape (2,), optional
        Roughly where the pivot is [pixels].

    Notes
    -----
    For each trial frequency, amplitudes follow from linear equations: of the distances from where
    the pivot roughly is, or of the circle with the pivot at ``v0 + p(t)``, which is linear in its
    place, its amplitudes and their products. The best ones are polished: noise makes the equations
    prefer others.
    """
    from scipy.signal import find_peaks

    count = [len(group) for group in places]
    if sum(count) < _FEWEST_DRIVEN:
        return None
    points = np.concatenate(places)
    t = np.repeat(times - times[0], count)
    span = max(float(t.max()), 1e-9)
    fastest = max(min(_FASTEST, 0.5 / interval), _SLOWEST)
    number = int(min(_FINENESS * span * (fastest - _SLOWEST), _MOST_TRIALS))
    rates = math.tau * np.linspace(_SLOWEST, fastest, max(number, 50))
    left, waves = np.empty(len(rates)), np.empty((len(rates), 2))
    trial = _circle_equation(points) if about is None else _distance_equation(points - about)
    for k, rate in enumerate(rates):
        left[k], waves[k] = trial(np.cos(rate * t), np.sin(rate * t))
    dips, _ = find_peaks(-left)

    def fitted(extra: Sequence[float]) -> CircleFit:
        return fit_circle(
            lambda *extra: points - _shifts(np.array(extra), t / span), 1.0,
            robust=_MISTAKEN, extra=extra,
        )  # fmt: skip

    fits = [fitted([rates[k] * span, *waves[k]]) for k in dips[np.argsort(left[dips])][:_POLISHED]]
    if not fits:
        return None
    best = min(fits, key=lambda fit: fit.residual)
    # To the side a pivot shows less, by the sine of the angle: it moves so if that explains much.
    planar = fitted([*best.extra, 0.0, 0.0])
    best = planar if planar.residual < _BETTER * best.residual else best
    return DrivenCircle(**vars(best), began=float(times[0]), span=span)


def _circle_equation(points: np.ndarray) -> _Trial:
    """Return the fit of a harmonic's amplitudes to points (place, 2) on a circle that moves."""
    middle, scale = points.mean(axis=0), max(float(np.std(points)), 1.0)
    u, v = ((points - middle) / scale).T
    squares, one = u * u + v * v, np.ones_like(u)

    def trial(cos: np.ndarray, sin: np.ndarray) -> tuple[float, np.ndarray]:
        columns = [u, v, one, v * cos, v * sin, cos, sin, cos * cos - sin * sin, cos * sin]
        left, solution = _solved(columns, squares)
        return left, 0.5 * scale * solution[3:5]

    return trial


def _distance_equation(away: np.ndarray, *, is_elastic: bool = False) -> _Trial:
    """Return the fit of a harmonic's amplitudes to distances of places (place, 2).

    It is of the height of the pivot, or if `is_elastic` of the arm's length.
    """
    off = np.hypot(*away.T)
    across, down = (away / np.maximum(off, 1e-9)[:, None]).T
    one = np.ones_like(off)
    along = one if is_elastic else down

    def trial(cos: np.ndarray, sin: np.ndarray) -> tuple[float, np.ndarray]:
        columns = [one, across, down, along * cos, along * sin]
        left, solution = _solved(columns, off)
        return left, solution[3:5]

    return trial


def _solved(columns: list[np.ndarray], values: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the median residual of a linear fit, and its solution."""
    design = np.column_stack(columns)
    solution = np.linalg.lstsq(design, values, rcond=None)[0]
    return float(np.median(np.abs(design @ solution - values))), solution


def unexplained(away: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Return what of the distances of places (place, 2) from a pivot their angles do not explain.

    A lens or an oblique view bends the path, as does a pivot that is not quite there; a ball that
    swings on an ellipse is off to one side on its way there, which its `speeds` (place,) tell
    [rad/s]. A pivot that moves makes distances depend on time [pixels].
    """
    angle, off = np.arctan2(away[:, 0], away[:, 1]), np.hypot(away[:, 0], away[:, 1])
    columns = [np.ones_like(angle), *(wave(k * angle) for k in (1, 2) for wave in (np.cos, np.sin))]
    plain, rest = np.column_stack([*columns, speeds]), off - np.median(off)
    for _ in range(3):  # a place that is another thing's bends nothing
        usual = np.abs(rest) <= _UNUSUAL * np.median(np.abs(rest))
        rest = off - plain @ np.linalg.lstsq(plain[usual], off[usual], rcond=None)[0]
    return np.asarray(rest)


def most_unexplained(arm: float) -> float:
    """Return how far distances may scatter about what angles explain [pixels].

    More is a motion of the pivot that is not known, or an error of the distances.
    """
    return max(_LEFT, _LEFT_SHARE * arm)


def better(still: CircleFit | None, driven: CircleFit | None) -> CircleFit | None:
    """Return the circle about a pivot at rest, unless one about a driven pivot fits far better."""
    if still is None or driven is None:
        return still or driven
    return driven if driven.residual < _BETTER * still.residual else still
