"""Cosines with changing frequency: stages with optional ramps, and the chirp."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar

from latolato.core.errors import InputError
from latolato.core.quantities import ANY, NON_NEGATIVE, POSITIVE, array_field, quantity_field
from latolato.core.rules import broken_rule
from latolato.core.scalar import formula, sine
from latolato.physics.drives.base import (
    Drive,
    check_stage_times,
    checked_lists,
    drives,
)
from latolato.physics.drives.segment import COSINE, SWEPT, write_next, write_segment

# A ramp may exceed its stage by so much, relatively: differences of decimal times are rounded.
_ROUNDING = 1e-12


@formula
def write_schedule(out: Any, drive: Any) -> int:
    """Write the segments of a `FrequencySchedule`; return their number."""
    times, frequencies, ramp = drive.times, drive.drive_frequencies, drive.ramp
    amplitude = drive.drive_amplitude
    write_segment(out[0], 0.0, COSINE, drive.drive_phase, frequencies[0], 0.0, amplitude)
    n = 1
    for k in range(1, len(times)):
        old, new = frequencies[k - 1], frequencies[k]
        if ramp > 0.0:
            n = write_next(out, n, times[k], old, (new - old) / ramp)
            end = times[k + 1] if k + 1 < len(times) else math.inf
            if end - times[k] > ramp * (1.0 + _ROUNDING):
                n = write_next(out, n, times[k] + ramp, new, 0.0)
            continue
        n = write_next(out, n, times[k], new, 0.0)
        if drive.step_impulse:
            out[n - 1].jump = -amplitude * (new - old) * sine(out[n - 1].phase)
    return n


@formula
def write_chirp(out: Any, drive: Any) -> int:
    """Write both segments of a `Chirp`; return 2."""
    first, last = drive.drive_frequency, drive.drive_frequency_final
    rate = (last - first) / drive.sweep_time
    write_segment(out[0], 0.0, SWEPT, drive.drive_phase, first, rate, drive.drive_amplitude)
    return write_next(out, 1, drive.sweep_time, last, 0.0)


@drives.register("frequency_schedule")
@dataclass(frozen=True, kw_only=True)
class FrequencySchedule(Drive):
    """Stages of constant frequency, phase-continuous, with an optional ramp between them.

    Stage k begins at ``times[k]`` (the first at 0) with ``drive_frequencies[k]``; with ``ramp > 0``
    the frequency changes to it linearly within `ramp` seconds after ``times[k]``.

    Notes
    -----
    With ``ramp = 0`` the pivot's height is continuous but its velocity jumps by
    ``-A0 (w_new - w_old) sin(phase)``. Each stage's smooth acceleration is used and the jump is
    not transmitted to the balls, unless ``step_impulse`` is true: then the balls get the velocity
    that a vanishing ramp would give them, ``-jump sin(angle)/length``, booked as drive work.
    """

    is_sinusoidal: ClassVar[bool] = True
    write: ClassVar[Any] = staticmethod(write_schedule)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))
    times: Sequence[float] = array_field("times", description="stage starts")
    drive_frequencies: Sequence[float] = array_field(
        "drive_frequencies", NON_NEGATIVE, description="angular frequency of each stage"
    )
    ramp: float = quantity_field("ramp", NON_NEGATIVE, default=0.0, suggested=(0.0, 2.0))
    step_impulse: bool = field(
        default=False, metadata={"description": "transmit the pivot's velocity jump at a step"}
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        times, rates = checked_lists(self).values()
        if len(times) != len(rates):
            raise broken_rule(
                "one_length",
                {
                    "names": "{parameter} and drive_frequencies",
                    "counts": f"{len(times)} and {len(rates)}",
                },
                parameter="times",
            )
        if not isinstance(self.step_impulse, bool):
            raise InputError(
                "must be True or False", parameter="step_impulse", value=self.step_impulse
            )
        check_stage_times(times)
        gaps = [b - a for a, b in pairwise(times)]
        if gaps and self.ramp > min(gaps) * (1.0 + _ROUNDING):
            raise broken_rule(
                "shortest_stage", {"shortest": min(gaps)}, parameter="ramp", value=self.ramp
            )


@drives.register("chirp")
@dataclass(frozen=True, kw_only=True)
class Chirp(Drive):
    """A frequency that changes linearly during `sweep_time` and then stays at its final value."""

    is_sinusoidal: ClassVar[bool] = True
    write: ClassVar[Any] = staticmethod(write_chirp)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))
    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    drive_frequency_final: float = quantity_field(
        "drive_frequency_final", NON_NEGATIVE, suggested=(0.1, 40.0)
    )
    sweep_time: float = quantity_field("sweep_time", POSITIVE, suggested=(1.0, 600.0))
