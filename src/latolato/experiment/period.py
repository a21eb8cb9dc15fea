"""The period of a swing from places in the picture or angles, without a model."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

# Standard deviations by which periods of halves of a clip differ.
_APART = 3.0
# Fewest passages through the middle that make a period, the longest one in frames, and the least
# share of known places.
_FEWEST, _PAUSE, _KNOWN = 4, 2.5, 0.5


def period_of(times: np.ndarray, places: np.ndarray) -> tuple[float, float]:
    """Return the period of a swing in the picture and its standard deviation [s], NaN for none.

    Parameters
    ----------
    times : numpy.ndarray, shape (frame,)
        Time stamps [s].
    places : numpy.ndarray, shape (frame, 2) or (frame, 1)
        Column and row [pixels], or angle [rad]; NaN where unknown.

    Notes
    -----
    The slope of a straight line through the instants at which the ball passes the middle of its
    path in one direction, along the path's longest extent. None where fewer than half of the places
    are known: whole swings may be missing. If the halves of the clip differ by more than 3 standard
    deviations, half their difference joins the deviation: periods change with the amplitude.
    """
    period, sigma = _period(times, places)
    apart = halves_apart(times, places)
    if apart is not None:
        sigma = math.hypot(sigma, 0.5 * abs(apart[1] - apart[0]))
    return period, sigma


def period_of_ball(table: xr.Dataset, ball: int) -> tuple[float, float]:
    """Return the period of a ball's swing and its standard deviation [s], NaN for none.

    By its angle, or by its place in the picture in a table without angles.
    """
    names = [f"angle_{ball}"]
    if names[0] not in table.variables or not np.isfinite(table[names[0]].values).any():
        names = [f"ball_{ball}_u", f"ball_{ball}_v"]
    if not all(name in table.variables for name in names):
        return math.nan, math.nan
    places = np.column_stack([table[name].values for name in names])
    return period_of(table["time"].values, places)


def halves_apart(times: np.ndarray, places: np.ndarray) -> tuple[float, float] | None:
    """Return the periods of the halves of a clip [s], None if they agree or are unknown.

    Arguments are those of `period_of`.
    """
    middle = len(times) // 2
    halves = [_period(times[part], places[part]) for part in (np.s_[:middle], np.s_[middle:])]
    (early, one), (late, other) = halves
    return (early, late) if abs(late - early) > _APART * math.hypot(one, other) else None


def _period(times: np.ndarray, places: np.ndarray) -> tuple[float, float]:
    """Return the period of passages through the middle and the deviation of their line [s]."""
    ok = np.isfinite(places).all(axis=1)
    if ok.sum() < max(8, _KNOWN * len(ok)):
        return math.nan, math.nan
    centred = places[ok] - np.median(places[ok], axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    swing, instants = centred @ axis, times[ok]
    low, high = np.quantile(swing, [0.02, 0.98])
    swing = swing - 0.5 * (low + high)
    pause = _PAUSE * float(np.median(np.diff(times)))
    slack = 0.15 * (high - low)
    periods = [_slope(_passages(instants, sign * swing, slack, pause)) for sign in (1, -1)]
    known = [pair for pair in periods if math.isfinite(pair[0])]
    if not known:
        return math.nan, math.nan
    period = float(np.mean([pair[0] for pair in known]))
    return period, float(max(pair[1] for pair in known))


def _passages(times: np.ndarray, swing: np.ndarray, slack: float, pause: float) -> np.ndarray:
    """Return when a swing passes zero upwards, having been well below; NaN amid a pause."""
    passages, is_armed = [], False
    for k in range(1, len(swing)):
        is_armed = is_armed or swing[k - 1] < -slack
        if is_armed and swing[k - 1] <= 0.0 < swing[k]:
            is_armed = False
            share = -swing[k - 1] / (swing[k] - swing[k - 1])
            passed = times[k] - times[k - 1]
            passages.append(times[k - 1] + share * passed if passed <= pause else math.nan)
    return np.array(passages)


def _slope(passages: np.ndarray) -> tuple[float, float]:
    """Return the period of passages, some of which may be missing, and its error."""
    counted = np.flatnonzero(np.isfinite(passages))
    if len(counted) < _FEWEST:
        return math.nan, math.nan
    passages, apart = passages[counted], np.diff(counted)
    typical = float(np.median(np.diff(passages) / apart))
    steps = np.maximum(np.rint(np.diff(passages) / typical), apart)
    number = np.concatenate([[0.0], np.cumsum(steps)])
    fit, covariance = np.polyfit(number, passages, 1, cov="unscaled")
    rest = passages - np.polyval(fit, number)
    freedom = max(len(passages) - 2, 1)
    return float(fit[0]), float(math.sqrt(covariance[0, 0] * (rest @ rest) / freedom))
