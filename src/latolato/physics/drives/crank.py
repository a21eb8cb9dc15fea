"""The motor of the experiment: a crank that moves a guided piston."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import NON_NEGATIVE, POSITIVE, choice_field, quantity_field
from latolato.core.scalar import formula
from latolato.physics.drives.base import PeriodicDrive, drives
from latolato.physics.drives.segment import CRANK, write_segment


@formula
def write_crank(out: Any, drive: Any) -> int:
    """Write the one segment of a `CrankSlider`; return 1."""
    s, phase, frequency = out[0], drive.drive_phase, drive.drive_frequency
    write_segment(s, 0.0, CRANK, phase, frequency, 0.0, drive.drive_amplitude)
    s.rod, s.side = drive.connecting_rod_length, 2.0 * drive.guide - 1.0
    return 1


@drives.register("crank_slider")
@dataclass(frozen=True, kw_only=True)
class CrankSlider(PeriodicDrive):
    """The paper's motor: a crank of radius A0 moves a guided piston by a connecting rod.

    `guide` says whether the piston lies ``"below"`` (the paper's) or ``"above"`` the crank.
    """

    write: ClassVar[Any] = staticmethod(write_crank)
    amplitude_limit: ClassVar[tuple[str, str] | None] = (
        "connecting_rod_length", "the crank would jam",
    )  # fmt: skip

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.1))
    connecting_rod_length: float = quantity_field(
        "connecting_rod_length", POSITIVE, suggested=(0.05, 1.0)
    )
    guide: str = choice_field(("below", "above"), default="below", description="side of the guide")
