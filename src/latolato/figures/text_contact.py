"""Judges the text on the colliding pair: when a push is needed, how often the top is reached."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import paper
from latolato.figures.cases import instants, quantity, stack, variable
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.physics.drives import Harmonic

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Starting the pair, and reaching the top"
# Fig. 4's toy without damping, as in the paper's sweep.
TOY = replace(paper.TOY, damping=0.0)
AMPLITUDES = (0.15, 0.2)  # m
# This part above the lift-off ratio the pair must leave the wall.
BESIDE = 1e-3
# A start that stays within rounding of the wall does not move.
STILL = 1e-12  # rad
OFTEN = paper.SWEEP_DURATION / 5.0  # top contacts: one in five seconds

STATEMENTS = (
    Statement(
        name="push-needed",
        where="Abstract, text on Fig. 11 and Conclusions",
        words=(
            "under periodic driving at moderate frequencies, the system requires initial "
            "perturbations … The absence of required perturbations at high frequencies might be "
            "attributed to … disturbances"
        ),
        printed=(
            Limit("rise_below", "rise from rest below lift-off", high=STILL, unit="rad"),
            Limit("pushed_below", "largest angle below lift-off after a push", low=1.0, unit="rad"),
            Limit("rise_above", "smallest rise from rest above lift-off", low=0.1, unit="rad"),
        ),
        finding=(
            "At A0 = 0.2 m a pair at rest stays at rest below ω/ω0 = √(l/A0) = {lift_off:.3f}, "
            "where a push of 0.2 rad leads to {pushed_below:.2f} rad; a thousandth above this "
            "ratio a start from rest reaches {reached_above:.2f} rad, and at every higher ratio "
            "of the scan it reaches more than 0.2 rad."
        ),
        why=(
            "A resting pair lifts off only while the pivot falls faster than gravity, A0 ω² > g: "
            "high frequencies need no disturbance. That noise helped cannot be excluded from the "
            "paper's data."
        ),
    ),
    Statement(
        name="top-at-0.2",
        where="text on Fig. 5",
        words=(
            "the driving amplitude A0 reaches approximately 0.2 m, the … balls can frequently "
            "achieve the maximum angular displacement"
        ),
        printed=(
            Limit(
                "most_tops",
                "top contacts in 300 s at the best ratio, A0 = 0.2 m from rest",
                low=OFTEN,
            ),
        ),
        finding=(
            "From rest the balls meet at the top up to {most_tops:.0f} times in 300 s at A0 = 0.2 "
            "m (ω/ω0 = {best_ratio:.2f}), and up to {most_tops_lower:.0f} times at 0.15 m."
        ),
        why=(
            "From rest the pair needs lift-off, √(l/A0), to lie in the resonance range. The "
            "motion is chaotic: the count depends on the ratio's digits, its size does not."
        ),
    ),
)


def data(quick: bool = False) -> xr.Dataset:
    """Return largest angles and contacts of runs of 300 s over the frequency ratio."""
    from latolato.simulation.run import simulate

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
    largest = [float(found.angle.max()) for found in runs.values()]
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
