"""Thermal-like noise: independent Gaussian velocity kicks at fixed instants."""

from __future__ import annotations

import math
from dataclasses import dataclass

from latolato.physics.pendulum import System
from latolato.quantities import NON_NEGATIVE, POSITIVE, Range, quantity_field
from latolato.registry import checked_number, number_fields

BOLTZMANN = 1.380649e-23  # J/K, exact in the SI of 2019
LARGEST_SEED = 2**63 - 1  # the largest integer attribute of a NetCDF file


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
        Seed of NumPy's PCG64 generator, in [0, 2^63).
    interval : float, optional
        Time between kicks [s]; by default 1/50 of the natural period of the right ball.
    """

    strength: float = quantity_field("noise_strength", NON_NEGATIVE)
    seed: int = quantity_field("noise_seed", Range(0, LARGEST_SEED), default=0, suggested=(0, 100))
    interval: float | None = quantity_field(
        "noise_interval", POSITIVE, default=None, suggested=(1e-3, 0.1)
    )

    def __post_init__(self) -> None:
        seed: object = self.seed  # callers may hand over anything
        if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
            raise ValueError(f"seed must be a non-negative integer, got {seed!r}")
        if seed > LARGEST_SEED:
            raise ValueError(f"seed must lie in [0, 2^63), got {seed}; files hold no larger one")
        for field in number_fields(self):
            value = getattr(self, field.name)
            if field.name == "seed" or (value is None and field.default is None):
                continue
            unit = field.metadata["quantity"].unit
            number = checked_number(field.name, value, field.metadata["range"], unit)
            object.__setattr__(self, field.name, number)

    @classmethod
    def thermal(cls, system: System, *, temperature: float, seed: int = 0) -> VelocityKicks:
        """Return the noise that balances the right ball's linear damping at `temperature` [K].

        Fluctuation-dissipation: ``sigma^2 = 2 gamma k_B T/(m l^2)``, ``gamma = C/(m l)``.
        """
        if not isinstance(system, System):
            raise TypeError(f"system must be a system such as LatoLato, got {system!r}")
        temperature = checked_number("temperature", temperature, NON_NEGATIVE, "K")
        ball = system.balls[0]
        rate = ball.damping / (ball.mass * ball.length)
        inertia = ball.mass * ball.length**2
        return cls(strength=math.sqrt(2.0 * rate * BOLTZMANN * temperature / inertia), seed=seed)

    def spacing(self, system: System) -> float:
        """Return the time between kicks [s]."""
        return self.interval or 2.0 * math.pi / system.natural_frequency / 50.0
