"""Closed forms: decays, falls and bounces of a pivot at rest, and the numbers of paper eq15."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from latolato.analysis.elliptic import Array, checked_shaped, checked_times, undriven_motion
from latolato.analysis.rules import broken_analysis
from latolato.core.quantities import ANY, NON_NEGATIVE, POSITIVE
from latolato.core.registry import checked_count, checked_number
from latolato.physics.pendulum import GRAVITY, LatoLato, Pendulum


def decay_rate(*, damping: float, mass: float, length: float) -> float:
    """Return the rate k at which small swings decay [1/s], ``C/(2 m l)`` (paper eq13).

    Examples
    --------
    The single pendulum of paper Fig. 7:

    >>> print(f"{decay_rate(damping=0.00274, mass=0.10804, length=0.3630):.7f}")
    0.0349325
    """
    system = Pendulum(length=length, mass=mass, damping=damping)
    return system.damping / (2.0 * system.mass * system.length)


def damping_from_decay_rate(decay_rate: float, *, mass: float, length: float) -> float:
    """Return the damping C [kg m/s] that belongs to a measured decay rate [1/s], ``2 m l k``."""
    system = Pendulum(length=length, mass=mass)
    k = checked_number("decay_rate", decay_rate, NON_NEGATIVE, "1/s")
    return 2.0 * system.mass * system.length * k


def damped_small_angle(
    times: ArrayLike,
    *,
    length: float,
    mass: float,
    damping: float,
    initial_angle: float,
    gravity: float = GRAVITY,
) -> tuple[Array, Array]:
    """Return angle [rad] and angular velocity [rad/s] of small damped swings from rest.

    Paper eq13, continued to critical and overcritical damping.

    Parameters
    ----------
    times : array_like
        Instants [s].
    length, mass : float
        Length l [m] and mass m [kg], positive.
    damping : float
        C [kg m/s], at least 0.
    initial_angle : float
        Angle [rad] at time zero; the equation is linear, smallness is the caller's concern.
    gravity : float
        Gravitational acceleration g [m/s^2], positive.

    Returns
    -------
    angle : ndarray
        Angle [rad], of the shape of `times`.
    angular_velocity : ndarray
        Angular velocity [rad/s], of the same shape.

    Notes
    -----
    With ``k = C/(2 m l)``, ``W^2 = w0^2 - k^2``:
    ``angle = angle_0 exp(-k t) (cos(W t) + k sin(W t)/W)``,
    ``angular_velocity = -angle_0 exp(-k t) w0^2 sin(W t)/W``; the first is eq13 with its amplitude
    and phase multiplied out, and has the right limit at W = 0.

    Examples
    --------
    >>> angle, _ = damped_small_angle(
    ...     [0.0, 20.0], length=0.3630, mass=0.10804, damping=0.00274, initial_angle=0.1
    ... )
    >>> print(angle.round(6))
    [ 0.1      -0.048347]
    """
    instants = checked_times(times)
    start = checked_number("initial_angle", initial_angle, ANY, "rad")
    system = Pendulum(length=length, mass=mass, damping=damping, gravity=gravity)
    w0 = system.natural_frequency
    k = decay_rate(damping=damping, mass=mass, length=length)
    W = math.sqrt(abs((w0 - k) * (w0 + k)))
    if k < w0:
        decay = np.exp(-k * instants)
        cosine, sine = decay * np.cos(W * instants), decay * np.sin(W * instants) / W
    elif W == 0.0:
        cosine = np.exp(-k * instants)
        sine = instants * cosine
    else:
        # The slow rate k - W as a quotient, which keeps its digits.
        slow = np.exp(-(w0 * w0 / (k + W)) * instants)
        fast = np.exp(-(k + W) * instants)
        cosine = 0.5 * (slow + fast)
        sine = 0.5 * slow * -np.expm1(-2.0 * W * instants) / W
    return np.asarray(start * (cosine + k * sine)), np.asarray(-start * w0 * w0 * sine)


def fall_time(
    *, length: float, radius: float, initial_angle: float, gravity: float = GRAVITY
) -> float:
    """Return the time tau from rest to the low wall ``asin(r/l)`` [s], undriven and undamped.

    Incomplete elliptic integral of the first kind (Carlson's R_F), see `undriven_motion`.

    Parameters
    ----------
    length : float
        Length l [m], positive.
    radius : float
        Ball radius [m], in [0, length).
    initial_angle : float
        Turning point [rad], above the low wall and not above the high one.
    gravity : float
        Gravitational acceleration g [m/s^2], positive.

    Returns
    -------
    float
        Time tau; elastic collision n follows at ``(2 n - 1) tau``.

    Examples
    --------
    >>> print(f"{fall_time(length=1.0, radius=0.1, initial_angle=0.6):.15f}")
    0.458901167124134
    """
    return _fall_time(_bounce(length, radius, initial_angle, gravity))


def impact_angular_velocity(
    *, length: float, radius: float, initial_angle: float, gravity: float = GRAVITY
) -> float:
    """Return the speed at which a ball released from rest meets the low wall [rad/s].

    ``sqrt(2 g/l (cos(wall) - cos(initial_angle)))``, from the energy; parameters of `fall_time`.

    Examples
    --------
    >>> print(f"{impact_angular_velocity(length=1.0, radius=0.1, initial_angle=0.6):.14f}")
    1.82350643406050
    """
    bounce = _bounce(length, radius, initial_angle, gravity)
    return 2.0 * bounce.frequency * bounce.speed


def collision_times(
    count: int,
    *,
    length: float,
    radius: float,
    initial_angle: float,
    gravity: float = GRAVITY,
) -> Array:
    """Return the first `count` collision times of the elastic bounce [s], shape ``(count,)``.

    ``(2 n - 1) tau``; the other parameters are those of `fall_time`.

    Examples
    --------
    >>> collision_times(3, length=1.0, radius=0.1, initial_angle=0.5).round(3)
    array([0.445, 1.334, 2.223])
    """
    count = checked_count("count", count, NON_NEGATIVE)
    tau = fall_time(length=length, radius=radius, initial_angle=initial_angle, gravity=gravity)
    return np.asarray((2.0 * np.arange(1, count + 1) - 1.0) * tau, dtype=np.float64)


def elastic_bounces(
    times: ArrayLike,
    *,
    length: float,
    radius: float,
    initial_angle: float,
    gravity: float = GRAVITY,
) -> tuple[Array, Array]:
    """Return angle [rad] and angular velocity [rad/s] of a ball bouncing on the low wall.

    Undriven, undamped, e = 1, from rest; the other parameters are those of `fall_time`.

    Parameters
    ----------
    times : array_like
        Instants [s]; at a collision the state just after it.

    Returns
    -------
    angle : ndarray
        Angle [rad], of the shape of `times`.
    angular_velocity : ndarray
        Angular velocity [rad/s], of the same shape.

    Notes
    -----
    The swing of `undriven_motion` on ``[-tau, tau)``, repeated with period ``2 tau``. Within the
    rounding of the time, some 1e-16 of it, an instant may fall on the other side of a collision.

    Examples
    --------
    >>> angle, speed = elastic_bounces([0.1, 0.2], length=1.0, radius=0.1, initial_angle=0.5)
    >>> angle.round(3), speed.round(3)
    (array([0.477, 0.409]), array([-0.463, -0.886]))
    """
    instants = checked_times(times)
    bounce = _bounce(length, radius, initial_angle, gravity)
    tau = _fall_time(bounce)
    since_top = instants - 2.0 * tau * np.floor(instants / (2.0 * tau) + 0.5)
    angle, angular_velocity = undriven_motion(
        since_top, length=length, initial_angle=initial_angle, gravity=gravity
    )
    return np.maximum(angle, bounce.wall), angular_velocity


def zeno_time(
    *,
    length: float,
    radius: float,
    initial_angle: float,
    restitution: float,
    gravity: float = GRAVITY,
) -> float:
    """Return the time at which infinitely many impacts have brought the ball to rest [s].

    Undriven and undamped, from rest; every flight is an elliptic integral, as in `fall_time`.

    Parameters
    ----------
    length, radius, initial_angle : float
        As in `fall_time`.
    restitution : float
        Coefficient of restitution e, in [0, 1).
    gravity : float
        As in `fall_time`.

    Returns
    -------
    float
        Accumulation time; infinite for ``radius = 0`` and e > 0, where flights keep their length.

    Raises
    ------
    InputError
        For a parameter outside its range, or e = 1, for which nothing accumulates.

    Notes
    -----
    ``tau(v) + 2 sum_n tau(e^n v)``, the tail (speeds below 1e-8 of ``2 w0 sin(wall/2)``, for which
    tau is linear in the speed) as a geometric series. The work grows as ``1/(1 - e)``.

    Examples
    --------
    >>> time = zeno_time(length=1.0, radius=0.1, initial_angle=math.pi / 2, restitution=0.6)
    >>> print(f"{time:.5f}")
    5.45806
    """
    bounce = _bounce(length, radius, initial_angle, gravity)
    system = LatoLato(length=length, mass=1.0, radius=radius, restitution=restitution)
    e = system.restitution
    if e == 1.0:
        raise broken_analysis("accumulating_impacts", parameter="restitution", value=e)
    total = _fall_time(bounce)
    if e == 0.0:
        return total
    low_sine, low_cosine = math.sin(0.5 * bounce.wall), math.cos(0.5 * bounce.wall)
    if low_sine == 0.0:
        return math.inf
    flights = max(0, math.ceil(math.log(1e-8 * low_sine / bounce.speed) / math.log(e)))
    chunk = 65536  # bounds the memory for e near 1
    for first in range(1, flights + 1, chunk):
        bounces = np.arange(first, min(first + chunk, flights + 1), dtype=np.float64)
        speeds = bounce.speed * np.power(e, bounces)
        complements = np.sqrt((low_cosine - speeds) * (low_cosine + speeds))
        total += 2.0 * math.fsum(_climb_time(bounce, speeds, complements))
    tail = bounce.speed * e ** (flights + 1) / (1.0 - e)
    return total + 2.0 * tail / (low_sine * low_cosine * bounce.frequency)


def reflected_angle(free_angle: ArrayLike) -> Array:
    """Return the angle [rad] of a colliding ball of radius 0, e = 1, from the free pendulum's.

    Mirror symmetry: reflecting at walls at 0 and pi is ``|wrap(angle)|``, for any drive and damping
    law that treats both directions alike.

    Parameters
    ----------
    free_angle : array_like
        Angle [rad] of the same pendulum without walls.

    Returns
    -------
    ndarray
        In [0, pi], of the shape of `free_angle`.

    Examples
    --------
    >>> print(reflected_angle([-0.5, 4.0]).round(6))
    [0.5      2.283185]
    """
    free = checked_shaped("free_angle", free_angle, ANY, "rad")
    return np.asarray(np.abs(free - 2.0 * math.pi * np.rint(free / (2.0 * math.pi))))


class _Bounce(NamedTuple):
    """A fall from rest on the low wall; `speed` is that of the impact over 2 w0."""

    wall: float
    top: float
    speed: float
    frequency: float


def _bounce(length: float, radius: float, initial_angle: float, gravity: float) -> _Bounce:
    """Return the checked fall."""
    system = LatoLato(length=length, mass=1.0, radius=radius, gravity=gravity)
    low, high = system.contact_angle_low, system.contact_angle_high
    top = checked_number("initial_angle", initial_angle, ANY, "rad")
    if not low < top <= high:
        raise broken_analysis(
            "start_above_wall", {"low": low, "high": high}, parameter="initial_angle", value=top
        )
    # sin^2(top/2) - sin^2(low/2) as a product, which keeps its digits.
    speed = math.sqrt(math.sin(0.5 * (top - low)) * math.sin(0.5 * (top + low)))
    return _Bounce(low, top, speed, system.natural_frequency)


def _fall_time(bounce: _Bounce) -> float:
    """Return the time [s] from the turning point at rest to the low wall."""
    return float(_climb_time(bounce, bounce.speed, math.cos(0.5 * bounce.top)))


def _climb_time(bounce: _Bounce, speed: float | Array, complement: float | Array) -> Array:
    """Return the time [s] from the low wall at `speed` (over 2 w0) to the turning point.

    With u counted from the turning point, ``cd u = sin(low/2)/k``; hence sn, cn, dn below.
    """
    from scipy.special import elliprf

    low_sine, low_cosine = math.sin(0.5 * bounce.wall), math.cos(0.5 * bounce.wall)
    k = np.hypot(low_sine, speed)
    sn, dn = speed / (k * low_cosine), complement / low_cosine
    cn = low_sine * dn / k
    return np.asarray(sn * elliprf(cn * cn, dn * dn, 1.0) / bounce.frequency)


class MathieuParameters(NamedTuple):
    """Dimensionless parameters of the undamped linear equation.

    The first two belong to the standard form ``x'' + (a - 2 q cos 2z) x = 0``, where the paper
    writes b for q; the third is gamma of paper eq15.

    Examples
    --------
    >>> mathieu_parameters(drive_amplitude=0.05, drive_frequency=6.0).mathieu_q
    0.1
    """

    mathieu_a: float
    mathieu_q: float
    mathieu_strength: float


def mathieu_parameters(
    *, drive_amplitude: float, drive_frequency: float, length: float = 1.0, gravity: float = GRAVITY
) -> MathieuParameters:
    """Return a, q and the excitation strength of the undamped linear equation [1].

    Source: paper eq15 and the standard form above it.

    Parameters
    ----------
    drive_amplitude : float
        A0 [m], at least 0.
    drive_frequency : float
        Angular frequency w [rad/s], positive.
    length, gravity : float
        Length l [m] and gravitational acceleration g [m/s^2], positive.

    Returns
    -------
    MathieuParameters
        ``a = (2 w0/w)^2``, ``q = 2 A0/l``, ``gamma = A0 w^2/(2 g)``.

    Examples
    --------
    >>> a, q, strength = mathieu_parameters(drive_amplitude=0.05, drive_frequency=6.26)
    >>> print(f"{a:.6f} {q} {strength:.6f}")
    1.000316 0.1 0.099968
    """
    system = Pendulum(length=length, mass=1.0, gravity=gravity)
    l, g = system.length, system.gravity
    A0 = checked_number("drive_amplitude", drive_amplitude, NON_NEGATIVE, "m")
    w = checked_number("drive_frequency", drive_frequency, POSITIVE, "rad/s")
    return MathieuParameters(4.0 * g / (l * w**2), 2.0 * A0 / l, A0 * w**2 / (2.0 * g))
