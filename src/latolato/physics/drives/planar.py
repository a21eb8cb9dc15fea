"""A pivot that moves vertically and horizontally with one frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import ANY, NON_NEGATIVE, quantity_field
from latolato.core.scalar import cosine, formula, sine
from latolato.physics.drives.base import Drive, drives
from latolato.physics.drives.segment import COSINE, write_segment


@formula
def write_ellipse(out: Any, drive: Any) -> int:
    """Write the one segment of a `PlanarHarmonic` drive; return 1."""
    phase = drive.vertical_phase
    write_segment(out[0], 0.0, COSINE, phase, drive.drive_frequency, 0.0, drive.vertical_amplitude)
    lead = drive.horizontal_phase - phase
    out[0].x0 = drive.horizontal_amplitude * cosine(lead)
    out[0].x1 = -drive.horizontal_amplitude * sine(lead)
    return 1


@drives.register("planar_harmonic")
@dataclass(frozen=True, kw_only=True)
class PlanarHarmonic(Drive):
    """``x0 = Ax cos(w t + phase_x), y0 = Ay cos(w t + phase_y)``: the pivot moves on an ellipse.

    Equal phases make it a tilted line, a difference of pi/2 an ellipse with upright axes.
    """

    write: ClassVar[Any] = staticmethod(write_ellipse)
    across_parameter: ClassVar[str | None] = "horizontal_amplitude"

    vertical_amplitude: float = quantity_field(
        "vertical_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5)
    )
    horizontal_amplitude: float = quantity_field(
        "horizontal_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5)
    )
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    vertical_phase: float = quantity_field(
        "vertical_phase", ANY, default=0.0, suggested=(0.0, 6.2832)
    )
    horizontal_phase: float = quantity_field(
        "horizontal_phase", ANY, default=0.0, suggested=(0.0, 6.2832)
    )
