"""Fig. 12 through the whole chain: the stepped frequency, a synthetic video and computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from latolato.figures import chain, chain_motion, paper, style
from latolato.figures.claim import Numbers
from latolato.physics.drives import FrequencySchedule

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NEEDS_VIDEO = True
START = 0.05  # rad above the low contact angle
TITLE = "Stepping the frequency, a synthetic experiment and its calculation"
CAPTION = (
    "A synthetic experiment with the stepped drive of Fig. 12, "
    f"{paper.COUPLED_WORDS}, and a start {START:g} rad above contact (from rest in contact the "
    "first hops are chaotic), and the motion computed on the drive that is fitted to it. The angle "
    "is half that between the balls."
)
STATEMENTS = (
    chain_motion.statement(
        "fig12-chain",
        "Fig. 12",
        "the experimental values demonstrated excellent agreement with numerical calculations "
        "during stable operation",
    ),
)


def data(quick: bool = False, full: bool = False) -> xr.Dataset:
    """Return the comparison of the pair's motion."""
    w0 = paper.COUPLED.natural_frequency
    clip = chain.Clip(
        system=paper.COUPLED,
        drive=FrequencySchedule(
            drive_amplitude=paper.COUPLED_AMPLITUDE,
            times=(0.0, paper.SWITCH_TIME),
            drive_frequencies=tuple(ratio * w0 for ratio in paper.STAGE_RATIOS),
        ),
        start=(("initial_offset", START),),
        duration=15.0,
        fps=60.0,
        seed=12,
    )
    return chain_motion.data(clip, TITLE, quick)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement needs."""
    return chain_motion.numbers(dataset)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with a frame, angles, residual and phase."""
    return chain_motion.draw(dataset)
