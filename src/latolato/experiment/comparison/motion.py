"""Compare a measured motion with the one computed on the measured drive: residuals and phase."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from latolato.core.errors import InputError, Sentence, joined
from latolato.core.quantities import POSITIVE
from latolato.core.registry import checked_count, checked_number
from latolato.experiment.comparison.uncertainties import (
    LATE,
    Floats,
    checked_sigmas,
    drawn,
    plain,
    variable,
)
from latolato.experiment.fits.least_squares import Data, Solution
from latolato.experiment.fits.pivots import measured_motion
from latolato.experiment.fits.samples import noise_of
from latolato.experiment.fits.windows import WindowedModel
from latolato.experiment.rules import said
from latolato.physics.drives import Drive, FixedPivot
from latolato.physics.pendulum import System, systems
from latolato.simulation.start import checked_system

if TYPE_CHECKING:
    import xarray as xr

# The start is found from so many natural periods.
_MATCHED = 4.0
# The computed motion has left the measured one where residuals exceed this share of the angle.
_LEFT = 0.3
# Differences so many times the noise of the samples are no noise.
_MORE = 3.0


def compare_motion(
    table: xr.Dataset,
    system: System,
    drive: Drive | str | None = None,
    *,
    ball: int | None = None,
    start: Annotated[float | None, "s"] = None,
    end: Annotated[float | None, "s"] = None,
    match: Annotated[float | None, "s"] = None,
    sigmas: Mapping[str, float] | None = None,
    draws: int = 12,
    seed: int = 0,
) -> xr.Dataset:
    """Return measured and computed angles at the same instants, their difference and phase.

    Parameters
    ----------
    table : xarray.Dataset
        A track table; samples that are not flagged ok are ignored.
    system : Pendulum, LatoLato or BallPair
        What is computed.
    drive : Drive or "measured", optional
        How the pivot moves; by default as measured, as in `latolato.fit_model`.
    ball : int, optional
        Which ball of the table a system of one angle describes; by default 1, and for a `LatoLato`
        with both balls in the table half the difference of their angles.
    start : float, optional
        First instant used [s].
    end : float, optional
        Last instant used [s].
    match : float, optional
        Time after the start during which the computed motion is fitted to the measured one, by its
        initial angle and velocity only; by default 4 natural periods [s].
    sigmas : mapping of str to float, optional
        Standard deviations of the system's parameters, in SI units.
    draws : int
        Number of motions computed with starts and parameters drawn within their deviations.
    seed : int
        Of these.

    Returns
    -------
    xarray.Dataset
        On ``sample``: `time`, `angle`, `angle_computed`, `angle_computed_sigma` (spread of the
        draws), `angle_residual`, `phase_difference` (measured ahead of computed: positive; of the
        ball's own swing) and `coherence` (1 where both swings have the same shape). As numbers: the
        residual and the phase in the last third, and both largest and settled angles.

    Raises
    ------
    InputError
        For bad input.
        If lmfit is missing.

    Notes
    -----
    After `match` the computed motion is a prediction.

    Phases are those of the analytic signals (Hilbert) z of both angles about their mean over two
    drive periods: the argument of the mean of ``z_measured conj(z_computed)`` over two drive
    periods, NaN at both ends and where samples are missing. A phase of chaotic or resting motion
    means little: see `coherence`.
    """
    import xarray as xr

    widths = checked_sigmas(checked_system(system), sigmas)
    count = checked_count("draws", draws)
    table, data, moving = measured_motion(table, system, drive, ball, start, end)
    first, last = float(data.times.min()), float(data.times.max())
    span = _MATCHED * math.tau / system.natural_frequency
    if match is not None:
        span = checked_number("match", match, POSITIVE, "s")
    begins = np.array([first])

    def motion(law: System, samples: Data) -> WindowedModel:
        return WindowedModel(samples, lambda _: (law, moving.drive), {}, begins, moving.origin)

    early = _early(data, first + span)
    model = motion(system, early)
    solution = model.solved(model.guesses())
    whole = motion(system, data)
    if np.isnan(whole.motion(solution.values)).any():
        raise InputError("the computed motion does not reach the end of the record")
    computed = whole(solution.values)
    computed_sigma = _computed_sigma(system, widths, solution, motion, data, count, seed)
    residual = data.values - computed
    period = _period(moving.drive, system)
    phase, coherence = np.full(len(data), np.nan), np.full(len(data), np.nan)
    for series in np.unique(data.series):
        own = data.series == series
        phase[own], coherence[own] = phases(
            data.times[own], data.values[own], computed[own], period
        )
    late = data.times >= last - (last - first) / 3.0
    followed = _followed(data, residual, 2.0 * period)
    numbers = {
        "residual_rms": (_rms(residual), "root mean square of the residual", "rad"),
        "residual_rms_late": (_rms(residual[late]), "the same in the last third", "rad"),
        "phase_rms_late": (_rms(phase[late]), "root mean square of the phase there", "rad"),
        "largest_angle": (_top(data.values), "largest measured angle", "rad"),
        "largest_angle_computed": (_top(computed), "largest computed angle", "rad"),
        LATE: (_top(data.values[late]), "largest measured angle there", "rad"),
        f"{LATE}_computed": (_top(computed[late]), "largest computed angle there", "rad"),
        "followed_until": (followed, "time until which the computation follows", "s"),
    }
    variables: dict[str, Any] = {
        "time": variable("sample", data.times, "time"),
        "ball_number": variable("sample", data.series, "ball_number"),
        "angle": variable("sample", data.values, "angle"),
        "angle_sigma": variable("sample", data.sigmas, "angle_sigma_1", "its standard deviation"),
        "angle_computed": variable("sample", computed, "angle", "computed angle"),
        "angle_computed_sigma": variable(
            "sample", computed_sigma, "angle_sigma_1", "deviation of the computed angle"
        ),
        "angle_residual": variable(
            "sample", residual, "angle_residual", "measured minus computed angle"
        ),
        "phase_difference": plain("sample", phase, "phase of measured over computed swing", "rad"),
        "coherence": plain("sample", coherence, "similarity of measured and computed swing"),
        **{name: plain((), value, text, unit) for name, (value, text, unit) in numbers.items()},
    }
    attributes = {
        "comparison": "motion",
        "system": systems.name_of(system),
        "system_description": json.dumps(systems.described(system)),
        "pivot": moving.words, "match": span, "source": str(table.attrs.get("source", "")),
        **{f"sigma_of_{name}": value for name, value in widths.items()},
    }  # fmt: skip
    dataset = xr.Dataset(variables, attrs=attributes)
    return dataset.assign_attrs(verdict=str(verdict_of(dataset)))


def phases(times: Floats, one: Floats, other: Floats, period: float) -> tuple[Floats, Floats]:
    """Return by how much one swing is ahead of another [rad], and how alike they are.

    Parameters
    ----------
    times, one, other : ndarray, shape (sample,)
        Instants [s] and both swings.
    period : float
        About which means are taken is twice this [s].
    """
    from scipy.ndimage import convolve1d
    from scipy.signal import hilbert

    pause = float(np.median(np.diff(times)))
    width = 2 * max(round(period / pause), 2) + 1
    unknown = np.full(len(times), np.nan)
    grid = np.arange(times[0], times[-1] + 0.5 * pause, pause)
    if len(grid) < 5 * width:
        return unknown, unknown.copy()
    window = np.hanning(width + 2)[1:-1]
    window /= window.sum()
    box = np.full(width, 1.0 / width)

    def mean(values: Any, weights: Floats) -> Any:
        return convolve1d(values, weights, mode="nearest")

    signals = []
    for swing in (one, other):
        even = np.interp(grid, times, swing)
        signals.append(hilbert(even - mean(even, box)))
    a, b = signals
    cross = a * np.conj(b)
    product = mean(cross.real, window) + 1j * mean(cross.imag, window)
    size = np.sqrt(mean(np.abs(a) ** 2, window) * mean(np.abs(b) ** 2, window))
    # A sample of the grid that has none of the record's beside it was made up.
    nearest = np.rint(np.interp(grid, times, np.arange(len(times)))).astype(int)
    made_up = np.abs(times[nearest] - grid) > 0.75 * pause
    unknown_phase = mean(made_up.astype(float), box) > 0.5
    unknown_phase[: 2 * width] = unknown_phase[-2 * width :] = True
    phase = np.where(unknown_phase, np.nan, np.angle(product))
    coherence = np.where(unknown_phase, np.nan, np.abs(product) / np.maximum(size, 1e-300))
    place = np.clip(np.round((times - grid[0]) / pause).astype(int), 0, len(grid) - 1)
    return phase[place], coherence[place]


def _early(data: Data, until: float) -> Data:
    """Return the samples up to an instant, at least ten of each series."""
    counts = [np.sort(data.times[data.series == s]) for s in np.unique(data.series)]
    until = max(until, *(float(times[min(9, len(times) - 1)]) for times in counts))
    return data[data.times <= until]


def _computed_sigma(
    system: System,
    widths: Mapping[str, float],
    solution: Solution,
    motion: Any,
    data: Data,
    count: int,
    seed: int,
) -> Floats:
    """Return the deviation of the computed angles because starts and parameters are uncertain."""
    random = np.random.default_rng(seed)
    varied = drawn(system, widths, count + 1, random)
    best = [solution.values[name] for name in solution.names]
    starts = random.multivariate_normal(best, solution.covariance, size=count)
    middle = motion(system, data)(solution.values)
    differences = []
    for k, start in enumerate(starts.tolist(), start=1):
        law = replace(system, **{name: float(values[k]) for name, values in varied.items()})
        trial, begun = motion(law, data), dict(zip(solution.names, start, strict=True))
        if not np.isnan(trial.motion(begun)).any():
            differences.append(trial(begun) - middle)
    if not differences:
        return np.zeros(len(data))
    return np.asarray(np.sqrt(np.mean(np.square(differences), axis=0)))


def _period(drive: Any, system: System) -> float:
    """Return the period that means are taken over [s]."""
    if isinstance(drive, FixedPivot):
        return math.tau / system.natural_frequency / 2.0
    slowest = [
        float(value)
        for name in ("drive_frequency", "drive_frequency_final")
        if (value := getattr(drive, name, None)) is not None
    ]
    slowest += [float(w) for w in getattr(drive, "drive_frequencies", ())]
    return math.tau / (min(slowest) if slowest else system.natural_frequency)


def _followed(data: Data, residual: Floats, window: float) -> float:
    """Return the instant until which the residual is a small part of the angle [s]."""
    first, last = float(data.times.min()), float(data.times.max())
    noise = 3.0 * noise_of(data.values[data.series == data.series[0]])
    for begin in np.arange(first, last, window):
        inside = (data.times >= begin) & (data.times < begin + window)
        if begin + 0.5 * window > last or inside.sum() < 3:
            continue
        swing = data.values[inside] - np.mean(data.values[inside])
        if _rms(residual[inside]) > _LEFT * max(_rms(swing), noise, 1e-3):
            return float(begin)
    return last


def _rms(values: Floats) -> float:
    """Return the root mean square of what is known, NaN if nothing is."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else math.nan


def _top(values: Floats) -> float:
    """Return the largest size."""
    return float(np.max(np.abs(values)))


def verdict_of(comparison: xr.Dataset) -> Sentence:
    """Return how computation and measurement compare in plain words."""
    value = {str(name): float(one) for name, one in comparison.variables.items() if not one.dims}
    times, series = comparison["time"].values, comparison["ball_number"].values
    first, last = float(times.min()), float(times.max())
    noise = noise_of(comparison["angle"].values[series == series[0]])
    one, other = (math.degrees(value[name]) for name in (LATE, f"{LATE}_computed"))
    if value["followed_until"] >= last:
        off, phase = value["residual_rms"], value["phase_rms_late"]
        follows = said(
            "followed_whole", span=last - first, off=1e3 * off,
            noise=said("followed_noise", ratio=off / noise) if off > _MORE * noise > 0.0 else "",
            phase=said("followed_phase", phase=phase) if math.isfinite(phase) else "",
        )  # fmt: skip
    else:
        until, off = value["followed_until"], 1e3 * value["residual_rms_late"]
        follows = said("followed_until", until=until, last=last, off=off)
    return joined([follows, said("last_third", measured=f"{one:.2f}", computed=f"{other:.2f}")])
