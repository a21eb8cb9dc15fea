"""The quality of a track table: shares of flags, typical errors, and the pivot's harmonic."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.experiment.calibration.tilt import tilt_of
from latolato.experiment.track_table import (
    FLAGS,
    OUTSIDE_SOURCES,
    balls_of,
    has_own_pivots,
    table_of_ball,
)

if TYPE_CHECKING:
    import xarray as xr

# Amplitude below which a pivot rests, as a multiple of what the fit leaves over, and as a share of
# that in the other direction.
_MOVES, _ASIDE = 1.0, 0.02
# Fewest turns of the drive that make a frequency.
_TURNS = 1.5
# Samples beyond which not every frequency is compared with all of them.
_MANY = 1000


def flag_shares(table: xr.Dataset) -> dict[str, float]:
    """Return the share of each flag that occurs, over the samples of all balls."""
    flags = _of_balls(table, "flag")
    return {flag: float(np.mean(flags == flag)) for flag in FLAGS if np.any(flags == flag)}


def typical_sigma(table: xr.Dataset) -> float | None:
    """Return the median standard deviation of the angles flagged ok [rad], None without any."""
    sigmas = _of_balls(table, "angle_sigma")
    sigmas = sigmas[(_of_balls(table, "flag") == "ok") & np.isfinite(sigmas)]
    return float(np.median(sigmas)) if sigmas.size else None


def _of_balls(table: xr.Dataset, name: str) -> np.ndarray:
    """A column of all balls, one after the other."""
    return np.concatenate([table[f"{name}_{b}"].values for b in range(1, balls_of(table) + 1)])


def unseen_pivot(attributes: Mapping[str, Any]) -> str | None:
    """Describe where a pivot outside the picture is, and how well it is known.

    None for a pivot in the picture, and where there is none.
    """
    source = attributes.get("pivot_source", "picture")
    if source not in OUTSIDE_SOURCES:
        return None
    known = "as declared" if source == "declared" else "from the arc"
    shared = "angles and scale" if attributes.get("scale_source") == "length" else "angles"
    return (
        f"out of the picture at ({attributes['origin_u']:.0f}, {attributes['origin_v']:.0f}) "
        f"{known}, assumed at rest; {shared} are known to "
        f"{100.0 * attributes['angle_scale_sigma']:.2g} %"
    )


def clock_text(attributes: Mapping[str, Any]) -> str:
    """Return why a table's times differ from those of its file; "" if they do not."""
    factor, filmed = attributes.get("slow_motion", 1.0), attributes.get("capture_rate")
    if filmed is None:
        return "" if factor == 1.0 else f"times divided by {factor:g}"
    shown = attributes["shown_rate"]
    source = "from the file" if abs(factor * shown / filmed - 1.0) < 0.05 else "against the file"
    return (
        f"{filmed:.4g} frames a second filmed, {shown:.4g} shown: times divided by {factor:g} "
        f"({source})"
    )


def circle_distances(table: xr.Dataset, ball: int) -> np.ndarray:
    """Return how far a ball is outside its circle about the pivot [m], in pixels without a scale.

    Shape (frame,).
    """
    if has_own_pivots(table):
        table, ball = table_of_ball(table, ball), 1
    ends = "xy" if np.isfinite(table["pivot_x"].values).any() else "uv"
    if f"pivot_{ends[0]}" not in table.variables:
        return np.full(table.sizes["frame"], np.nan)
    away = [table[f"ball_{ball}_{end}"].values - table[f"pivot_{end}"].values for end in ends]
    if ends == "uv":
        away = list(tilt_of(table.attrs).flat(np.stack(away, axis=-1)).T)
    distance = np.hypot(*away)
    arm = table.attrs["length"] if ends == "xy" else table.attrs["arm_pixels"]
    return np.asarray(distance - arm)


def pivot_places(table: xr.Dataset, axis: str = "y") -> np.ndarray:
    """Return the pivot's x, to the right, or y, upwards [m], in pixels where there is no scale."""
    if np.isfinite(table[f"pivot_{axis}"].values).any():
        return np.asarray(table[f"pivot_{axis}"].values)
    column, sign = {"x": ("pivot_u", 1.0), "y": ("pivot_v", -1.0)}[axis]
    if column not in table.variables:
        return np.full(table.sizes["frame"], np.nan)
    places = table[column].values
    return np.asarray(sign * (places - np.nanmean(places)))


@dataclass(frozen=True)
class Harmonic:
    """The pivot's motion as one harmonic over the whole clip; `fit_drive` fits drives that change.

    `amplitude` and `places` (frame,) are in metres, in pixels without a scale, `frequency` is
    angular [rad/s].
    """

    amplitude: float
    frequency: float
    places: np.ndarray


def pivot_harmonic(table: xr.Dataset, axis: str = "y") -> Harmonic | None:
    """Return the harmonic of the pivot's motion along an axis, "x" or "y".

    None if it does not move along it, is unknown, or does so for less than two cycles.
    """
    places, times = pivot_places(table, axis), table["time"].values
    ok = np.isfinite(places)
    if ok.sum() < 16:
        return None
    frequency, weights, rest = fitted_harmonic(times[ok], places[ok])
    amplitude = math.hypot(weights[1], weights[2])
    if amplitude < max(_MOVES * rest, 0.15 * table.attrs.get("metres_per_pixel", 1.0)):
        return None
    if frequency * float(np.ptp(times[ok])) < 2.0 * math.tau:  # a drift looks like less
        return None
    return Harmonic(amplitude, frequency, _waves(times, frequency) @ weights)


def pivot_numbers(table: xr.Dataset) -> dict[str, float | None]:
    """Return amplitudes and frequencies of the pivot's motion up and down and to the side.

    They are ``drive_amplitude`` and ``sideways_amplitude`` [m, pixels without a scale] and
    ``drive_frequency`` and ``sideways_frequency`` [rad/s], None as for `pivot_harmonic`. A track
    bends a large motion up and down a little to the side: that is none.
    """
    up, aside = pivot_harmonic(table), pivot_harmonic(table, "x")
    if up is not None and aside is not None and aside.amplitude < _ASIDE * up.amplitude:
        aside = None
    return {
        f"{way}_{name}": None if harmonic is None else getattr(harmonic, name)
        for way, harmonic in (("drive", up), ("sideways", aside))
        for name in ("amplitude", "frequency")
    }


def pivot_text(values: Mapping[str, Any]) -> str:
    """Describe how a pivot moves, or where it is if the picture does not show it.

    Where only its axis says where down is, that is said.

    `values` are the attributes of a table and its `pivot_numbers`.
    """
    scale, unit = (1.0, "pixel") if values["geometry"] == "angles" else (1e3, "mm")
    is_oblique = values["sideways_amplitude"] is not None
    parts = []
    for name, way in (
        ("drive", " up and down" if is_oblique else ""),
        ("sideways", " to each side"),
    ):
        amplitude, rate = values[f"{name}_amplitude"], values[f"{name}_frequency"]
        if amplitude is not None:
            size = f"{scale * amplitude:.5g} {unit}{way}"
            parts.append(f"{size} at {rate:.6g} rad/s ({rate / math.tau:.5g} Hz)")
    source = values.get("gravity_source", "")
    if not parts:
        parts = ["moves" if "drive" in source else "rests"]
    if source == "vertical drive":
        parts.append("its axis taken as vertical: the clip shows too little of the swing to tell")
    return unseen_pivot(values) or ", ".join(parts)


def _waves(times: np.ndarray, frequency: float) -> np.ndarray:
    """Return a constant, cosine and sine as columns."""
    phase = frequency * times
    return np.column_stack([np.ones_like(times), np.cos(phase), np.sin(phase)])


def fitted_harmonic(
    times: np.ndarray, heights: np.ndarray, fastest: float | None = None
) -> tuple[float, np.ndarray, float]:
    """Return angular frequency, weights of `_waves` and residual of the best harmonic.

    Frequencies up to `fastest` [rad/s] are tried, by default half the rate of the samples.
    """
    from scipy.optimize import minimize_scalar

    span = float(times[-1] - times[0])
    pause = float(np.median(np.diff(times)))
    centred = heights - heights.mean()
    slowest = 2.0 * math.pi * _TURNS / span
    if fastest is None and len(times) > _MANY:
        # The same on a grid of even times, as fast as a Fourier transform is.
        grid = np.bincount(np.round((times - times[0]) / pause).astype(int), centred)
        size = 4 * len(grid)
        rates = 2.0 * math.pi / (size * pause) * np.arange(size // 2 + 1)
        power = np.abs(np.fft.rfft(grid, size))
        best = float(rates[int(np.argmax(np.where(rates >= slowest, power, 0.0)))])
    else:
        fastest = math.pi / pause if fastest is None else fastest
        count = int(min(4 * span * fastest / math.pi, 20_000))
        trials = np.linspace(slowest, fastest, max(count, 16))
        phases = np.exp(-1j * np.outer(trials, times))
        best = float(trials[int(np.argmax(np.abs(phases @ centred)))])

    def solved(frequency: float) -> tuple[np.ndarray, float]:
        waves = _waves(times, frequency)
        weights = np.linalg.lstsq(waves, heights, rcond=None)[0]
        return weights, float(np.mean((heights - waves @ weights) ** 2))

    width = math.pi / span
    minimum = minimize_scalar(
        lambda frequency: solved(frequency)[1],
        bounds=(best - width, best + width),
        method="bounded",
        options={"xatol": 1e-7 * best},
    )
    weights, cost = solved(float(minimum.x))
    return float(minimum.x), weights, math.sqrt(cost)
