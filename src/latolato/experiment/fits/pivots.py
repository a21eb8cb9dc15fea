"""The measured pivot as the drive of a model, and other pivots that its track allows as well."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.experiment.fits.drive import fit_drive, without_scale
from latolato.experiment.fits.drive_motion import vertical_part
from latolato.experiment.fits.least_squares import Data
from latolato.experiment.fits.samples import angles_of, is_driven, noise_of, of_own_pivot
from latolato.experiment.fits.sight import stroke_error
from latolato.experiment.rules import broken
from latolato.experiment.track_table import checked_table
from latolato.physics.drives import Drive, FixedPivot, MeasuredPivot, PlanarHarmonic
from latolato.physics.pendulum import LatoLato, System
from latolato.simulation.start import checked_system

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.result import Fit

# A fitted drive stands for the track if it leaves less than this share of the amplitude.
_GOOD = 0.02
# What a drive has of a fit, with the names in a fit where they are others, and its phases.
_PARAMETERS = (
    "drive_amplitude", "vertical_amplitude", "horizontal_amplitude",
    "drive_frequency", "drive_phase", "vertical_phase", "horizontal_phase",
)  # fmt: skip
_OF_HEIGHT = {"vertical_amplitude": "drive_amplitude", "vertical_phase": "drive_phase"}
_PHASES = ("drive_phase", "vertical_phase", "horizontal_phase")
# Noisy copies of a track from which the effect of its noise is seen.
_COPIES = 4


@dataclass(frozen=True)
class Pivot:
    """A drive, the instant that is its time zero, and others that fit the track as well.

    Attributes
    ----------
    others : list of (Drive, float)
        Each with the weight of the squared change that it makes.
    deviations : dict of str to float
        Standard deviations of the parameters of a fitted drive, empty for any other.
    """

    drive: Drive
    origin: float
    others: list[tuple[Drive, float]]
    words: str
    deviations: dict[str, float] = field(default_factory=dict)


def pivot_for(
    drive: Drive | str | None,
    table: xr.Dataset,
    length: float,
    first: float,
    last: float,
    *,
    across: bool = False,
) -> Pivot:
    """Return the pivot of a motion in a track table.

    Parameters
    ----------
    drive : Drive, "measured" or None
        A drive that is known, from the table's first frame on; or, as it was measured, a smoothing
        spline of the heights ("measured") or the simplest of three (None): at rest, what
        `fit_drive` finds where that leaves less than 2 percent of the amplitude, the spline.
    table : xarray.Dataset
        A track table.
    length : float
        Of the pendulum [m], against which the pivot may be at rest.
    first, last : float
        What must be covered [s].
    across : bool
        Whether the pivot may move sideways; without, its measured horizontal motion is left out.
    """
    origin = float(table["time"].values[0])
    if isinstance(drive, Drive):
        return Pivot(drive, origin, [], "the given drive")
    if drive not in (None, "measured"):
        raise InputError("must be a drive, 'measured' or None", parameter="drive", value=drive)
    swings = across and "pivot_x" in table.variables and is_driven(table, length, "pivot_x")
    if not (swings or is_driven(table, length)):
        return Pivot(FixedPivot(), origin, [], "the pivot is at rest")
    if drive is None:
        try:
            fit = fit_drive(table, profile=False)
        except InputError:
            fit = None
        if fit is not None and _is_good(fit, swings):
            assert fit.drive is not None
            moving = fit.drive if across else vertical_part(fit.drive)
            error = stroke_error(table, length, fit["drive_amplitude"].value)
            words = "the pivot's fitted drive"
            if moving != fit.drive:
                words += " without its horizontal part"
            sigmas = _deviations(fit, moving, error)
            return Pivot(moving, origin, _neighbours(fit, moving, sigmas), words, sigmas)
    return _spline(table, length, (first, last), swings)


def measured_motion(
    table: xr.Dataset,
    system: System,
    drive: Drive | str | None,
    ball: int | None,
    start: float | None,
    end: float | None,
) -> tuple[xr.Dataset, Data, Pivot]:
    """Return the part of a table that a system is about, the angles there, and the pivot.

    Arguments are those of `latolato.fit_model`, checked here.
    """
    checked_table(table)
    checked_system(system)
    table, ball = of_own_pivot(table, system, ball)
    data = angles_of(table, system, ball, start, end)
    first, last = float(data.times.min()), float(data.times.max())
    # A mirrored pair stays one only on a pivot that moves up and down.
    across = not isinstance(system, LatoLato)
    length = system.balls[0].length
    return table, data, pivot_for(drive, table, length, first, last, across=across)


def _is_good(fit: Fit, swings: bool) -> bool:
    """Return whether a fitted drive stands for the track, in both directions if it `swings`."""
    limit = _GOOD * fit["drive_amplitude"].value
    if not (fit.describes and fit.dataset.attrs["scatter"] < limit):
        return False
    if not swings:
        return True
    if not isinstance(fit.drive, PlanarHarmonic):
        return False
    return float((fit.dataset["pivot_across"] - fit.dataset["pivot_across_fit"]).std()) < limit


def _deviations(fit: Fit, drive: Drive, scale: float) -> dict[str, float]:
    """Return the standard deviations of a fitted drive's parameters.

    `scale` is the relative error that the amplitudes share beside a given length. That of the
    table's scale is in it if the scale is that of the length, and no part of it otherwise.
    """
    share = fit.dataset.attrs["scale_share"]
    part = share if fit.dataset.attrs.get("scale_source") == "length" else 0.0
    sigmas: dict[str, float] = {}
    for name in _PARAMETERS:
        estimate = _OF_HEIGHT.get(name, name)
        if estimate in fit and hasattr(drive, name):
            sigmas[name] = fit[estimate].sigma
            if name.endswith("_amplitude"):
                own = without_scale(fit[estimate], part)
                sigmas[name] = math.hypot(own, scale * fit[estimate].value)
    return sigmas


def _neighbours(fit: Fit, drive: Drive, sigmas: Mapping[str, float]) -> list[tuple[Drive, float]]:
    """Return drives that differ by one standard deviation in one parameter each."""
    others: list[tuple[Drive, float]] = []
    about: Any = drive
    phases = [name for name in _PHASES if hasattr(drive, name)]
    for name, sigma in sigmas.items():
        moved: Any = {name: getattr(drive, name) + sigma}
        if name == "drive_frequency":
            # About the middle of the record, where frequency and phase are independent.
            about_table = fit.dataset.attrs
            middle = 0.5 * (about_table["start"] + about_table["end"]) - about_table["origin"]
            moved |= {phase: getattr(about, phase) - sigma * middle for phase in phases}
        # The phase's own deviation at time zero holds the frequency's: half of it is left.
        weight = 0.25 if name in phases and hasattr(drive, "drive_frequency") else 1.0
        others.append((replace(about, **moved), weight))
    return others


def _spline(table: xr.Dataset, length: float, span: tuple[float, float], swings: bool) -> Pivot:
    """Return a smoothing spline of the heights, and splines of noisier copies.

    With the horizontal positions if the pivot `swings`.
    """
    columns = {"pivot_y": ("pivot_heights", "height_sigma")}
    if swings:
        columns["pivot_x"] = ("pivot_across", "across_sigma")
    time = table["time"].values
    known = np.logical_and.reduce([np.isfinite(table[column].values) for column in columns])
    time = time[known]
    if not len(time) or time[0] > span[0] or time[-1] < span[1]:
        raise broken("partly_known_pivot")
    places = {column: table[column].values[known] for column in columns}
    noises = {column: noise_of(place) for column, place in places.items()}
    generator = np.random.default_rng(0)

    def through(factor: float, noise: float) -> MeasuredPivot:
        traces: Any = {}
        for column, (name, sigma) in columns.items():
            error = noise * noises[column] * generator.normal(size=len(time))
            traces |= {name: factor * places[column] + error, sigma: noises[column]}
        return MeasuredPivot(times=time - time[0], **traces)

    others = [(through(1.0, 1.0), 1.0 / _COPIES) for _ in range(_COPIES)]
    size = math.hypot(*(float(np.std(place)) for place in places.values()))
    scale = stroke_error(table, length, size * 2.0**0.5)
    if scale > 0.0:
        others.append((through(1.0 + scale, 0.0), 1.0))
    words = "a spline of the pivot's track"
    return Pivot(through(1.0, 0.0), float(time[0]), [*others], words)
