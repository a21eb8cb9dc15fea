"""Thermal-like noise: independent Gaussian velocity kicks at fixed instants."""

from __future__ import annotations

import math
from dataclasses import dataclass

from latolato.core.errors import InputError
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, Range, quantity_field
from latolato.core.registry import check_fields, checked_number, named
from latolato.physics.pendulum import System

BOLTZMANN = 1.380649e-23  # J/K, exact in the SI of 2019
SEEDS = Range(0, 2**63, open_high=True)  # integer attributes of a NetCDF file
STREAMS = Range(0, 2**53, open_high=True)  # values along the axes of a sweep are floats
# The whole numbers that say which random sequence is drawn.
KEY = ("noise_seed", "noise_stream")


@named
@dataclass(frozen=True, kw_only=True)
class VelocityKicks:
    """White noise in the acceleration: kicks of deviation ``noise_strength sqrt(noise_interval)``.

    The kicks come at fixed instants whatever the step, so that a seed gives the same noise at
    every tolerance. They are drawn by a counter-based generator (Philox 4x64; Salmon et al., 2011,
    *Parallel random numbers: as easy as 1, 2, 3*) with the key
    (noise_seed, noise_stream): every stream of every seed is an independent sequence that can be
    drawn without any other, and a longer run begins with the kicks of a shorter one.

    Parameters
    ----------
    noise_strength : float
        Strength sigma [rad/s^(3/2)]; the velocity variance grows by sigma^2 per second.
    noise_seed : int
        First half of the generator's key, in [0, 2^63).
    noise_stream : int
        Second half, in [0, 2^53): which of a seed's independent sequences. A sweep gives its
        point k the stream ``noise_stream + k``.
    noise_interval : float, optional
        Time between kicks [s]; by default 1/50 of the natural period of the right ball.
    """

    noise_strength: float = quantity_field("noise_strength", NON_NEGATIVE)
    noise_seed: int = quantity_field("noise_seed", SEEDS, default=0, suggested=(0, 100))
    noise_stream: int = quantity_field("noise_stream", STREAMS, default=0, suggested=(0, 100))
    noise_interval: float | None = quantity_field(
        "noise_interval", POSITIVE, default=None, suggested=(1e-3, 0.1)
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @classmethod
    def thermal(
        cls, system: System, *, temperature: float, noise_seed: int = 0, noise_stream: int = 0
    ) -> VelocityKicks:
        """Return the noise that balances the right ball's linear damping at `temperature` [K].

        Fluctuation-dissipation: ``sigma^2 = 2 gamma k_B T/(m l^2)``, ``gamma = C/(m l)``.
        """
        if not isinstance(system, System):
            raise InputError("must be a system such as LatoLato", parameter="system", value=system)
        temperature = checked_number("temperature", temperature, NON_NEGATIVE, "K")
        ball = system.balls[0]
        rate = ball.damping / (ball.mass * ball.length)
        inertia = ball.mass * ball.length**2
        noise_strength = math.sqrt(2.0 * rate * BOLTZMANN * temperature / inertia)
        return cls(noise_strength=noise_strength, noise_seed=noise_seed, noise_stream=noise_stream)

    def spacing(self, system: System) -> float:
        """Return the time between kicks [s]."""
        return self.noise_interval or 2.0 * math.pi / system.natural_frequency / 50.0
