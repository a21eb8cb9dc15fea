"""Horizontal motion of a driven pivot at the frequency of its vertical motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from latolato.experiment.fits.drive_shape import Shape
from latolato.experiment.fits.least_squares import Floats, Guess, Solution, one_series, solve
from latolato.experiment.fits.result import TWO_SIDED, Estimate
from latolato.physics.drives import Drive, Harmonic, PlanarHarmonic, drives

if TYPE_CHECKING:
    import xarray as xr

# Samples that are needed, and standard deviations above which the motion is seen.
_FEWEST, _SEEN = 16, 4.0
# Standard deviation of a phase that may be any.
_ANY_PHASE = math.pi / math.sqrt(3.0)


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


def with_across(drive: Drive, across: Across) -> tuple[Drive, str]:
    """Return a drive with the horizontal motion if it can have one, and a sentence on that."""
    size = across.amplitude.scaled(1e3, "mm")
    if not across.is_seen:
        return drive, f"No horizontal motion was detected ({size})."
    lead = across.lead.scaled(math.copysign(1.0, across.lead.value), "rad")
    order = "ahead of" if across.lead.value > 0.0 else "behind"
    words = f"Horizontally it moves with {size}, {lead} {order} the height"
    if not isinstance(drive, Harmonic):
        return drive, f"{words}, which the drive {drives.name_of(drive)} leaves out."
    planar = PlanarHarmonic(
        vertical_amplitude=drive.drive_amplitude,
        horizontal_amplitude=across.amplitude.value,
        drive_frequency=drive.drive_frequency,
        vertical_phase=drive.drive_phase,
        horizontal_phase=across.phase.value,
    )
    return planar, f"{words}."


def vertical_part(drive: Drive) -> Drive:
    """Return a drive without the horizontal part of a `PlanarHarmonic`."""
    if not isinstance(drive, PlanarHarmonic):
        return drive
    return Harmonic(
        drive_amplitude=drive.vertical_amplitude,
        drive_frequency=drive.drive_frequency,
        drive_phase=drive.vertical_phase,
    )
