"""Fig. 2: the amplitude of a driven pendulum grows, beats and saturates; eq14 is its beginning."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import style
from latolato.paper import measure
from latolato.paper import systems as paper
from latolato.paper.cases import Floats, Residuals, instants, quantity, stack
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "Growth, beats and saturation of the amplitude"
CAPTION = (
    "Angle of a pendulum on an oscillating pivot, driven near twice its natural frequency. (a) "
    "Equation 10 until its beats have died out; dots mark the beats' maxima. (b) Its first 40 s, "
    "the shaded part of (a). (c) The small-angle equation 14 over the same time. The grey lines "
    "in (b) and (c) are at 5 degrees."
)
DURATION = 400.0  # s, long enough for the beats to fall below 1 %
LASTING = 1000.0  # s, long enough for them to vanish
LATE = 40.0  # s, the last stretch, of which the turning points are averaged
EARLY = 40.0  # s, the paper's panels (b) and (c)
FIVE_DEGREES = np.deg2rad(5.0)
FULL, LINEAR = "eq10", "eq14"


def data(quick: bool = False) -> xr.Dataset:
    """Return the angles of eq10 and eq14 over 400 s."""
    from latolato import simulate

    times = instants(DURATION, paper.DRIVE.drive_frequency)
    systems = {FULL: paper.PENDULUM, LINEAR: paper.LINEAR}
    runs = {
        label: simulate(system, paper.DRIVE, initial_angle=paper.SMALL_ANGLE, times=times)
        for label, system in systems.items()
    }
    residuals = Residuals()
    longer = residuals.of(
        simulate(
            paper.PENDULUM,
            paper.DRIVE,
            initial_angle=paper.SMALL_ANGLE,
            times=instants(LASTING, paper.DRIVE.drive_frequency),
        )
    )
    return (
        stack(runs, title=TITLE, keep=("angle", "angular_velocity"))
        .assign(
            lasting_amplitude=quantity(
                "largest_angle",
                (),
                _late(*_peaks(longer), LASTING).mean(),
                long_name="largest angle of each swing after 1000 s",
            )
        )
        .assign(residuals.variables())
    )


def _peaks(run: xr.Dataset) -> tuple[Floats, Floats]:
    """Return times [s] and sizes [rad] of the turning points of one run."""
    return measure.peaks(run.time.values, run.angle.values, run.angular_velocity.values)


def _late(when: Floats, sizes: Floats, end: float) -> Floats:
    """Return the turning points in the last stretch before `end` [rad]."""
    return sizes[when > end - LATE]


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 2's statements need."""
    time = dataset.time.values
    full, linear = (dataset.angle.sel(case=case).values for case in (FULL, LINEAR))
    early = time <= EARLY
    so_far = np.maximum.accumulate(np.abs(full[early]))
    when, sizes = _peaks(dataset.sel(case=FULL))
    beat_sizes = measure.beats(when, sizes)[1]
    late = _late(when, sizes, DURATION)
    top = int(np.argmax(sizes))
    return {
        "difference": float(np.max(np.abs(linear[early] - full[early]) / so_far)),
        "five_degrees": measure.first_above(time, np.abs(full), FIVE_DEGREES),
        "sine_error": float(1.0 - np.sin(FIVE_DEGREES) / FIVE_DEGREES),
        "beats": float(np.sum(beat_sizes > measure.VISIBLE_BEAT * late.mean())),
        "largest": float(sizes[top]),
        "largest_time": float(when[top]),
        "settled": float(late.mean()),
        "lasting": float(dataset.lasting_amplitude),
        "last_spread": float(np.ptp(late) / late.mean()),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (c)."""
    figure, panels = style.new_mosaic([["a", "a"], ["b", "c"]], height=4.2)
    time = dataset.time.values
    early = time <= EARLY
    full = dataset.angle.sel(case=FULL)
    linear = dataset.angle.sel(case=LINEAR)

    a = panels["a"]
    a.axvspan(0.0, EARLY, color=style.PALE_BLUE, lw=0)
    a.plot(time, full, color=style.BLUE, lw=style.THIN)
    when, sizes = _peaks(dataset.sel(case=FULL))
    beat_times, beat_sizes = measure.beats(when, sizes)
    visible = beat_sizes > measure.VISIBLE_BEAT * sizes[-1]
    a.plot(beat_times[visible], beat_sizes[visible], "o", ms=2.6, color=style.RED, clip_on=False)
    settled = _late(when, sizes, DURATION).mean()
    style.note(a, f"{sizes.max():.4f} rad", (when[np.argmax(sizes)], sizes.max()), (5, 2))
    style.note(a, f"{settled:.4f} rad", (time[-1], settled), (-2, 4), ha="right", va="bottom")
    style.degree_axis(a, spacing=30)
    a.set_xlim(0.0, DURATION)
    for name, angle, colour in (("b", full, style.BLUE), ("c", linear, style.GREEN)):
        axes = panels[name]
        for level in (-FIVE_DEGREES, FIVE_DEGREES):
            axes.axhline(level, color=style.GREY, lw=style.THIN)
        axes.plot(time[early], angle[early], color=colour, lw=0.8)
        axes.set_xlim(0.0, EARLY)
    panels["c"].sharey(panels["b"])
    panels["c"].tick_params(labelleft=False)
    for name, title in (
        ("a", "equation 10"),
        ("b", "equation 10, the first 40 s"),
        ("c", "equation 14, small angles"),
    ):
        style.panel_title(panels[name], name, title)
        panels[name].set_xlabel(style.label(dataset.time))
    for name in ("a", "b"):
        panels[name].set_ylabel(style.label(full, short=True))
    return figure
