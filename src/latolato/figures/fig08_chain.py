"""Fig. 8 through the whole chain: a synthetic video beside the computed motion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.figures import chain, chain_motion, paper, style
from latolato.figures.claim import Numbers
from latolato.physics.drives import Harmonic

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NEEDS_VIDEO = True
TITLE = "The single pendulum, a synthetic experiment and its calculation"
CAPTION = (
    f"A synthetic experiment with ω = 10.09 rad/s, A0 = {1e3 * paper.SINGLE_AMPLITUDE:g} mm and a "
    "start at 2°, and the motion computed on the drive that is fitted to it: angles, their "
    "difference over twice the deviation that the fitted start leaves open, and the phase of one "
    "over the other."
)
STATEMENTS = (
    chain_motion.statement(
        "fig8-chain",
        "Fig. 8",
        "the experimental results align well with numerical simulations as the system approaches "
        "stabilization",
    ),
)


def data(quick: bool = False, full: bool = False) -> xr.Dataset:
    """Return the comparison of the single pendulum's motion."""
    clip = chain.Clip(
        system=paper.SINGLE,
        drive=Harmonic(
            drive_amplitude=paper.SINGLE_AMPLITUDE, drive_frequency=paper.SINGLE_FREQUENCY
        ),
        start=(("initial_angle", math.radians(2.0)),),
        duration=70.0,
        seed=8,
    )
    return chain_motion.data(clip, TITLE, quick)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement needs."""
    return chain_motion.numbers(dataset)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with a frame, angles, residual and phase."""
    return chain_motion.draw(dataset)
