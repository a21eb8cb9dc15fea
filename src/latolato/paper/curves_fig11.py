"""Why the curves of Fig. 11 are steep on the left and gentle on the right."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.quantities import QUANTITIES
from latolato.figures import style
from latolato.paper import fig11, grids
from latolato.paper import systems as paper
from latolato.paper.cases import Floats
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

TITLE = "The edges of Fig. 11 as curves"
CAPTION = (
    "(a) Largest angle after 60 s of the coupled experiment's pair, each run started "
    f"{fig11.START:g} rad above the wall, over amplitude and frequency. Orange: the fold at which "
    "the swing with one impact in every shake begins; blue: lift-off from rest, A0 ω² = g. (b) "
    "That swing at the four amplitudes of Fig. 11, solid where it is stable, dashed where it is "
    "not; dots: one motion followed as the frequency falls step by step."
)
FINDING = (
    "The steep left side of Fig. 11 is the edge of a basin, not the end of a motion. The swing "
    "with one impact in every shake lasts down to a fold, at {fold_3:.3f} natural frequencies for "
    "30 mm and {fold_0:.3f} for 15 mm, far to the left of the peaks; but runs that begin low come "
    "to rest where the unstable twin of the swing is too large for them, below {edge_3:.2f} to "
    "{edge_0:.2f}. The stronger the shakes, the smaller is the twin, so the peaks move to the "
    "left. The gentle right side is no bifurcation either: up to {highest:.1f} natural "
    "frequencies the same swing lasts, stable and without any special point, and only becomes "
    "smaller."
)
CHECK = (
    "Motions followed as the frequency falls lose the swing within {miss:.3f} of the fold at all "
    "{count:.0f} amplitudes ({steps:.1f} steps of that sweep), and none of them below it. The left "
    "edges of runs that begin {start:g} rad above the wall lie {least:.2f} to {most:.2f} to the "
    "right of where the largest angle of the twin is that of the start, and move to the left with "
    "it: by {edge_shift:.2f} from 15 to 30 mm, the twin by {twin_shift:.2f}."
)
POINTS, QUICK_POINTS = (61, 121), (13, 31)  # of the map, along amplitude and frequency
DOWN, QUICK_DOWN = 481, 121  # frequencies of the motions that are followed
AMPLITUDES = (0.005, 0.035)  # m, of the map
LATE = fig11.LATE
# Where the swing is found first: the frequency ratio, a start above the wall [rad], and the shakes
# after which it has settled.
_BEGIN, _START, _SETTLED = 2.4, 0.8, 400
# The frequency ratio at which it begins at the middle amplitude, and its angle [rad] and angular
# velocity [rad/s] there: a guess, of which the curve of the fold begins.
_FOLD, _AT_FOLD = 1.438, (1.625, 5.96)
# Up to this frequency ratio its unstable twin is followed.
_TWIN = 2.6
# Above the wall, an angle that only a swing reaches [rad].
_SWINGS = 0.1
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
    "set_specials": _PLAIN | {"long_name": "special points to the right of the fold"},
    "fold_amplitude": _AMPLITUDE,
    "fold_ratio": _RATIO,
    "lift_amplitude": _AMPLITUDE,
    "lift_ratio": _RATIO,
}


def data(quick: bool = False) -> xr.Dataset:
    """Return the map, the curve of the fold, and branches and followed motions at four sets."""
    import xarray as xr

    from latolato import sweep

    rows, columns = QUICK_POINTS if quick else POINTS
    axes = {
        "drive_amplitude": np.linspace(*AMPLITUDES, rows),
        "frequency_ratio": np.linspace(*fig11.RATIOS, columns),
    }
    options: dict[str, Any] = {"duration": fig11.DURATION, "transient": fig11.TRANSIENT}
    grid = sweep(
        paper.COUPLED, axes=axes, initial_offset=fig11.START,
        observables=grids.PAIR_OBSERVABLES, **options,
    )  # fmt: skip
    ratios = np.linspace(*fig11.RATIOS, QUICK_DOWN if quick else DOWN)
    followed = sweep(
        paper.COUPLED,
        axes={"drive_amplitude": list(fig11.AMPLITUDES), "frequency_ratio": ratios},
        initial_offset=fig11.START, observables=grids.PAIR_OBSERVABLES,
        continuation="frequency_ratio", direction="down", **options,
    )  # fmt: skip
    sets = [_swing(amplitude) for amplitude in fig11.AMPLITUDES]
    falling, rising = zip(*sets, strict=True)
    fold, lift = curves()
    # From the end of the unstable twin through the fold to fast shakes.
    longest = max(down.sizes["point"] + up.sizes["point"] - 1 for down, up in sets)

    def padded(name: str) -> Floats:
        rows = np.full((len(sets), longest), np.nan)
        for row, (down, up) in zip(rows, sets, strict=True):
            whole = np.concatenate([down[name].values[:0:-1], up[name].values])
            row[: len(whole)] = whole
        return rows

    plane = (
        ("drive_amplitude", "frequency_ratio"),
        grid[LATE].values[..., :, :].reshape(rows, columns),
    )
    variables = {
        LATE: plane,
        "followed": (("set", "followed_ratio"), followed[LATE].values),
        "branch_ratio": (("set", "branch_point"), padded("frequency_ratio")),
        "branch_angle": (("set", "branch_point"), padded("largest_angle")),
        "branch_is_stable": (("set", "branch_point"), padded("is_stable")),
        "set_fold": ("set", np.array([float(down.special_value[0]) for down in falling])),
        "set_specials": ("set", np.array([up.sizes["special"] for up in rising], dtype=float)),
        "fold_amplitude": ("fold_point", fold.drive_amplitude.values),
        "fold_ratio": ("fold_point", fold.frequency_ratio.values),
        "lift_amplitude": ("lift_point", lift.drive_amplitude.values),
        "lift_ratio": ("lift_point", lift.frequency_ratio.values),
    }
    return xr.Dataset(
        {name: (dims, values, _ABOUT[name]) for name, (dims, values) in variables.items()},
        coords={
            "drive_amplitude": ("drive_amplitude", axes["drive_amplitude"], _AMPLITUDE),
            "frequency_ratio": ("frequency_ratio", axes["frequency_ratio"], _RATIO),
            "followed_ratio": ("followed_ratio", ratios, _RATIO),
            "set": ("set", np.array(fig11.AMPLITUDES), _AMPLITUDE),
        },
        attrs={"title": TITLE},
    )


def curves(largest: float = AMPLITUDES[1]) -> list[xr.Dataset]:
    """Return the fold at which the swing begins, and lift-off from rest, up to an amplitude [m]."""
    from latolato import analysis

    low, high = zip((AMPLITUDES[0], largest), fig11.RATIOS, strict=True)
    fold = analysis.bifurcation_curve(
        paper.COUPLED, grids.shake(paper.COUPLED, _FOLD, fig11.MIDDLE), kind="fold",
        low=low, high=high, initial_angle=_AT_FOLD[0], initial_angular_velocity=_AT_FOLD[1],
    )  # fmt: skip
    lift = analysis.bifurcation_curve(
        paper.COUPLED, grids.shake(paper.COUPLED, 2.86, 0.03), kind="lift_off",
        initial_angle=paper.COUPLED.contact_angle_low, low=low, high=high,
    )  # fmt: skip
    return [fold, lift]


def _swing(amplitude: float) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the branch of the swing towards slower and towards faster shakes, at an amplitude."""
    from latolato import analysis, simulate

    drive = grids.shake(paper.COUPLED, _BEGIN, amplitude)
    late = simulate(
        paper.COUPLED,
        drive,
        initial_offset=_START,
        times=[_SETTLED * math.tau / drive.drive_frequency],
    )
    start = {
        "initial_angle": late.angle.item(),
        "initial_angular_velocity": late.angular_velocity.item(),
    }
    low, high = fig11.RATIOS
    down = analysis.continue_orbit(
        paper.COUPLED, drive, low=low, high=_TWIN, direction="down", points=300, **start
    )
    up = analysis.continue_orbit(paper.COUPLED, drive, low=low, high=high, points=60, **start)
    return down, up


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return where the swing ends, and how far from there motions lose it."""
    rest = paper.COUPLED.contact_angle_low + _SWINGS
    folds = dataset.set_fold.values
    ratios = dataset.followed_ratio.values
    lost = np.array([ratios[row > rest].min() for row in dataset.followed.values])
    step = float(ratios[1] - ratios[0])
    edges, twins = [], []
    begun = paper.COUPLED.contact_angle_low + fig11.START
    for i, amplitude in enumerate(fig11.AMPLITUDES):
        row = dataset[LATE].sel(drive_amplitude=amplitude, method="nearest").values > rest
        edges.append(float(dataset.frequency_ratio[int(np.argmax(row))]))
        unstable = dataset.branch_is_stable.values[i] == 0.0
        angle = dataset.branch_angle.values[i][unstable]
        order = np.argsort(angle)
        ratio = dataset.branch_ratio.values[i][unstable][order]
        twins.append(float(np.interp(begun, angle[order], ratio, left=math.nan)))
    apart = np.subtract(edges, twins)
    return {
        **{f"fold_{i}": float(each) for i, each in enumerate(folds)},
        **{f"edge_{i}": each for i, each in enumerate(edges)},
        **{f"twin_{i}": each for i, each in enumerate(twins)},
        "least": float(apart.min()),
        "most": float(apart.max()),
        "edge_shift": edges[0] - edges[-1],
        "twin_shift": twins[0] - twins[-1],
        "specials": float(dataset.set_specials.values.sum()),
        "highest": fig11.RATIOS[1],
        "miss": float(np.abs(lost - folds).max()),
        "below": float((lost < folds).sum()),
        "steps": float(np.abs(lost - folds).max()) / step,
        "count": float(len(folds)),
        "start": fig11.START,
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) and (b)."""
    import matplotlib as mpl

    figure, axes = style.new_figure(1, 2, height=3.3)
    a, b = axes[0]
    angles = np.degrees(dataset[LATE])
    mesh = a.pcolormesh(
        dataset.frequency_ratio, 1e3 * dataset.drive_amplitude, angles, shading="nearest",
        rasterized=True,
    )  # fmt: skip
    curves = [
        a.plot(dataset.fold_ratio, 1e3 * dataset.fold_amplitude, color=style.ORANGE)[0],
        a.plot(dataset.lift_ratio, 1e3 * dataset.lift_amplitude, color=style.SKY)[0],
    ]
    a.set_xlim(*fig11.RATIOS)
    a.set_ylim(1e3 * AMPLITUDES[0], 1e3 * AMPLITUDES[1])
    a.set_ylabel("driving amplitude [mm]")
    style.colour_bar(mesh, "largest angle after 60 s [degrees]", ax=a, location="top", aspect=30)
    shades = mpl.colormaps["viridis"]
    for i, amplitude in enumerate(fig11.AMPLITUDES):
        colour = shades(0.85 * (1.0 - i / (len(fig11.AMPLITUDES) - 1)))
        ratio, angle = dataset.branch_ratio.values[i], np.degrees(dataset.branch_angle.values[i])
        stable = dataset.branch_is_stable.values[i] == 1.0
        b.plot(ratio, np.where(stable, angle, np.nan), color=colour, lw=1.2,
               label=rf"$A_0$ = {1e3 * amplitude:g} mm")  # fmt: skip
        b.plot(ratio, np.where(stable, np.nan, angle), color=colour, lw=1.0, ls=(0, (3, 2)))
        every = slice(None, None, max(1, dataset.sizes["followed_ratio"] // 60))
        b.plot(
            dataset.followed_ratio[every], np.degrees(dataset.followed.values[i][every]), ".",
            ms=2.5, color=colour,
        )  # fmt: skip
    b.set_xlim(*fig11.RATIOS)
    b.set_ylim(0.0, None)
    b.set_ylabel("largest angle [degrees]")
    b.legend(loc="upper right")
    for panel, letter, title in ((a, "a", "where runs swing"), (b, "b", "the swing and its twin")):
        panel.set_xlabel(style.label(dataset.frequency_ratio))
        style.panel_title(panel, letter, title)
    texts = ["fold, where the swing begins", "lift-off from rest"]
    figure.legend(curves, texts, loc="outside lower left", ncols=2)
    return figure
