"""Why the region of Fig. 9 is steep on the left and gentle on the right."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from latolato.core.quantities import QUANTITIES
from latolato.figures import style
from latolato.paper import fig09, grids
from latolato.paper import systems as paper
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The edges of Fig. 9 as curves"
CAPTION = (
    "(a) Largest angle after 240 s of the single pendulum of the experiment, each run started at "
    "1°, over amplitude and frequency. Orange: where hanging loses its stability to a swing that "
    "is unstable and lies outside; blue: to one that is stable and lies inside. (b) The swing of "
    "two shakes at two amplitudes, solid where it is stable, dashed where it is not; small dots: "
    "one motion followed as the frequency falls step by step; rings: the runs of (a), some of "
    "which still swing to and fro about the branch."
)
FINDING = (
    "Both edges of Fig. 9 are period doublings of the hanging pendulum, and they are steep and "
    "gentle because a pendulum swings slower the wider it swings. On the right the swing is born "
    "stable and grows from nothing, as the root of the distance to the edge. On the left it is "
    "born unstable and leans outwards: what crosses the edge at 20 mm has nowhere to go but "
    "to {jump:.0f}°. That swing does not end there, it lasts down to a fold at {fold_1:.2f} "
    "natural frequencies, {beyond:.1f} to the left of what the map shows; a push decides between "
    "it and rest. The classes weak and strong have no edges of their own: they are levels of this "
    "one swing and of how far it overshoots."
)
CHECK = (
    "Motions followed as the frequency falls keep within {apart:.2f}° of the branches and lose "
    "the swing within {miss:.3f} of their folds, none of them below. Just inside the right edge "
    "the square of the swing's angle is proportional to the distance, to {straight:.1f} %. The "
    "branches end where the edges of (a), which know only the hanging pendulum, say they must, to "
    "{ends:.0e} natural frequencies; and the sign of the cubic term in the map over a shake, which "
    "says whether a doubled motion begins stable, is that of a steep edge at {steep:.0f} % of the "
    "points on the left and that of a soft one at {soft:.0f} % on the right."
)
POINTS, QUICK_POINTS = (111, 161), (28, 41)  # of the map, along amplitude and frequency
DOWN, QUICK_DOWN = 265, 67  # frequencies of the motions that are followed
AMPLITUDES = (0.010, 0.020)  # m, of the branches
# Followed from within the region to below the folds, in natural frequencies.
FOLLOWED = (2.04, 0.72)
# Within these the curves and branches are computed: drive amplitude [m], natural frequencies.
_LOW, _HIGH = (0.005, 0.5), (0.060, 2.6)
# Where the swing is found first: a start [rad], and the shakes after which it has settled.
_BEGIN, _START, _SETTLED = 1.95, 0.5, 800
# How far inside the right edge, in natural frequencies, the growth of the swing is compared.
_NEAR = (0.001, 0.015)
# A branch that comes so near to the hanging pendulum [rad] ends there.
_SMALL = 0.1
LATE = fig09.LATE
_RATIO = QUANTITIES["frequency_ratio"].attributes
_AMPLITUDE = QUANTITIES["drive_amplitude"].attributes
_ANGLE = QUANTITIES["largest_angle"].attributes
_PLAIN = {"units": "1", "symbol": ""}
_ABOUT = {
    LATE: _ANGLE,
    "followed": _ANGLE,
    "branch_ratio": _RATIO,
    "branch_angle": _ANGLE,
    "branch_is_stable": _PLAIN | {"long_name": "whether the swing is stable"},
    "set_fold": _RATIO,
    "edge_amplitude": _AMPLITUDE,
    "edge_ratio": _RATIO,
    "edge_is_soft": _PLAIN | {"long_name": "whether the new swing begins stable"},
}


def data(quick: bool = False) -> xr.Dataset:
    """Return the map, both edges, and the branches and followed motions at two amplitudes."""
    import xarray as xr

    from latolato import sweep

    rows, columns = QUICK_POINTS if quick else POINTS
    axes = {
        "drive_amplitude": np.linspace(*fig09.AMPLITUDES, rows),
        "frequency_ratio": np.linspace(*fig09.RATIOS, columns),
    }
    options: dict[str, Any] = {
        "duration": paper.SWEEP_DURATION,
        "transient": fig09.TRANSIENT,
        "observables": grids.PENDULUM_OBSERVABLES,
    }
    grid = sweep(paper.SINGLE, axes=axes, initial_angle=paper.SINGLE_START, **options)
    ratios = np.linspace(*FOLLOWED, QUICK_DOWN if quick else DOWN)
    followed = sweep(
        paper.SINGLE,
        axes={"drive_amplitude": list(AMPLITUDES), "frequency_ratio": ratios[::-1]},
        initial_angle=_START, continuation="frequency_ratio", direction="down", **options,
    )  # fmt: skip
    edges = curves()
    branches = [_branch(amplitude) for amplitude in AMPLITUDES]
    late = grid[LATE].values.reshape(rows, columns)
    variables = {
        LATE: (("drive_amplitude", "frequency_ratio"), late),
        "followed": (("set", "followed_ratio"), followed[LATE].values),
        "branch_ratio": (("set", "branch_point"), grids.padded(branches, "frequency_ratio")),
        "branch_angle": (("set", "branch_point"), grids.padded(branches, "largest_angle")),
        "branch_is_stable": (("set", "branch_point"), grids.padded(branches, "is_stable")),
        "set_fold": ("set", np.array([_fold_of(branch) for branch in branches])),
        "edge_amplitude": (("edge", "edge_point"), grids.padded(edges, "drive_amplitude")),
        "edge_ratio": (("edge", "edge_point"), grids.padded(edges, "frequency_ratio")),
        "edge_is_soft": (("edge", "edge_point"), grids.padded(edges, "is_supercritical")),
    }
    return xr.Dataset(
        {name: (dims, values, _ABOUT[name]) for name, (dims, values) in variables.items()},
        coords={
            "drive_amplitude": ("drive_amplitude", axes["drive_amplitude"], _AMPLITUDE),
            "frequency_ratio": ("frequency_ratio", axes["frequency_ratio"], _RATIO),
            "followed_ratio": ("followed_ratio", ratios[::-1], _RATIO),
            "set": ("set", np.array(AMPLITUDES), _AMPLITUDE),
        },
        attrs={"title": TITLE},
    )


def curves() -> list[xr.Dataset]:
    """Return the left and the right edge, on which hanging doubles its period."""
    from latolato import analysis

    # Without damping and for small amplitudes they are at 2 -+ 2 A0/l.
    side = 2.0 * AMPLITUDES[-1] / paper.SINGLE.length
    return [
        analysis.bifurcation_curve(
            paper.SINGLE, grids.shake(paper.SINGLE, 2.0 + sign * side, AMPLITUDES[-1]),
            kind="period_doubling", initial_angle=0.0, low=_LOW, high=_HIGH, points=60,
        )
        for sign in (-1.0, 1.0)
    ]  # fmt: skip


def _branch(amplitude: float) -> xr.Dataset:
    """Return the swing of two shakes from the right edge through its fold to the left edge.

    At both edges it has become as small as nothing; beyond them it comes back as its own image.
    """
    import xarray as xr

    from latolato import analysis, simulate

    drive = grids.shake(paper.SINGLE, _BEGIN, amplitude)
    late = simulate(
        paper.SINGLE,
        drive,
        initial_angle=_START,
        times=[_SETTLED * math.tau / drive.drive_frequency],
    )
    low, high = _LOW[1], _HIGH[1]
    halves = []
    ways: tuple[tuple[Literal["up", "down"], int], ...] = (("up", 100), ("down", 400))
    for direction, points in ways:
        half = analysis.continue_orbit(
            paper.SINGLE, drive, low=low, high=high, direction=direction, points=points, period=2,
            initial_angle=late.angle.item(), initial_angular_velocity=late.angular_velocity.item(),
        ).drop_dims("special")  # fmt: skip
        angle = half.largest_angle.values
        turns = (angle[1:-1] < _SMALL) & (angle[1:-1] < angle[:-2]) & (angle[1:-1] <= angle[2:])
        halves.append(half.isel(point=slice(0, int(np.argmax(turns)) + 2)))
    up, down = halves
    return xr.concat([up.isel(point=slice(None, 0, -1)), down], "point", data_vars="all")


def _fold_of(branch: xr.Dataset) -> float:
    """Return the frequency ratio at which a branch turns."""
    return float(branch.frequency_ratio.min())


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return where the swing begins and ends, and how far motions and the map are from it."""
    ratios = dataset.followed_ratio.values
    folds = dataset.set_fold.values
    lost = np.array([ratios[row > fig09.GROWN].min() for row in dataset.followed.values])
    known_points = np.isfinite(dataset.edge_ratio).sum("edge_point")
    gaps, ends, straight, jumps = [], [], [], []
    for i, amplitude in enumerate(AMPLITUDES):
        ratio, angle = dataset.branch_ratio.values[i], dataset.branch_angle.values[i]
        stable = dataset.branch_is_stable.values[i] == 1.0
        order = np.flatnonzero(stable)[np.argsort(ratio[stable])]
        left, right = (
            float(np.interp(amplitude, *_in_order(a, r)))
            for a, r in zip(dataset.edge_amplitude.values, dataset.edge_ratio.values, strict=True)
        )
        known = np.flatnonzero(np.isfinite(ratio))
        ends += [abs(ratio[known[0]] - right), abs(ratio[known[-1]] - left)]
        jumps.append(float(np.interp(left, ratio[order], angle[order])))
        motion = dataset.followed.values[i]
        grown = (motion > fig09.GROWN) & (ratios < right - _NEAR[1])
        there = np.interp(ratios[grown], ratio[order], angle[order])
        gaps.append(float(np.abs(motion[grown] - there).max()))
        inside = right - ratio[order]
        near = order[(inside > _NEAR[0]) & (inside < _NEAR[1])]
        slopes = angle[near] ** 2 / (right - ratio[near])
        straight.append(float(slopes.max() / slopes.min() - 1.0))
    return {
        "fold_0": float(folds[0]),
        "fold_1": float(folds[1]),
        "beyond": fig09.RATIOS[0] - float(folds[1]),
        "jump": math.degrees(jumps[1]),
        "miss": float(np.abs(lost - folds).max()),
        "below": float((lost < folds).sum()),
        "step": float(ratios[1] - ratios[0]),
        "apart": math.degrees(max(gaps)),
        "straight": 100.0 * max(straight),
        "ends": max(ends),
        "steep": 100.0 * float((dataset.edge_is_soft[0] == 0.0).sum() / known_points[0]),
        "soft": 100.0 * float((dataset.edge_is_soft[1] == 1.0).sum() / known_points[1]),
    }


def _in_order(amplitude: np.ndarray, ratio: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return an edge by rising amplitude."""
    known = np.isfinite(amplitude)
    order = np.argsort(amplitude[known])
    return amplitude[known][order], ratio[known][order]


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) and (b)."""
    figure, axes = style.new_figure(1, 2, height=3.3)
    a, b = axes[0]
    mesh = a.pcolormesh(
        dataset.frequency_ratio, 1e3 * dataset.drive_amplitude, np.degrees(dataset[LATE]),
        shading="nearest", rasterized=True, vmin=0.0, vmax=180.0,
    )  # fmt: skip
    curves = [
        a.plot(ratio, 1e3 * amplitude, color=colour)[0]
        for ratio, amplitude, colour in zip(
            dataset.edge_ratio.values,
            dataset.edge_amplitude.values,
            (style.ORANGE, style.SKY),
            strict=True,
        )
    ]
    a.set_xlim(*fig09.RATIOS)
    a.set_ylim(*(1e3 * each for each in fig09.AMPLITUDES))
    a.set_ylabel("driving amplitude [mm]")
    style.colour_bar(
        mesh, "largest angle after 240 s [degrees]", ax=a, location="top", aspect=30, extend="max"
    )
    every = slice(None, None, max(1, dataset.sizes["followed_ratio"] // 60))
    for i, colour in enumerate((style.GREEN, style.RED)):
        ratio, angle = dataset.branch_ratio.values[i], np.degrees(dataset.branch_angle.values[i])
        stable = dataset.branch_is_stable.values[i] == 1.0
        b.plot(ratio, np.where(stable, angle, np.nan), color=colour, lw=1.2,
               label=rf"$A_0$ = {1e3 * AMPLITUDES[i]:g} mm")  # fmt: skip
        b.plot(ratio, np.where(stable, np.nan, angle), color=colour, lw=1.0, ls=(0, (3, 2)))
        b.plot(
            dataset.followed_ratio[every], np.degrees(dataset.followed.values[i][every]), ".",
            ms=2.5, color=colour,
        )  # fmt: skip
        row = dataset.sel(drive_amplitude=AMPLITUDES[i], method="nearest")
        b.plot(
            row.frequency_ratio, np.degrees(row[LATE]), "o", ms=3.0, mfc="none", mew=0.5,
            color=colour, markevery=max(1, dataset.sizes["frequency_ratio"] // 40),
        )  # fmt: skip
    b.set_xlim(FOLLOWED[1], fig09.RATIOS[1])
    b.set_ylim(0.0, None)
    b.set_ylabel("largest angle [degrees]")
    b.legend(loc="upper right")
    for panel, letter, title in ((a, "a", "where runs swing"), (b, "b", "the swing and its ends")):
        panel.set_xlabel(style.label(dataset.frequency_ratio))
        style.panel_title(panel, letter, title)
    texts = ["hanging gives way to an unstable swing", "to a stable one"]
    figure.legend(curves, texts, loc="outside lower left", ncols=2)
    return figure
