"""Smooth segments of the pivot's motion: the forms that all drives of the package are made of.

A number gives the form of a segment, so that one compiled kernel serves every drive.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, NamedTuple

from latolato.core.scalar import cosine, formula, sine

# Forms of the motion: a pivot at rest; a cosine of constant amplitude and frequency; one whose
# amplitude is a cubic of the time and whose frequency changes linearly; the piston of a crank; a
# quintic of the time. A cosine and a quintic may move the pivot horizontally too.
STILL, COSINE, SWEPT, CRANK, POLYNOMIAL = 0.0, 1.0, 2.0, 3.0, 4.0


class Segment(NamedTuple):
    """One smooth segment of the pivot's motion: its form and the numbers that the form reads.

    All count from `start`. The coefficients c are those of the height [m] of a polynomial and of
    the amplitude [m] of everything else, per power of a second. The coefficients x give the
    horizontal position [m]: likewise for a polynomial, ``x0 cos(q) + x1 sin(q)`` for a cosine, with
    the phase q of the height, and none for other forms.
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
    x0: float = 0.0
    x1: float = 0.0
    x2: float = 0.0
    x3: float = 0.0
    x4: float = 0.0
    x5: float = 0.0
    rod: float = 0.0  # m, a crank's connecting_rod_length
    side: float = 0.0  # +1 for a crank's guide above, -1 for one below
    jump: float = 0.0  # of the pivot's velocity at the start that the balls are given [m/s]


def written(write: Any, room: int, *given: Any) -> list[Segment]:
    """Return the segments, at most `room`, that ``number = write(out, *given)`` writes."""
    out = [SimpleNamespace(**Segment()._asdict()) for _ in range(room)]
    return [Segment(**vars(segment)) for segment in out[: write(out, *given)]]


@formula
def write_segment(
    s: Any, start: float, form: float, phase: float, frequency: float, rate: float, c0: float
) -> None:
    """Write a segment whose further numbers are zero."""
    s.start, s.form, s.phase, s.frequency, s.rate, s.c0 = start, form, phase, frequency, rate, c0
    s.c1 = s.c2 = s.c3 = s.c4 = s.c5 = s.rod = s.side = s.jump = 0.0
    s.x0 = s.x1 = s.x2 = s.x3 = s.x4 = s.x5 = 0.0


@formula
def write_next(out: Any, n: int, start: float, frequency: float, rate: float) -> int:
    """Write segment n, a cosine that carries the phase of the one before on; return n + 1."""
    p = out[n - 1]
    s = start - p.start
    phase = p.phase + s * (p.frequency + 0.5 * p.rate * s)
    write_segment(out[n], start, COSINE if rate == 0.0 else SWEPT, phase, frequency, rate, p.c0)
    return n + 1


@formula
def write_later(out: Any, p: Any, time: float) -> int:
    """Write the cosine p as one that starts at `time` [s]; return 1."""
    s, q = time - p.start, out[0]
    phase = p.phase + s * (p.frequency + 0.5 * p.rate * s)
    write_segment(q, time, p.form, phase, p.frequency + p.rate * s, p.rate, 0.0)
    q.c0 = p.c0 + s * (p.c1 + s * (p.c2 + s * p.c3))
    q.c1 = p.c1 + s * (2.0 * p.c2 + s * 3.0 * p.c3)
    q.c2, q.c3 = p.c2 + 3.0 * p.c3 * s, p.c3
    return 1


@formula
def write_change(
    out: Any, p: Any, time: float, amplitude: float, frequency: float, ramp: float
) -> int:
    """Write the segment from `time` that leads to a new amplitude and frequency, and the next.

    Height and velocity of the pivot are continuous at both ends: the amplitude is the cubic that
    begins with the value and the slope that the cosine p has there and ends level, the frequency is
    linear, the phase is carried on. The number written is returned, 2.
    """
    write_later(out, p, time)
    way = out[0]
    phase = way.phase + ramp * 0.5 * (way.frequency + frequency)
    write_segment(out[1], time + ramp, COSINE, phase, frequency, 0.0, amplitude)
    rise = (amplitude - way.c0) / ramp
    way.form, way.rate = SWEPT, (frequency - way.frequency) / ramp
    way.c2, way.c3 = (3.0 * rise - 2.0 * way.c1) / ramp, (way.c1 - 2.0 * rise) / (ramp * ramp)
    return 2


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
def _crank_bend(phase: float, p: Any) -> float:
    """Return -A [cos q + side lam (cos 2q + lam^2 sin^4 q)/(1 - lam^2 sin^2 q)^(3/2)] at q.

    That is the acceleration over the square of the frequency [m], with lam = A/L.
    """
    lam = p.c0 / p.rod
    square = sine(phase) ** 2
    inner = 1.0 - lam * lam * square
    bend = (1.0 - 2.0 * square + lam * lam * square * square) / (inner * math.sqrt(inner))
    return -p.c0 * (cosine(phase) + p.side * lam * bend)


@formula
def _crank_acceleration(s: float, p: Any) -> float:
    """Return the second time derivative of `_crank_height`."""
    return p.frequency * p.frequency * _crank_bend(p.frequency * s + p.phase, p)


@formula
def _quintic(s: float, c0: float, c1: float, c2: float, c3: float, c4: float, c5: float) -> float:
    """Return the quintic with these coefficients."""
    return c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))


@formula
def _quintic_slope(s: float, c1: float, c2: float, c3: float, c4: float, c5: float) -> float:
    """Return a quintic's first derivative."""
    return c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))


@formula
def _quintic_bend(s: float, c2: float, c3: float, c4: float, c5: float) -> float:
    """Return a quintic's second derivative."""
    return 2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))


@formula
def _other_height(s: float, p: Any) -> float:
    """Return the height of the rarer forms."""
    if p.form == SWEPT:
        return _swept_height(s, p)
    if p.form == CRANK:
        return _crank_height(s, p)
    return _quintic(s, p.c0, p.c1, p.c2, p.c3, p.c4, p.c5)


@formula
def _other_velocity(s: float, p: Any) -> float:
    """Return the velocity of the rarer forms."""
    if p.form == SWEPT:
        return _swept_velocity(s, p)
    if p.form == CRANK:
        return _crank_velocity(s, p)
    return _quintic_slope(s, p.c1, p.c2, p.c3, p.c4, p.c5)


@formula
def _other_acceleration(s: float, p: Any) -> float:
    """Return the acceleration of the rarer forms."""
    if p.form == SWEPT:
        return _swept_acceleration(s, p)
    if p.form == CRANK:
        return _crank_acceleration(s, p)
    return _quintic_bend(s, p.c2, p.c3, p.c4, p.c5)


@formula
def pivot_height(t: float, p: Any) -> float:
    """Return the height of the pivot [m] at the time t [s] in the segment p."""
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
def pivot_across(t: float, p: Any) -> float:
    """Return the horizontal position of the pivot [m], positive to the right, at the time t [s]."""
    s = t - p.start
    if p.form == COSINE:
        q = p.frequency * s + p.phase
        return p.x0 * cosine(q) + p.x1 * sine(q)
    return _quintic(s, p.x0, p.x1, p.x2, p.x3, p.x4, p.x5) if p.form == POLYNOMIAL else 0.0


@formula
def pivot_across_velocity(t: float, p: Any) -> float:
    """Return the first time derivative of `pivot_across` [m/s]."""
    s, w = t - p.start, p.frequency
    if p.form == COSINE:
        q = w * s + p.phase
        return w * (p.x1 * cosine(q) - p.x0 * sine(q))
    return _quintic_slope(s, p.x1, p.x2, p.x3, p.x4, p.x5) if p.form == POLYNOMIAL else 0.0


@formula
def pivot_across_acceleration(t: float, p: Any) -> float:
    """Return the second time derivative of `pivot_across` [m/s^2]."""
    s, w = t - p.start, p.frequency
    if p.form == COSINE:
        if p.x0 == 0.0 and p.x1 == 0.0:  # straight up and down
            return 0.0
        q = w * s + p.phase
        return -w * w * (p.x0 * cosine(q) + p.x1 * sine(q))
    return _quintic_bend(s, p.x2, p.x3, p.x4, p.x5) if p.form == POLYNOMIAL else 0.0


# Derivatives with respect to a parameter, on which a segment's numbers depend: p holds the numbers
# and d by how much each of them changes per unit of the parameter. The time since the segment's
# start changes as well, against `start`.


@formula
def _swept_parts(s: float, p: Any) -> tuple[float, float, float, float, float]:
    """Return amplitude, its first and second derivative, frequency and phase of a swept cosine."""
    amplitude = p.c0 + s * (p.c1 + s * (p.c2 + s * p.c3))
    growth = p.c1 + s * (2.0 * p.c2 + s * 3.0 * p.c3)
    bend = 2.0 * p.c2 + s * 6.0 * p.c3
    phase = p.phase + s * (p.frequency + 0.5 * p.rate * s)
    return amplitude, growth, bend, p.frequency + p.rate * s, phase


@formula
def _swept_changes(s: float, p: Any, d: Any) -> tuple[float, float, float, float, float]:
    """Return the derivatives of all that `_swept_parts` returns."""
    _, growth, bend, w, _ = _swept_parts(s, p)
    amplitude, own_growth, own_bend, own_w, phase = _swept_parts(s, d)
    later = -d.start
    return (
        amplitude + growth * later,
        own_growth + bend * later,
        own_bend + 6.0 * p.c3 * later,
        own_w + p.rate * later,
        phase + w * later,
    )


@formula
def _swept_velocity_change(s: float, p: Any, d: Any) -> float:
    """Return the derivative of `_swept_velocity`."""
    amplitude, growth, _, w, phase = _swept_parts(s, p)
    d_amplitude, d_growth, _, d_w, d_phase = _swept_changes(s, p, d)
    across = d_growth - amplitude * w * d_phase
    along = growth * d_phase + d_amplitude * w + amplitude * d_w
    return across * cosine(phase) - along * sine(phase)


@formula
def _swept_acceleration_change(s: float, p: Any, d: Any) -> float:
    """Return the derivative of `_swept_acceleration`."""
    amplitude, growth, bend, w, phase = _swept_parts(s, p)
    d_amplitude, d_growth, d_bend, d_w, d_phase = _swept_changes(s, p, d)
    along, across = bend - amplitude * w * w, 2.0 * growth * w + amplitude * p.rate
    d_along = d_bend - d_amplitude * w * w - 2.0 * amplitude * w * d_w
    d_across = 2.0 * (d_growth * w + growth * d_w) + d_amplitude * p.rate + amplitude * d.rate
    return (d_along - across * d_phase) * cosine(phase) - (d_across + along * d_phase) * sine(phase)


@formula
def _crank_velocity_change(s: float, p: Any, d: Any) -> float:
    """Return the derivative of `_crank_velocity`.

    With ``u = A sin q`` and ``r = sqrt(L^2 - u^2)`` the velocity is ``-w u (1 + side A cos q/r)``.
    """
    phase = p.frequency * s + p.phase
    turned = d.phase + d.frequency * s - p.frequency * d.start
    c, q = cosine(phase), sine(phase)
    u, du = p.c0 * q, d.c0 * q + p.c0 * c * turned
    root = math.sqrt(p.rod * p.rod - u * u)
    d_root = (p.rod * d.rod - u * du) / root
    tilt = p.side * p.c0 * c / root
    d_tilt = p.side * (d.c0 * c - p.c0 * q * turned - p.c0 * c * d_root / root) / root
    return -(d.frequency * u + p.frequency * du) * (1.0 + tilt) - p.frequency * u * d_tilt


@formula
def _crank_acceleration_change(s: float, p: Any, d: Any) -> float:
    """Return the derivative of `_crank_acceleration`: that of ``w^2`` times `_crank_bend`.

    The bend is ``-A (cos q + side lam n/m^(3/2))`` with ``n = 1 - 2 S + lam^2 S^2``,
    ``m = 1 - lam^2 S`` and ``S = sin^2 q``.
    """
    w, phase = p.frequency, p.frequency * s + p.phase
    turned = d.phase + d.frequency * s - w * d.start
    c, q, lam = cosine(phase), sine(phase), p.c0 / p.rod
    d_lam = (d.c0 - lam * d.rod) / p.rod
    square, d_square = q * q, 2.0 * q * c * turned
    n = 1.0 - 2.0 * square + lam * lam * square * square
    dn = 2.0 * (lam * lam * square - 1.0) * d_square + 2.0 * lam * square * square * d_lam
    m = 1.0 - lam * lam * square
    dm = -2.0 * lam * square * d_lam - lam * lam * d_square
    shape = n / (m * math.sqrt(m))
    d_shape = (dn - 1.5 * n * dm / m) / (m * math.sqrt(m))
    bend = -p.c0 * (c + p.side * lam * shape)
    d_bend = -d.c0 * (c + p.side * lam * shape)
    d_bend -= p.c0 * (p.side * (d_lam * shape + lam * d_shape) - q * turned)
    return w * (2.0 * d.frequency * bend + w * d_bend)


@formula
def pivot_velocity_change(t: float, p: Any, d: Any) -> float:
    """Return the derivative of `pivot_velocity` with respect to a parameter [m/s per unit]."""
    s, w = t - p.start, p.frequency
    if p.form == COSINE:
        q, turned = w * s + p.phase, d.phase + d.frequency * s - w * d.start
        return -(d.c0 * w + p.c0 * d.frequency) * sine(q) - p.c0 * w * turned * cosine(q)
    if p.form == STILL:
        return 0.0
    if p.form == SWEPT:
        return _swept_velocity_change(s, p, d)
    if p.form == CRANK:
        return _crank_velocity_change(s, p, d)
    bend = _quintic_bend(s, p.c2, p.c3, p.c4, p.c5)
    return _quintic_slope(s, d.c1, d.c2, d.c3, d.c4, d.c5) - bend * d.start


@formula
def pivot_acceleration_change(t: float, p: Any, d: Any) -> float:
    """Return the derivative of `pivot_acceleration` with respect to a parameter [m/s^2 per unit].

    A change of `start` alone, by -1, makes it the derivative with respect to the time.
    """
    s, w = t - p.start, p.frequency
    if p.form == COSINE:
        q, turned = w * s + p.phase, d.phase + d.frequency * s - w * d.start
        weaker = (d.c0 * w + 2.0 * p.c0 * d.frequency) * w
        return p.c0 * w * w * turned * sine(q) - weaker * cosine(q)
    if p.form == STILL:
        return 0.0
    if p.form == SWEPT:
        return _swept_acceleration_change(s, p, d)
    if p.form == CRANK:
        return _crank_acceleration_change(s, p, d)
    steeper = 6.0 * p.c3 + s * (24.0 * p.c4 + s * 60.0 * p.c5)
    return _quintic_bend(s, d.c2, d.c3, d.c4, d.c5) - steeper * d.start


@formula
def pivot_across_velocity_change(t: float, p: Any, d: Any) -> float:
    """Return the derivative of `pivot_across_velocity` with respect to a parameter."""
    s, w = t - p.start, p.frequency
    if p.form == COSINE:
        q, turned = w * s + p.phase, d.phase + d.frequency * s - w * d.start
        c, n = cosine(q), sine(q)
        moved = w * (d.x1 * c - d.x0 * n - (p.x1 * n + p.x0 * c) * turned)
        return moved + d.frequency * (p.x1 * c - p.x0 * n)
    if p.form != POLYNOMIAL:
        return 0.0
    bend = _quintic_bend(s, p.x2, p.x3, p.x4, p.x5)
    return _quintic_slope(s, d.x1, d.x2, d.x3, d.x4, d.x5) - bend * d.start


@formula
def pivot_across_acceleration_change(t: float, p: Any, d: Any) -> float:
    """Return the derivative of `pivot_across_acceleration` with respect to a parameter."""
    s, w = t - p.start, p.frequency
    if p.form == COSINE:
        q, turned = w * s + p.phase, d.phase + d.frequency * s - w * d.start
        c, n = cosine(q), sine(q)
        moved = d.x0 * c + d.x1 * n + (p.x1 * c - p.x0 * n) * turned
        return -w * (w * moved + 2.0 * d.frequency * (p.x0 * c + p.x1 * n))
    if p.form != POLYNOMIAL:
        return 0.0
    steeper = 6.0 * p.x3 + s * (24.0 * p.x4 + s * 60.0 * p.x5)
    return _quintic_bend(s, d.x2, d.x3, d.x4, d.x5) - steeper * d.start


# The derivative with respect to a parameter of each formula that a motion depends on.
CHANGES = {
    pivot_acceleration: pivot_acceleration_change,
    pivot_velocity: pivot_velocity_change,
    pivot_across_acceleration: pivot_across_acceleration_change,
    pivot_across_velocity: pivot_across_velocity_change,
}


@formula
def rotation(p: Any) -> tuple[float, float, float]:
    """Return strength [m/s^2], frequency [rad/s] and phase of a pivot at rest or a steady cosine.

    Its acceleration is ``strength cos(frequency t + phase)``.
    """
    w = p.frequency
    return -p.c0 * w * w, w, p.phase - w * p.start


@formula
def _swept_bound(p: Any, span: float) -> float:
    """Return a bound of |_swept_acceleration| within `span` seconds [m/s^2]."""
    fastest = max(abs(p.frequency), abs(p.frequency + p.rate * span))
    # A cubic is below the largest of its Bezier points, and so are its derivatives.
    end = p.c0 + span * (p.c1 + span * (p.c2 + span * p.c3))
    end_growth = p.c1 + span * (2.0 * p.c2 + span * 3.0 * p.c3)
    third = span / 3.0
    inner = max(abs(p.c0 + third * p.c1), abs(end - third * end_growth))
    amplitude = max(abs(p.c0), inner, abs(end))
    growth = max(abs(p.c1), abs(p.c1 + span * p.c2), abs(end_growth))
    bend = 2.0 * max(abs(p.c2), abs(p.c2 + 3.0 * p.c3 * span))
    return bend + 2.0 * growth * fastest + amplitude * (fastest * fastest + abs(p.rate))


# Phases at which a crank's acceleration is looked at, and what may be added to the largest.
_CRANK_LOOKS, _CRANK_MARGIN = 720, 1.01


@formula
def _crank_bound(p: Any) -> float:
    """Return a bound of a crank's |pivot_acceleration| [m/s^2]."""
    largest = 0.0
    for i in range(_CRANK_LOOKS):
        largest = max(largest, abs(_crank_bend(math.tau * i / _CRANK_LOOKS, p)))
    return _CRANK_MARGIN * p.frequency * p.frequency * largest


@formula
def _quintic_bound(span: float, c2: float, c3: float, c4: float, c5: float) -> float:
    """Return the largest |_quintic_bend|, a cubic: at its ends or turning points."""
    largest = max(abs(_quintic_bend(0.0, c2, c3, c4, c5)), abs(_quintic_bend(span, c2, c3, c4, c5)))
    a, b, c = 60.0 * c5, 24.0 * c4, 6.0 * c3  # zeros of the third derivative
    root = b * b - 4.0 * a * c
    if root >= 0.0:
        q = -0.5 * (b + math.copysign(math.sqrt(root), b))
        first = q / a if a != 0.0 else 0.0
        second = c / q if q != 0.0 else 0.0
        if 0.0 <= first <= span:
            largest = max(largest, abs(_quintic_bend(first, c2, c3, c4, c5)))
        if 0.0 <= second <= span:
            largest = max(largest, abs(_quintic_bend(second, c2, c3, c4, c5)))
    return largest


@formula
def _hypotenuse(a: float, b: float) -> float:
    """Return the length of (a, b); exactly |a| for b = 0, as the square root is rounded."""
    return math.sqrt(a * a + b * b)


@formula
def _ellipse_bound(p: Any) -> float:
    """Return the larger half axis of the ellipse on which a cosine moves the pivot [m]."""
    # Half the sum of two circles' radii, one for each sense of turning; |c0| for a vertical line.
    return 0.5 * (_hypotenuse(p.c0 - p.x1, p.x0) + _hypotenuse(p.c0 + p.x1, p.x0))


@formula
def acceleration_bound(p: Any, span: float) -> float:
    """Return a bound of the pivot's acceleration in the first `span` s of a segment [m/s^2]."""
    if p.form == COSINE:
        return _ellipse_bound(p) * p.frequency * p.frequency
    if p.form == SWEPT:
        return _swept_bound(p, span)
    if p.form == CRANK:
        return _crank_bound(p)
    if p.form == STILL:
        return 0.0
    up = _quintic_bound(span, p.c2, p.c3, p.c4, p.c5)
    return _hypotenuse(up, _quintic_bound(span, p.x2, p.x3, p.x4, p.x5))


@formula
def _span(segments: Any, i: int, end: float) -> float:
    """Return how long segment i lasts [s]; a last one that never ends is steady: 0 will do."""
    until = segments[i + 1].start if i + 1 < len(segments) else end
    return until - segments[i].start if until < math.inf else 0.0


@formula
def largest_acceleration(segments: Any, end: float) -> float:
    """Return a bound of the pivot's acceleration in all segments, the last up to `end` [m/s^2]."""
    largest = 0.0
    for i in range(len(segments)):
        largest = max(largest, acceleration_bound(segments[i], _span(segments, i, end)))
    return largest


@formula
def fastest_frequency(segments: Any, end: float) -> float:
    """Return the largest angular frequency that matters in all segments [rad/s].

    For a crank it is that of the strongest overtone, for polynomials that of a cosine of the same
    larger extent and acceleration.
    """
    fastest = steepest = 0.0
    low, high, left, right = math.inf, -math.inf, math.inf, -math.inf
    for i in range(len(segments)):
        p, span = segments[i], _span(segments, i, end)
        if p.form == POLYNOMIAL:
            first, last = p.c0, _quintic(span, p.c0, p.c1, p.c2, p.c3, p.c4, p.c5)
            low, high = min(low, first, last), max(high, first, last)
            first, last = p.x0, _quintic(span, p.x0, p.x1, p.x2, p.x3, p.x4, p.x5)
            left, right = min(left, first, last), max(right, first, last)
            steepest = max(steepest, acceleration_bound(p, span))
        elif p.form == CRANK:
            lam = p.c0 / p.rod
            fastest = max(fastest, p.frequency / math.sqrt(1.0 - lam * lam) * (1.0 + lam))
        else:
            fastest = max(fastest, abs(p.frequency), abs(p.frequency + p.rate * span))
    extent = max(high - low, right - left)
    return max(fastest, math.sqrt(2.0 * steepest / extent)) if extent > 0.0 else fastest
