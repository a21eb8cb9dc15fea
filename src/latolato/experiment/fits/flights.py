"""Free flights of balls about an instant: angle and angular velocity there from a few samples."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.experiment.fits.least_squares import Floats
from latolato.physics.drives import Drive

# Samples that a flight needs.
FEWEST = 5
# A flight with so many times the usual sum of squares hides an impact.
ROUGH = 6.0
# Gives (g + y0'')/l at an instant [1/s^2].
Pull = Callable[[float], float]


def pull_of(drive: Drive, origin: float, gravity: float, length: float) -> Pull:
    """A function for (g + y0'')/l [1/s^2] at an instant of the table [s]."""
    segments = drive.segments(_end_of(drive))
    starts = [segment.start for segment in segments]
    acceleration = drive.acceleration

    def pull(instant: float) -> float:
        t = instant - origin
        place = max(bisect_right(starts, t) - 1, 0)
        return float((gravity + acceleration(t, segments[place])) / length)

    return pull


def _end_of(drive: Any) -> float:
    """Return an instant up to which all segments of a drive are known [s]."""
    times = getattr(drive, "times", None)
    return float(times[-1]) if times is not None and hasattr(drive, "pivot_heights") else 1e9


class Flights:
    """The free flights of all balls on one side of an instant, fitted there."""

    def __init__(
        self,
        time: Floats,
        angles: Sequence[Floats],
        sigmas: Sequence[Floats],
        chosen: NDArray[np.int64],
        instant: float,
        pull: Pull,
        drag: float,
        widen: float = 1.0,
    ) -> None:
        self.enough = len(chosen) >= FEWEST
        self.states: list[Floats] = []
        self.covariances: list[Floats] = []
        # Of what all flights share, the drag and a factor of (g + y0'')/l: curvature and slope of
        # the sum of squares once the states have adapted.
        self.curvature, self.slope = np.zeros((2, 2)), np.zeros(2)
        # Largest reduced sum of squares of a ball.
        self.spread = 0.0
        # Of neighbouring errors, and of errors themselves.
        self.products = self.squares = 0.0
        self.count = len(chosen)
        self.widen = widen
        if not self.enough:
            return
        # Outwards from the instant, either way.
        order = np.argsort(np.abs(time[chosen] - instant))
        own = chosen[order]
        grid = time[own]
        pulls = _grid_pulls(instant, grid, pull)
        for angle, sigma in zip(angles, sigmas, strict=True):
            self._fit(instant, grid, angle[own], sigma[own], pulls, drag)

    def _fit(
        self, instant: float, grid: Floats, angle: Floats, sigma: Floats, pulls: Floats, drag: float
    ) -> None:
        """Fit one ball's flight."""
        late = grid - instant
        line = np.polyfit(late, angle, 2 if len(grid) > 5 else 1)
        state = np.array([line[-1], line[-2], drag, 1.0])
        steps = np.array([1e-5, 1e-4, 1e-3, 1e-3])
        for _ in range(2):
            trials = np.column_stack([state, *(state + np.diag(steps))])
            seen = _carried(instant, grid, trials, pulls)
            slopes = (seen[:, 1:] - seen[:, :1]) / steps / sigma[:, None]
            errors = (angle - seen[:, 0]) / sigma
            change, *_ = np.linalg.lstsq(slopes[:, :2], errors, rcond=None)
            state[:2] += change
        errors = errors - slopes[:, :2] @ change
        inverse = np.linalg.inv(slopes[:, :2].T @ slopes[:, :2])
        spread = float(errors @ errors) / max(len(grid) - 2, 1)
        self.spread = max(self.spread, spread)
        self.products += float(errors[1:] @ errors[:-1])
        self.squares += float(errors @ errors) * (len(grid) - 1) / len(grid)
        rest = slopes[:, 2:] - slopes[:, :2] @ (inverse @ (slopes[:, :2].T @ slopes[:, 2:]))
        self.curvature += rest.T @ rest
        self.slope += rest.T @ errors
        self.states.append(state[:2])
        # A few samples tell little of their own scatter.
        floor = 0.5 if len(grid) < 10 else 0.0
        self.covariances.append(inverse * self.widen * max(spread, floor))

    @property
    def gap(self) -> float:
        """Angle between the balls, or of the one [rad]."""
        return float(self.states[0][0] - (self.states[1][0] if len(self.states) > 1 else 0.0))

    @property
    def velocity(self) -> float:
        """Its rate [rad/s]."""
        return float(self.states[0][1] - (self.states[1][1] if len(self.states) > 1 else 0.0))

    @property
    def sigma(self) -> float:
        """Standard deviation of the rate [rad/s]."""
        return math.sqrt(sum(float(c[1, 1]) for c in self.covariances))

    @property
    def gap_sigma(self) -> float:
        """Standard deviation of the angle between the balls [rad]."""
        return math.sqrt(sum(float(c[0, 0]) for c in self.covariances))


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


def good_flights(flights: Sequence[Flights]) -> list[Flights]:
    """Return the flights that are pendulum motion, not several with an impact between them."""
    known = [flight for flight in flights if flight.enough]
    if not known:
        return []
    typical = float(np.median([flight.spread for flight in known]))
    return [flight for flight in known if flight.spread <= ROUGH * typical]


def widening_of(flights: Sequence[Flights]) -> float:
    """Return by how much correlated errors of neighbours widen variances of smooth curves."""
    long = [flight for flight in flights if flight.squares > 0.0]
    squares = sum(flight.squares for flight in long)
    if squares <= 0.0:
        return 1.0
    seen = sum(flight.products for flight in long) / squares
    # A line fitted to n samples takes (2 + 4 rho)/n off the correlation (Kendall 1954).
    count = max(sum(flight.count * flight.squares for flight in long) / squares, 8.0)
    correlation = min(max((seen + 2.0 / count) / (1.0 - 4.0 / count), 0.0), 0.95)
    return (1.0 + correlation) / (1.0 - correlation)


def shared_changes(flights: Sequence[Flights], count: int) -> tuple[Floats, Floats]:
    """Return by how much all flights ask to change what they share, and the deviations of that.

    The first is the drag [1/s], the second, with a `count` of 2, the factor of (g + y0'')/l. This
    is 1 if length, clock and the scale of the angles are right. Without flights nothing changes.
    """
    curvature = sum((flight.curvature for flight in flights), np.zeros((2, 2)))[:count, :count]
    slope = sum((flight.slope for flight in flights), np.zeros(2))[:count]
    if not np.linalg.det(curvature) > 0.0:
        return np.zeros(count), np.zeros(count)
    inverse = np.linalg.inv(curvature)
    spread = float(np.median([flight.spread for flight in flights]))
    return inverse @ slope, np.sqrt(spread * widening_of(flights) * np.diag(inverse))
