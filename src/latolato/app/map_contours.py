"""Contour lines of a map for a page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from latolato.app.blocks import pack
from latolato.app.given import TooLargeError
from latolato.app.map_shown import Shown
from latolato.core.errors import InputError
from latolato.core.quantities import ANY
from latolato.core.registry import checked_number
from latolato.figures.contours import Line, round_levels
from latolato.figures.level_lines import lines_of

MOST_LEVELS = 20
MOST_VERTICES = 2_000_000


def contours(shown: Shown, given: Mapping[str, Any]) -> tuple[list[float], list[Line], int]:
    """Return the levels of a map, the lines there and how many tiny ones are left out.

    `given` holds ``levels``, a list of values [SI], or None for round numbers, and ``log``,
    whether these are spaced evenly in their logarithm.

    Raises
    ------
    InputError
        For bad levels, and for a variable of classes.
    TooLargeError
        If there is more to draw than a page can.
    """
    drawing = shown.drawing
    if drawing.classes:
        raise InputError(f"{drawing.name} has classes, not a scale: it has no contour lines")
    levels = _levels(given["levels"]) if given.get("levels") is not None else _usual(shown, given)
    lines, tiny = lines_of(drawing, levels)
    if sum(len(line.x) for line in lines) > MOST_VERTICES:
        raise TooLargeError("the contour lines have too many corners: choose fewer levels")
    return levels, lines, tiny


def contour_block(shown: Shown, given: Mapping[str, Any]) -> bytes:
    """Return the contour lines of a map as a block.

    ``x`` and ``y`` are the corners of all lines; ``first`` is where each begins, and ``level`` the
    number of its level.
    """
    levels, lines, tiny = contours(shown, given)
    numbers = {level: number for number, level in enumerate(levels)}
    about = {"levels": levels, "most": MOST_LEVELS, "lines": len(lines), "tiny": tiny}
    return pack(
        {**about, "missing": shown.missing},
        {
            "x": np.concatenate([*(line.x for line in lines), np.empty(0)]),
            "y": np.concatenate([*(line.y for line in lines), np.empty(0)]),
            "first": np.cumsum([0, *(len(line.x) for line in lines)]).astype(np.int32),
            "level": np.array([numbers[line.level] for line in lines], dtype=np.int32),
        },
    )


def _levels(given: Any) -> list[float]:
    """Return the levels that a page asks for."""
    if not isinstance(given, (list, tuple)) or not given:
        raise InputError(f"levels must be a list of numbers, got {given!r}")
    if len(given) > MOST_LEVELS:
        raise TooLargeError(f"at most {MOST_LEVELS} contour lines, got {len(given)} levels")
    return sorted({checked_number("a level", value, ANY, "SI") for value in given})


def _usual(shown: Shown, given: Mapping[str, Any]) -> list[float]:
    """Return round levels between the ends of the values, or of the colours."""
    low, high = shown.drawing.limits
    log = bool(given.get("log"))
    if log:
        above = shown.drawing.values[shown.drawing.values > 0.0]
        low = float(above.min()) if above.size else math.nan
    return round_levels(low, high, unit=shown.unit, log=log)[:MOST_LEVELS]
