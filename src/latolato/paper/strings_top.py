"""The least drive that carries the toy to the top, on strings and on rods."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import cells, style
from latolato.paper import grids
from latolato.paper.claim import Numbers
from latolato.paper.string_toys import (
    COLOURS,
    CORD_TOY,
    ELASTIC,
    INELASTIC,
    RODS,
    label_of,
    on_each,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from latolato.paper.cases import Floats

TITLE = "The least drive that carries the toy to the top"
DURATION = 60.0  # s
STARTS = {"rest": 0.0, "push": 0.5}  # rad above the contact angle
AMPLITUDES, QUICK_AMPLITUDES = np.linspace(0.025, 1.0, 40), np.linspace(0.1, 1.0, 10)
FREQUENCIES, QUICK_FREQUENCIES = np.linspace(0.6, 6.0, 37), np.linspace(1.0, 6.0, 11)
CAPTION = (
    f"A toy with l = {CORD_TOY.length:g} m, r = {CORD_TOY.radius:g} m, e = "
    f"{CORD_TOY.restitution:g} and C/(ml) = 0.16 1/s. (a), (b) The least amplitude on the grid at "
    f"which the balls hit each other above the pivot within {DURATION:g} s, from rest and from "
    f"{STARTS['push']:g} rad above the contact angle; dashed: lift-off from rest, A0 ω² = g. (c) "
    "Share of the time in which a rod is pushed, with a push; white: never."
)
FINDING = (
    "From rest at ω = 4 ω0 the toy reaches the top if A0 is at least {rest_rods:.3f} l on rods, "
    "{rest_inelastic:.3f} l on strings with e_s = 0 and {rest_elastic:.3f} l on strings with "
    "e_s = 0.9 (with a push {push_rods:.3f}, {push_inelastic:.3f} and {push_elastic:.3f} l). "
    "Strings do not always need less: at 3 ω0 it takes {rest3_rods:.3f} l on rods and "
    "{rest3_inelastic:.3f} l with e_s = 0. Rods are pushed for some of the time at "
    "{pushed_push:.0%} of the points of this map with a push and at {pushed_rest:.0%} from rest. "
    "These shares depend on the range: up to A0 = {small:g} l they are {small_push:.0%} and "
    "{small_rest:.0%}. A MATLAB toolkit, whose runs end at 90°, gives up to 51 % for this toy over "
    "a range that we do not know; of our points that stay below 90°, rods are pushed at "
    "{quiet_push:.0%} and {quiet_rest:.0%}."
)
CHECK = (
    "At all {unpushed:.0f} points where no rod is pushed, both kinds of strings reach the same "
    "largest angle as rods, to {same:.0e} rad. Below the onset no toy reaches the top from rest "
    "({early:.0f} points do). Rods are pushed for more than 1 % of the time at {long_push:.0%} of "
    "the points with a push and at {long_rest:.0%} from rest."
)
SMALL = 0.2  # A0/l, up to which shares of pushed rods are given too
LONG = 0.01  # of the time
_PUSHED = "compression_fraction"
KEPT = ("top_contacts", "largest_angle", _PUSHED)


def data(quick: bool = False) -> xr.Dataset:
    """Return maps of contacts above the pivot for each suspension and start."""
    from latolato import sweep

    maps: dict[str, xr.Dataset] = {}
    for start, offset in STARTS.items():
        for name, toy in on_each(CORD_TOY).items():
            grid = sweep(
                toy,
                axes={
                    "amplitude_ratio": QUICK_AMPLITUDES if quick else AMPLITUDES,
                    "frequency_ratio": QUICK_FREQUENCIES if quick else FREQUENCIES,
                },
                duration=DURATION,
                initial_offset=offset,
                observables=("top_contacts", "largest_angle", *([_PUSHED] if name == RODS else [])),
            )
            if name != RODS:  # a string is never pushed
                grid[_PUSHED] = 0.0 * maps[f"{start}, {RODS}"][_PUSHED]
            maps[f"{start}, {name}"] = grid
    return grids.gather(maps, title=TITLE, keep=KEPT)


def least(dataset: xr.Dataset, start: str, name: str) -> Floats:
    """Return the least amplitude over the length that reaches the top at each frequency, or NaN."""
    reaches = dataset.top_contacts.sel(case=f"{start}, {name}").values > 0.0
    amplitude = dataset.amplitude_ratio.values[np.argmax(reaches, axis=0)]
    return np.where(reaches.any(axis=0), amplitude, np.nan)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return least amplitudes at 4 and 3 times the natural frequency, and shares of pushed rods."""
    words = {"rods": RODS, "inelastic": INELASTIC, "elastic": ELASTIC}
    result = {"small": SMALL, "unpushed": 0.0, "same": 0.0}
    for ratio, suffix in ((4.0, ""), (3.0, "3")):
        at = int(np.argmin(np.abs(dataset.frequency_ratio.values - ratio)))
        result |= {
            f"{start}{suffix}_{word}": float(least(dataset, start, name)[at])
            for start in STARTS
            for word, name in words.items()
        }
    strength = dataset.amplitude_ratio.values[:, None] * dataset.frequency_ratio.values**2
    tops = [dataset.top_contacts.sel(case=f"rest, {name}").values for name in COLOURS]
    result["early"] = float(sum((top[strength < 1.0] > 0.0).sum() for top in tops))
    for start in STARTS:
        rods = dataset.sel(case=f"{start}, {RODS}")
        pushed, is_low = rods[_PUSHED].values > 0.0, rods.largest_angle.values < 0.5 * np.pi
        # Rounding aside: amplitudes are sums.
        is_small = dataset.amplitude_ratio.values < SMALL + 1e-9
        result[f"pushed_{start}"] = float(pushed.mean())
        result[f"long_{start}"] = float((rods[_PUSHED].values > LONG).mean())
        result[f"small_{start}"] = float(pushed[is_small].mean())
        result[f"quiet_{start}"] = float(pushed[is_low].mean())
        result["unpushed"] += float((~pushed).sum())
        for name in (INELASTIC, ELASTIC):
            strings = dataset.sel(case=f"{start}, {name}")
            apart = np.abs(strings.largest_angle.values - rods.largest_angle.values)
            result["same"] = max(result["same"], float(apart[~pushed].max()))
    return result


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (c)."""
    figure, axes = style.new_figure(1, 3, sharex=True, sharey=True, height=2.9)
    ratio = dataset.frequency_ratio.values
    for panel, letter, start in zip(axes[0], "ab", STARTS, strict=False):
        for name, colour in COLOURS.items():
            panel.plot(
                ratio, least(dataset, start, name), color=colour, marker=".", ms=3.0,
                label=label_of(name),
            )  # fmt: skip
        style.panel_title(panel, letter, "from rest" if start == "rest" else "with a push")
    rods = dataset[_PUSHED].sel(case=f"push, {RODS}")
    mesh = cells.draw_cells(axes[0, 2], rods, norm=None, cmap="viridis")
    style.panel_title(axes[0, 2], "c", "rods that are pushed")
    style.colour_bar(mesh, "share of the time", ax=axes[0, 2])
    for panel in axes[0]:
        _draw_onset(panel, ratio)
        panel.set_xlabel(style.label(dataset.frequency_ratio, short=True))
        panel.set_xlim(0.0, float(ratio[-1]))
        panel.set_ylim(0.0, float(dataset.amplitude_ratio[-1]))
    axes[0, 0].set_ylabel(style.label(dataset.amplitude_ratio, short=True))
    handles, texts = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside lower center", ncols=3)
    return figure


def _draw_onset(panel: Axes, ratio: Floats) -> None:
    """Draw where the pivot falls as fast as gravity."""
    fine = np.linspace(ratio[0], ratio[-1], 200)
    panel.plot(fine, fine**-2.0, color=style.INK, lw=style.THIN, ls=(0, (4, 3)))
