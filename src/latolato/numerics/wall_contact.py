"""What happens to one ball at a wall: impact, capture, and hops too small to be seen."""

from __future__ import annotations

import math

from latolato.core.scalar import formula
from latolato.physics.contacts import wall_impact

# Hops lower than this are taken as parabolas [rad]: thousands of roundings of the angle, while the
# pull changes by less than a millionth in the time.
SMALLEST_HOP = 1e-12


@formula
def hop(velocity: float, pull: float, coulomb: float) -> tuple[float, float]:
    """Return duration [s] and final speed [rad/s] of a hop too small for the angle's digits.

    A parabola: up against the deceleration `pull`, which includes the friction `coulomb`, and
    down with ``pull - 2 coulomb``. The duration is zero if the hop can be seen, or if friction
    holds the ball at its top.
    """
    fall = pull - 2.0 * coulomb
    if pull <= 0.0 or fall <= 0.0 or velocity * velocity >= 2.0 * pull * SMALLEST_HOP:
        return 0.0, 0.0
    back = abs(velocity) * math.sqrt(fall / pull)
    return abs(velocity) / pull + back / fall, back


@formula
def wall_contact(
    velocity: float, outward: float, restitution: float, rest_speed: float, coulomb: float
) -> tuple[float, float, float, bool]:
    """Return velocity after, impact loss, capture loss (both per inertia) and whether rest begins.

    `outward` is the free acceleration away from the wall. Speeds up to `rest_speed` are captured
    where bounces die out in finite time, by restitution below 1 or by Coulomb friction in flight;
    otherwise only at exactly zero speed.
    """
    presses = outward <= coulomb
    energy = 0.5 * velocity * velocity
    dies_out = restitution < 1.0 or coulomb > 0.0
    if presses and (velocity == 0.0 or (dies_out and abs(velocity) <= rest_speed)):
        return 0.0, 0.0, energy, True
    after = wall_impact(velocity, restitution)
    return after, energy - 0.5 * after * after, 0.0, presses and after == 0.0
