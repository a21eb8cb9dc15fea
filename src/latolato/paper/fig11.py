"""Fig. 11, its theoretical part: the pair's largest angle against frequency, and its hysteresis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato import Harmonic
from latolato.figures import style
from latolato.paper import grids
from latolato.paper import systems as paper
from latolato.paper.cases import Floats
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The response of the colliding pair against frequency"
AMPLITUDES = (0.015, 0.020, 0.025, 0.030)  # m, assumed: four sets, none printed
START = 0.15  # rad above the low contact angle, assumed
STARTS = (0.1, 0.2, 0.3)  # rad
MIDDLE = 0.025  # m, the set that is started otherwise and followed
RATIOS = (1.2, 3.6)
POINTS, QUICK_POINTS = 241, 121
DURATION, TRANSIENT = 90.0, 60.0  # s
CAPTION = (
    "Largest angle after 60 s of the coupled experiment's pair against the driving frequency; "
    "shaded: the paper's range of peaks. (a) Four driving amplitudes, each run started at rest "
    f"{START:g} rad above the wall. (b) A0 = {1e3 * MIDDLE:g} mm: other starts, and one motion "
    "followed as the frequency rises and falls step by step."
)
LATE = "largest_angle_after_transient"


def data(quick: bool = False) -> xr.Dataset:
    """Return the late largest angles over frequency for amplitudes, starts and both ways."""
    from latolato import sweep

    ratios = np.linspace(*RATIOS, QUICK_POINTS if quick else POINTS)
    middle = Harmonic(drive_amplitude=MIDDLE, drive_frequency=paper.COUPLED.natural_frequency)

    def run(
        axes: dict[str, Any],
        drive: Harmonic | None = None,
        offset: float | None = None,
        follow: str | None = None,
    ) -> xr.Dataset:
        return sweep(
            paper.COUPLED,
            drive,
            axes={**axes, "frequency_ratio": ratios},
            duration=DURATION,
            transient=TRANSIENT,
            observables=grids.PAIR_OBSERVABLES,
            initial_offset=offset,
            continuation=follow,
            direction="both" if follow else "up",
        )

    amplitudes = run({"drive_amplitude": AMPLITUDES}, offset=START)
    starts = run({"initial_offset": STARTS}, middle)
    followed = run({}, middle, START, "frequency_ratio")
    return grids.gather(
        {"amplitudes": amplitudes},
        title=TITLE,
        keep=(LATE,),
        apart={"starts": starts, "followed": followed},
    )


def _flanks(ratio: Floats, angle: Floats) -> tuple[float, float, float, float]:
    """Return peak ratio and angle, and how far on its left and right half its height is left."""
    rest = paper.COUPLED.contact_angle_low
    top = int(np.argmax(angle))
    small = angle < rest + 0.5 * (angle[top] - rest)
    left = ratio[top] - ratio[:top][small[:top]].max(initial=-math.inf)
    right = ratio[top:][small[top:]].min(initial=math.inf) - ratio[top]
    return float(ratio[top]), float(angle[top]), float(left), float(right)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 11's statements need."""
    ratio = dataset.frequency_ratio.values
    rows = [_flanks(ratio, row) for row in dataset[LATE].values[0]]
    peaks, heights, lefts, rights = np.transpose(rows)
    starts = np.array([_flanks(ratio, row)[0] for row in dataset[f"starts_{LATE}"].values])
    up, down = (
        np.degrees(dataset[f"followed_{LATE}"].sel(followed_direction=way).values)
        for way in ("up", "down")
    )
    first, last = paper.PEAK_RATIOS
    inside = (ratio >= first - 1e-9) & (ratio <= last + 1e-9)
    end = int(np.argmax(down))
    return {
        **{f"peak_{i}": float(peak) for i, peak in enumerate(peaks)},
        **{f"height_{i}": math.degrees(height) for i, height in enumerate(heights)},
        "first_peak": float(peaks.min()),
        "last_peak": float(peaks.max()),
        "flanks": float((rights / lefts).min()),
        "left_half": float(lefts.max()),
        "right_half": float(rights.min()),
        "largest_shift": float(np.diff(peaks).max()),
        "whole_shift": float(peaks[-1] - peaks[0]),
        "lowest_start": float(starts.min()),
        "highest_start": float(starts.max()),
        "start_spread": float(np.ptp(starts)),
        "hysteresis": float((down - up)[inside].max()),
        "down_end": float(ratio[end]),
        "down_height": float(down[end]),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) and (b)."""
    import matplotlib as mpl

    figure, axes = style.new_figure(1, 2, sharex=True, height=3.1)
    a, b = axes[0]
    ratio = dataset.frequency_ratio.values
    shades = mpl.colormaps["viridis"]
    look = {"marker": "o", "ms": 1.8, "lw": 0.9}
    amplitudes = dataset.drive_amplitude.values
    for i, (amplitude, row) in enumerate(zip(amplitudes, dataset[LATE].values[0], strict=True)):
        colour = shades(0.85 * (1.0 - i / (len(amplitudes) - 1)))
        name = rf"$A_0$ = {1e3 * amplitude:g} mm"
        a.plot(ratio, np.degrees(row), color=colour, label=name, **look)
    offsets = dataset.starts_initial_offset.values
    for i, (offset, row) in enumerate(zip(offsets, dataset[f"starts_{LATE}"].values, strict=True)):
        colour = shades(0.85 * (1.0 - i / (len(offsets) - 1)))
        b.plot(ratio, np.degrees(row), color=colour, label=f"start {offset:g} rad up", **look)
    for way, word, ink in (("up", "rising", style.ORANGE), ("down", "falling", style.RED)):
        row = np.degrees(dataset[f"followed_{LATE}"].sel(followed_direction=way).values)
        b.plot(ratio, row, color=ink, lw=1.4, label=f"frequency {word}", zorder=1.5)
    for panel, letter, title in (
        (a, "a", f"start {START:g} rad above the wall"),
        (b, "b", f"$A_0$ = {1e3 * MIDDLE:g} mm"),
    ):
        panel.axvspan(*paper.PEAK_RATIOS, color=style.ORANGE, alpha=0.22, lw=0, zorder=0)
        panel.set_xlim(*RATIOS)
        panel.set_ylim(0.0, None)
        panel.set_xlabel(style.label(dataset.frequency_ratio))
        panel.legend(loc="upper right")
        style.panel_title(panel, letter, title)
    a.set_ylabel("largest angle after 60 s [degrees]")
    return figure
