"""The motion of a driven pivot: stages, ramps, drift and overtones of its height, and sideways."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from latolato.core.errors import Sentence, Word
from latolato.experiment.fits.least_squares import Data, Floats, Guess, Solution, one_series, solve
from latolato.experiment.fits.result import TWO_SIDED, Estimate
from latolato.experiment.rules import broken, said
from latolato.physics.drives import Drive, Harmonic, PlanarHarmonic

if TYPE_CHECKING:
    import xarray as xr

# Samples that are needed sideways, and standard deviations above which that motion is seen.
_FEWEST, _SEEN = 16, 4.0
# Standard deviation of a phase that may be any.
_ANY_PHASE = math.pi / math.sqrt(3.0)


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


@dataclass(frozen=True)
class Across:
    """The horizontal motion, ``amplitude cos(q + lead)`` with the phase q of the height.

    Attributes
    ----------
    lead : Estimate
        Phase of the horizontal motion ahead of the height [rad].
    samples, curve : ndarray, shape (sample,)
        Measured, NaN where it is not known, and fitted [m].
    """

    amplitude: Estimate
    phase: Estimate
    lead: Estimate
    samples: Floats
    curve: Floats

    @property
    def is_seen(self) -> bool:
        """Whether the amplitude exceeds four standard deviations."""
        return self.amplitude.value > _SEEN * self.amplitude.sigma


def across_of(
    table: xr.Dataset,
    times: Floats,
    origin: float,
    shape: Shape,
    solution: Solution,
    least: float,
) -> Across | None:
    """Return the horizontal motion, None where the table does not have it.

    Parameters
    ----------
    table : xarray.Dataset
        A track table.
    times : ndarray, shape (sample,)
        Those of its instants that the height was fitted at [s], from its first frame on.
    origin : float
        Instant of its first frame [s].
    shape, solution : Shape, Solution
        Of the height.
    least : float
        What a track may bend a motion by [m].

    Notes
    -----
    Fitted is ``mean + a cos q + b sin q`` with the phase q of the height. The deviations of a and b
    include a quarter of `least`, that of a the table's ``angle_offset_sigma`` times the vertical
    amplitude; the deviation of the phase includes that of q.
    """
    if "pivot_x" not in table.variables:
        return None
    since = table["time"].values - origin
    positions = table["pivot_x"].values[np.searchsorted(since, times)]
    known = np.isfinite(positions)
    # A column of one value is no measurement.
    if known.sum() < _FEWEST or np.ptp(positions[known]) == 0.0:
        return None
    phase = shape.phase(solution.values, times)
    columns = {"mean": np.ones(len(times)), "cosine": np.cos(phase), "sine": np.sin(phase)}
    design = {name: column[known] for name, column in columns.items()}
    count = int(known.sum())
    found = solve(
        lambda p: sum((p[n] * column for n, column in design.items()), np.zeros(count)),
        dict.fromkeys(columns, Guess(0.0)),
        one_series(times[known], positions[known]),
        jacobian=lambda _, names: np.column_stack([design[n] for n in names]),
    )
    a, b = found.values["cosine"], found.values["sine"]
    places = [found.names.index(n) for n in ("cosine", "sine")]
    tilt = float(table.attrs.get("angle_offset_sigma", 0.0)) * solution.values["drive_amplitude"]
    covariance = found.covariance[np.ix_(places, places)]
    covariance = covariance + np.diag([tilt**2, 0.0]) + (0.25 * least) ** 2 * np.eye(2)
    size, lead = math.hypot(a, b), math.atan2(-b, a)
    along = np.array([math.cos(lead), -math.sin(lead)])
    aside = np.array([math.sin(lead), math.cos(lead)])
    sigma = math.sqrt(along @ covariance @ along)
    turned = math.sqrt(aside @ covariance @ aside) / max(size, 1e-300)
    of_phase = solution.covariance_of(  # of that at time 0, as it follows from the mean
        lambda p: np.array([p["drive_phase"] - np.mean(shape.phase(p, times[known]))])
    )
    own = math.hypot(turned, math.sqrt(max(float(of_phase[0, 0]), 0.0)))
    start = math.remainder(solution.values["drive_phase"] + lead, math.tau)
    return Across(
        Estimate(size, sigma, "m", max(size - TWO_SIDED * sigma, 0.0)),
        Estimate(start, min(own, _ANY_PHASE), "rad"),
        Estimate(lead, min(turned, _ANY_PHASE), "rad"),
        positions,
        sum((found.values[n] * column for n, column in columns.items()), np.zeros(len(times))),
    )


def with_across(drive: Drive, across: Across) -> tuple[Drive, Sentence]:
    """Return a drive with the horizontal motion if it can have one, and a sentence on that."""
    size = str(across.amplitude.scaled(1e3, "mm"))
    if not across.is_seen:
        return drive, said("no_horizontal", size=size)
    lead = str(across.lead.scaled(math.copysign(1.0, across.lead.value), "rad"))
    rule = "horizontal_ahead" if across.lead.value > 0.0 else "horizontal_behind"
    if not isinstance(drive, Harmonic):
        left = said("left_out_by", drive=Word(type(drive).__name__))
        return drive, said(rule, size=size, lead=lead, left=left)
    planar = PlanarHarmonic(
        vertical_amplitude=drive.drive_amplitude,
        horizontal_amplitude=across.amplitude.value,
        drive_frequency=drive.drive_frequency,
        vertical_phase=drive.drive_phase,
        horizontal_phase=across.phase.value,
    )
    return planar, said(rule, size=size, lead=lead, left="")


def vertical_part(drive: Drive) -> Drive:
    """Return a drive without the horizontal part of a `PlanarHarmonic`."""
    if not isinstance(drive, PlanarHarmonic):
        return drive
    return Harmonic(
        drive_amplitude=drive.vertical_amplitude,
        drive_frequency=drive.drive_frequency,
        drive_phase=drive.vertical_phase,
    )
