"""A pivot at rest and a pivot that moves like a cosine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import ANY, NON_NEGATIVE, quantity_field
from latolato.core.scalar import formula
from latolato.physics.drives.base import Drive, drives
from latolato.physics.drives.stretch import COSINE, STILL, rotation, write_stretch


@formula
def write_rest(out: Any, drive: Any) -> int:
    """Write one stretch of rest; return 1."""
    write_stretch(out[0], 0.0, STILL, 0.0, 0.0, 0.0, 0.0)
    return 1


@formula
def write_cosine(out: Any, drive: Any) -> int:
    """Write the one stretch of a `Harmonic` drive; return 1."""
    phase, frequency, amplitude = drive.drive_phase, drive.drive_frequency, drive.drive_amplitude
    write_stretch(out[0], 0.0, COSINE, phase, frequency, 0.0, amplitude)
    return 1


@drives.register("fixed_pivot")
@dataclass(frozen=True, kw_only=True)
class FixedPivot(Drive):
    """A pivot at rest; what ``drive=None`` means."""

    rotation: ClassVar[Any] = staticmethod(rotation)
    write: ClassVar[Any] = staticmethod(write_rest)


@drives.register("harmonic")
@dataclass(frozen=True, kw_only=True)
class Harmonic(Drive):
    """``y0 = A0 cos(w t + phase)`` (Paper, before eq8)."""

    rotation: ClassVar[Any] = staticmethod(rotation)
    write: ClassVar[Any] = staticmethod(write_cosine)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))
