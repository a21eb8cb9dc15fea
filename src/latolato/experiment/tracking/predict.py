"""Where balls will be in the next frame: pendulum and collision physics with its uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from latolato.physics.pendulum import restoring_sine

# Longest step of the prediction [s]: it bridges frames, it does not simulate.
_STEP = 2.5e-3
# Restitution that is assumed, and its uncertainty as a share of the speed of approach.
_RESTITUTION, _UNSURE = 0.85, 0.15
# Uncertainty of the angular acceleration, as a share of gravity over length, and at least [1/s^2]:
# where these are known, and where the swing tells them.
_UNSURE_FORCE, _LEAST_FORCE = {True: 0.08, False: 0.3}, {True: 1.0, False: 60.0}
# Fewest accelerations that say how uncertain they are, and how much more they are believed to be.
_FEWEST, _ROUGH = 12, 2.0
# Largest sum of a state's variances [rad^2, rad^2/s^2]. Unseen for long, nothing is known anyway;
# rounding would make larger ones negative.
_UNKNOWN = 1e4


@dataclass
class Prediction:
    """Balls at the middle of an exposure.

    Attributes
    ----------
    angles, velocities : numpy.ndarray, shape (ball,)
        Expected state [rad, rad/s].
    covariance : numpy.ndarray, shape (ball, 2, 2)
        Of each ball's state.
    path : numpy.ndarray, shape (sample, ball)
        Angles at the requested instants.
    contact_times : list of float
        Instants of contacts since the last frame [s].
    guess : numpy.ndarray, shape (ball,)
        Angles from which a fit starts: the expected ones, unless the image says otherwise.
    """

    angles: np.ndarray
    velocities: np.ndarray
    covariance: np.ndarray
    path: np.ndarray
    contact_times: list[float]
    guess: np.ndarray


class Predictor:
    """Carries angles from one frame to the next.

    Parameters
    ----------
    stiffness : float
        Gravity over length [1/s^2]; if it is unknown, 0, and the motion is assumed uniform.
    gap : float
        Smallest angle between two balls [rad]; 0 for one ball.
    is_known : bool
        Whether the stiffness is declared, not estimated: then `learn` corrects it.
    """

    def __init__(self, stiffness: float, gap: float, is_known: bool = True) -> None:
        self.stiffness = stiffness
        self.is_known = is_known
        self.noise = max(_UNSURE_FORCE[is_known] * stiffness, _LEAST_FORCE[is_known])
        # Sums of what accelerations say about the stiffness, which begin with what is believed.
        self.sums = np.array([1.0, stiffness, stiffness**2, 0.0])
        self.gap = gap
        self.angles = np.zeros(0)
        self.velocities = np.zeros(0)
        self.covariance = np.zeros((0, 2, 2))
        self.time = 0.0

    def start(self, time: float, angles: np.ndarray, speeds: np.ndarray, sigma: float) -> None:
        """Begin at given angles and velocities; NaN where these are unknown."""
        self.time = time
        self.angles = np.array(angles, float)
        self.velocities = np.nan_to_num(speeds)
        speed = max(4.0 * math.sqrt(self.stiffness), 5.0)
        self.covariance = np.stack(
            [np.diag([sigma**2, speed**2 if np.isnan(v) else 0.25 * v**2 + 1.0]) for v in speeds]
        )

    def predict(
        self, time: float, instants: np.ndarray, pivot_stiffness: float, until: float = -math.inf
    ) -> Prediction:
        """Return the state at `time` and the angles at `instants`, sorted, around it.

        `pivot_stiffness` is the pivot's acceleration over the length [1/s^2], which adds to
        gravity's. Contacts are predicted up to `until` [s] at least.
        """
        force = self.stiffness + pivot_stiffness
        # Plain numbers: arrays of one or two are slow.
        angles, speeds = self.angles.tolist(), self.velocities.tolist()
        passed = {}
        now, contacts = self.time, []
        for stop in sorted({*instants.tolist(), time, max(time, until)}):
            count = max(1, math.ceil(abs(stop - now) / _STEP))
            h = (stop - now) / count
            for _ in range(count if h != 0.0 else 0):
                for b, speed in enumerate(speeds):
                    angles[b] += 0.5 * h * speed
                    speeds[b] -= h * force * restoring_sine(angles[b])
                    angles[b] += 0.5 * h * speeds[b]
                now += h
                if len(angles) == 2:
                    ago = self._collide(angles, speeds)
                    if ago is not None:
                        contacts.append(now - ago)
            now = stop
            passed[stop] = angles.copy(), speeds.copy()
        state = np.array(passed[time])
        path = np.array([passed[instant][0] for instant in instants.tolist()])
        spread = self._spread(time - self.time, force, contacts)
        return Prediction(state[0], state[1], spread, path, contacts, state[0].copy())

    def _collide(self, angles: list[float], speeds: list[float]) -> float | None:
        """Reflect two balls that would pass each other, at the bottom or at the top.

        Returns how long ago they met [s], or None if they did not or hardly moved.
        """
        between, closing = angles[0] - angles[1], speeds[0] - speeds[1]
        for wall, sign in ((self.gap, 1.0), (2.0 * math.pi - self.gap, -1.0)):
            past = sign * (wall - between)
            if past > 0.0:
                hits = sign * closing < 0.0
                shift = sign * past * (1.0 + _RESTITUTION) / 2.0 if hits else sign * past / 2.0
                angles[:] = angles[0] + shift, angles[1] - shift
                if hits:
                    change = -0.5 * (1.0 + _RESTITUTION) * closing
                    speeds[:] = speeds[0] + change, speeds[1] - change
                return past / abs(closing) if hits and abs(closing) > 0.05 else None
        return None

    def _spread(self, interval: float, force: float, contacts: list[float]) -> np.ndarray:
        """Return the covariance after an interval."""
        grown = np.empty_like(self.covariance)
        for b, before in enumerate(self.covariance):
            move = np.array([[1.0, interval], [-force * math.cos(self.angles[b]) * interval, 1.0]])
            push = np.array([0.5 * interval**2, interval]) * self.noise
            grown[b] = move @ before @ move.T + np.outer(push, push) + np.diag([0.0, 1e-6])
            if contacts:
                error = _UNSURE * 2.0 * abs(self.velocities[b]) + 0.1
                grown[b] += np.diag([(0.5 * error * interval) ** 2, error**2])
            grown[b] *= min(1.0, _UNKNOWN / float(np.trace(grown[b])))
        return grown

    def learn(self, angle: float, acceleration: float) -> None:
        """Correct an estimated stiffness by an acceleration [rad/s^2] that gravity alone made."""
        if self.is_known:
            return
        sine = -restoring_sine(angle)
        self.sums += [sine**2, sine * acceleration, acceleration**2, 1.0]
        squares, products, total, count = self.sums
        self.stiffness = max(float(products / squares), 0.0)
        if count >= _FEWEST:
            left = max(float(total - products**2 / squares), 0.0)
            self.noise = max(_ROUGH * math.sqrt(left / count), _LEAST_FORCE[True])

    def accept(self, time: float, expected: Prediction) -> None:
        """Take a prediction as the state."""
        self.time = time
        self.angles, self.velocities = expected.angles.copy(), expected.velocities.copy()
        self.covariance = expected.covariance.copy()

    def correct(self, ball: int, angle: float, sigma: float) -> None:
        """Draw the state of one ball towards a measured angle (Kalman).

        The covariance is Joseph's form, which rounding cannot make negative.
        """
        covariance = self.covariance[ball]
        gain = covariance[:, 0] / (covariance[0, 0] + sigma**2)
        change = angle - self.angles[ball]
        self.angles[ball] += gain[0] * change
        self.velocities[ball] += gain[1] * change
        kept = np.eye(2) - np.outer(gain, [1.0, 0.0])
        self.covariance[ball] = kept @ covariance @ kept.T + sigma**2 * np.outer(gain, gain)
