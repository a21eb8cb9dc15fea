"""Fig. 3a and b: resonance at 6 rad/s and none at 5.9 rad/s, on two very different scales."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato import Harmonic
from latolato.analysis import growth_rate, tongue_edges
from latolato.figures import style
from latolato.paper import measure
from latolato.paper import systems as paper
from latolato.paper.cases import Residuals, instants, quantity, stack, variable
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "On either side of the edge of resonance"
CAPTION = (
    "The pendulum of Fig. 2 with two driving frequencies. (a) Resonance at 6 rad/s; the dot marks "
    "the largest angle. (b) Decay at 5.9 rad/s. The vertical scale of (b) is a thousandth of that "
    "of (a), as in the paper, whose scales differ as much. The maps (c) and (d) are a figure of "
    "their own."
)
DURATION = 300.0  # s
RESONANT, QUIET, TWICE = "resonant", "quiet", "twice"
FREQUENCIES = {
    RESONANT: paper.RESONANT_FREQUENCY,
    QUIET: paper.QUIET_FREQUENCY,
    TWICE: paper.DRIVE.drive_frequency,  # Fig. 2, for comparison
}


def data(quick: bool = False) -> xr.Dataset:
    """Return the angles at three frequencies, and eq14's growth close to the edge."""
    from latolato import simulate

    system, amplitude = paper.PENDULUM, paper.DRIVE.drive_amplitude
    # The same instants for all, so that they fit into one dataset.
    times = instants(DURATION, paper.DRIVE.drive_frequency)
    runs = {
        label: simulate(
            system,
            Harmonic(drive_amplitude=amplitude, drive_frequency=frequency),
            initial_angle=paper.SMALL_ANGLE,
            times=times,
        )
        for label, frequency in FREQUENCIES.items()
    }
    dataset = stack(runs, title=TITLE, keep=("angle", "angular_velocity"))
    frequencies = list(FREQUENCIES.values())
    rates = [
        float(
            growth_rate(
                system, Harmonic(drive_amplitude=amplitude, drive_frequency=frequency)
            ).growth_rate
        )
        for frequency in frequencies
    ]
    edge, undamped = (
        float(tongue_edges(each, drive_amplitude=amplitude).low)
        for each in (system, replace(system, damping=0.0))
    )
    beside = np.array([edge - 1e-3, edge + 1e-3])
    residuals = Residuals()
    dataset = dataset.assign(
        drive_frequency=quantity("drive_frequency", "case", frequencies),
        growth_rate=quantity("growth_rate", "case", rates),
        tongue_edge=quantity("frequency_ratio", "damped", [edge, undamped]),
        ratio_beside_edge=quantity("frequency_ratio", "side", beside),
        rate_beside_edge=quantity(
            "growth_rate", "side", [_linear_rate(ratio, residuals) for ratio in beside]
        ),
    )
    return dataset.assign(residuals.variables()).assign_coords(
        damped=variable("damped", [1, 0], units="1", long_name="with damping"),
        side=variable("side", [-1, 1], units="1", long_name="side of the edge"),
    )


def _linear_rate(ratio: float, residuals: Residuals) -> float:
    """Return the growth rate of eq14 at a frequency ratio, from a run [1/s]."""
    from latolato import simulate

    frequency = ratio * paper.LINEAR.natural_frequency
    times = instants(DURATION, frequency, per_period=1)
    run = simulate(
        paper.LINEAR,
        Harmonic(drive_amplitude=paper.DRIVE.drive_amplitude, drive_frequency=frequency),
        initial_angle=paper.SMALL_ANGLE,
        times=times,
    )
    rate, _ = measure.growth_per_period(
        times,
        residuals.of(run).angle.values,
        samples_per_period=1,
        first=DURATION / 2,
        last=DURATION,
    )
    return rate


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 3's statements need."""
    time = dataset.time.values
    result: dict[str, float] = {}
    for case in FREQUENCIES:
        run = dataset.sel(case=case)
        when, sizes = measure.peaks(time, run.angle.values, run.angular_velocity.values)
        start = abs(float(run.angle[0]))
        top = int(np.argmax(sizes))
        result[f"largest_{case}"] = max(float(sizes[top]), start)
        result[f"largest_{case}_time"] = float(when[top])
        result[f"last_{case}"] = float(sizes[when > DURATION - 20.0].max()) / start
        result[f"growth_{case}"] = float(run.growth_rate)
        result[f"ratio_{case}"] = float(run.drive_frequency) / paper.PENDULUM.natural_frequency
    edge, undamped = (float(value) for value in dataset.tongue_edge)
    below, above = (float(value) for value in dataset.rate_beside_edge)
    return result | {
        "scale_ratio": result["largest_resonant"] / result["largest_quiet"],
        "gain": result["largest_resonant"] / result["largest_twice"],
        "edge": edge,
        "edge_undamped": undamped,
        "edge_above_quiet": edge - result["ratio_quiet"],
        "edge_below_resonant": result["ratio_resonant"] - edge,
        "rate_below": below,
        "rate_above": above,
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) and (b)."""
    figure, axes = style.new_figure(2, 1, sharex=True, height=3.8)
    (a,), (b,) = axes
    time = dataset.time.values
    angle = dataset.angle
    resonant, quiet = angle.sel(case=RESONANT), angle.sel(case=QUIET)
    a.plot(time, resonant, color=style.BLUE, lw=style.THIN)
    when, sizes = measure.peaks(
        time, resonant.values, dataset.angular_velocity.sel(case=RESONANT).values
    )
    top = int(np.argmax(sizes))
    a.plot(when[top], sizes[top], "o", ms=2.6, color=style.RED, clip_on=False)
    style.note(a, f"{sizes[top]:.3f} rad", (when[top], sizes[top]), (5, 3))
    style.degree_axis(a, spacing=45)
    a.set_ylabel(style.label(angle, short=True))
    b.plot(time, 1e3 * quiet, color=style.GREEN, lw=style.THIN)
    b.set_ylabel(style.label(angle, short=True, unit="mrad"))
    for panel, letter, case in ((a, "a", RESONANT), (b, "b", QUIET)):
        frequency = float(dataset.drive_frequency.sel(case=case))
        ratio = frequency / paper.PENDULUM.natural_frequency
        style.panel_title(
            panel, letter, rf"$\omega$ = {frequency:g} rad/s, $\omega/\omega_0$ = {ratio:.4f}"
        )
        panel.set_xlim(0.0, DURATION)
    b.set_xlabel(style.label(dataset.time))
    return figure
