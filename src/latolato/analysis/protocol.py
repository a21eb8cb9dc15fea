"""Stages of the driving frequency that bring energy in, as one object."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from latolato.analysis.rules import broken_analysis
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, array_field, quantity_field
from latolato.core.registry import check_fields, checked_array
from latolato.physics.drives import FrequencySchedule

if TYPE_CHECKING:
    from latolato.physics.pendulum import System


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """Driving frequencies one after the other, each held for a while: Paper Fig. 12.

    Parameters
    ----------
    drive_frequencies : sequence of float, shape (stage,)
        Angular frequency of each stage [rad/s].
    dwells : sequence of float, shape (stage - 1,)
        How long each stage but the last is held [s], without the ramp that leads to it; the last
        one goes on.
    ramp : float
        Time in which the frequency moves from each stage to the next, linearly and with a
        continuous phase [s].

    Examples
    --------
    >>> steps = Protocol(drive_frequencies=[19.8, 15.1], dwells=[4.0], ramp=0.5)
    >>> steps.times, steps.lead_time
    ((0.0, 4.0), 4.5)
    >>> steps.drive(0.03).drive_frequencies
    (19.8, 15.1)
    """

    drive_frequencies: Sequence[float] = array_field(
        "drive_frequencies", POSITIVE, description="angular frequency of each stage"
    )
    dwells: Sequence[float] = array_field(
        "dwell_time", POSITIVE, description="how long each stage but the last is held"
    )
    ramp: float = quantity_field("ramp", NON_NEGATIVE, default=0.0, suggested=(0.0, 2.0))

    def __post_init__(self) -> None:
        check_fields(self)
        frequencies, dwells = self.drive_frequencies, self.dwells
        stages = tuple(checked_array("drive_frequencies", frequencies, POSITIVE, unit="rad/s"))
        dwells = tuple(checked_array("dwells", dwells, POSITIVE, at_least=0, unit="s"))
        if len(dwells) != len(stages) - 1:
            raise broken_analysis(
                "one_dwell_fewer", {"count": len(stages)}, parameter="dwells", value=dwells
            )
        object.__setattr__(self, "drive_frequencies", stages)
        object.__setattr__(self, "dwells", dwells)

    @classmethod
    def of_ratios(
        cls,
        system: System,
        *,
        frequency_ratios: Sequence[float],
        dwells: Sequence[float],
        ramp: float = 0.0,
    ) -> Protocol:
        """Return the protocol whose stages are given in natural frequencies of a system [1]."""
        w0 = system.natural_frequency
        return cls(drive_frequencies=[r * w0 for r in frequency_ratios], dwells=dwells, ramp=ramp)

    @property
    def times(self) -> tuple[float, ...]:
        """When the frequency begins to move to each stage [s], 0 for the first."""
        result = [0.0]
        for number, dwell in enumerate(self.dwells):
            result.append(result[-1] + dwell + (self.ramp if number else 0.0))
        return tuple(result)

    @property
    def lead_time(self) -> float:
        """When the last stage is reached [s]."""
        return math.fsum(self.dwells) + self.ramp * len(self.dwells)

    def drive(self, drive_amplitude: float, drive_phase: float = 0.0) -> FrequencySchedule:
        """Return the drive with an amplitude [m] and a phase at its start [rad]."""
        return FrequencySchedule(
            drive_amplitude=drive_amplitude,
            drive_phase=drive_phase,
            times=self.times,
            drive_frequencies=self.drive_frequencies,
            ramp=self.ramp,
        )
