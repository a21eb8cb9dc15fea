"""Cosines whose frequency changes: stages with optional ramps, and the chirp."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from latolato.errors import InputError
from latolato.physics.drives.base import (
    Drive,
    check_increasing,
    checked_array,
    drives,
)
from latolato.physics.drives.stretch import COSINE, SWEPT, Stretch
from latolato.quantities import ANY, NON_NEGATIVE, POSITIVE, array_field, quantity_field
from latolato.scalar import sine

# A ramp may exceed its stage by so much, relatively: differences of decimal times are rounded.
_ROUNDING = 1e-12


@dataclass(frozen=True, kw_only=True)
class _Swept(Drive):
    """A cosine whose frequency is piecewise linear in time, phase-continuous."""

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE, suggested=(0.0, 0.5))
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))

    def _knots(self) -> list[tuple[float, float, float]]:
        """Return (start, frequency there, rate of change) of each stretch."""
        raise TypeError(f"{type(self).__name__} must define _knots()")

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the stretches with the phase carried on from one to the next."""
        found: list[Stretch] = []
        knots = self._knots()
        phase = self.drive_phase
        for i, (start, frequency, rate) in enumerate(knots):
            if i:
                before, w, r = knots[i - 1]
                s = start - before
                phase += s * (w + 0.5 * r * s)
            if start <= duration:
                form = COSINE if rate == 0.0 else SWEPT
                found.append(Stretch(start, form, phase, frequency, rate, self.drive_amplitude))
        return found


@drives.register("frequency_schedule")
@dataclass(frozen=True, kw_only=True)
class FrequencySchedule(_Swept):
    """Stages of constant frequency, phase-continuous, with an optional ramp between them.

    Stage k begins at ``times[k]`` (the first at 0) with ``drive_frequencies[k]``; with ``ramp > 0``
    the frequency moves there linearly within `ramp` seconds from ``times[k]`` on.

    Notes
    -----
    With ``ramp = 0`` the pivot's height is continuous but its velocity jumps by
    ``-A0 (w_new - w_old) sin(phase)``. Each stage's smooth acceleration is used and the jump is
    not transmitted to the balls, unless ``step_impulse`` is true: then the balls get the velocity
    that a vanishing ramp would give them, ``-jump sin(angle)/length``, booked as drive work.
    """

    times: Sequence[float] = array_field("times", "stage starts")
    drive_frequencies: Sequence[float] = array_field(
        "drive_frequencies", "angular frequency of each stage"
    )
    ramp: float = quantity_field("ramp", NON_NEGATIVE, default=0.0, suggested=(0.0, 2.0))
    step_impulse: bool = field(
        default=False, metadata={"description": "transmit the pivot's velocity jump at a step"}
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        times = checked_array("times", self.times, ANY, 1)
        rates = checked_array("drive_frequencies", self.drive_frequencies, NON_NEGATIVE, 1)
        if len(times) != len(rates):
            raise InputError(
                f"times and drive_frequencies must be of one length, got {len(times)} and "
                f"{len(rates)}"
            )
        if not isinstance(self.step_impulse, bool):
            raise InputError(f"step_impulse must be True or False, got {self.step_impulse!r}")
        if times[0] != 0.0:
            raise InputError(f"times must begin with 0, got {times[0]:g}; the first stage is there")
        check_increasing("times", times)
        gaps = [b - a for a, b in pairwise(times)]
        if gaps and self.ramp > min(gaps) * (1.0 + _ROUNDING):
            raise InputError(
                f"ramp must not exceed the shortest stage {min(gaps):g} s, got {self.ramp:g}"
            )
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "drive_frequencies", rates)

    def _knots(self) -> list[tuple[float, float, float]]:
        knots = [(0.0, self.drive_frequencies[0], 0.0)]
        rates, ends = self.drive_frequencies, (*self.times[2:], math.inf)
        for start, end, old, new in zip(self.times[1:], ends, rates, rates[1:], strict=False):
            if self.ramp > 0.0:
                knots.append((start, old, (new - old) / self.ramp))
                if end - start > self.ramp * (1.0 + _ROUNDING):
                    knots.append((start + self.ramp, new, 0.0))
            else:
                knots.append((start, new, 0.0))
        return knots

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the stretches, with the jumps that are transmitted."""
        found = super().stretches(duration)
        if not self.step_impulse or self.ramp > 0.0:
            return found
        return found[:1] + [
            new._replace(jump=-new.c0 * (new.frequency - old.frequency) * sine(new.phase))
            for old, new in pairwise(found)
        ]


@drives.register("chirp")
@dataclass(frozen=True, kw_only=True)
class Chirp(_Swept):
    """A frequency that moves linearly within `sweep_time` and stays at its end value then."""

    drive_frequency: float = quantity_field("drive_frequency", NON_NEGATIVE, suggested=(0.1, 40.0))
    drive_frequency_final: float = quantity_field(
        "drive_frequency_final", NON_NEGATIVE, suggested=(0.1, 40.0)
    )
    sweep_time: float = quantity_field("sweep_time", POSITIVE, suggested=(1.0, 600.0))

    def _knots(self) -> list[tuple[float, float, float]]:
        w0, w1, span = self.drive_frequency, self.drive_frequency_final, self.sweep_time
        return [(0.0, w0, (w1 - w0) / span), (span, w1, 0.0)]
