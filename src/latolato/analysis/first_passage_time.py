"""How long noise takes to start the motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from latolato.analysis.registry import analyses, labelled, warn
from latolato.analysis.rules import broken_analysis
from latolato.analysis.starts import start_options
from latolato.core.quantities import POSITIVE, Quantity
from latolato.observables import FirstPassage
from latolato.physics.drives import Drive
from latolato.physics.noise import STREAMS, VelocityKicks
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED, checked_system
from latolato.sweeps import sweep
from latolato.sweeps.statuses import has_answer

if TYPE_CHECKING:
    import xarray as xr

PASSED, NONE = "passed", "none passed"
DELAYED, AT_ONCE = "not exponential", "all at once"
# Probability below which a long beginning without a passage contradicts exponential times.
_UNLIKELY = 1e-3
_CONFIDENCE = 0.95

_QUANTITIES = {
    "trajectory": Quantity("1", "k", "number of the trajectory, which is its random stream"),
    "mean_first_passage_time": Quantity("s", r"\tau", "mean first-passage time"),
    "mean_first_passage_time_error": Quantity(
        "s", r"\Delta\tau", "standard error of the mean first-passage time"
    ),
    "mean_first_passage_time_low": Quantity("s", r"\tau_-", "lower end of its 95 % interval"),
    "mean_first_passage_time_high": Quantity("s", r"\tau_+", "upper end of its 95 % interval"),
    "passage_fraction": Quantity("1", "p", "fraction that passes within the duration"),
    "passage_fraction_error": Quantity("1", r"\Delta p", "its standard error"),
}


class Lifetime(NamedTuple):
    """A mean waiting time [s], its standard error and its 95 % interval, and the events seen."""

    mean: float
    error: float
    low: float
    high: float
    events: int


def censored_mean(waited: float, events: int) -> Lifetime:
    """Return the mean waiting time of exponential events from a time waited in all [s].

    Maximum likelihood under censoring (Epstein & Sobel, 1953).

    Parameters
    ----------
    waited : float
        Time waited in all trajectories together, those without an event included [s].
    events : int
        Events seen.

    Returns
    -------
    Lifetime
        The mean is NaN and the upper end infinite where no event was seen.

    Notes
    -----
    ``mean = waited/events``, ``error = mean/sqrt(events)``; the interval is that of a Poisson
    count, ``2 waited/chi2``. With no event the lower end is ``waited/ln 20``, the one-sided bound.

    Examples
    --------
    >>> result = censored_mean(120.0, 4)
    >>> print(f"{result.mean:.0f} +- {result.error:.0f} s, {result.low:.1f} to {result.high:.0f} s")
    30 +- 15 s, 11.7 to 110 s
    """
    from scipy.stats import chi2

    if events == 0:
        return Lifetime(math.nan, math.nan, -waited / math.log(1.0 - _CONFIDENCE), math.inf, 0)
    tail = 0.5 * (1.0 - _CONFIDENCE)
    low = 2.0 * waited / float(chi2.ppf(1.0 - tail, 2 * events + 2))
    high = 2.0 * waited / float(chi2.ppf(tail, 2 * events))
    mean = waited / events
    return Lifetime(mean, mean / math.sqrt(events), low, high, events)


@analyses.register("first_passage_time", checked_system)
def first_passage_time(
    system: System,
    drive: Drive | None = None,
    *,
    noise_strength: Annotated[float, POSITIVE],
    threshold_angle: Annotated[float, POSITIVE] = math.pi / 4.0,
    duration: float = 300.0,
    trajectories: int = 200,
    noise_seed: Annotated[int, STREAMS] = 0,
    noise_interval: float | None = None,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    tolerance: float = 1e-6,
    contact: str | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return how long velocity noise takes to bring the angle to a threshold [s].

    First-passage times of an ensemble; the mean as for thermally activated escape (Kramers, 1940).

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, optional
        How the pivot moves; None is a pivot at rest.
    noise_strength : float
        Strength of the velocity kicks [rad/s^(3/2)], positive.
    threshold_angle : float
        The absolute angle whose first passage counts [rad], beyond that of the start.
    duration : float
        Time after which a trajectory is given up [s].
    trajectories : int
        How many trajectories, each with its own random stream.
    noise_seed : int
        Seed of the streams.
    noise_interval : float, optional
        Time between kicks [s]; by default 1/50 of the natural period.
    initial_angle, initial_angular_velocity, initial_offset, tolerance, contact, rest_speed
        As for `latolato.sweep`; by default the system hangs at rest, in contact if it can be.

    Returns
    -------
    xarray.Dataset
        ``first_passage`` over ``trajectory`` (NaN where the threshold was not reached; trajectory k
        is the run with ``VelocityKicks(..., noise_stream=k)``), ``mean_first_passage_time``
        with error and 95 % interval, ``passage_fraction`` with error, and ``status``: "passed";
        "not exponential" (no passage for so long at the beginning as exponential waiting times show
        once in a thousand ensembles); "none passed" (the mean is NaN, only the lower end is
        known); "all at once" (every passage within 1 % of the same time: drift, not noise, and no
        mean waiting time).

    Raises
    ------
    InputError
        For a parameter outside its range, or a start beyond the threshold.

    Notes
    -----
    With k passages at t_i among n trajectories, ``mean = (sum t_i + (n - k) duration)/k``, its
    error ``mean/sqrt(k)``: exact for exponential waiting times. The motion takes a while from the
    bottom to the threshold, however early the noise kicks it over: with this dead time, or where
    a drift carries the motion, waiting times are not exponential. Where all trajectories pass, the
    error and the interval then are those of a mean of any times, by their scatter; where some are
    given up, the mean depends on `duration`. What it can miss: other ways not to be exponential.
    The fraction's error is Wilson's at one standard deviation. For two balls the earlier one
    counts.

    Examples
    --------
    >>> import latolato as ll
    >>> pendulum = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> result = first_passage_time(
    ...     pendulum, noise_strength=0.5, threshold_angle=0.6, duration=60.0, trajectories=50
    ... )
    >>> result.sizes["trajectory"], bool(result.passage_fraction > 0.5)
    (50, True)
    """
    kicks = VelocityKicks(
        noise_strength=noise_strength, noise_seed=noise_seed, noise_interval=noise_interval
    )
    start = start_options(system, initial_angle, initial_angular_velocity, initial_offset)
    grid = sweep(
        system,
        drive,
        axes={"noise_stream": range(trajectories)},
        duration=duration,
        observables=[FirstPassage(threshold_angle=threshold_angle)],
        noise=kicks,
        tolerance=tolerance,
        contact=contact,
        rest_speed=rest_speed,
        **start,
    )
    times = grid.first_passage.values
    if system.angles == 2:
        times = np.fmin(times[:, 0], times[:, 1])
    if np.any(times == 0.0):
        raise broken_analysis("start_below_threshold", {"threshold": threshold_angle})
    known = has_answer(grid.status)
    result = _statistics(times[known], duration)
    if result["status"] == NONE:
        warn("none_reached", count=trajectories, angle=threshold_angle, duration=duration)
    return labelled(
        {"first_passage": ("trajectory", times)} | result,
        system=system,
        drive=drive,
        coordinates={"trajectory": np.arange(trajectories)},
        quantities=_QUANTITIES,
        settings={**start, "noise_interval": kicks.spacing(system)},
    )


def _plain_mean(times: np.ndarray[Any, Any]) -> Lifetime:
    """Return the mean of waiting times of any kind, all of which are known [s]."""
    from scipy.stats import t

    mean, error = float(times.mean()), float(times.std(ddof=1)) / math.sqrt(len(times))
    low, high = t.interval(_CONFIDENCE, len(times) - 1, mean, error)
    return Lifetime(mean, error, float(low), float(high), len(times))


def _statistics(times: np.ndarray[Any, Any], end: float) -> dict[str, Any]:
    """Return mean, fraction and status of passages, NaN where there is none before the end."""
    passed = times[np.isfinite(times)]
    k, n = len(passed), len(times)
    mean = censored_mean(float(passed.sum()) + (n - k) * end, k)
    share = k / n if n else math.nan
    # Wilson (1927) at one standard deviation: right also where all or none pass.
    spread = math.sqrt(share * (1.0 - share) / n + 0.25 / n**2) / (1.0 + 1.0 / n) if n else math.nan
    status = PASSED if k else NONE
    if k > 1 and k == n and np.ptp(passed) <= 0.01 * passed.mean():
        status, mean = AT_ONCE, Lifetime(math.nan, math.nan, math.nan, math.nan, k)
    elif k and math.exp(-n * float(passed.min()) / mean.mean) < _UNLIKELY:
        status, mean = DELAYED, _plain_mean(passed) if k == n else mean
    return {
        "mean_first_passage_time": mean.mean,
        "mean_first_passage_time_error": mean.error,
        "mean_first_passage_time_low": mean.low,
        "mean_first_passage_time_high": mean.high,
        "passage_fraction": share,
        "passage_fraction_error": spread,
        "status": status,
    }
