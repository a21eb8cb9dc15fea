"""The height of a driven pivot: stages of a frequency, ramps, drift and a crank's overtones."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from latolato.experiment.fits.least_squares import Data, Floats, Guess
from latolato.experiment.rules import broken


@dataclass(frozen=True)
class Shape:
    """How the height of a driven pivot follows from its parameters.

    Those of a crank (``crank_ratio``), of changes between stages (``ramp``) and of a drift
    (``amplitude_drift``, ``frequency_drift``) are 0 where they are not among them.

    Attributes
    ----------
    stages : int
        Number of stages of one frequency each.
    middle : float
        Instant about which amplitude and frequency drift [s].
    """

    stages: int
    middle: float

    @property
    def frequencies(self) -> list[str]:
        """Names of the frequencies."""
        return ["drive_frequency", *(f"frequency_{i}" for i in range(1, self.stages))]

    @property
    def times(self) -> list[str]:
        """Names of the instants of the steps."""
        return [f"step_{i}" for i in range(1, self.stages)]

    def phase(self, p: Mapping[str, float], times: Floats) -> Floats:
        """Return the phase at instants, as a `FrequencySchedule` has it."""
        rates = [p[name] for name in self.frequencies]
        drift = 0.5 * p.get("frequency_drift", 0.0)
        phase = p["drive_phase"] + rates[0] * times + drift * (times - self.middle) ** 2
        ramp = p.get("ramp", 0.0)
        for name, old, new in zip(self.times, rates[:-1], rates[1:], strict=True):
            s = np.maximum(times - p[name], 0.0)
            rising = np.minimum(s, ramp)
            gained = 0.5 * rising**2 / ramp if ramp > 0.0 else 0.0
            phase += (new - old) * (gained + s - rising)
        return phase

    def height(self, p: Mapping[str, float], times: Floats) -> Floats:
        """Return the height at instants [m]."""
        phase = self.phase(p, times)
        shape, q = np.cos(phase), p.get("crank_ratio", 0.0)
        if q != 0.0:
            square = np.sin(phase) ** 2
            shape -= q * square / (1.0 + np.sqrt(np.maximum(1.0 - q * q * square, 0.0)))
        amplitude = p["drive_amplitude"] + p.get("amplitude_drift", 0.0) * (times - self.middle)
        out: Floats = amplitude * shape + p["mean_height"]
        return out


def guesses_of_passages(data: Data, zeros: Floats, shape: Shape) -> dict[str, Guess]:
    """Return guesses from the passages, between which the phase grows by pi each."""
    phases: Floats = math.pi * np.arange(len(zeros), dtype=np.float64)
    breaks = _breaks(zeros, phases, shape.stages)
    design = _hinges(zeros, breaks)
    slopes, *_ = np.linalg.lstsq(design, phases, rcond=None)
    rates = np.cumsum(slopes[1:])
    low, high = np.percentile(data.values, [2.0, 98.0])
    # At the first passage the cosine goes up (phase -pi/2) or down (phase pi/2).
    span = zeros[1] - zeros[0]
    begun = (data.times > zeros[0]) & (data.times < zeros[0] + 0.9 * span)
    goes_up = np.mean(data.values[begun]) > 0.5 * (low + high)
    phase = (-0.5 if goes_up else 0.5) * math.pi + float(slopes[0])
    guesses = {
        "mean_height": Guess(0.5 * float(low + high)),
        "drive_amplitude": Guess(0.5 * float(high - low), 0.0),
        "drive_phase": Guess(phase),
    }
    for name, rate in zip(shape.frequencies, rates, strict=True):
        guesses[name] = Guess(float(rate))
    for name, instant in zip(shape.times, breaks, strict=True):
        guesses[name] = Guess(instant, float(data.times[0]), float(data.times[-1]))
    return guesses


def _hinges(zeros: Floats, breaks: list[float]) -> Floats:
    """Return the basis of continuous piecewise straight lines."""
    columns = [np.ones(len(zeros)), zeros, *(np.maximum(zeros - b, 0.0) for b in breaks)]
    return np.column_stack(columns)


def _breaks(zeros: Floats, phases: Floats, stages: int) -> list[float]:
    """Return the instants at which straight pieces of the phase meet best, one after another."""
    breaks: list[float] = []
    for _ in range(stages - 1):
        best = (math.inf, 0.0)
        for place in zeros[2:-2]:
            design = _hinges(zeros, sorted([*breaks, float(place)]))
            coefficients, *_ = np.linalg.lstsq(design, phases, rcond=None)
            best = min(best, (float(np.sum((phases - design @ coefficients) ** 2)), float(place)))
        if best[0] == math.inf:
            raise broken("short_drive", {"count": stages})
        breaks = sorted([*breaks, best[1]])
    return breaks
