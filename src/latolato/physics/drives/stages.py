"""A cosine whose amplitude and frequency both move smoothly from stage to stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from latolato.errors import InputError
from latolato.physics.drives.base import (
    Drive,
    check_increasing,
    checked_array,
    drives,
)
from latolato.physics.drives.stretch import COSINE, SWEPT, Stretch
from latolato.quantities import ANY, NON_NEGATIVE, POSITIVE, array_field, quantity_field


def moved(
    before: Stretch, time: float, amplitude: float, frequency: float, ramp: float
) -> tuple[Stretch, Stretch]:
    """Return the stretch from `time` that leads to a new amplitude and frequency, and the next.

    Height and velocity of the pivot are continuous at both ends: the amplitude is the cubic that
    begins with the value and the slope that `before` has there and ends level, the frequency is
    linear, the phase is carried on.
    """
    now = before.at(time)
    rise = (amplitude - now.c0) / ramp
    way = Stretch(
        time,
        SWEPT,
        now.phase,
        now.frequency,
        (frequency - now.frequency) / ramp,
        now.c0,
        now.c1,
        (3.0 * rise - 2.0 * now.c1) / ramp,
        (now.c1 - 2.0 * rise) / (ramp * ramp),
    )
    phase = now.phase + ramp * 0.5 * (now.frequency + frequency)
    return way, Stretch(time + ramp, COSINE, phase, frequency, 0.0, amplitude)


@drives.register("stages")
@dataclass(frozen=True, kw_only=True)
class Stages(Drive):
    """Stages of constant amplitude and frequency, with a smooth change at the start of each.

    Stage k begins at ``times[k]`` (the first at 0, without a change); within ``ramps[k]`` seconds
    from there the amplitude moves along a cubic, the frequency along a line, from what they are to
    ``drive_amplitudes[k]`` and ``drive_frequencies[k]``. A stage that begins before the last
    change has ended goes on from where that is. `ramps` counts from the second stage on.

    Notes
    -----
    ``y0 = A(t) cos(phase(t))``: height and velocity of the pivot are continuous, so that no change
    is a blow.
    """

    times: Sequence[float] = array_field("times", "stage starts")
    drive_amplitudes: Sequence[float] = array_field(
        "drive_amplitudes", "driving amplitude of each stage"
    )
    drive_frequencies: Sequence[float] = array_field(
        "drive_frequencies", "angular frequency of each stage"
    )
    ramps: Sequence[float] = array_field("ramps", "time of the change into each stage")
    drive_phase: float = quantity_field("drive_phase", ANY, default=0.0, suggested=(0.0, 6.2832))
    _stages: tuple[Stretch, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        columns = {
            "times": checked_array("times", self.times, ANY, 1),
            "drive_amplitudes": checked_array("drive_amplitudes", self.drive_amplitudes, ANY, 1),
            "drive_frequencies": checked_array(
                "drive_frequencies", self.drive_frequencies, NON_NEGATIVE, 1
            ),
            "ramps": checked_array("ramps", self.ramps, POSITIVE, 1),
        }
        if len({len(column) for column in columns.values()}) > 1:
            found = ", ".join(str(len(column)) for column in columns.values())
            raise InputError(f"{', '.join(columns)} must be of one length, got {found}")
        if columns["times"][0] != 0.0:
            raise InputError(
                f"times must begin with 0, got {columns['times'][0]:g}; the first stage is there"
            )
        check_increasing("times", columns["times"])
        for name, column in columns.items():
            object.__setattr__(self, name, column)
        object.__setattr__(self, "_stages", tuple(self._follow()))

    def _follow(self) -> list[Stretch]:
        """Return the stretches, changes and what lies between them."""
        rows = zip(self.times, self.drive_amplitudes, self.drive_frequencies, self.ramps,
                   strict=True)  # fmt: skip
        _, amplitude, frequency, _ = next(rows)
        found = [Stretch(0.0, COSINE, self.drive_phase, frequency, 0.0, amplitude)]
        for time, amplitude, frequency, ramp in rows:
            if found[-1].start >= time:  # the last change has not ended
                found.pop()
            found.extend(moved(found[-1], time, amplitude, frequency, ramp))
        return found

    def stretches(self, duration: float) -> list[Stretch]:
        """Return the stretches that meet [0, duration]."""
        return [stage for stage in self._stages if stage.start <= duration]
