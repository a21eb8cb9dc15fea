"""Drag laws: linear (the paper's C), quadratic and Coulomb, and any sum of them.

The tangential force on a ball is ``-(C w + C2 w |w| + C0 sgn w)`` with w the angular velocity, so
the deceleration is ``c1 w + c2 w |w| + c0 sgn w`` with ``c = C/(m l)`` each. Within a step the
sign of the velocity is constant: a zero of the velocity ends the step (see `numerics.engine`), so
that each law keeps its full order there.
"""

from __future__ import annotations

import math
from typing import Any

from latolato.core.scalar import formula

# Below this argument six terms of (1 - exp(-x))/x miss less than 1e-17 of it.
_SERIES = 4e-3
# Less quadratic drag than this changes no digit, and near the smallest floats spoils all of them.
_NONE = 1e-100


@formula
def effective_time(rate: float, time: float) -> float:
    """(1 - exp(-rate time))/rate [s]: the distance per initial speed under linear drag."""
    x = rate * time
    if abs(x) < _SERIES:
        return time * (
            1.0 - x * (1 / 2 - x * (1 / 6 - x * (1 / 24 - x * (1 / 120 - x * (1 / 720)))))
        )
    return -math.expm1(-x) / rate


@formula
def drift(velocity: float, sign: float, time: float, body: Any) -> tuple[float, float]:
    """Angle travelled [rad] and angular velocity after a force-free interval.

    Exact flow of ``w' = -c1 w - c2 sign w^2``: with the effective time
    ``E = (1 - exp(-c1 t))/c1``, ``d = 1 + c2 sign w E``, ``w -> w (1 - c1 E)/d`` and the travelled
    angle is ``ln(d)/(c2 sign)``, or ``w E`` for c2 = 0.

    Parameters
    ----------
    velocity : float
        Angular velocity at the start [rad/s].
    sign : float
        Sign of the velocity in this interval, +1 or -1; only used by quadratic drag.
    time : float
        `effective_time` of the interval [s]; negative in the backward substeps of a splitting.
    body : record
        ``damping_rate`` is c1 [1/s], ``quadratic`` c2 [1]; see `numerics.records.BODY`.

    Notes
    -----
    A velocity against its sign grows without bound within ``1/(c2 |w|)``: d is then 0, and both
    results are NaN. A step that ends with NaN has thus gone far beyond a turning point.
    """
    return _flow(velocity, sign, time, body.damping_rate, body.quadratic)


@formula
def drift_slopes(velocity: float, sign: float, time: float, body: Any) -> tuple[float, float]:
    """Derivatives of what `drift` returns by the velocity, [s] and [1]."""
    return _flow_slopes(velocity, sign, time, body.damping_rate, body.quadratic)


@formula
def drift_in_plane(
    vx: float, vy: float, time: float, body: Any
) -> tuple[float, float, float, float]:
    """Distance that a ball travels in the plane [m], x and y, and its velocity afterwards [m/s].

    The drag opposes the velocity and keeps its direction: this is the flow of the speed, with
    ``c2/l`` [1/m].
    """
    rate, quadratic = body.damping_rate, body.quadratic * body.inverse_length
    if quadratic < _NONE:
        kept = rate * time
        return vx * time, vy * time, vx - vx * kept, vy - vy * kept
    speed = math.hypot(vx, vy)
    if speed == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    travelled, slower = _flow(speed, 1.0, time, rate, quadratic)
    far, kept = travelled / speed, slower / speed
    return vx * far, vy * far, vx * kept, vy * kept


@formula
def drift_slopes_in_plane(
    speed: float, time: float, body: Any
) -> tuple[float, float, float, float]:
    """Derivatives of `drift_in_plane` by the velocity: along it [s] and [1], and across it."""
    rate, quadratic = body.damping_rate, body.quadratic * body.inverse_length
    far, kept = _flow_slopes(speed, 1.0, time, rate, quadratic)
    if speed == 0.0:
        return far, kept, far, kept
    travelled, slower = _flow(speed, 1.0, time, rate, quadratic)
    return far, kept, travelled / speed, slower / speed


@formula
def _flow(
    velocity: float, sign: float, time: float, rate: float, quadratic: float
) -> tuple[float, float]:
    """See `drift`."""
    # Not velocity * (1 - c1 E): the rounding of that factor is the same in every step and adds up.
    slowed = velocity - velocity * (rate * time)
    if quadratic < _NONE:
        return velocity * time, slowed
    excess = quadratic * sign * velocity * time
    if excess <= -1.0:
        return math.nan, math.nan
    return sign * math.log1p(excess) / quadratic, slowed / (1.0 + excess)


@formula
def _flow_slopes(
    velocity: float, sign: float, time: float, rate: float, quadratic: float
) -> tuple[float, float]:
    """See `drift_slopes`."""
    if quadratic < _NONE:
        return time, 1.0 - rate * time
    divisor = 1.0 + quadratic * sign * velocity * time
    return time / divisor, (1.0 - rate * time) / (divisor * divisor)


# Below this argument the series of `effective_time_slope` and `_log_excess` are exact enough.
_SERIES_OF_SLOPES = 0.01


@formula
def effective_time_slope(rate: float, time: float) -> float:
    """Derivative of `effective_time` with respect to the rate [s^2]."""
    x = rate * time
    if abs(x) < _SERIES_OF_SLOPES:
        terms = 1 / 2 - x * (1 / 3 - x * (1 / 8 - x * (1 / 30 - x * (1 / 144 - x * (1 / 840)))))
        return -time * time * terms
    return (time * math.exp(-x) + math.expm1(-x) / rate) / rate


@formula
def _log_excess(x: float) -> float:
    """``(x/(1 + x) - ln(1 + x))/x^2``, -1/2 at zero."""
    if abs(x) < _SERIES_OF_SLOPES:
        total = 0.0
        for k in range(8, -1, -1):
            total = (k + 1) / (k + 2) - x * total
        return -total
    return (x / (1.0 + x) - math.log1p(x)) / (x * x)


@formula
def drift_rate_weights(
    velocity: float, sign: float, time: float, time_slope: float, body: Any
) -> tuple[float, float]:
    """Derivatives of what `drift` returns by ``damping_rate``, at a fixed velocity [rad s], [rad].

    With ``d = 1 + c2 sign w E`` the travelled angle ``ln(d)/(c2 sign)`` has the derivative ``w/d``
    by E, and the velocity afterwards is ``w (1 - c1 E)/d``.

    Parameters
    ----------
    time, time_slope : float
        E, and its `effective_time_slope` [s^2].
    """
    return _rate_weights(velocity, sign, time, time_slope, body.damping_rate, body.quadratic)


@formula
def drift_quadratic_weights(
    velocity: float, sign: float, time: float, body: Any
) -> tuple[float, float]:
    """Derivatives of what `drift` returns by ``quadratic``, at a fixed velocity [rad], [rad/s].

    With ``x = c2 sign w E`` and ``d = 1 + x`` that of the travelled angle ``ln(d)/(c2 sign)`` is
    ``sign (w E)^2 (x/d - ln d)/x^2``, and the velocity afterwards is ``w (1 - c1 E)/d``.
    """
    return _quadratic_weights(velocity, sign, time, body.damping_rate, body.quadratic)


@formula
def drift_changes_in_plane(
    speed: float, interval: float, body: Any, change: Any
) -> tuple[float, float]:
    """Derivatives of the way and the speed of `drift_in_plane` with respect to a parameter."""
    quadratic = body.quadratic * body.inverse_length
    grown = change.quadratic * body.inverse_length + body.quadratic * change.inverse_length
    rate, rate_change = body.damping_rate, change.damping_rate
    time, time_slope = effective_time(rate, interval), effective_time_slope(rate, interval)
    way, slower = _rate_weights(speed, 1.0, time, time_slope, rate, quadratic)
    longer, drawn = _quadratic_weights(speed, 1.0, time, rate, quadratic)
    return way * rate_change + longer * grown, slower * rate_change + drawn * grown


@formula
def _rate_weights(
    velocity: float, sign: float, time: float, time_slope: float, rate: float, quadratic: float
) -> tuple[float, float]:
    """See `drift_rate_weights`."""
    slowed = time + rate * time_slope
    if quadratic < _NONE:
        return velocity * time_slope, -velocity * slowed
    divisor = 1.0 + quadratic * sign * velocity * time
    kept = (1.0 - rate * time) * sign / divisor
    slowed += kept * quadratic * velocity * time_slope
    return velocity * time_slope / divisor, -velocity * slowed / divisor


@formula
def _quadratic_weights(
    velocity: float, sign: float, time: float, rate: float, quadratic: float
) -> tuple[float, float]:
    """See `drift_quadratic_weights`."""
    way = velocity * time
    x, divisor = quadratic * sign * way, 1.0 + quadratic * sign * way
    kept = (1.0 - rate * time) * sign / divisor
    return sign * way * way * _log_excess(x), -velocity * kept * way / divisor


@formula
def viscous_drag_slope(velocity: float, body: Any) -> float:
    """Derivative of `viscous_drag` with respect to the velocity [1/s]."""
    slope: float = body.damping_rate + 2.0 * body.quadratic * abs(velocity)
    return slope


@formula
def viscous_drag(velocity: float, body: Any) -> float:
    """Deceleration by all drag that vanishes with the velocity [rad/s^2]."""
    slowing: float = body.damping_rate * velocity + body.quadratic * velocity * abs(velocity)
    return slowing


@formula
def drag(velocity: float, sign: float, body: Any) -> float:
    """Deceleration by all drag [rad/s^2]; `sign` is the velocity's (0 when it sticks)."""
    slowing: float = viscous_drag(velocity, body) + body.coulomb * sign
    return slowing


@formula
def slowing_in_plane(speed: float, body: Any) -> float:
    """Deceleration per velocity of a ball that moves freely in the plane [1/s]."""
    slowing: float = body.damping_rate + body.quadratic * body.inverse_length * speed
    return slowing


@formula
def divergence(time: float, travelled: float, body: Any) -> float:
    """Logarithm of the tangent map's determinant after a time and an angle travelled [1]."""
    shrinks: float = body.damping_rate * time + 2.0 * body.quadratic * abs(travelled)
    return -shrinks


@formula
def is_nonsmooth(body: Any) -> bool:
    """Whether any drag is not smooth where the velocity is zero."""
    return bool(body.quadratic > 0.0 or body.coulomb > 0.0)


@formula
def drag_force(
    velocity: float, sign: float, damping: float, quadratic_damping: float, coulomb_damping: float
) -> float:
    """Tangential force that opposes the motion of a ball [N]: C w + C2 w |w| + C0 sgn w."""
    return (
        damping * velocity + quadratic_damping * velocity * abs(velocity) + coulomb_damping * sign
    )


@formula
def static_friction(force: float, limit: float) -> float:
    """Static friction [N] that opposes a tangential force, at most `limit`."""
    return min(max(force, -limit), limit)


@formula
def damping_power(
    velocity: float,
    length: float,
    damping: float,
    quadratic_damping: float,
    coulomb_damping: float,
) -> float:
    """Dissipated power [W], l (C w^2 + C2 |w|^3 + C0 |w|)."""
    speed = abs(velocity)
    return length * speed * (coulomb_damping + speed * (damping + speed * quadratic_damping))
