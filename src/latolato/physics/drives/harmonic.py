"""A pivot at rest and a pivot that moves like a cosine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.physics.drives.base import Drive, drives
from latolato.physics.drives.stretch import COSINE, Stretch, rotation
from latolato.quantities import ANY, NON_NEGATIVE, quantity_field


@drives.register("static")
@dataclass(frozen=True, kw_only=True)
class Static(Drive):
    """A pivot at rest; what ``drive=None`` means."""

    rotation: ClassVar[Any] = staticmethod(rotation)

    def stretches(self, duration: float) -> list[Stretch]:
        """Return one stretch of rest."""
        return [Stretch()]


@drives.register("harmonic")
@dataclass(frozen=True, kw_only=True)
class Harmonic(Drive):
    """``y0 = A0 cos(w t + phase)`` (Paper, before eq8)."""

    rotation: ClassVar[Any] = staticmethod(rotation)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the one stretch."""
        return [
            Stretch(
                form=COSINE,
                phase=self.drive_phase,
                frequency=self.drive_frequency,
                c0=self.drive_amplitude,
            )
        ]
