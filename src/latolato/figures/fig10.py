"""Fig. 10: damping of the coupled apparatus, one ball parked aside, through a synthetic video."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.figures import chain, paper, style
from latolato.figures.claim import Numbers
from latolato.physics.pendulum import Pendulum

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NEEDS_VIDEO = True
TITLE = "Damping of the coupled apparatus, from a synthetic video"
CAPTION = (
    "As Fig. 7 with l, m and C of the coupled apparatus; the other ball is parked aside, as in the "
    "paper's measurement."
)
STATEMENTS = (
    chain.decay_statement(
        "fig10-chain",
        "Fig. 10",
        paper.COUPLED_DAMPING,
        "suspending one ball while allowing the other to perform underdamped oscillations with a "
        "stationary pivot … calculated to be 0.00506 kg m/s",
    ),
)
# Where the other ball is parked, from the pivot, in lengths.
_PARKED = (0.8, -0.45)


def data(quick: bool = False, full: bool = False) -> xr.Dataset:
    """Return the fitted decay of one ball of the pair."""
    length = paper.COUPLED_LENGTH
    clip = chain.Clip(
        system=Pendulum(length=length, mass=paper.COUPLED_MASS, damping=paper.COUPLED_DAMPING),
        start=(("initial_angle", math.radians(20.0)),),
        duration=16.0 if quick else 30.0,
        fps=24.0 if quick else 30.0,
        size=(640, 480) if quick else (1280, 960),
        scene=(
            ("ball_radius", paper.COUPLED.radius),
            ("parked_x", _PARKED[0] * length),
            ("parked_y", _PARKED[1] * length),
        ),
        seed=10,
    )
    return chain.decay_data(clip, TITLE, quick)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that Fig. 10's statement needs."""
    return chain.decay_numbers(dataset)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the figure with panels (a) to (c)."""
    return chain.draw_decay(dataset)
