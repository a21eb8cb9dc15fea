"""How fast a clip plays: gravity and length make a pendulum a clock."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

from latolato.core.errors import Sentence, joined
from latolato.experiment.calibration.swing import Motion, Swing, fit_swing, windows
from latolato.experiment.rules import said

# Factor from which a pace does not fit length and gravity: the mass of a rod makes less; and by
# which parts of a clip differ.
_WRONG, _OTHER = 1.3, 1.25
# How surely a pace must be known, as a share.
_SURE = 0.15
# Least share of a clip with a pace of its own, and square of the slowest pace over the fastest.
_LEAST, _SLOWEST = 0.1, 1e-3
# Windows that are taken together, and half the width of one in the time in which the phase grows
# by 1.
_FEWEST, _WIDTH = 12, 1.0
# Slow motion that a camera may make: from time lapse to high speed.
_SLOWED = 0.01, 1000.0
# How near a whole number counts as whole.
_WHOLE = 0.07


def pace_warnings(
    motion: Motion, swing: Swing | None, stiffness: float | None, slow_motion: float
) -> list[Sentence]:
    """Warnings about the pace at which a clip plays.

    `stiffness` is gravity over length [1/s^2], None where it is unknown, and `slow_motion` what the
    times were divided by.
    """
    parts = parts_of(motion)
    if parts:
        values = np.array([part[2] for part in parts])
        factors = np.sqrt((stiffness or values.max()) / values)
        ratios = factors / factors.min()
        if np.max(np.abs(np.rint(ratios) / ratios - 1.0)) > _WHOLE:
            return []

        def parts_text(rule: str, scales: np.ndarray) -> Sentence:
            texts = []
            for (begin, end, _), factor, scale in zip(parts, factors, scales, strict=True):
                ends = {"begin": f"{begin / scale:.2f}", "end": f"{end / scale:.2f}"}
                texts.append(said(rule, **ends, factor=_number(factor * slow_motion)))
            return joined(texts, ", ")

        paces = parts_text("pace_from", np.ones(len(parts)))
        known = "" if stiffness else said("pace_known")
        # Times of a part are divided by its own slow motion.
        each = parts_text("pace_part", factors)
        return [said("changed_pace", paces=paces, known=known, parts=each)]
    if swing is None or not stiffness or swing.stiffness_sigma > _SURE * swing.stiffness:
        return []
    factor = math.sqrt(stiffness / swing.stiffness)
    if max(factor, 1.0 / factor) < _WRONG:
        return []
    rule = "too_slow" if factor > 1.0 else "too_fast"
    pace = factor * slow_motion
    advice = (
        said("declare_pace", factor=_number(pace))
        if _SLOWED[0] < pace < _SLOWED[1]
        else said("correct_length")
    )
    return [said(rule, factor=_number(max(factor, 1.0 / factor)), advice=advice)]


def _number(factor: float) -> str:
    """Return a factor as text, as a whole number if it is near one."""
    whole = round(factor)
    return str(whole) if abs(factor - whole) < _WHOLE * factor else f"{factor:.2g}"


def parts_of(motion: Motion) -> list[tuple[float, float, float]]:
    """Return begin, end [s] and gravity over length [1/s^2] of parts of a clip with two paces.

    None if there is one pace only. It can miss changes by less than a factor of 1.25, a third pace,
    and parts of less than half a swing or a tenth of the clip.
    """
    rows = windows(motion, _WIDTH)
    if len(rows) < _FEWEST:
        return []
    times, bend, push, _, sine = rows[:, :5].T
    square = uniform_filter1d(sine**2, _FEWEST, mode="nearest")
    pull = uniform_filter1d(-(bend + push) * sine, _FEWEST, mode="nearest")
    near = pull / np.maximum(square, 1e-30)
    low, high = np.maximum(np.quantile(near, [_LEAST, 1.0 - _LEAST]), 0.0)
    if high <= _OTHER**2 * low:
        return []
    limit = math.sqrt(max(low, _SLOWEST * high) * high)
    is_fast = median_filter(near > limit, 2 * _FEWEST + 1, mode="nearest")
    changes = times[np.flatnonzero(np.diff(is_fast)) + 1].tolist()
    parts = []
    for begin, end in pairwise([motion.times[0], *changes, motion.times[-1]]):
        inside = (begin <= motion.times) & (motion.times <= end)
        swing = fit_swing(Motion(*(values[inside] for values in motion)))
        if swing is not None and swing.stiffness_sigma < _SURE * swing.stiffness:
            parts.append((float(begin), float(end), swing.stiffness))
    values = [stiffness for _, _, stiffness in parts]
    return parts if parts and max(values) > _OTHER**2 * min(values) else []
