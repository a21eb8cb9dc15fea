"""The words of `swing_time`, as they would lie in `latolato/figures/analyses`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from latolato.figures.analyses.question import LONG_RUN, Cost, Question
from latolato.figures.analyses.sentences import degrees, number

if TYPE_CHECKING:
    import xarray as xr


def verdict(dataset: xr.Dataset) -> str:
    """Tell the time of the widest swing."""
    widest = dataset.isel(largest_angle=-1)
    angle, time = float(widest.largest_angle), float(widest.swing_time)
    return f"A swing of {degrees(angle)} takes {number(time)} s."


QUESTION = Question(
    group=LONG_RUN,
    title="Do wide swings take longer?",
    term="period of free swings",
    reading="To the right how wide it swings, upwards how long a swing takes.",
    first=("largest_angle",),
    quick={"swings": "20"},
    cost=Cost(counts=("swings",)),
    labels={"swings": "Number of swings"},
    verdict=verdict,
)
