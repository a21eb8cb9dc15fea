"""How a table sees angles: about a pivot that lies a little beside the place it was taken to be.

Errors that all samples of a table share do not show as scatter, yet bend angles in step with the
swing. Fits include them as parameters with known standard deviations: the position of the pivot;
the shift of a ball's smeared image; and the distortion along the path, taken to equal the one seen
across it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.experiment.fits.least_squares import FAR, Data, Floats, Guess, Solution
from latolato.experiment.fits.result import Adequacy
from latolato.experiment.rules import said

if TYPE_CHECKING:
    import xarray as xr

# Error of the pivot's place in a table that tells its scale but no error [pixels].
TYPICAL = 0.15
# Error of how far a pivot is seen to move to one side [pixels].
STROKE = 0.05
# Shift of a smeared image, as a share of the smear: half of what synthetic videos showed at most.
SMEARED = 0.02
# The parameters, all over the distance of the ball: how far right of and above the real pivot the
# table's lies, the same for what a smeared image adds at the largest speed, and the bend of the
# path at the largest angle.
ASIDE, ABOVE = "pivot_error_x", "pivot_error_y"
SMEAR_ASIDE, SMEAR_ABOVE = "smear_error_x", "smear_error_y"
BENT = "path_error"
SEEN = ("angle_offset", ASIDE, ABOVE, SMEAR_ASIDE, SMEAR_ABOVE, BENT)


def sight_guesses(table: xr.Dataset, data: Data) -> dict[str, Guess]:
    """Return the parameters of how a table sees angles, with their deviations, over the arm.

    The pivot's from the attributes ``pivot_offset_x_sigma``, ``pivot_offset_y_sigma`` and
    ``arm_pixels``; 0.15 pixels where there is a scale only (``metres_per_pixel``, ``length``). The
    smear's from ``exposure``, the path's from ``circle_residual``. Tables without a scale, as those
    of sensors, have none: their angles have a constant offset only.
    """
    attrs = table.attrs
    arm = _arm(table)
    if arm is None:
        return {}
    priors = dict(zip((ASIDE, ABOVE), _place_priors(table, arm), strict=True))
    exposure, residual = _positive(attrs.get("exposure")), _positive(attrs.get("circle_residual"))
    if exposure is not None:
        frame = float(np.median(np.diff(table["time"].values)))
        smear = SMEARED * exposure * frame * float(np.max(_speeds(data)))
        priors |= {SMEAR_ASIDE: smear, SMEAR_ABOVE: smear}
    if residual is not None:
        priors[BENT] = residual / arm
    return {name: Guess(0.0, prior=prior) for name, prior in priors.items() if prior > 0.0}


def stroke_error(table: xr.Dataset, length: float, amplitude: float) -> float:
    """Return the relative error of a pivot's motion that all frames share.

    The distance to the pivot scales it, and where it is seen may depend on where it is.
    """
    arm = _arm(table)
    if arm is None:
        return 0.0
    return math.hypot(_place_priors(table, arm)[1], STROKE / arm * length / max(amplitude, 1e-9))


@dataclass(frozen=True)
class Sight:
    """What is needed of samples to see angles as a table does.

    Parameters
    ----------
    smears : ndarray, shape (sample,)
        Speed over the largest.
    drop : float
        ``1 - cos`` of the largest angle.
    """

    smears: Floats
    drop: float

    @classmethod
    def of(cls, data: Data) -> Sight:
        """Return that of samples."""
        speeds = _speeds(data)
        return cls(speeds / max(float(np.max(speeds)), 1e-9), drop_of(data.values))

    def seen(self, angles: Floats, p: Mapping[str, float], nearer: float | Floats = 1.0) -> Floats:
        """Return angles [rad] as a table sees them.

        Parameters
        ----------
        angles : ndarray, shape (sample,)
            True ones.
        p : mapping of str to float
            May hold those of `SEEN`, of which ``angle_offset`` is the angle of the hanging ball in
            the table [rad].
        nearer : float or ndarray, shape (sample,)
            Distance over which errors are stated, over that of the ball.

        Notes
        -----
        ``atan2(sin th - u, cos th + v) + b sin th (1 - cos th)/(1 - cos th_max)``, less its value
        at rest for th = 0; u and v are the pivot's error and the smear's times the speed. As
        written, turns are kept.
        """
        offset = p.get("angle_offset", 0.0)
        if not p.keys() & {ASIDE, ABOVE}:
            return angles + offset
        aside, above = nearer * p.get(ASIDE, 0.0), nearer * p.get(ABOVE, 0.0)
        u = aside + nearer * p.get(SMEAR_ASIDE, 0.0) * self.smears
        v = above + nearer * p.get(SMEAR_ABOVE, 0.0) * self.smears
        sine, cosine = np.sin(angles), np.cos(angles)
        turned = np.arctan2(-u * cosine - v * sine, 1.0 - u * sine + v * cosine)
        bent = nearer * p.get(BENT, 0.0) / self.drop * sine * (1.0 - cosine)
        apparent: Floats = angles + turned + bent + (offset + np.arctan2(aside, 1.0 + above))
        return apparent


def pivot_doubt(solution: Solution) -> Adequacy | None:
    """Return the doubt in a fit whose pivot is far from its place in the table, None without."""
    for name, rule in ((ABOVE, "pivot_above"), (ASIDE, "pivot_beside")):
        guess = solution.guesses.get(name)
        if guess is not None and abs(guess.surprise) > FAR:
            share, times = abs(guess.value), abs(guess.surprise)
            return Adequacy(said(rule, share=share, times=times), "pivot")
    return None


def drop_of(angles: Floats) -> float:
    """Return ``1 - cos`` of the largest angle, up to 2."""
    largest = float(np.max(np.abs(angles - np.median(angles))))
    return max(1.0 - math.cos(min(largest, math.pi)), 1e-9)


def _arm(table: xr.Dataset) -> float | None:
    """Return the distance of the ball [pixels], None where it is unknown."""
    attrs = table.attrs
    arm = _positive(attrs.get("arm_pixels"))
    length, scale = _positive(attrs.get("length")), _positive(attrs.get("metres_per_pixel"))
    return length / scale if arm is None and length and scale else arm


def _place_priors(table: xr.Dataset, arm: float) -> tuple[float, float]:
    """Return the standard deviations of the pivot's place across and along gravity over the arm."""
    attrs = table.attrs
    column = _positive(attrs.get("pivot_offset_x_sigma")) or TYPICAL
    row = _positive(attrs.get("pivot_offset_y_sigma")) or TYPICAL
    tilt = attrs.get("gravity_direction", 0.0)
    turn = float(tilt) if isinstance(tilt, (int, float)) else 0.0
    cosine, sine = math.cos(turn), math.sin(turn)
    across = math.hypot(column * cosine, row * sine)
    return across / arm, math.hypot(column * sine, row * cosine) / arm


def _speeds(data: Data) -> Floats:
    """Return angular speeds from neighbouring samples, up to what nearly all stay below [rad/s]."""
    out = np.zeros(len(data))
    for series in np.unique(data.series):
        own = data.series == series
        if own.sum() > 2:
            out[own] = np.abs(np.gradient(data.values[own], data.times[own]))
    return np.minimum(out, np.quantile(out, 0.99))


def _positive(value: Any) -> float | None:
    """Return a number above 0, None for anything else."""
    if isinstance(value, (int, float)) and math.isfinite(value) and value > 0.0:
        return float(value)
    return None
