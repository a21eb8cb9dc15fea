"""A pivot at rest and a pivot that moves like a cosine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.physics.drives.base import Drive, Stretch, drives
from latolato.quantities import ANY, NON_NEGATIVE, quantity_field
from latolato.scalar import cosine, formula, sine


@formula
def _nothing(t: float, p: Any) -> float:
    """Return 0."""
    return 0.0


@formula
def _no_rotation(p: Any) -> tuple[float, float, float]:
    """Return no strength, frequency or phase."""
    return 0.0, 0.0, 0.0


@drives.register("static")
@dataclass(frozen=True, kw_only=True)
class Static(Drive):
    """A pivot at rest; what ``drive=None`` means."""

    height: ClassVar[Any] = staticmethod(_nothing)
    velocity: ClassVar[Any] = staticmethod(_nothing)
    acceleration: ClassVar[Any] = staticmethod(_nothing)
    rotation: ClassVar[Any] = staticmethod(_no_rotation)

    def stretches(self, duration: float) -> list[Stretch]:
        """Return one stretch of rest."""
        return [(0.0, (0.0,))]


@formula
def _harmonic_height(t: float, p: Any) -> float:
    """Return A0 cos(w t + phase)."""
    return p.drive_amplitude * cosine(p.drive_frequency * t + p.drive_phase)


@formula
def _harmonic_velocity(t: float, p: Any) -> float:
    """Return -A0 w sin(w t + phase)."""
    w = p.drive_frequency
    return -p.drive_amplitude * w * sine(w * t + p.drive_phase)


@formula
def _harmonic_acceleration(t: float, p: Any) -> float:
    """Return -A0 w^2 cos(w t + phase)."""
    w = p.drive_frequency
    return -p.drive_amplitude * w * w * cosine(w * t + p.drive_phase)


@formula
def _harmonic_rotation(p: Any) -> tuple[float, float, float]:
    """Return -A0 w^2, the frequency and the phase."""
    w = p.drive_frequency
    return -p.drive_amplitude * w * w, w, p.drive_phase


@drives.register("harmonic")
@dataclass(frozen=True, kw_only=True)
class Harmonic(Drive):
    """``y0 = A0 cos(w t + phase)`` (Paper, before eq8)."""

    stretch_fields: ClassVar[tuple[str, ...]] = (
        "drive_amplitude",
        "drive_frequency",
        "drive_phase",
    )
    height: ClassVar[Any] = staticmethod(_harmonic_height)
    velocity: ClassVar[Any] = staticmethod(_harmonic_velocity)
    acceleration: ClassVar[Any] = staticmethod(_harmonic_acceleration)
    rotation: ClassVar[Any] = staticmethod(_harmonic_rotation)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the one stretch."""
        return [(0.0, (self.drive_amplitude, self.drive_frequency, self.drive_phase))]

    @property
    def fastest_frequency(self) -> float:
        """The drive's angular frequency [rad/s]."""
        return self.drive_frequency

    @property
    def largest_acceleration(self) -> float:
        """A0 w^2 [m/s^2]."""
        return self.drive_amplitude * self.drive_frequency * self.drive_frequency
