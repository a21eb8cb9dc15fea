"""The motor of the experiment: a crank that moves a guided piston."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from latolato.errors import InputError
from latolato.physics.drives.base import Drive, drives
from latolato.physics.drives.stretch import CRANK, Stretch, pivot_acceleration
from latolato.quantities import ANY, NON_NEGATIVE, POSITIVE, quantity_field


@drives.register("crank_slider")
@dataclass(frozen=True, kw_only=True)
class CrankSlider(Drive):
    """The paper's motor: a crank of radius A0 moves a guided piston by a connecting rod.

    `guide` says whether the piston lies ``"below"`` (the paper's) or ``"above"`` the crank.
    """

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.1))
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    connecting_rod_length: float = quantity_field(
        "connecting_rod_length", POSITIVE, suggested=(0.05, 1.0)
    )
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))
    guide: str = field(
        default="below",
        metadata={"description": "side of the guide", "choices": ("below", "above")},
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.guide not in ("below", "above"):
            raise InputError(f"guide must be 'below' or 'above', got {self.guide!r}")
        if not self.drive_amplitude < self.connecting_rod_length:
            raise InputError(
                f"drive_amplitude must be less than connecting_rod_length "
                f"{self.connecting_rod_length:g}, got {self.drive_amplitude:g}: the crank would jam"
            )

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the one stretch."""
        return [
            Stretch(
                form=CRANK,
                phase=self.drive_phase,
                frequency=self.drive_frequency,
                c0=self.drive_amplitude,
                rod=self.connecting_rod_length,
                side=self.side,
            )
        ]

    @property
    def side(self) -> float:
        """+1 for a guide above the crank, -1 for one below."""
        return -1.0 if self.guide == "below" else 1.0

    @property
    def fastest_frequency(self) -> float:
        """Angular frequency of the strongest overtone that matters [rad/s]."""
        lam = self.drive_amplitude / self.connecting_rod_length
        return self.drive_frequency / math.sqrt(1.0 - lam * lam) * (1.0 + lam)

    @property
    def largest_acceleration(self) -> float:
        """Bound of the acceleration [m/s^2]: its largest size at 720 phases, and a percent."""
        (stretch,) = self.stretches(0.0)
        turning = stretch._replace(phase=0.0, frequency=1.0)  # the time is the phase
        samples = (pivot_acceleration(math.tau * i / 720.0, turning) for i in range(720))
        return 1.01 * self.drive_frequency**2 * max(abs(a) for a in samples)
