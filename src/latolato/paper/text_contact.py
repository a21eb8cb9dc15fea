"""Judges the text on the colliding pair: when a push is needed, how often the top is reached."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato import Harmonic
from latolato.paper import systems as paper
from latolato.paper.cases import instants, quantity, stack, variable
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Starting the pair, and reaching the top"
# Fig. 4's toy without damping, as in the paper's sweep.
TOY = replace(paper.TOY, damping=0.0)
AMPLITUDES = (0.15, 0.2)  # m
# This part above the lift-off ratio the pair must leave the wall.
BESIDE = 1e-3


def data(quick: bool = False) -> xr.Dataset:
    """Return largest angles and contacts of runs of 300 s over the frequency ratio."""
    from latolato import simulate

    w0 = TOY.natural_frequency
    ratios = np.linspace(1.6, 3.4, 37 if quick else 145)
    times = instants(paper.SWEEP_DURATION, w0, per_period=40)

    def run(amplitude: float, ratio: float, offset: float) -> xr.Dataset:
        drive = Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * w0)
        return simulate(TOY, drive, initial_offset=offset, times=times, tolerance=1e-8)

    lift_off = math.sqrt(TOY.length / AMPLITUDES[-1])
    starts = [(a, r, 0.0) for a in AMPLITUDES for r in ratios]
    starts += [(AMPLITUDES[-1], r, paper.PUSH) for r in ratios]
    starts.append((AMPLITUDES[-1], (1.0 + BESIDE) * lift_off, 0.0))
    runs = {str(i): run(*start) for i, start in enumerate(starts)}
    amplitudes, ratios, offsets = np.transpose(starts)
    largest = [float(each.angle.max()) for each in runs.values()]
    return (
        stack(runs, title=TITLE, keep=())
        .assign(
            largest_angle=quantity("largest_angle", "case", largest),
            lift_off_ratio=variable(
                (), lift_off, units="1", long_name="ratio above which rest ends"
            ),
        )
        .assign_coords(
            drive_amplitude=quantity("drive_amplitude", "case", amplitudes),
            initial_offset=quantity("initial_offset", "case", offsets),
            frequency_ratio=quantity("frequency_ratio", "case", ratios),
        )
    )


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statements on the pair need."""
    ratio, largest = dataset.frequency_ratio.values[:-1], dataset.largest_angle.values[:-1]
    tops = dataset.top_contacts.values[:-1]
    pushed = dataset.initial_offset.values[:-1] > 0.0
    strong = dataset.drive_amplitude.values[:-1] == AMPLITUDES[-1]
    lift_off = float(dataset.lift_off_ratio)
    low = TOY.contact_angle_low
    from_rest = strong & ~pushed
    below = ratio < lift_off
    best = np.flatnonzero(from_rest)[int(np.argmax(tops[from_rest]))]
    return {
        "lift_off": lift_off,
        "rise_below": float(largest[from_rest & below].max() - low),
        "pushed_below": float(largest[pushed & below].max()),
        "rise_above": float(largest[from_rest & ~below].min() - low),
        "reached_above": float(dataset.largest_angle[-1]),
        "most_tops": float(tops[best]),
        "best_ratio": float(ratio[best]),
        "most_tops_lower": float(tops[~strong].max()),
    }
