"""Drag laws: linear (the paper's C), quadratic and Coulomb, and any sum of them.

The tangential force on a ball is ``-(C w + C2 w |w| + C0 sgn w)`` with w the angular velocity, so
the deceleration is ``c1 w + c2 w |w| + c0 sgn w`` with ``c = C/(m l)`` each. Within a step the
sign of the velocity is constant: a zero of the velocity ends the step (see `numerics.engine`), so
that each law keeps its full order there.
"""

from __future__ import annotations

import math

from latolato.core.scalar import formula

# Below this argument six terms of (1 - exp(-x))/x miss less than 1e-17 of it.
_SERIES = 4e-3
# Less quadratic drag than this changes no digit, and near the smallest floats spoils all of them.
_NONE = 1e-100


@formula
def decay_time(rate: float, time: float) -> float:
    """Return (1 - exp(-rate time))/rate [s], the distance per initial speed of linear drag."""
    x = rate * time
    if abs(x) < _SERIES:
        return time * (
            1.0 - x * (1 / 2 - x * (1 / 6 - x * (1 / 24 - x * (1 / 120 - x * (1 / 720)))))
        )
    return -math.expm1(-x) / rate


@formula
def drift(
    velocity: float, sign: float, reach: float, rate: float, quadratic: float
) -> tuple[float, float]:
    """Return the angle travelled [rad] and the angular velocity after a force-free stretch.

    Exact flow of ``w' = -c1 w - c2 sign w^2``: with the reach
    ``E = (1 - exp(-c1 t))/c1`` of `decay_time`, ``d = 1 + c2 sign w E``,
    ``w -> w (1 - c1 E)/d`` and the travelled angle is ``ln(d)/(c2 sign)``, or ``w E`` for c2 = 0.

    Parameters
    ----------
    velocity : float
        Angular velocity at the start [rad/s].
    sign : float
        Sign of the velocity in this stretch of motion, +1 or -1; only used by quadratic drag.
    reach : float
        `decay_time` of the stretch [s]; negative in the backward substeps of a splitting.
    rate : float
        c1 = damping/(mass length) [1/s].
    quadratic : float
        c2 = quadratic_damping/(mass length) [1].

    Notes
    -----
    A velocity against its sign grows without bound within ``1/(c2 |w|)``: d is then 0, and both
    results are NaN. A step that ends with NaN has thus gone far beyond a turning point.
    """
    # Not velocity * (1 - c1 E): the rounding of that factor is the same in every step and adds up.
    slowed = velocity - velocity * (rate * reach)
    if quadratic < _NONE:
        return velocity * reach, slowed
    stretch = quadratic * sign * velocity * reach
    if stretch <= -1.0:
        return math.nan, math.nan
    return sign * math.log1p(stretch) / quadratic, slowed / (1.0 + stretch)


@formula
def drift_in_plane(
    vx: float, vy: float, reach: float, rate: float, quadratic: float
) -> tuple[float, float, float, float]:
    """Return how far a ball travels in the plane [m], x and y, and its velocity afterwards [m/s].

    The drag opposes the velocity and keeps its direction: this is `drift` of the speed. Here
    `quadratic` is quadratic_damping/(mass length^2) [1/m].
    """
    if quadratic < _NONE:
        kept = rate * reach
        return vx * reach, vy * reach, vx - vx * kept, vy - vy * kept
    speed = math.hypot(vx, vy)
    if speed == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    travelled, slower = drift(speed, 1.0, reach, rate, quadratic)
    far, kept = travelled / speed, slower / speed
    return vx * far, vy * far, vx * kept, vy * kept


@formula
def drift_slopes(
    velocity: float, sign: float, reach: float, rate: float, quadratic: float
) -> tuple[float, float]:
    """Return how what `drift` returns changes with the velocity, [s] and [1]."""
    stretch = 1.0 + quadratic * sign * velocity * reach
    return reach / stretch, (1.0 - rate * reach) / (stretch * stretch)


@formula
def drag(velocity: float, sign: float, rate: float, quadratic: float, coulomb: float) -> float:
    """Return the deceleration by drag [rad/s^2]; `sign` is the velocity's (0 when it sticks)."""
    return rate * velocity + quadratic * velocity * abs(velocity) + coulomb * sign


@formula
def static_friction(force: float, limit: float) -> float:
    """Return the static friction [N] that opposes a tangential force, at most `limit`."""
    return min(max(force, -limit), limit)


@formula
def damping_power(
    velocity: float,
    length: float,
    damping: float,
    quadratic_damping: float,
    coulomb_damping: float,
) -> float:
    """Return the dissipated power [W], l (C w^2 + C2 |w|^3 + C0 |w|)."""
    speed = abs(velocity)
    return length * speed * (coulomb_damping + speed * (damping + speed * quadratic_damping))
