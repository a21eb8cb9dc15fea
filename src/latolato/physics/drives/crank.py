"""The motor of the experiment: a crank that moves a guided piston."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from latolato.errors import InputError
from latolato.physics.drives.base import Drive, Stretch, drives
from latolato.quantities import ANY, NON_NEGATIVE, POSITIVE, quantity_field
from latolato.scalar import cosine, formula, sine


@formula
def _crank_height(t: float, p: Any) -> float:
    """Return A0 cos p + s (sqrt(L^2 - A0^2 sin^2 p) - L), p = w t + phase."""
    a, rod = p.drive_amplitude, p.connecting_rod_length
    phase = p.drive_frequency * t + p.drive_phase
    x = a * sine(phase)
    # sqrt(L^2 - x^2) - L without cancellation
    return a * cosine(phase) - p.side * x * x / (rod + math.sqrt(rod * rod - x * x))


@formula
def _crank_velocity(t: float, p: Any) -> float:
    """Return the time derivative of `_crank_height`."""
    a, rod, w = p.drive_amplitude, p.connecting_rod_length, p.drive_frequency
    phase = w * t + p.drive_phase
    x = a * sine(phase)
    root = math.sqrt(rod * rod - x * x)
    return -w * x * (1.0 + p.side * a * cosine(phase) / root)


@formula
def _crank_acceleration(t: float, p: Any) -> float:
    """Return -A0 w^2 [cos p + s lam (cos 2p + lam^2 sin^4 p)/(1 - lam^2 sin^2 p)^(3/2)]."""
    a, w = p.drive_amplitude, p.drive_frequency
    lam = a / p.connecting_rod_length
    phase = w * t + p.drive_phase
    square = sine(phase) ** 2
    inner = 1.0 - lam * lam * square
    bend = (1.0 - 2.0 * square + lam * lam * square * square) / (inner * math.sqrt(inner))
    return -a * w * w * (cosine(phase) + p.side * lam * bend)


class _Phase(NamedTuple):
    """A crank at drive_frequency 1, whose time is its phase."""

    drive_amplitude: float
    drive_frequency: float
    connecting_rod_length: float
    side: float
    drive_phase: float = 0.0


@drives.register("crank_slider")
@dataclass(frozen=True, kw_only=True)
class CrankSlider(Drive):
    """The paper's motor: a crank of radius A0 moves a guided piston by a connecting rod.

    `guide` says whether the piston lies ``"below"`` (the paper's) or ``"above"`` the crank.
    """

    stretch_fields: ClassVar[tuple[str, ...]] = (
        "drive_amplitude",
        "drive_frequency",
        "drive_phase",
        "connecting_rod_length",
        "side",
    )
    height: ClassVar[Any] = staticmethod(_crank_height)
    velocity: ClassVar[Any] = staticmethod(_crank_velocity)
    acceleration: ClassVar[Any] = staticmethod(_crank_acceleration)

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
        a, w, phase = self.drive_amplitude, self.drive_frequency, self.drive_phase
        return [(0.0, (a, w, phase, self.connecting_rod_length, self.side))]

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
        stretch = _Phase(self.drive_amplitude, 1.0, self.connecting_rod_length, self.side)
        samples = (_crank_acceleration(math.tau * i / 720.0, stretch) for i in range(720))
        return 1.01 * self.drive_frequency**2 * max(abs(a) for a in samples)
