"""Thermal-like noise: independent Gaussian velocity kicks at fixed instants."""

from __future__ import annotations

import math
from dataclasses import dataclass

from latolato.physics.pendulum import System
from latolato.quantities import NON_NEGATIVE, POSITIVE, quantity_field
from latolato.registry import check_fields, checked_number

BOLTZMANN = 1.380649e-23  # J/K, exact in the SI of 2019


@dataclass(frozen=True, kw_only=True)
class VelocityKicks:
    """Kicks of standard deviation ``strength sqrt(interval)``: white noise in the acceleration.

    The kicks come at fixed instants whatever the step, so that a seed gives the same noise at
    every tolerance.

    Parameters
    ----------
    strength : float
        Noise strength sigma [rad/s^(3/2)]; the velocity variance grows by sigma^2 per second.
    seed : int
        Seed of NumPy's PCG64 generator.
    interval : float, optional
        Time between kicks [s]; by default 1/50 of the natural period of the right ball.
    """

    strength: float = quantity_field("noise_strength", NON_NEGATIVE)
    seed: int = 0
    interval: float | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        seed: object = self.seed  # callers may hand over anything
        if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
            raise ValueError(f"seed must be a non-negative integer, got {seed!r}")
        if self.interval is not None:
            interval = checked_number("interval", self.interval, POSITIVE, "s")
            object.__setattr__(self, "interval", interval)

    @classmethod
    def thermal(cls, system: System, *, temperature: float, seed: int = 0) -> VelocityKicks:
        """Return the noise that balances the right ball's linear damping at `temperature` [K].

        Fluctuation-dissipation: ``sigma^2 = 2 gamma k_B T/(m l^2)``, ``gamma = C/(m l)``.
        """
        if not (math.isfinite(temperature) and temperature >= 0):
            raise ValueError(f"temperature must lie in [0, inf) K, got {temperature}")
        ball = system.balls[0]
        rate = ball.damping / (ball.mass * ball.length)
        inertia = ball.mass * ball.length**2
        return cls(strength=math.sqrt(2.0 * rate * BOLTZMANN * temperature / inertia), seed=seed)

    def spacing(self, system: System) -> float:
        """Return the time between kicks [s]."""
        return self.interval or 2.0 * math.pi / system.natural_frequency / 50.0
