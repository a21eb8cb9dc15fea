"""A cosine whose amplitude and frequency both change smoothly from stage to stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import ANY, NON_NEGATIVE, POSITIVE, array_field, quantity_field
from latolato.core.rules import broken_rule
from latolato.core.scalar import formula
from latolato.physics.drives.base import (
    Drive,
    check_stage_times,
    checked_lists,
    drives,
)
from latolato.physics.drives.segment import COSINE, write_change, write_segment


@formula
def write_stages(out: Any, drive: Any) -> int:
    """Write the segments of a `StagedHarmonic` and of its changes; return their number."""
    amplitude, frequency = drive.drive_amplitudes[0], drive.drive_frequencies[0]
    write_segment(out[0], 0.0, COSINE, drive.drive_phase, frequency, 0.0, amplitude)
    n = 1
    for k in range(1, len(drive.times)):
        if out[n - 1].start >= drive.times[k]:  # the last change has not ended
            n -= 1
        n += write_change(
            out[n:], out[n - 1], drive.times[k], drive.drive_amplitudes[k],
            drive.drive_frequencies[k], drive.ramps[k],
        )  # fmt: skip
    return n


@drives.register("staged_harmonic")
@dataclass(frozen=True, kw_only=True)
class StagedHarmonic(Drive):
    """Stages of constant amplitude and frequency, with a smooth change at the start of each.

    Stage k begins at ``times[k]`` (the first at 0, without a change); within ``ramps[k]`` seconds
    from then on the amplitude follows a cubic and the frequency a line, from their present values
    to ``drive_amplitudes[k]`` and ``drive_frequencies[k]``. A stage that begins before the last
    change has ended continues from the values reached. `ramps` counts from the second stage on.

    Notes
    -----
    ``y0 = A(t) cos(phase(t))``: height and velocity of the pivot are continuous, so no change acts
    as a blow.
    """

    is_sinusoidal: ClassVar[bool] = True
    write: ClassVar[Any] = staticmethod(write_stages)

    times: Sequence[float] = array_field("times", description="stage starts")
    drive_amplitudes: Sequence[float] = array_field(
        "drive_amplitudes", description="driving amplitude of each stage"
    )
    drive_frequencies: Sequence[float] = array_field(
        "drive_frequencies", NON_NEGATIVE, description="angular frequency of each stage"
    )
    ramps: Sequence[float] = array_field(
        "ramps", POSITIVE, description="time of the change into each stage"
    )
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))

    def __post_init__(self) -> None:
        super().__post_init__()
        columns = checked_lists(self)
        if len({len(column) for column in columns.values()}) > 1:
            counts = ", ".join(str(len(column)) for column in columns.values())
            names = ", ".join(["{parameter}", *(name for name in columns if name != "times")])
            raise broken_rule("one_length", {"names": names, "counts": counts}, parameter="times")
        check_stage_times(columns["times"])
