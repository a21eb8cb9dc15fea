"""Free flights of balls about an instant: angle and angular velocity there from a few samples."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from latolato.experiment.fits.least_squares import Floats
from latolato.experiment.fits.samples import check_end
from latolato.physics.drives import Drive

# Samples that a flight needs.
FEWEST = 5
# A flight with so many times the usual sum of squares hides an impact.
ROUGH = 6.0
# Gives (g + y0'')/l at an instant [1/s^2].
Pull = Callable[[float], float]


def pull_of(drive: Drive, origin: float, gravity: float, length: float, last: float) -> Pull:
    """A function for (g + y0'')/l [1/s^2] at an instant of the table up to its `last` one [s].

    Raises
    ------
    InputError
        If the samples of the drive end before.
    """
    check_end(drive, origin, last)
    segments = drive.segments(last - origin)
    starts = [segment.start for segment in segments]
    acceleration = drive.acceleration

    def pull(instant: float) -> float:
        t = instant - origin
        place = max(bisect_right(starts, t) - 1, 0)
        return float((gravity + acceleration(t, segments[place])) / length)

    return pull


@dataclass(frozen=True)
class Flights:
    """The free flights of all balls on one side of an instant, fitted there.

    Attributes
    ----------
    states : ndarray, shape (ball, 2)
        Angle and angular velocity [rad, rad/s].
    covariances : ndarray, shape (ball, 2, 2)
        Of the states.
    errors : list of ndarray, shape (sample,)
        Of the samples of each ball, over their sigmas.
    slopes : ndarray, shape (error, 2)
        Derivatives of the errors once the states have adapted, by what all flights share: the drag
        and a factor of (g + y0'')/l.
    """

    states: Floats
    covariances: Floats
    errors: list[Floats]
    slopes: Floats

    @property
    def spread(self) -> float:
        """Largest reduced sum of squares of a ball."""
        return max(_spread(errors) for errors in self.errors)

    @property
    def separation(self) -> Floats:
        """Angle between the balls and its rate, or those of the one [rad, rad/s]."""
        between: Floats = self.states[0] - self.states[1:].sum(axis=0)
        return between

    @property
    def separation_sigma(self) -> Floats:
        """Standard deviations of the separation."""
        return np.sqrt(np.diag(self.covariances.sum(axis=0)))


def fit_flights(
    time: Floats,
    angles: Sequence[Floats],
    sigmas: Sequence[Floats],
    chosen: NDArray[np.int64],
    instant: float,
    pull: Pull,
    drag: float,
    widen: float = 1.0,
) -> Flights | None:
    """Return the flights of the chosen samples, carried to an instant; None for too few samples.

    `drag` is that of all flights [1/s], `widen` what correlated errors widen variances by.
    """
    if len(chosen) < FEWEST:
        return None
    # Outwards from the instant, either way.
    own = chosen[np.argsort(np.abs(time[chosen] - instant))]
    grid = time[own]
    pulls = _grid_pulls(instant, grid, pull)
    states, covariances, rests, left = [], [], [], []
    for angle, sigma in zip(angles, sigmas, strict=True):
        state, slopes, errors = _fit(instant, grid, angle[own], sigma[own], pulls, drag)
        inverse = np.linalg.inv(slopes[:, :2].T @ slopes[:, :2])
        rests.append(slopes[:, 2:] - slopes[:, :2] @ (inverse @ (slopes[:, :2].T @ slopes[:, 2:])))
        left.append(errors)
        states.append(state)
        # A few samples tell little of their own scatter.
        floor = 0.5 if len(grid) < 10 else 0.0
        covariances.append(inverse * widen * max(_spread(errors), floor))
    return Flights(np.array(states), np.array(covariances), left, np.vstack(rests))


def _spread(errors: Floats) -> float:
    """Return the reduced sum of squares about a flight."""
    return float(errors @ errors) / max(len(errors) - 2, 1)


def _fit(
    instant: float, grid: Floats, angle: Floats, sigma: Floats, pulls: Floats, drag: float
) -> tuple[Floats, Floats, Floats]:
    """Return the state of one ball's flight, its derivatives and its errors, both over sigmas.

    The derivatives are those for angle, angular velocity, drag and factor.
    """
    line = np.polyfit(grid - instant, angle, 2 if len(grid) > 5 else 1)
    state = np.array([line[-1], line[-2], drag, 1.0])
    steps = np.array([1e-5, 1e-4, 1e-3, 1e-3])
    for _ in range(2):
        trials = np.column_stack([state, *(state + np.diag(steps))])
        seen = _carried(instant, grid, trials, pulls)
        slopes = (seen[:, 1:] - seen[:, :1]) / steps / sigma[:, None]
        errors = (angle - seen[:, 0]) / sigma
        change, *_ = np.linalg.lstsq(slopes[:, :2], errors, rcond=None)
        state[:2] += change
    return state[:2], slopes, errors - slopes[:, :2] @ change


def _grid_pulls(instant: float, grid: Floats, pull: Pull) -> Floats:
    """Return (g + y0'')/l at the ends and the middle of each step outwards, shape (step, 3)."""
    ends = np.concatenate([[instant], grid])
    rows = [[pull(a), pull(0.5 * (a + b)), pull(b)] for a, b in pairwise(ends)]
    return np.array(rows)


def _carried(instant: float, grid: Floats, trials: Floats, pulls: Floats) -> Floats:
    """Return angles at instants, shape (instant, trial), by classical Runge-Kutta steps.

    A step is the time between two frames: its error is below 1e-6 rad.
    """
    angle, velocity, drag, factor = trials.copy()
    now = instant
    out = np.empty((len(grid), trials.shape[1]))
    for i, (then, (k0, k1, k2)) in enumerate(zip(grid, pulls, strict=True)):
        h = then - now

        def rate(th: Floats, w: Floats, k: float) -> Floats:
            bent: Floats = -k * factor * np.sin(th) - drag * w
            return bent

        a1 = rate(angle, velocity, k0)
        v2 = velocity + 0.5 * h * a1
        a2 = rate(angle + 0.5 * h * velocity, v2, k1)
        v3 = velocity + 0.5 * h * a2
        a3 = rate(angle + 0.5 * h * v2, v3, k1)
        v4 = velocity + h * a3
        a4 = rate(angle + h * v3, v4, k2)
        angle = angle + h / 6.0 * (velocity + 2.0 * v2 + 2.0 * v3 + v4)
        velocity = velocity + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        out[i], now = angle, then
    return out


def good_flights(flights: Sequence[Flights | None]) -> list[Flights]:
    """Return the flights that are pendulum motion, not several with an impact between them."""
    known = [flight for flight in flights if flight is not None]
    if not known:
        return []
    typical = float(np.median([flight.spread for flight in known]))
    return [flight for flight in known if flight.spread <= ROUGH * typical]


def widening_of(flights: Sequence[Flights]) -> float:
    """Return by how much correlated errors of neighbours widen variances of smooth curves."""
    errors = [each for flight in flights for each in flight.errors]
    squares = np.array([float(e @ e) * (len(e) - 1) / len(e) for e in errors])
    if not squares.any():
        return 1.0
    seen = sum(float(e[1:] @ e[:-1]) for e in errors) / float(squares.sum())
    # A line fitted to n samples takes (2 + 4 rho)/n off the correlation (Kendall 1954).
    count = max(float(np.average([len(e) for e in errors], weights=squares)), 8.0)
    correlation = min(max((seen + 2.0 / count) / (1.0 - 4.0 / count), 0.0), 0.95)
    return (1.0 + correlation) / (1.0 - correlation)


def shared_changes(flights: Sequence[Flights], count: int) -> tuple[Floats, Floats]:
    """Return by how much all flights ask to change what they share, and the deviations of that.

    The first is the drag [1/s], the second, with a `count` of 2, the factor of (g + y0'')/l. This
    is 1 if length, clock and the scale of the angles are right. Without flights nothing changes.
    """
    slopes = np.vstack([np.empty((0, 2)), *(flight.slopes for flight in flights)])[:, :count]
    curvature = slopes.T @ slopes
    if not np.linalg.det(curvature) > 0.0:
        return np.zeros(count), np.zeros(count)
    inverse = np.linalg.inv(curvature)
    spread = float(np.median([flight.spread for flight in flights]))
    errors = np.concatenate([each for flight in flights for each in flight.errors])
    return inverse @ (slopes.T @ errors), np.sqrt(spread * widening_of(flights) * np.diag(inverse))
