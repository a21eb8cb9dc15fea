"""What bounds the region of Fig. 5 in which the pair leaves its rest for wide swings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from latolato.core.quantities import QUANTITIES
from latolato.figures import style
from latolato.paper import fig05, grids
from latolato.paper import systems as paper
from latolato.paper.cases import Floats
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The edges of Fig. 5 as curves"
CAPTION = (
    "(a) Blue: runs of the undamped pair from rest that pass 2 rad within 300 s, and within 3000 s "
    "in the framed part. Dashed: lift-off from rest, A0 ω² = g. Orange and red: where two motions "
    "of ten and fourteen shakes lose their stability by period doubling. Circles: above these "
    "amplitudes all runs of 3000 s pass 2 rad. (b), (c) The pair once a shake, at the top of the "
    "pivot, below and above the edge at four natural frequencies: one run from rest (blue), others "
    "that start at rest above the wall (grey) and far above it (orange)."
)
FINDING = (
    "Two edges bound Fig. 5 from rest, and no motion of one shake ends at either. On the left it "
    "is lift-off itself. On the right the pair has left the wall, but invariant curves enclose it: "
    "the impacts on a wall that shakes cannot lift it beyond the last of them, however long it "
    "runs. The edge is where this last curve breaks, and motions near it show where: a motion with "
    "{few:.0f} impacts in {shakes:.0f} shakes (11 in 14 below {change:.1f} natural frequencies) "
    "doubles its period within {apart:.0f} % of the edge at all {compared:.0f} frequencies "
    "compared, {usual:.1f} % on average. That the map is ragged there is no want of accuracy: just "
    "above the edge the pair finds the gap in the broken curve late, and after 300 s the edge lies "
    "up to {late:.0f} % higher than after 3000 s. Below the edge, long runs show islands in which "
    "the curves are open as well: at {fast:g} natural frequencies the pair comes out from "
    "{island:.3f} m on, at {most:.3f} m it does not."
)
CHECK = (
    "To the left of {left:.1f} natural frequencies {between:.2f} % of all runs pass 2 rad if A0 ω² "
    "exceeds g and do not if it does not. The curves are closed from outside as well: seen once a "
    "shake, {sea:.0f} times, the motions of (b) that start far above the wall are never within "
    "{near:g} rad of it and slower than {slow:g} rad/s; those of (c) are {visits:.0f} times, and "
    "the run from rest comes out. Both motions were found "
    "by Greene's (1979) symmetry: released at rest at the top of the pivot, they are at rest or on "
    "the wall half a period later."
)
POINTS, QUICK_POINTS = 200, 60  # of the map, along each axis
LONG = 3000.0  # s
# Of the long runs: natural frequencies, and amplitudes [m].
RATIOS, QUICK_RATIOS = np.linspace(2.75, 5.0, 46), np.array([3.96, 4.0, 4.04, 5.0])
EDGE, QUICK_EDGE = np.linspace(0.15, 0.34, 191), np.linspace(0.22, 0.34, 61)
# The motions: shakes, amplitude [m] and frequency ratio near the doubling, and the start there
# [rad]; then the frequency ratios between which the curve is computed.
MOTIONS = ((10, 0.267, 4.0, 0.27666, 3.3, 5.1), (14, 0.206, 3.0, 0.3035, 2.7, 3.3))
QUICK_MOTIONS = ((*MOTIONS[0][:4], 3.95, 4.05),)
# Of the sections: amplitudes [m] on either side of the edge, shakes, and starts above the wall
# [rad], the first at rest on it, the last ones outside all invariant curves.
SECTIONS = (0.24, 0.31)
SECTION_RATIO = 4.0
SECTION_SHAKES = 600
STARTS, OUTSIDE = (0.0, 0.06, 0.1, 0.14, 0.18, 0.22, 0.26, 0.3), (1.0, 1.4, 1.8)
# Nearer to the wall than this [rad] and slower than this [rad/s]: inside all curves of (b).
NEAR, SLOW = 0.25, 2.0
_LEFT = 2.3  # natural frequencies, up to where lift-off is the edge
_AMPLITUDE = QUANTITIES["drive_amplitude"].attributes
_RATIO = QUANTITIES["frequency_ratio"].attributes
_PLAIN = {"units": "1", "symbol": ""}
_IMPACTS = _PLAIN | {"long_name": "impacts in a period of the motion"}
_SHAKES = _PLAIN | {"long_name": "shakes in a period of the motion"}
_REACHES = _PLAIN | {"long_name": "whether a run passes 2 rad"}
TOY = fig05.TOY


def data(quick: bool = False) -> xr.Dataset:
    """Return the map from rest, its edge after long runs, two curves, and two sections."""
    import xarray as xr

    from latolato import analysis, sweep

    def reaches(axes: dict[str, Floats], duration: float) -> xr.DataArray:
        runs = sweep(
            TOY, axes=axes, duration=duration, initial_offset=0.0,
            observables=grids.PAIR_OBSERVABLES,
        )  # fmt: skip
        passages: xr.DataArray = runs.crossings
        return passages > 0.0

    count = QUICK_POINTS if quick else POINTS
    axes = grids.paper_axes(TOY.length, count)
    edge, ratios = (QUICK_EDGE, QUICK_RATIOS) if quick else (EDGE, RATIOS)
    long = {"drive_amplitude": edge, "frequency_ratio": ratios}
    doublings = curves(QUICK_MOTIONS if quick else MOTIONS)
    sections = [
        [
            analysis.poincare_section(
                TOY, grids.shake(TOY, SECTION_RATIO, amplitude), initial_offset=offset,
                periods=SECTION_SHAKES, transient_periods=0.0,
            )
            for offset in (*STARTS, *OUTSIDE)
        ]
        for amplitude in SECTIONS
    ]  # fmt: skip
    plane = ("drive_amplitude", "frequency_ratio")
    visits = ("section", "start", "shake")
    variables = {
        "reaches": (plane, _plane(reaches(axes, paper.SWEEP_DURATION)), _REACHES),
        "reaches_late": (
            ("edge_amplitude", "edge_ratio"), _plane(reaches(long, LONG)), _REACHES,
        ),
        "reaches_soon": (
            ("edge_amplitude", "edge_ratio"), _plane(reaches(long, paper.SWEEP_DURATION)), _REACHES,
        ),
        "curve_amplitude": (
            ("motion", "point"), grids.padded(doublings, "drive_amplitude"), _AMPLITUDE,
        ),
        "curve_ratio": (("motion", "point"), grids.padded(doublings, "frequency_ratio"), _RATIO),
        "impacts": ("motion", [float(curve.impacts[0]) for curve in doublings], _IMPACTS),
        "shakes": ("motion", [float(curve.attrs["period"]) for curve in doublings], _SHAKES),
        **{
            name: (visits, np.array([[run[name].values for run in row] for row in sections]),
                   QUANTITIES[name].attributes)
            for name in ("angle", "angular_velocity")
        },
    }  # fmt: skip
    return xr.Dataset(
        variables,
        coords={
            "drive_amplitude": ("drive_amplitude", axes["drive_amplitude"], _AMPLITUDE),
            "frequency_ratio": ("frequency_ratio", axes["frequency_ratio"], _RATIO),
            "edge_amplitude": ("edge_amplitude", edge, _AMPLITUDE),
            "edge_ratio": ("edge_ratio", ratios, _RATIO),
        },
        attrs={"title": TITLE},
    )


def curves(motions: Sequence[Sequence[float]] = MOTIONS) -> list[xr.Dataset]:
    """Return the curves on which motions of many shakes double their period."""
    from latolato import analysis

    return [
        analysis.bifurcation_curve(
            TOY, grids.shake(TOY, ratio, amplitude), kind="period_doubling", initial_angle=start,
            period=int(shakes), low=(0.1, slow), high=(0.4, fast), points=100,
        )
        for shakes, amplitude, ratio, start, slow, fast in motions
    ]  # fmt: skip


def _plane(runs: xr.DataArray) -> Floats:
    return np.asarray(runs.values, dtype=float).reshape(runs.shape[-2:])


def _edge_of(amplitudes: Floats, reaches: Floats) -> Floats:
    """Return for each column the amplitude above which all runs reach."""
    last = len(amplitudes) - 1 - np.argmin(reaches[::-1], axis=0)
    return np.asarray(0.5 * (amplitudes[last] + amplitudes[last + 1]))


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return how far the edges are from lift-off, from the curves, and from those of short runs."""
    amplitudes, ratios = dataset.edge_amplitude.values, dataset.edge_ratio.values
    late = _edge_of(amplitudes, dataset.reaches_late.values)
    soon = _edge_of(amplitudes, dataset.reaches_soon.values)
    rows = []
    for ratio, amplitude in zip(
        dataset.curve_ratio.values, dataset.curve_amplitude.values, strict=True
    ):
        known = np.isfinite(ratio)
        order = np.argsort(ratio[known])
        rows.append(
            np.interp(
                ratios, ratio[known][order], amplitude[known][order], left=np.nan, right=np.nan
            )
        )
    # Of the motions that were followed to a frequency, the one that lasts longest.
    curve = np.fmax.reduce(rows)
    apart = np.abs(curve / late - 1.0)[np.isfinite(curve)]
    lift = grids.acceleration_ratio(dataset)
    left = np.broadcast_to(dataset.frequency_ratio.values < _LEFT, lift.shape)
    same = (lift > 1.0) == (dataset.reaches.values > 0.0)
    angle = dataset.angle.values - TOY.contact_angle_low
    close = (angle < NEAR) & (np.abs(dataset.angular_velocity.values) < SLOW)
    outside = close[:, len(STARTS) :]
    return {
        "few": float(dataset.impacts[0]),
        "shakes": float(dataset.shakes[0]),
        "change": MOTIONS[0][4],
        "apart": 100.0 * float(apart.max()),
        "compared": float(apart.size),
        "usual": 100.0 * float(apart.mean()),
        "late": 100.0 * float(np.max(soon / late - 1.0)),
        "fast": float(ratios[-1]),
        "island": float(amplitudes[np.argmax(dataset.reaches_late.values[:, -1])]),
        "most": float(late[-1] - 0.5 * (amplitudes[1] - amplitudes[0])),
        "between": 100.0 * float(same[left].mean()),
        "left": _LEFT,
        "near": NEAR,
        "slow": SLOW,
        "low": SECTIONS[0],
        "high": SECTIONS[1],
        "sea": float(outside[0].size),
        "visits_below": float(outside[0].sum()),
        "visits": float(outside[1].sum()),
        "enclosed": float(angle[0, 0].max()),
        "freed": float(angle[1, 0].max()),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a), (b) and (c)."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Rectangle

    figure, axes = style.new_figure(1, 3, height=3.2)
    a, *sections = axes[0]
    shades = ListedColormap([style.PAPER, style.SKY])
    a.pcolormesh(
        dataset.frequency_ratio, dataset.drive_amplitude, dataset.reaches, shading="nearest",
        rasterized=True, cmap=shades,
    )  # fmt: skip
    extent = (
        dataset.edge_ratio.values.min(), dataset.edge_ratio.values.max(),
        dataset.edge_amplitude.values.min(), dataset.edge_amplitude.values.max(),
    )  # fmt: skip
    a.imshow(
        dataset.reaches_late, origin="lower", aspect="auto", extent=extent, cmap=shades,
        vmin=0.0, vmax=1.0, interpolation="nearest", zorder=1.2,
    )  # fmt: skip
    a.add_patch(
        Rectangle(extent[::2], extent[1] - extent[0], extent[3] - extent[2], fill=False,
                  ec=style.GREY, lw=0.6)
    )  # fmt: skip
    slowest = (TOY.length / paper.LARGEST_AMPLITUDE_RATIO) ** 0.5
    ratios = np.linspace(slowest, paper.LARGEST_FREQUENCY_RATIO, 200)
    handles = a.plot(ratios, TOY.length / ratios**2, color=style.INK, ls=(0, (4, 2)), lw=1.0,
                     label="lift-off from rest")  # fmt: skip
    for i, colour in zip(range(dataset.sizes["motion"]), (style.ORANGE, style.RED), strict=False):
        text = f"{dataset.impacts[i]:.0f} impacts in {dataset.shakes[i]:.0f} shakes"
        handles += a.plot(
            dataset.curve_ratio[i], dataset.curve_amplitude[i], color=colour, lw=1.6, label=text
        )
    edge = _edge_of(dataset.edge_amplitude.values, dataset.reaches_late.values)
    some = slice(None, None, max(1, len(edge) // 9))
    handles += a.plot(dataset.edge_ratio[some], edge[some], "o", ms=3.5, mfc="none",
                      color=style.INK, label="edge after 3000 s")  # fmt: skip
    a.set_xlim(0.0, paper.LARGEST_FREQUENCY_RATIO)
    a.set_ylim(0.0, paper.LARGEST_AMPLITUDE_RATIO * TOY.length)
    a.set_xlabel(style.label(dataset.frequency_ratio, short=True))
    a.set_ylabel(style.label(dataset.drive_amplitude))
    style.panel_title(a, "a", "runs that pass 2 rad")
    for i, panel in enumerate(sections):
        angle, speed = (dataset[each].values[i] for each in ("angle", "angular_velocity"))
        for runs, colour, size in (
            (slice(len(STARTS), None), style.ORANGE, 0.4),
            (slice(1, len(STARTS)), style.GREY, 0.6),
            (slice(0, 1), style.BLUE, 0.8),
        ):
            panel.plot(angle[runs].ravel(), speed[runs].ravel(), ".", ms=size, color=colour,
                       rasterized=True)  # fmt: skip
        panel.set_xlim(0.0, 1.2)
        panel.set_ylim(-6.0, 6.0)
        panel.set_xlabel("angle [rad]")
        style.panel_title(panel, "bc"[i], rf"$A_0$ = {SECTIONS[i]:g} m")
    sections[0].set_ylabel("angular velocity [rad/s]")
    figure.legend(handles=handles, loc="outside lower left", ncols=2)
    return figure
