"""The solution within a step, as the quintic that fits angle, velocity and acceleration."""

from __future__ import annotations

from latolato.core.scalar import formula


@formula
def quintic_terms(
    h: float, x0: float, v0: float, a0: float, x1: float, v1: float, a1: float
) -> tuple[float, float, float, float, float]:
    """Return the factors of the powers 1 to 5 of the share of the step."""
    d = x1 - x0
    b1, c1 = v0 * h, 0.5 * a0 * h * h
    b2, c2 = v1 * h, 0.5 * a1 * h * h
    r0 = d - b1 - c1
    r1 = b2 - b1 - 2.0 * c1
    r2 = c2 - c1
    p3 = 10.0 * r0 - 4.0 * r1 + r2
    p4 = -15.0 * r0 + 7.0 * r1 - 2.0 * r2
    p5 = 6.0 * r0 - 3.0 * r1 + r2
    return b1, c1, p3, p4, p5


@formula
def quintic(
    u: float, h: float, x0: float, v0: float, a0: float, x1: float, v1: float, a1: float
) -> float:
    """Return the angle at the share `u` of a step of length h [rad]; its error goes as h^6.

    Written from the nearer end, so that it returns the ends exactly.
    """
    b1, c1, p3, p4, p5 = quintic_terms(h, x0, v0, a0, x1, v1, a1)
    return x0 + u * (b1 + u * (c1 + u * (p3 + u * (p4 + u * p5))))


@formula
def quintic_bounds(
    h: float, x0: float, v0: float, a0: float, x1: float, v1: float, a1: float
) -> tuple[float, float]:
    """Return bounds of the quintic between its ends: its lowest and highest inner Bezier points."""
    b1, c1, b2, c2 = 0.2 * h * v0, 0.05 * h * h * a0, 0.2 * h * v1, 0.05 * h * h * a1
    p, q, r, s = x0 + b1, x0 + 2.0 * b1 + c1, x1 - b2, x1 - 2.0 * b2 + c2
    return min(min(p, q), min(r, s)), max(max(p, q), max(r, s))


@formula
def turning_angle(
    h: float, x0: float, v0: float, a0: float, x1: float, v1: float, a1: float
) -> float:
    """Return the angle at which the velocity passes zero within a step, x1 if it does not [rad].

    The zero of the velocity's cubic is found by Newton from the secant; the angle is stationary
    there, so that its error is of the order of the step's own.
    """
    if not v0 * v1 < 0.0:
        return x1
    # The cubic through velocities and accelerations at both ends.
    change = v1 - v0
    b, c2, c3 = a0 * h, 3.0 * change - (2.0 * a0 + a1) * h, -2.0 * change + (a0 + a1) * h
    u = -v0 / change
    for _ in range(2):
        slope = b + u * (2.0 * c2 + 3.0 * u * c3)
        steep = slope if abs(slope) > 1e-3 * abs(change) else change
        u = min(max(u - (v0 + u * (b + u * (c2 + u * c3))) / steep, 0.0), 1.0)
    return quintic(u, h, x0, v0, a0, x1, v1, a1)
