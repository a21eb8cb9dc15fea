"""Fig. 11 through the whole chain: response curves of four sets and where they peak."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import chain, chain_trials, comparisons, grids, paper, style
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.physics.drives import Harmonic

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NEEDS_VIDEO = True
TITLE = "Response curves of the colliding pair, synthetic trials and calculation"
AMPLITUDES = (0.015, 0.020, 0.025, 0.030)  # m, assumed: four sets, none printed
RATIOS = (1.9, 3.1)
TRIALS = 12  # in each set
START = 0.15  # rad above the low contact angle, assumed
DURATION, TRANSIENT = 24.0, 16.0  # s
# One trial of each set that goes through a video.
FILMED = (7, 6, 5, 4)
BAND = (2.2, 2.6)
SIGMAS = {"restitution": 0.005, "damping": 5e-5}
CAPTION = (
    "Four sets of twelve trials (A0 = 15 to 30 mm, a start 0.15 rad above the wall, 24 s, the "
    "largest angle after 16 s), each a synthetic experiment, beside the computed curves (lines). "
    "Triangles: peaks with their deviation, that of the gap to the trial left of the cliff. "
    "Shaded: the paper's range."
)
STATEMENTS = (
    Statement(
        name="fig11-chain",
        is_method_check=True,
        where="Fig. 11, through the chain",
        words=(
            "each curve exhibits a peak occurring at frequency ratios between 2.2 and 2.6 … with "
            "increasing driving amplitude, these peaks gradually shift leftward"
        ),
        assumed=(
            Limit("pull", "largest distance of the peaks over its deviation", high=3.0),
            Limit("first", "lowest peak of the trials", low=BAND[0]),
            Limit("last", "highest peak of the trials", high=BAND[1]),
        ),
        assumption=(
            "A synthetic experiment stands for the paper's trials, with r/l, e, A0 and start "
            "assumed: this tests the chain and how sharply twelve trials tell a peak."
        ),
        finding=(
            "In synthetic trials of Fig. 11 the four peaks lie at {peak_0:.2f}, {peak_1:.2f}, "
            "{peak_2:.2f} and {peak_3:.2f} ± {sigma:.2f}; the computed curves peak at "
            "{shown_0:.3f}, {shown_1:.3f}, {shown_2:.3f} and {shown_3:.3f}."
        ),
        why=(
            "The left flank is a cliff between two trials: their distance, not the tracking, "
            "limits how well the peak's place is known."
        ),
    ),
)


def data(quick: bool = False, full: bool = False) -> xr.Dataset:
    """Return measured and computed response curves."""
    from latolato.experiment.comparison.response import compare_response

    clips: list[chain.Clip] = []
    for amplitude in AMPLITUDES:
        for ratio in np.linspace(*RATIOS, TRIALS):
            drive = Harmonic(
                drive_amplitude=amplitude,
                drive_frequency=float(ratio) * paper.COUPLED.natural_frequency,
            )
            clips.append(
                chain.Clip(
                    system=paper.COUPLED, drive=drive, start=(("initial_offset", START),),
                    duration=DURATION, fps=60.0, seed=100 + len(clips),
                )
            )  # fmt: skip
    chosen = [TRIALS * i + k for i, k in enumerate(FILMED)]
    by_video = [] if quick else list(range(len(clips))) if full else chosen
    trials = chain_trials.gathered(clips, by_video, TRANSIENT)
    found = compare_response(
        trials,
        paper.COUPLED,
        duration=DURATION,
        transient=TRANSIENT,
        initial_offset=START,
        points=121 if quick else 241,
        sigmas=SIGMAS,
        draws=3 if quick else 8,
        observables=grids.PAIR_OBSERVABLES,
    )
    return chain_trials.marked(found, TITLE, trials.attrs["failed"])


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement needs."""
    seen, shown = dataset.peak_measured_place.values, dataset.peak_computed_place.values
    sigma = np.hypot(dataset.peak_measured_sigma.values, dataset.peak_computed_sigma.values)
    return {
        **{f"peak_{i}": float(peak) for i, peak in enumerate(seen)},
        **{f"shown_{i}": float(peak) for i, peak in enumerate(shown)},
        "sigma": float(np.mean(dataset.peak_measured_sigma)),
        "pull": float(np.max(np.abs(seen - shown) / sigma)),
        "first": float(seen.min()),
        "last": float(seen.max()),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the response curves."""
    figure, axes = style.new_figure(width=0.85 * style.PAGE, height=3.6)
    panel = axes[0, 0]
    panel.axvspan(*BAND, color=style.ORANGE, alpha=0.22, lw=0, zorder=0)
    x, y = dataset.trial_ratio.values, np.degrees(dataset.largest_angle_after_transient.values)
    chain_trials.draw_squares(panel, dataset, x, y)
    comparisons.draw_responses(panel, dataset)
    return figure
