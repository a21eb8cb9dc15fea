"""The free pendulum at any energy, by Jacobi's elliptic functions."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from latolato.core.quantities import ANY, Range
from latolato.core.registry import checked_array, checked_number, in_unit
from latolato.physics.pendulum import GRAVITY, Pendulum

Array = NDArray[np.float64]


def undriven_period(
    *,
    length: float,
    initial_angle: float,
    initial_angular_velocity: float = 0.0,
    gravity: float = GRAVITY,
) -> float:
    """Return the period of the undriven, undamped pendulum [s].

    Paper eq4; Whittaker, Analytical Dynamics (1904), section 44.

    Parameters
    ----------
    length : float
        Length l [m], positive.
    initial_angle, initial_angular_velocity : float
        State [rad, rad/s] at time zero, any energy.
    gravity : float
        Gravitational acceleration g [m/s^2], positive.

    Returns
    -------
    float
        Time of a full swing, or of one revolution if the pendulum rotates; infinite on the
        separatrix, ``2 pi/w0`` at rest in the lowest point.

    Notes
    -----
    ``4 K(k)/w0`` with ``k^2 = sin^2(angle/2) + (angular_velocity/(2 w0))^2`` below 1, else
    ``2 K(1/k)/(k w0)``; K from the arithmetic-geometric mean of the *complementary* modulus, whose
    square ``1 - k^2`` is formed in decimal arithmetic. Error: some 1e-16 of the period for the
    floating-point numbers given, at any distance from the separatrix; an angle beyond half a turn
    is reduced first, at 1e-16 of its size.

    Examples
    --------
    >>> print(f"{undriven_period(length=1.0, initial_angle=1.5707963267948966):.12f}")
    2.369049722175
    """
    orbit = _orbit(length, initial_angle, initial_angular_velocity, gravity)
    if orbit.complement == 0.0:
        return math.inf
    quarter = _quarter_period(orbit.complement)
    return (2.0 if orbit.rotates else 4.0) * quarter / orbit.rate


def undriven_motion(
    times: ArrayLike,
    *,
    length: float,
    initial_angle: float,
    initial_angular_velocity: float = 0.0,
    gravity: float = GRAVITY,
) -> tuple[Array, Array]:
    """Return angle [rad] and angular velocity [rad/s] of the undriven, undamped pendulum.

    Paper eq4; Whittaker, Analytical Dynamics (1904), section 44.

    Parameters
    ----------
    times : array_like
        Instants [s], of either sign.
    length, initial_angle, initial_angular_velocity, gravity : float
        As for `undriven_period`.

    Returns
    -------
    angle : ndarray
        Angle [rad], of the shape of `times`; it is not wrapped.
    angular_velocity : ndarray
        Angular velocity [rad/s], of the same shape.

    Notes
    -----
    Swing: ``sin(angle/2) = k sn(u, k)``, ``angular_velocity = 2 w0 k cn(u, k)``, ``u = w0 t + u0``.
    Rotation: ``angle = 2 am(u, 1/k)``, ``angular_velocity = 2 w0 k dn(u, 1/k)``,
    ``u = k w0 t + u0``. Separatrix: ``tan(angle/4 + pi/4) = exp(u)``. k as in `undriven_period`.
    Error: some 1e-15 plus 1e-16 of ``w0 t`` times the speed, for the floating-point numbers given:
    ``math.pi`` is 1.2e-16 below pi, so a pendulum released there falls after some 38/w0.

    Examples
    --------
    >>> angle, _ = undriven_motion([0.0, 0.5, 1.0], length=1.0, initial_angle=1.5)
    >>> print(angle.round(6))
    [ 1.5       0.350455 -1.365467]
    """
    instants = checked_times(times)
    orbit = _orbit(length, initial_angle, initial_angular_velocity, gravity)
    phase = orbit.rate * instants + orbit.phase
    turns, direction, k, w0 = orbit.turns, orbit.direction, orbit.modulus, orbit.frequency
    if k == 0.0:
        return np.full_like(instants, turns), np.zeros_like(instants)
    if orbit.complement == 0.0:
        u = np.clip(phase, -700.0, 700.0)  # cosh beyond it overflows
        angle = turns + direction * 2.0 * np.arctan(np.sinh(u))
        return np.asarray(angle), np.asarray(direction * 2.0 * w0 / np.cosh(u))
    amplitude, sn, cn, dn = _jacobi(phase, orbit.complement)
    if orbit.rotates:
        angle, angular_velocity = turns + direction * 2.0 * amplitude, direction * 2.0 * w0 * k * dn
    else:
        angle, angular_velocity = turns + 2.0 * np.arctan2(k * sn, dn), 2.0 * w0 * k * cn
    return np.asarray(angle), np.asarray(angular_velocity)


class _Orbit(NamedTuple):
    """One solution of the free pendulum in the variables of `undriven_motion`."""

    rotates: bool
    modulus: float  # k = sqrt(energy / (2 m g l)), above 1 if it rotates
    complement: float  # sqrt(1 - k^2), of 1/k if it rotates
    frequency: float  # w0
    rate: float  # du/dt
    phase: float  # u at time zero
    turns: float  # the lowest point it starts around [rad]
    direction: float  # of rotation


def _orbit(
    length: float, initial_angle: float, initial_angular_velocity: float, gravity: float
) -> _Orbit:
    """Return the orbit through a state, checked."""
    # The mass drops out of eq4.
    pendulum = Pendulum(length=length, mass=1.0, gravity=gravity)
    w0 = pendulum.natural_frequency
    start = checked_number("initial_angle", initial_angle, ANY, "rad")
    velocity = checked_number("initial_angular_velocity", initial_angular_velocity, ANY, "rad/s")
    angle = math.remainder(start, 2.0 * math.pi)
    turns = start - angle
    s, c, p = math.sin(0.5 * angle), math.cos(0.5 * angle), abs(velocity) / (2.0 * w0)
    k = math.hypot(s, p)
    direction = math.copysign(1.0, velocity)
    excess = _excess(angle, velocity, pendulum.length, pendulum.gravity)
    if k == 0.0:
        return _Orbit(False, 0.0, 1.0, w0, w0, 0.0, turns, 1.0)
    if excess < 0.0:
        phase = _first_kind(s / k, p / k, c)
        complement = math.sqrt(-excess)
        if velocity < 0.0:
            phase = 2.0 * _quarter_period(complement) - phase
        return _Orbit(False, k, complement, w0, w0, phase, turns, 1.0)
    if excess == 0.0:
        phase = direction * math.asinh(s / c)
        return _Orbit(False, 1.0, 0.0, w0, w0, phase, turns, direction)
    phase = _first_kind(direction * s, c, p / k)
    return _Orbit(True, k, math.sqrt(excess) / k, w0, k * w0, phase, turns, direction)


def _excess(angle: float, velocity: float, length: float, gravity: float) -> float:
    """Return k^2 - 1 = (velocity/(2 w0))^2 - cos^2(angle/2), rounded once.

    The period near the separatrix hangs on this difference of nearly equal numbers.
    """
    with localcontext(prec=60):
        square = Decimal(velocity) ** 2 * Decimal(length) / (4 * Decimal(gravity))
        minus_angle_squared = -(Decimal(angle) ** 2)
        term = total = Decimal(1)
        for n in range(2, 80, 2):  # cos(angle), |angle| <= pi: the last term is below 1e-70
            term *= minus_angle_squared / (n * (n - 1))
            total += term
        return float(square - (1 + total) / 2)


def _first_kind(sn: float, cn: float, dn: float) -> float:
    """Return u in [-K, K] of given sn, |cn| and dn (Carlson, DLMF 19.25.5)."""
    from scipy.special import elliprf

    return sn * float(elliprf(cn * cn, dn * dn, 1.0))


def _ladder(complement: float) -> tuple[float, list[float]]:
    """Return the arithmetic-geometric mean of 1 and k', and the moduli of the Landen steps."""
    a, b = 1.0, complement
    moduli: list[float] = []
    while not moduli or moduli[-1] > 1e-9:  # the next modulus would be below 1e-18
        moduli.append((a - b) / (a + b))
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    return a, moduli


def _quarter_period(complement: float) -> float:
    """Return K of a complementary modulus k' > 0."""
    return 0.5 * math.pi / _ladder(complement)[0]


def _jacobi(u: Array, complement: float) -> tuple[Array, Array, Array, Array]:
    """Return am, sn, cn and dn at u for a complementary modulus 0 < k' <= 1.

    Descending Landen transformation (DLMF 22.7.2-4) on [-K/2, K/2], to which u is reduced by
    quarter periods; scipy's ellipj takes k^2 instead, which cannot hold k' near the separatrix.
    """
    mean, moduli = _ladder(complement)
    quarters = np.rint(u * mean / (0.5 * math.pi))
    angle = u * mean - quarters * (0.5 * math.pi)
    s, c, d = np.sin(angle), np.cos(angle), np.ones_like(angle)
    for k in reversed(moduli):
        below = 1.0 + k * s * s
        s, c, d = (1.0 + k) * s / below, c * d / below, (1.0 - k + k * c * c) / below
    # A shift by K exchanges the roles of sn and cn (DLMF 22.4, table 3).
    is_odd = quarters % 2.0 == 1.0
    amplitude = quarters * (0.5 * math.pi) + np.arctan2(np.where(is_odd, complement * s, s), c)
    sign = np.where(quarters % 4.0 >= 2.0, -1.0, 1.0)
    sn = sign * np.where(is_odd, c / d, s)
    cn = sign * np.where(is_odd, -complement * s / d, c)
    return amplitude, sn, cn, np.where(is_odd, complement / d, d)


def checked_times(times: ArrayLike) -> Array:
    """Return the instants [s] as float64, all finite."""
    return checked_shaped("times", times, ANY, "s")


def checked_shaped(name: str, values: ArrayLike, allowed: Range, unit: str) -> Array:
    """Return checked numbers in the shape in which they are given."""
    given = in_unit(name, values, unit)
    given = given if hasattr(given, "dtype") else np.array(given, dtype=object)
    if not given.shape:
        return np.array(checked_number(name, given.item(), allowed, unit))
    return np.array(checked_array(name, given.ravel(), allowed, 0, unit=unit)).reshape(given.shape)
