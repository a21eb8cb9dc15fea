"""How good a track table is: shares of flags, typical errors, the pivot's plain harmonic."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.experiment.track_table import FLAGS, balls_of

if TYPE_CHECKING:
    import xarray as xr

# Amplitude below which a pivot rests, as a multiple of what the fit leaves over.
_MOVES = 1.0
# Fewest turns of the drive that make a frequency.
_TURNS = 1.5


def flag_shares(table: xr.Dataset) -> dict[str, float]:
    """Return the share of each flag that occurs, over the samples of all balls."""
    flags = np.concatenate([table[f"flag_{b}"].values for b in range(1, balls_of(table) + 1)])
    return {flag: float(np.mean(flags == flag)) for flag in FLAGS if np.any(flags == flag)}


def typical_sigma(table: xr.Dataset) -> float | None:
    """Return the median standard deviation of the angles flagged ok [rad], None without any."""
    sigmas = np.concatenate(
        [
            table[f"angle_sigma_{b}"].values[table[f"flag_{b}"].values == "ok"]
            for b in range(1, balls_of(table) + 1)
        ]
    )
    sigmas = sigmas[np.isfinite(sigmas)]
    return float(np.median(sigmas)) if sigmas.size else None


def circle_distances(table: xr.Dataset, ball: int) -> np.ndarray:
    """Return how far a ball is outside its circle about the pivot [m], in pixels without a scale.

    Shape (frame,).
    """
    ends = "xy" if np.isfinite(table["pivot_x"].values).any() else "uv"
    if f"pivot_{ends[0]}" not in table.variables:
        return np.full(table.sizes["frame"], np.nan)
    away = [table[f"ball_{ball}_{end}"].values - table[f"pivot_{end}"].values for end in ends]
    distance = np.hypot(*away)
    arm = table.attrs["length"] if ends == "xy" else table.attrs["arm_pixels"]
    return np.asarray(distance - arm)


def pivot_heights(table: xr.Dataset) -> np.ndarray:
    """Return how high the pivot is [m], or in pixels where there is no scale."""
    if np.isfinite(table["pivot_y"].values).any():
        return np.asarray(table["pivot_y"].values)
    if "pivot_v" in table.variables:
        rows = table["pivot_v"].values
        return np.asarray(np.nanmean(rows) - rows)
    return np.full(table.sizes["frame"], np.nan)


def drive_of(table: xr.Dataset) -> tuple[float | None, float | None]:
    """Return amplitude [m, or pixels without a scale] and angular frequency of the pivot [rad/s].

    None for a pivot that rests or is unknown. One harmonic over the whole clip: drives that change
    are fitted elsewhere.
    """
    heights, times = pivot_heights(table), table["time"].values
    ok = np.isfinite(heights)
    if ok.sum() < 16:
        return None, None
    amplitude, frequency, rest = _harmonic(times[ok], heights[ok])
    pixel = table.attrs.get("metres_per_pixel", 1.0)
    if amplitude < max(_MOVES * rest, 0.15 * pixel):
        return None, None
    return amplitude, frequency


def harmonic_at(table: xr.Dataset) -> np.ndarray:
    """Return the pivot's height by its plain harmonic at the table's times."""
    heights, times = pivot_heights(table), table["time"].values
    ok = np.isfinite(heights)
    _, frequency, _ = _harmonic(times[ok], heights[ok])
    weights = np.linalg.lstsq(_waves(times[ok], frequency), heights[ok], rcond=None)[0]
    return np.asarray(_waves(times, frequency) @ weights)


def _waves(times: np.ndarray, frequency: float) -> np.ndarray:
    """Return a constant, cosine and sine as columns."""
    phase = frequency * times
    return np.column_stack([np.ones_like(times), np.cos(phase), np.sin(phase)])


def _harmonic(times: np.ndarray, heights: np.ndarray) -> tuple[float, float, float]:
    """Return amplitude, angular frequency and residual of the best harmonic."""
    from scipy.optimize import minimize_scalar

    span = float(times[-1] - times[0])
    fastest = math.pi / float(np.median(np.diff(times)))
    count = int(min(4 * span * fastest / math.pi, 20_000))
    trials = np.linspace(2.0 * math.pi * _TURNS / span, fastest, max(count, 16))
    centred = heights - heights.mean()
    phases = np.exp(-1j * np.outer(trials, times))
    best = float(trials[int(np.argmax(np.abs(phases @ centred)))])

    def cost(frequency: float) -> float:
        waves = _waves(times, frequency)
        weights = np.linalg.lstsq(waves, heights, rcond=None)[0]
        return float(np.mean((heights - waves @ weights) ** 2))

    width = math.pi / span
    minimum = minimize_scalar(
        cost, bounds=(best - width, best + width), method="bounded", options={"xatol": 1e-7 * best}
    )
    frequency = float(minimum.x)
    weights = np.linalg.lstsq(_waves(times, frequency), heights, rcond=None)[0]
    return math.hypot(weights[1], weights[2]), frequency, math.sqrt(cost(frequency))
