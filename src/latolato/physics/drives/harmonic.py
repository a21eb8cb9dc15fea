"""A pivot at rest and a pivot that moves like a cosine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.scalar import formula
from latolato.physics.drives.base import Drive, PeriodicDrive, drives
from latolato.physics.drives.segment import COSINE, STILL, rotation, write_segment


@formula
def write_rest(out: Any, drive: Any) -> int:
    """Write one segment of rest; return 1."""
    write_segment(out[0], 0.0, STILL, 0.0, 0.0, 0.0, 0.0)
    return 1


@formula
def write_cosine(out: Any, drive: Any) -> int:
    """Write the one segment of a `Harmonic` drive; return 1."""
    phase, frequency, amplitude = drive.drive_phase, drive.drive_frequency, drive.drive_amplitude
    write_segment(out[0], 0.0, COSINE, phase, frequency, 0.0, amplitude)
    return 1


@drives.register("fixed_pivot")
@dataclass(frozen=True, kw_only=True)
class FixedPivot(Drive):
    """A pivot at rest, as without a drive."""

    moves: ClassVar[bool] = False
    is_sinusoidal: ClassVar[bool] = True
    rotation: ClassVar[Any] = staticmethod(rotation)
    write: ClassVar[Any] = staticmethod(write_rest)


@drives.register("harmonic")
@dataclass(frozen=True, kw_only=True)
class Harmonic(PeriodicDrive):
    """``y0 = A0 cos(w t + phase)`` (Paper, before eq8)."""

    is_sinusoidal: ClassVar[bool] = True
    rotation: ClassVar[Any] = staticmethod(rotation)
    write: ClassVar[Any] = staticmethod(write_cosine)
