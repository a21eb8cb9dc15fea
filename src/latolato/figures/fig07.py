"""Fig. 7: damping of the single pendulum from its free decay, through a synthetic video."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.figures import chain, paper, style
from latolato.figures.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NEEDS_VIDEO = True
TITLE = "Damping of the single pendulum, from a synthetic video"
CAPTION = (
    "A free decay from 20° with the printed l, m and C, rendered as a video, tracked and fitted. "
    "(a) A frame. (b) Angle, the full equation's fit, turning points and the envelope of eq13. (c) "
    "What the equation leaves."
)
STATEMENTS = (
    chain.decay_statement(
        "fig7-chain",
        "Fig. 7",
        paper.SINGLE.damping,
        "The upper envelope of the θ-t curve of the damped vibration is fitted … The damping "
        "coefficient C is calculated to be 0.00274 kg m/s",
    ),
)


def data(quick: bool = False, full: bool = False) -> xr.Dataset:
    """Return the fitted decay of the single pendulum."""
    clip = chain.Clip(
        system=paper.SINGLE,
        start=(("initial_angle", math.radians(20.0)),),
        duration=16.0 if quick else 40.0,
        fps=24.0 if quick else 30.0,
        size=(640, 480) if quick else (1280, 960),
        seed=7,
    )
    return chain.decay_data(clip, TITLE, quick)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 7's statement needs."""
    return chain.decay_numbers(dataset)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (c)."""
    return chain.draw_decay(dataset)
