"""The circle on which balls move about a pivot at rest that the picture does not show."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from latolato.experiment.calibration.hinge import CLICK, UNROUND
from latolato.experiment.calibration.lens import UNKNOWN_LENS, undistorted

# Fewest places that make a circle, and the distance from which one is a mistake of the tracker
# [standard deviations].
_FEWEST, _MISTAKEN = 20, 4.0
# Pieces of the clip whose errors count as independent.
_PIECES = 12
# Error of a declared place outside the picture, as a share of the arm, and how far off the arc's
# centre it may be [standard deviations].
_DECLARED, _AGREES = 0.02, 4.0
# Relative error of the arm from which a path is too straight.
_STRAIGHT = 1.0 / 3.0
# Largest residual of a circle: pixels, share of the arm.
_ROUND, _ROUND_SHARE = 3.0, 0.02
# Residual from which a pivot may move [pixels, arm], by how much that must lessen it, and how sure
# its amplitude must be [standard deviations].
_STILL, _STILL_SHARE, _BETTER, _SURE = 0.5, 0.002, 0.5, 5.0
# Frequencies of a pivot's motion that are tried [Hz], how finely over the clip, and most places.
_SLOWEST, _FASTEST, _FINENESS, _MOST = 0.3, 12.0, 8, 800


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
    warnings : list of str
        What the user should know.
    """

    centre: np.ndarray
    arm: float
    covariance: np.ndarray
    residual: float
    is_declared: bool = False
    warnings: list[str] = field(default_factory=list)

    @property
    def scale_sigma(self) -> float:
        """Relative standard deviation of the arm, and so of all angles."""
        return math.sqrt(float(self.covariance[2, 2])) / self.arm


def fit_circle(
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
    bow = _Bow.through(points)
    keep = np.ones(len(points), bool)
    for _ in range(3):
        bow = bow.fitted(points[keep], 1.0)[0]
        off = bow.distances(points)
        keep = np.abs(off) <= _MISTAKEN * max(1.4826 * float(np.median(np.abs(off))), 1e-3)
    points = points[keep]
    sigma = _shared_sigma(bow, points, frames[keep] * _PIECES // len(places))
    bent = np.zeros_like(points) if has_lens else undistorted(points, size, UNKNOWN_LENS) - points
    bow, spread = bow.fitted(points, sigma, bent)
    warnings, is_declared = [], False
    if declared is not None:
        about = bow.about(declared)
        error = math.hypot(CLICK, _DECLARED * about.centre[2])
        # Directions and curvatures have errors that are alike on both sides; far centres have not.
        apart = (about.shape - bow.shape)[1:]
        both = spread[1:, 1:] + np.diag([1.0, about.shape[2]]) ** 2 * (error / about.centre[2]) ** 2
        is_declared = bool(apart @ np.linalg.solve(both, apart) <= _AGREES**2)
        if is_declared:
            bow, spread = about.fitted(points, sigma, bent, (declared, error))
        else:
            centre, away = bow.centre, np.sqrt(np.diag(bow.covariance(spread)))
            warnings = [
                f"the pivot declared at ({declared[0]:.0f}, {declared[1]:.0f}) is not the centre "
                f"of the ball's arc, ({centre[0]:.0f}, {centre[1]:.0f}) give or take "
                f"({away[0]:.0f}, {away[1]:.0f}) pixels, which is used instead"
            ]
    residual = 1.4826 * float(np.median(np.abs(bow.distances(points))))
    *place, arm = bow.centre
    covariance = bow.covariance(spread)
    return Circle(np.array(place), arm, covariance, residual, is_declared, warnings)


@dataclass(frozen=True)
class _Bow:
    """A circle by a point on it, its direction there, and its curvature: all finite if straight.

    Attributes
    ----------
    origin, outwards : numpy.ndarray, shape (2,)
        A place near the path [pixels], and a unit vector across it.
    unit : float
        Extent of the path [pixels].
    shape : numpy.ndarray, shape (3,)
        How far the path is outside the origin [unit], its turn from the direction of `outwards`
        [rad], and its curvature towards the other side [1/unit].
    """

    origin: np.ndarray
    outwards: np.ndarray
    unit: float
    shape: np.ndarray

    @classmethod
    def through(cls, points: np.ndarray) -> _Bow:
        """Return roughly the circle of places."""
        middle = points.mean(axis=0)
        away = points - middle
        # x^2 + y^2 = 2 a x + 2 b y + c is linear.
        columns = np.column_stack([2.0 * away, np.ones(len(away))])
        a, b, c = np.linalg.lstsq(columns, (away**2).sum(axis=1), rcond=None)[0]
        distance = max(math.hypot(a, b), 1e-6)
        arm = math.sqrt(max(c + a * a + b * b, 1.0))
        unit = max(float(np.hypot(*np.ptp(away, axis=0))), 1.0)
        shape = np.array([(arm - distance) / unit, 0.0, unit / arm])
        return cls(middle, np.array([-a, -b]) / distance, unit, shape)

    def about(self, centre: np.ndarray) -> _Bow:
        """Return the circle about a centre through the origin."""
        away = self.origin - centre
        across = _turned(self.outwards, 0.5 * math.pi)
        turn = math.atan2(float(away @ across), float(away @ self.outwards))
        bend = self.unit / max(float(np.hypot(*away)), 1e-9)
        return replace(self, shape=np.array([0.0, turn, bend]))

    @property
    def centre(self) -> tuple[float, float, float]:
        """Column, row and radius [pixels]."""
        height, turn, bend = self.shape
        bend = bend or 1e-12
        place = self.unit * (height * self.outwards - _turned(self.outwards, turn) / bend)
        return *(self.origin + place).tolist(), self.unit / abs(bend)

    def covariance(self, spread: np.ndarray) -> np.ndarray:
        """Return the covariance of column, row and radius [pixels^2] from that of the shape."""
        _, turn, bend = self.shape
        bend = bend or 1e-12
        outwards, across = _turned(self.outwards, turn), _turned(self.outwards, turn + math.pi / 2)
        slopes = self.unit * np.column_stack(
            [self.outwards, -across / bend, outwards / bend**2],
        )
        slopes = np.vstack([slopes, [0.0, 0.0, -self.unit * math.copysign(1.0, bend) / bend**2]])
        return np.asarray(slopes @ spread @ slopes.T)

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Return how far places are outside the circle [pixels]."""
        height, turn, bend = self.shape
        outwards = _turned(self.outwards, turn)
        away = (points - self.origin) / self.unit - height * self.outwards
        inside = -(away @ outwards) - 0.5 * bend * np.sum(away**2, axis=1)
        root = np.sqrt(np.maximum(1.0 - 2.0 * bend * inside, 0.0))
        return np.asarray(-2.0 * self.unit * inside / (1.0 + root))

    def slopes(self, points: np.ndarray) -> np.ndarray:
        """Return the derivatives of the distances by the shape, shape (place, 3)."""
        steps = 1e-6 * np.eye(3)
        up, down = (
            [replace(self, shape=self.shape + sign * step).distances(points) for step in steps]
            for sign in (1.0, -1.0)
        )
        return np.asarray((np.array(up) - np.array(down)).T / 2e-6)

    def fitted(
        self,
        points: np.ndarray,
        sigma: float,
        bent: np.ndarray | None = None,
        belief: tuple[np.ndarray, float] | None = None,
    ) -> tuple[_Bow, np.ndarray]:
        """Return the circle of places and the covariance of its shape.

        Parameters
        ----------
        points : numpy.ndarray, shape (place, 2)
            The places [pixels].
        sigma : float
            Error of one of them [pixels].
        bent : numpy.ndarray, shape (place, 2), optional
            An error of all of them by one and the same number with a standard deviation of 1.
        belief : tuple of numpy.ndarray, shape (2,), and float, optional
            Where the centre is beforehand, and the error of that [pixels].
        """
        from scipy.optimize import least_squares

        def rest(shape: np.ndarray) -> np.ndarray:
            bow = replace(self, shape=shape)
            off = bow.distances(points) / sigma
            if belief is None:
                return off
            return np.append(off, (bow.centre[:2] - belief[0]) / belief[1])

        fit = least_squares(rest, self.shape, x_scale="jac", max_nfev=100)
        found, spread = replace(self, shape=fit.x), np.linalg.pinv(fit.jac.T @ fit.jac)
        if bent is not None:
            change = (found.distances(points + bent) - found.distances(points)) / sigma
            shift = spread @ (fit.jac[: len(points)].T @ change)
            spread = spread + np.outer(shift, shift)
        return found, spread


def _turned(vector: np.ndarray, angle: float) -> np.ndarray:
    """Return a vector turned by an angle [rad]."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


def _shared_sigma(bow: _Bow, points: np.ndarray, piece: np.ndarray) -> float:
    """Return the error of one place [pixels] with which a fit to all has the right covariance.

    Errors of neighbours go together: the curvatures of pieces of the clip differ by more than the
    scatter inside each explains. Of `UNROUND` all places together are worth one.
    """
    off, slopes = bow.distances(points), bow.slopes(points)
    bends = np.linalg.pinv(slopes)[2]
    plain = float(np.mean(off**2))
    said = np.bincount(piece, bends * off, minlength=_PIECES)
    factor = float(said @ said) * _PIECES / (_PIECES - 3) / max(plain * float(bends @ bends), 1e-30)
    return math.sqrt(max(factor, 1.0) * plain + len(points) * UNROUND**2)


def doubt_about(times: np.ndarray, places: np.ndarray, circle: Circle | None) -> str | None:
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
    instead of position and speed; one harmonic of the pivot's motion describes them. It can miss
    a motion locked to the swing at exactly twice its frequency, which bends the path like a
    different arm.
    """
    if circle is None:
        return "the ball was seen too rarely to locate its pivot"
    if circle.scale_sigma > _STRAIGHT:
        least = circle.arm / (1.0 + 2.0 * circle.scale_sigma)
        return (
            "the path is too straight to locate the pivot: it is more than about "
            f"{least:.0f} pixels from the ball"
        )
    for ball in range(places.shape[1]):
        moves = _pivot_motion(times, places[:, ball] - circle.centre, circle.arm)
        if moves is not None:
            return (
                f"the pivot seems to move outside the picture, by {moves[0]:.1f} pixels at "
                f"{moves[1]:.2g} Hz"
            )
    if circle.residual > max(_ROUND, _ROUND_SHARE * circle.arm):
        return (
            f"the path is not a circle about one pivot: it is {circle.residual:.1f} pixels off the "
            "best fit"
        )
    return None


def _pivot_motion(times: np.ndarray, away: np.ndarray, arm: float) -> tuple[float, float] | None:
    """Return amplitude [pixels] and frequency [Hz] of a pivot's motion, None if it rests.

    `away` (frame, 2) is where one ball is from the centre of its circle.
    """
    ok = np.flatnonzero(np.isfinite(away).all(axis=1))
    if len(ok) < _FEWEST:
        return None
    times, away = times[ok] - times[ok[0]], away[ok]
    angle = np.unwrap(np.arctan2(away[:, 0], away[:, 1]))
    off = np.hypot(away[:, 0], away[:, 1]) - arm
    turn = (angle - angle.mean()) / max(float(np.ptp(angle)), 1e-9)
    # A lens bends the path; a ball that swings on an ellipse is off to one side on its way there.
    plain = np.column_stack([turn**k for k in range(5)] + [np.gradient(turn, times)])
    rest = off - plain @ np.linalg.lstsq(plain, off, rcond=None)[0]
    scatter = 1.4826 * float(np.median(np.abs(rest)))
    if scatter <= max(_STILL, _STILL_SHARE * arm):
        return None
    # Uneven steps, or frequencies beyond that of the steps would look like lower ones.
    chosen = np.flatnonzero(np.abs(rest) <= _MISTAKEN * scatter)
    chosen = chosen[(0.6180339887498949 * np.arange(len(chosen))) % 1.0 < _MOST / len(chosen)]
    times, off, plain = times[chosen], off[chosen], plain[chosen]
    sine, cosine = np.sin(angle[chosen]), np.cos(angle[chosen])
    fastest = min(_FASTEST, 0.5 / float(np.median(np.diff(times))))
    count = math.ceil(_FINENESS * float(times[-1]) * max(fastest - _SLOWEST, 0.0)) + 2
    best: tuple[float, float, np.ndarray, np.ndarray] | None = None
    for frequency in np.linspace(_SLOWEST, fastest, count):
        phase = math.tau * frequency * times
        waves = np.column_stack(
            [plain, cosine * np.cos(phase), cosine * np.sin(phase), sine * np.cos(phase),
             sine * np.sin(phase)]
        )  # fmt: skip
        solution = np.linalg.lstsq(waves, off, rcond=None)[0]
        left = float(np.sum((off - waves @ solution) ** 2))
        if best is None or left < best[0]:
            best = left, float(frequency), solution, waves
    assert best is not None
    left, frequency, solution, waves = best
    spread = np.linalg.pinv(waves.T @ waves) * left / max(len(off) - waves.shape[1], 1)
    amplitude = float(np.linalg.norm(solution[-4:]))
    sigma = math.sqrt(float(np.trace(spread[-4:, -4:])))
    after = 1.4826 * float(np.median(np.abs(off - waves @ solution)))
    if amplitude < _SURE * sigma or after > _BETTER * scatter:
        return None
    return amplitude, frequency
