"""What people read about where two equal balls stay mirror images."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from latolato.figures.analyses.question import DISTURBANCE, Question, is_toy, on_rods
from latolato.figures.analyses.sentences import e_folding, no_answer, number, percent

if TYPE_CHECKING:
    import xarray as xr


def verdict(dataset: xr.Dataset) -> str:
    """Tell whether departures grow, of one toy or of how many."""
    status = dataset["status"].values.astype(str)
    rate = dataset["transverse_exponent"].values.ravel()
    if status.size > 1:
        return f"They do in {percent(float((status == 'valid').mean()))} of {status.size} cases."
    state, value = str(status.ravel()[0]), float(rate[0])
    if math.isnan(value):
        return no_answer(state)
    if state == "valid" and math.isinf(value):
        return "Yes: they rest on each other, and every difference vanishes."
    if state == "valid":
        return f"Yes: differences between them die out, {e_folding(value)}."
    if state == "broken":
        return f"No: a small difference between them grows, {e_folding(value)}."
    return f"The run is too short to tell: a difference grows at {number(value)} 1/s."


QUESTION = Question(
    group=DISTURBANCE,
    title="Do both balls stay mirror images?",
    term="transverse stability of the symmetric motion",
    reading="Both balls start almost as mirror images. Below zero the difference dies out, and one "
    "ball tells you everything. Above zero it grows, and each ball goes its own way.",
    first=("duration", "transient"),
    quick={"duration": "300"},
    conditions=(is_toy, on_rods),
    place=4,
    verdict=verdict,
)
