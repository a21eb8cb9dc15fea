"""Smooth stretches of the pivot's motion: the forms that all drives of the package are made of.

A stretch says its form by a number, so that one compiled kernel serves every drive.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from latolato.scalar import cosine, formula, sine

# Forms of the motion: a pivot at rest; a cosine of constant amplitude and frequency; one whose
# amplitude is a cubic of the time and whose frequency changes linearly; the piston of a crank; a
# quintic of the time.
STILL, COSINE, SWEPT, CRANK, POLYNOMIAL = 0.0, 1.0, 2.0, 3.0, 4.0


class Stretch(NamedTuple):
    """One smooth stretch of the pivot's motion: its form and the numbers that the form reads.

    All count from `start`. The coefficients are those of the height [m] of a polynomial and of the
    amplitude [m] of everything else, per power of a second.
    """

    start: float = 0.0  # s
    form: float = STILL
    phase: float = 0.0  # rad, at the start
    frequency: float = 0.0  # rad/s, there
    rate: float = 0.0  # rad/s^2, how the frequency changes
    c0: float = 0.0
    c1: float = 0.0
    c2: float = 0.0
    c3: float = 0.0
    c4: float = 0.0
    c5: float = 0.0
    rod: float = 0.0  # m, a crank's connecting_rod_length
    side: float = 0.0  # +1 for a crank's guide above, -1 for one below

    def at(self, time: float) -> Stretch:
        """Return the same cosine with another start [s]."""
        s = time - self.start
        return self._replace(
            start=time,
            phase=self.phase + s * (self.frequency + 0.5 * self.rate * s),
            frequency=self.frequency + self.rate * s,
            c0=self.c0 + s * (self.c1 + s * (self.c2 + s * self.c3)),
            c1=self.c1 + s * (2.0 * self.c2 + s * 3.0 * self.c3),
            c2=self.c2 + 3.0 * self.c3 * s,
        )

    def acceleration_bound(self, span: float) -> float:
        """Return a bound of a cosine's |pivot_acceleration| within `span` seconds [m/s^2]."""
        if self.c1 == self.c2 == self.c3 == 0.0:
            fastest = max(abs(self.frequency), abs(self.frequency + self.rate * span))
            return abs(self.c0) * (fastest * fastest + abs(self.rate))
        end = self.at(self.start + span)
        fastest = max(abs(self.frequency), abs(end.frequency))
        # A cubic is below the largest of its Bezier points, and so are its derivatives.
        third = span / 3.0
        points = (self.c0, self.c0 + third * self.c1, end.c0 - third * end.c1, end.c0)
        middle = self.c1 + span * self.c2
        amplitude = max(map(abs, points))
        growth = max(abs(self.c1), abs(middle), abs(end.c1))
        bend = 2.0 * max(abs(self.c2), abs(end.c2))
        return bend + 2.0 * growth * fastest + amplitude * (fastest * fastest + abs(self.rate))


@formula
def _swept_height(s: float, p: Any) -> float:
    """Return A(s) cos(phase + w s + rate s^2/2)."""
    amplitude = p.c0 + s * (p.c1 + s * (p.c2 + s * p.c3))
    return amplitude * cosine(p.phase + s * (p.frequency + 0.5 * p.rate * s))


@formula
def _swept_velocity(s: float, p: Any) -> float:
    """Return the time derivative of `_swept_height`."""
    amplitude = p.c0 + s * (p.c1 + s * (p.c2 + s * p.c3))
    growth = p.c1 + s * (2.0 * p.c2 + s * 3.0 * p.c3)
    w = p.frequency + p.rate * s
    phase = p.phase + s * (p.frequency + 0.5 * p.rate * s)
    return growth * cosine(phase) - amplitude * w * sine(phase)


@formula
def _swept_acceleration(s: float, p: Any) -> float:
    """Return the second time derivative of `_swept_height`."""
    amplitude = p.c0 + s * (p.c1 + s * (p.c2 + s * p.c3))
    growth = p.c1 + s * (2.0 * p.c2 + s * 3.0 * p.c3)
    bend = 2.0 * p.c2 + s * 6.0 * p.c3
    w = p.frequency + p.rate * s
    phase = p.phase + s * (p.frequency + 0.5 * p.rate * s)
    across = 2.0 * growth * w + amplitude * p.rate
    return (bend - amplitude * w * w) * cosine(phase) - across * sine(phase)


@formula
def _crank_height(s: float, p: Any) -> float:
    """Return A cos q + side (sqrt(L^2 - A^2 sin^2 q) - L), q = w s + phase."""
    phase = p.frequency * s + p.phase
    x = p.c0 * sine(phase)
    # sqrt(L^2 - x^2) - L without cancellation
    return p.c0 * cosine(phase) - p.side * x * x / (p.rod + math.sqrt(p.rod * p.rod - x * x))


@formula
def _crank_velocity(s: float, p: Any) -> float:
    """Return the time derivative of `_crank_height`."""
    phase = p.frequency * s + p.phase
    x = p.c0 * sine(phase)
    root = math.sqrt(p.rod * p.rod - x * x)
    return -p.frequency * x * (1.0 + p.side * p.c0 * cosine(phase) / root)


@formula
def _crank_acceleration(s: float, p: Any) -> float:
    """Return -A w^2 [cos q + side lam (cos 2q + lam^2 sin^4 q)/(1 - lam^2 sin^2 q)^(3/2)]."""
    lam = p.c0 / p.rod
    phase = p.frequency * s + p.phase
    square = sine(phase) ** 2
    inner = 1.0 - lam * lam * square
    bend = (1.0 - 2.0 * square + lam * lam * square * square) / (inner * math.sqrt(inner))
    return -p.c0 * p.frequency * p.frequency * (cosine(phase) + p.side * lam * bend)


@formula
def _polynomial_height(s: float, p: Any) -> float:
    """Return the quintic."""
    return p.c0 + s * (p.c1 + s * (p.c2 + s * (p.c3 + s * (p.c4 + s * p.c5))))


@formula
def _polynomial_velocity(s: float, p: Any) -> float:
    """Return the quintic's first derivative."""
    return p.c1 + s * (2.0 * p.c2 + s * (3.0 * p.c3 + s * (4.0 * p.c4 + s * 5.0 * p.c5)))


@formula
def _polynomial_acceleration(s: float, p: Any) -> float:
    """Return the quintic's second derivative."""
    return 2.0 * p.c2 + s * (6.0 * p.c3 + s * (12.0 * p.c4 + s * 20.0 * p.c5))


@formula
def _other_height(s: float, p: Any) -> float:
    """Return the height of the rarer forms."""
    if p.form == SWEPT:
        return _swept_height(s, p)
    return _crank_height(s, p) if p.form == CRANK else _polynomial_height(s, p)


@formula
def _other_velocity(s: float, p: Any) -> float:
    """Return the velocity of the rarer forms."""
    if p.form == SWEPT:
        return _swept_velocity(s, p)
    return _crank_velocity(s, p) if p.form == CRANK else _polynomial_velocity(s, p)


@formula
def _other_acceleration(s: float, p: Any) -> float:
    """Return the acceleration of the rarer forms."""
    if p.form == SWEPT:
        return _swept_acceleration(s, p)
    return _crank_acceleration(s, p) if p.form == CRANK else _polynomial_acceleration(s, p)


@formula
def pivot_height(t: float, p: Any) -> float:
    """Return the height of the pivot [m] at the time t [s] in the stretch p."""
    s = t - p.start
    if p.form == STILL:
        return 0.0
    return p.c0 * cosine(p.frequency * s + p.phase) if p.form == COSINE else _other_height(s, p)


@formula
def pivot_velocity(t: float, p: Any) -> float:
    """Return the first time derivative of `pivot_height` [m/s]."""
    s = t - p.start
    if p.form == STILL:
        return 0.0
    w = p.frequency
    return -p.c0 * w * sine(w * s + p.phase) if p.form == COSINE else _other_velocity(s, p)


@formula
def pivot_acceleration(t: float, p: Any) -> float:
    """Return the second time derivative of `pivot_height` [m/s^2]."""
    # Read before any branch, so that a loop over the stages of a step reads it once.
    start, w, phase = p.start, p.frequency, p.phase
    strength = -p.c0 * w * w
    if p.form == COSINE:
        return strength * cosine(w * (t - start) + phase)
    return 0.0 if p.form == STILL else _other_acceleration(t - start, p)


@formula
def rotation(p: Any) -> tuple[float, float, float]:
    """Return strength [m/s^2], frequency [rad/s] and phase of a pivot at rest or a steady cosine.

    Its acceleration is ``strength cos(frequency t + phase)``.
    """
    w = p.frequency
    return -p.c0 * w * w, w, p.phase - w * p.start
