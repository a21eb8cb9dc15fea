"""Fig. 11, its theoretical part: the pair's largest angle against frequency, and its hysteresis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.figures import grids, paper, style
from latolato.figures.cases import Floats
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.physics.drives import Harmonic

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The response of the colliding pair against frequency"
BAND = (2.2, 2.6)  # w/w0, shaded in the paper
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
ASSUMED = (
    f"A0 = 15 to 30 mm, r/l = {paper.COUPLED.radius / paper.COUPLED.length:g}, e = "
    f"{paper.COUPLED.restitution:g} and a start {START:g} rad above the wall, none of them printed."
)
LATE = "largest_angle_after_transient"

STATEMENTS = (
    Statement(
        name="response-peaks",
        where="Fig. 11",
        words="each curve exhibits a peak occurring at frequency ratios between 2.2 and 2.6",
        assumed=(
            Limit("first_peak", "lowest ω/ω0 of the four peaks", low=BAND[0]),
            Limit("last_peak", "highest ω/ω0 of the four peaks", high=BAND[1]),
        ),
        assumption=ASSUMED,
        finding=(
            "The response curves of Fig. 11 peak at ω/ω0 = {peak_0:.2f}, {peak_1:.2f}, "
            "{peak_2:.2f} and {peak_3:.2f}, with {height_0:.0f}, {height_1:.0f}, {height_2:.0f} "
            "and {height_3:.0f} degrees, for A0 = 15, 20, 25 and 30 mm."
        ),
        why=(
            "They are where the start still reaches the large motion; with starts of 0.1 to 0.3 "
            "rad the peak at 25 mm lies anywhere from {lowest_start:.2f} to {highest_start:.2f}."
        ),
    ),
    Statement(
        name="response-flanks",
        where="text on Fig. 11",
        words=(
            "The left side of each peak appears steeper than the right side, and with increasing "
            "driving amplitude, these peaks gradually shift leftward"
        ),
        assumed=(
            Limit("flanks", "half width on the right over that on the left, smallest", low=3.0),
            Limit("largest_shift", "shift of ω/ω0 from one A0 to the next, largest", high=-0.01),
        ),
        assumption=ASSUMED,
        finding=(
            "Left of the peaks of Fig. 11 the angle falls to half its height within "
            "{left_half:.3f} in ω/ω0, right of them within {right_half:.2f} or more; from A0 = 15 "
            "to 30 mm the peak moves by {whole_shift:+.2f}."
        ),
        why=(
            "A pendulum that softens has a branch of large motion that rises towards low "
            "frequencies; left of the peak the start falls off it, back to rest on the wall."
        ),
    ),
    Statement(
        name="flank-is-boundary",
        where="text on Fig. 11",
        words=(
            "These phenomena precisely correspond to the left and right boundaries observed in "
            "numerical calculations (Fig. 5), thereby confirming the theoretical results"
        ),
        printed=(
            Limit(
                "start_spread",
                "spread of the peak in ω/ω0 over starts of 0.1 to 0.3 rad",
                high=0.05,
            ),
            Limit("hysteresis", "difference of falling and rising frequency in the band", high=5.0),
        ),
        finding=(
            "The left flank of Fig. 11 at A0 = 25 mm moves by {start_spread:.2f} in ω/ω0 with the "
            "start; followed downwards in frequency the same motion lasts to ω/ω0 = "
            "{down_end:.2f} and {down_height:.0f} degrees, and in the band it is up to "
            "{hysteresis:.0f} degrees larger than on the way up."
        ),
        why=(
            "The left flank is the end of a start's basin, not an edge of the parameters: this is "
            "hysteresis. The experiment would show it by changing the frequency during a run, as "
            "Fig. 12 does."
        ),
    ),
)


def data(quick: bool = False) -> xr.Dataset:
    """Return the late largest angles over frequency for amplitudes, starts and both ways."""
    from latolato.sweeps import sweep

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
    inside = (ratio >= BAND[0] - 1e-9) & (ratio <= BAND[1] + 1e-9)
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
        panel.axvspan(*BAND, color=style.ORANGE, alpha=0.22, lw=0, zorder=0)
        panel.set_xlim(*RATIOS)
        panel.set_ylim(0.0, None)
        panel.set_xlabel(style.label(dataset.frequency_ratio))
        panel.legend(loc="upper right")
        style.panel_title(panel, letter, title)
    a.set_ylabel("largest angle after 60 s [degrees]")
    return figure
