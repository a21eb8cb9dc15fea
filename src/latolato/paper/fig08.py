"""Fig. 8b: the single pendulum of the experiment, and the amplitude that its motion needs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato import Harmonic, Mathieu
from latolato.analysis import growth_rate, threshold_amplitude
from latolato.figures import style
from latolato.paper import measure
from latolato.paper import systems as paper
from latolato.paper.cases import SAMPLES_PER_PERIOD, Residuals, instants, quantity, stack
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The single-pendulum experiment, numerical part"
CAPTION = (
    "(a) Equation 10 for the single pendulum of the experiment. The broken lines grow at the rate "
    "of the linear equation. (b) That rate against the driving amplitude; dots are runs of "
    "equation 14. Below the threshold there is no growth. The measured curve of the paper's panel "
    "(a) is not printed as numbers."
)
DURATION = 180.0  # s
LATE = 20.0  # s, the last stretch, in which the motion has settled
BELOW, ABOVE = 0.99, 1.01  # of the threshold


def data(quick: bool = False) -> xr.Dataset:
    """Return the angle at 15 mm, and the growth rate against the amplitude."""
    from latolato import simulate

    frequency = paper.SINGLE_FREQUENCY
    times = instants(DURATION, frequency)
    drive = Harmonic(drive_amplitude=paper.SINGLE_AMPLITUDE, drive_frequency=frequency)
    run = simulate(paper.SINGLE, drive, initial_angle=paper.SINGLE_START, times=times)
    threshold = float(
        threshold_amplitude(
            paper.SINGLE, frequency_ratio=frequency / paper.SINGLE.natural_frequency
        ).drive_amplitude
    )
    amplitudes = np.linspace(0.008, 0.030, 221)
    checked = np.concatenate([[BELOW * threshold, ABOVE * threshold], np.arange(9, 31, 3) * 1e-3])
    residuals = Residuals()
    dataset = stack({"eq10": run}, title=TITLE, keep=("angle", "angular_velocity"))
    dataset = dataset.assign(
        growth_rate=quantity(
            "growth_rate",
            "drive_amplitude",
            [_growth_rate(amplitude) for amplitude in amplitudes],
            long_name="growth rate by Hill's determinant",
        ),
        growth_rate_of_runs=quantity(
            "growth_rate",
            "checked_amplitude",
            [_linear_rate(amplitude, residuals) for amplitude in checked],
            long_name="growth rate of runs of eq14",
        ),
        threshold_amplitude=quantity(
            "drive_amplitude", (), threshold, long_name="smallest driving amplitude that grows"
        ),
    )
    return dataset.assign(residuals.variables()).assign_coords(
        drive_amplitude=quantity("drive_amplitude", "drive_amplitude", amplitudes),
        checked_amplitude=quantity("drive_amplitude", "checked_amplitude", checked),
    )


def _growth_rate(amplitude: float) -> float:
    """Growth rate by Hill's determinant at a driving amplitude [1/s]."""
    drive = Harmonic(drive_amplitude=amplitude, drive_frequency=paper.SINGLE_FREQUENCY)
    return float(growth_rate(paper.SINGLE, drive).growth_rate)


def _linear_rate(amplitude: float, residuals: Residuals) -> float:
    """Return the growth rate of eq14 at a driving amplitude, from a run [1/s]."""
    from latolato import simulate

    single, frequency = paper.SINGLE, paper.SINGLE_FREQUENCY
    linear = Mathieu(**paper.body(single))
    times = instants(200.0, frequency, per_period=1)
    run = simulate(
        linear,
        Harmonic(drive_amplitude=amplitude, drive_frequency=frequency),
        initial_angle=paper.SINGLE_START,
        times=times,
    )
    rate, _ = measure.growth_per_period(
        times, residuals.of(run).angle.values, samples_per_period=1, first=120.0, last=200.0
    )
    return rate


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 8's statements need."""
    time = dataset.time.values
    run = dataset.sel(case="eq10")
    angle = run.angle.values
    when, sizes = measure.peaks(time, angle, run.angular_velocity.values)
    top = int(np.argmax(sizes))
    late = sizes[when > DURATION - LATE]
    # While the peaks are between 3 and 10 degrees, growth prevails and the sine is straight.
    rising = when < when[top]
    first, last = (float(when[rising & (sizes > np.deg2rad(limit))][0]) for limit in (3.0, 10.0))
    growth, _ = measure.growth_per_period(
        time, angle, samples_per_period=SAMPLES_PER_PERIOD, first=first, last=last
    )
    hill = _growth_rate(paper.SINGLE_AMPLITUDE)
    below, above = (float(value) for value in dataset.growth_rate_of_runs[:2])
    return {
        "ratio": paper.SINGLE_FREQUENCY / paper.SINGLE.natural_frequency,
        "natural": paper.SINGLE.natural_frequency,
        "growth": growth,
        "hill": hill,
        "growth_error": abs(growth / hill - 1.0),
        "largest": float(sizes[top]),
        "largest_degrees": float(np.rad2deg(sizes[top])),
        "largest_time": float(when[top]),
        "settled_degrees": float(np.rad2deg(late.mean())),
        "last_spread": float(np.ptp(late) / late.mean()),
        "threshold_mm": 1e3 * float(dataset.threshold_amplitude),
        "rate_below": below,
        "rate_above": above,
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) and (b)."""
    figure, axes = style.new_figure(1, 2, height=2.5, width_ratios=[1.7, 1.0])
    ((a, b),) = axes
    time = dataset.time.values
    run = dataset.sel(case="eq10")
    a.plot(time, np.rad2deg(run.angle), color=style.BLUE, lw=0.5)
    rate = float(dataset.growth_rate.interp(drive_amplitude=paper.SINGLE_AMPLITUDE))
    when, sizes = measure.peaks(time, run.angle.values, run.angular_velocity.values)
    start = int(np.flatnonzero(sizes > np.deg2rad(5.0))[0])
    growing = time <= when[np.argmax(sizes)]
    envelope = np.rad2deg(sizes[start]) * np.exp(rate * (time[growing] - when[start]))
    for sign in (-1.0, 1.0):
        a.plot(time[growing], sign * envelope, color=style.INK, lw=style.THIN, ls="--")
    a.set_ylim(-100.0, 100.0)
    a.set_xlim(0.0, DURATION)
    a.set_xlabel(style.label(dataset.time))
    a.set_ylabel(style.label(dataset.angle, short=True, unit="°"))
    style.panel_title(a, "a", f"$A_0$ = {1e3 * paper.SINGLE_AMPLITUDE:g} mm (assumed)")

    b.axhline(0.0, color=style.GREY, lw=style.THIN)
    b.plot(1e3 * dataset.drive_amplitude, dataset.growth_rate, color=style.GREEN)
    b.plot(
        1e3 * dataset.checked_amplitude,
        dataset.growth_rate_of_runs,
        "o",
        ms=2.6,
        color=style.INK,
        clip_on=False,
    )
    threshold = 1e3 * float(dataset.threshold_amplitude)
    style.note(b, f"threshold {threshold:.2f} mm", (threshold, 0.0), (7, -9))
    b.set_xlabel(style.label(dataset.drive_amplitude, short=True, unit="mm"))
    b.set_ylabel("growth rate " + style.label(dataset.growth_rate, short=True))
    style.panel_title(b, "b", "growth of small swings")
    return figure
