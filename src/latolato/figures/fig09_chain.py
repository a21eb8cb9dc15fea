"""Fig. 9 through the whole chain: classified trials over the computed map."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import chain, chain_trials, comparisons, grids, paper, style
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.physics.drives import Harmonic

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NEEDS_VIDEO = True
TITLE = "Synthetic trials of the single pendulum over the computed map"
AMPLITUDES = (0.012, 0.016, 0.020, 0.025, 0.030, 0.036)  # m, assumed: six sets, none printed
RATIOS = (1.80, 2.35)
TRIALS = 8  # in each set
START = math.radians(10.0)  # rad, assumed
DURATION, TRANSIENT = 45.0, 30.0  # s
# One trial of each set that goes through a video.
FILMED = (2, 2, 1, 2, 2, 1)
SIGMAS = {"length": 5e-4, "damping": 3e-5}
POINTS, QUICK_POINTS = (71, 111), (36, 56)
CAPTION = (
    "Six sets of eight trials (A0 = 12 to 36 mm, a start at 10°, 45 s, the angle that lasts after "
    "30 s), each a synthetic experiment with its drive fitted, classified and laid over the map of "
    "the same protocol. The white dashed line is the boundary between the trials. The "
    "agreement's interval allows for 0.5 mm of length and 3e-05 kg m/s of damping, the tracker's "
    "noise, and chance."
)
STATEMENTS = (
    Statement(
        name="fig9-chain",
        is_method_check=True,
        where="Fig. 9, through the chain",
        words=(
            "The white dashed boundaries separating stable and unstable experimental states "
            "closely match the numerical stability threshold"
        ),
        assumed=(
            Limit("agreement", "share of trials with the class of the map", low=0.9),
            Limit("kappa", "Cohen's kappa", low=0.8),
            Limit("enclosed", "share of boundaries between trials that enclose the map's", low=0.7),
        ),
        assumption=(
            "A synthetic experiment stands for the paper's trials: this tests the chain and how "
            "sharply so many trials tell a boundary, not the paper's experiment."
        ),
        finding=(
            "In synthetic trials of Fig. 9, {agreement:.0%} of {count:.0f} have the class of the "
            "map (95 %: {low:.0%} to {high:.0%}; kappa {kappa:.2f}), and {inside:.0f} of "
            "{boundaries:.0f} boundaries between neighbouring trials enclose that of the map."
        ),
        why=(
            "Trials of a set lie {gap:.3f} apart in ω/ω0: a boundary is known to half of that, "
            "whatever the tracking does."
        ),
    ),
)


def data(quick: bool = False, full: bool = False) -> xr.Dataset:
    """Return the trials over the map."""
    from latolato.experiment.comparison.places import compare_map
    from latolato.sweeps import sweep

    random = np.random.default_rng(9)
    clips: list[chain.Clip] = []
    for amplitude in AMPLITUDES:
        step = (RATIOS[1] - RATIOS[0]) / (TRIALS - 1)
        for ratio in np.linspace(*RATIOS, TRIALS) + step * random.uniform(-0.35, 0.35, TRIALS):
            drive = Harmonic(
                drive_amplitude=amplitude,
                drive_frequency=float(ratio) * paper.SINGLE.natural_frequency,
            )
            clips.append(
                chain.Clip(
                    system=paper.SINGLE, drive=drive, start=(("initial_angle", START),),
                    duration=DURATION, seed=len(clips),
                )
            )  # fmt: skip
    chosen = [TRIALS * i + k for i, k in enumerate(FILMED)]
    by_video = [] if quick else list(range(len(clips))) if full else chosen
    trials = chain_trials.gathered(clips, by_video, TRANSIENT)
    up, across = QUICK_POINTS if quick else POINTS
    grid = sweep(
        paper.SINGLE,
        axes={
            "drive_amplitude": np.linspace(0.008, 0.040, up),
            "frequency_ratio": np.linspace(1.70, 2.45, across),
        },
        duration=DURATION,
        transient=TRANSIENT,
        initial_angle=START,
        observables=grids.PENDULUM_OBSERVABLES,
    )
    found = compare_map(trials, grid, sigmas=SIGMAS, draws=20 if quick else 60)
    known = np.flatnonzero(np.isfinite(found.boundary_computed.values))
    return chain_trials.marked(found.isel(boundary=known), TITLE, trials.attrs["failed"])


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement needs."""
    inside = np.abs(dataset.boundary_x - dataset.boundary_computed) <= dataset.boundary_half_gap
    return {
        "agreement": float(dataset.agreement),
        "low": float(dataset.agreement_low),
        "high": float(dataset.agreement_high),
        "kappa": float(dataset.kappa),
        "count": float(dataset.sizes["trial"]),
        "inside": float(inside.sum()),
        "boundaries": float(inside.size),
        "enclosed": float(inside.mean()),
        "gap": 2.0 * float(dataset.boundary_half_gap.mean()),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the map with the trials over it."""
    figure, axes = style.new_figure(width=0.85 * style.PAGE, height=4.2)
    handles = comparisons.draw_trials(axes[0, 0], dataset)
    square = chain_trials.draw_squares(axes[0, 0], dataset, dataset.x.values, dataset.y.values)
    handles += [] if square is None else [square]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure
