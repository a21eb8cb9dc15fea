"""The measured pivot as the drive of a model, and other pivots that its track allows as well."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.fits.drive import fit_drive
from latolato.experiment.fits.samples import is_driven, noise_of
from latolato.experiment.fits.sight import stroke_error
from latolato.physics.drives import Drive, FixedPivot, MeasuredPivot

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.result import Fit

# A fitted drive stands for the track if it leaves less than this share of the amplitude.
_GOOD = 0.02
# Noisy copies of a track from which the effect of its noise is seen.
_COPIES = 4


@dataclass(frozen=True)
class Pivot:
    """A drive, the instant that is its time zero, and others that fit the track as well.

    Attributes
    ----------
    others : list of (Drive, float)
        Each with the weight of the squared change that it makes.
    """

    drive: Drive
    origin: float
    others: list[tuple[Drive, float]]
    words: str


def pivot_for(
    drive: Drive | str | None, table: xr.Dataset, length: float, first: float, last: float
) -> Pivot:
    """Return the pivot of a motion in a track table.

    Parameters
    ----------
    drive : Drive, "measured" or None
        A drive that is known; or, as it was measured, a smoothing spline of the heights
        ("measured") or the simplest of three (None): at rest, what `fit_drive` finds where that
        leaves less than 2 percent of the amplitude, the spline.
    table : xarray.Dataset
        A track table.
    length : float
        Of the pendulum [m], against which the pivot may be at rest.
    first, last : float
        What must be covered [s].
    """
    if isinstance(drive, Drive):
        return Pivot(drive, 0.0, [], "the given drive")
    if drive not in (None, "measured"):
        raise InputError("must be a drive, 'measured' or None", parameter="drive", value=drive)
    if not is_driven(table, length):
        return Pivot(FixedPivot(), 0.0, [], "the pivot is at rest")
    if drive is None:
        try:
            fit = fit_drive(table, profile=False)
        except InputError:
            fit = None
        if fit is not None and fit.dataset.attrs["scatter"] < _GOOD * fit["drive_amplitude"].value:
            assert fit.drive is not None
            error = stroke_error(table, length, fit["drive_amplitude"].value)
            others = _neighbours(fit, fit.drive, error)
            return Pivot(fit.drive, 0.0, others, "the pivot's fitted drive")
    return _spline(table, length, first, last)


def _neighbours(fit: Fit, drive: Drive, scale: float) -> list[tuple[Drive, float]]:
    """Return drives that differ by one standard deviation in one parameter each, or the scale."""
    others: list[tuple[Drive, float]] = []
    for name in ("drive_amplitude", "drive_frequency", "drive_phase"):
        if name in fit and hasattr(drive, name):
            sigma = fit[name].sigma
            if name == "drive_amplitude":
                sigma = float(np.hypot(sigma, scale * fit[name].value))
            moved: Any = {name: getattr(drive, name) + sigma}
            if name == "drive_frequency":
                # About the middle of the record, where frequency and phase are independent.
                middle = 0.5 * (fit.dataset.attrs["start"] + fit.dataset.attrs["end"])
                about: Any = drive
                moved["drive_phase"] = about.drive_phase - sigma * middle
            # The phase's own deviation at time zero holds the frequency's: half of it is left.
            weight = 0.25 if name == "drive_phase" and hasattr(drive, "drive_frequency") else 1.0
            others.append((replace(drive, **moved), weight))
    return others


def _spline(table: xr.Dataset, length: float, first: float, last: float) -> Pivot:
    """Return a smoothing spline of the heights, and splines of noisier copies."""
    time, height = table["time"].values, table["pivot_y"].values
    known = np.isfinite(height)
    time, height = time[known], height[known]
    if not len(time) or time[0] > first or time[-1] < last:
        raise InputError(
            "the pivot is not known over all of the motion: give start and end, or the drive"
        )
    noise = noise_of(height)
    generator = np.random.default_rng(0)

    def through(heights: Any) -> MeasuredPivot:
        return MeasuredPivot(times=time - time[0], pivot_heights=heights, height_sigma=noise)

    others = [
        (through(height + noise * generator.normal(size=len(height))), 1.0 / _COPIES)
        for _ in range(_COPIES)
    ]
    scale = stroke_error(table, length, float(np.std(height)) * 2.0**0.5)
    if scale > 0.0:
        others.append((through((1.0 + scale) * height), 1.0))
    return Pivot(through(height), float(time[0]), [*others], "a spline of the pivot's track")
