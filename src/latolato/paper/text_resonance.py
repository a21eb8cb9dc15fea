"""Judges the text on where resonance occurs: its range, its orders, its smallest amplitude."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from latolato import Harmonic
from latolato.analysis import (
    decay_rate,
    growth_rate,
    threshold_amplitude,
    tongue_edges,
)
from latolato.paper import measure
from latolato.paper import systems as paper
from latolato.paper.cases import Floats, instants, quantity, stack, variable
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Where parametric resonance occurs"
AMPLITUDES = np.array([0.005, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5])  # m for l = 1 m
BAND_AMPLITUDES = np.arange(0.1, 2.01, 0.05)  # m, beyond the paper's sweep to see the bands grow
ORDERS = (3, 4)
TIMES_OMEGA0 = (1, 2, 3, 4)
SMALL = 0.01  # m, "too small" an amplitude
# A band shows once it multiplies the start by this within the paper's 300 s.
SHOWING = 10.0


def data(quick: bool = False) -> xr.Dataset:
    """Return edges, growth rates and thresholds of eq14, and runs of eq10 at a small amplitude."""
    from latolato import simulate

    w0 = paper.UNDAMPED.natural_frequency
    edges = [float(tongue_edges(paper.UNDAMPED, drive_amplitude=a).low) for a in AMPLITUDES]
    multiples = [_growth(paper.DRIVE.drive_amplitude, w0 * n) for n in TIMES_OMEGA0]
    dampings = (paper.UNDAMPED.damping, paper.PENDULUM.damping)
    thresholds = [
        float(threshold_amplitude(replace(paper.UNDAMPED, damping=damping)).drive_amplitude)
        for damping in dampings
    ]
    bands = np.array([[_band(order, a) for a in BAND_AMPLITUDES] for order in ORDERS])
    ratios = np.linspace(1.9, 2.1, 21 if quick else 81)
    times = instants(paper.SWEEP_DURATION, 2.0 * w0, per_period=20)
    runs = {
        f"{ratio:.4f}": simulate(
            paper.UNDAMPED,
            Harmonic(drive_amplitude=SMALL, drive_frequency=ratio * w0),
            initial_angle=paper.TOY.contact_angle_low,  # the start of the paper's sweep
            times=times,
            tolerance=1e-8,
        )
        for ratio in ratios
    }
    dataset = stack(runs, title=TITLE, keep=())
    dataset = dataset.assign(
        lower_edge=quantity("frequency_ratio", "drive_amplitude", edges, long_name="lower edge"),
        growth_at_multiples=quantity("growth_rate", "multiple", multiples),
        threshold_amplitude=quantity(
            "drive_amplitude", "damping", thresholds, long_name="smallest amplitude that grows"
        ),
        band_growth=quantity("growth_rate", ("order", "band_amplitude"), bands[..., 0]),
        band_width=variable(
            ("order", "band_amplitude"),
            bands[..., 1],
            units="1",
            long_name="width in frequency ratio",
        ),
        largest_angle=quantity(
            "largest_angle", "case", [float(np.abs(run.angle).max()) for run in runs.values()]
        ),
    )
    return dataset.assign_coords(
        drive_amplitude=quantity("drive_amplitude", "drive_amplitude", AMPLITUDES),
        multiple=variable("multiple", list(TIMES_OMEGA0), units="1", long_name="multiple of ω0"),
        damping=quantity("damping", "damping", list(dampings)),
        order=variable("order", list(ORDERS), units="1", long_name="order of the band"),
        band_amplitude=quantity("drive_amplitude", "band_amplitude", BAND_AMPLITUDES),
        frequency_ratio=quantity("frequency_ratio", "case", ratios),
    )


def _band(order: int, amplitude: float) -> tuple[float, float]:
    """Return the largest growth rate in an undamped band [1/s] and its width in w/w0.

    The rate rises from zero at one edge and falls to zero at the other, with one maximum between.
    """
    from scipy.optimize import minimize_scalar

    w0 = paper.UNDAMPED.natural_frequency
    tongue = tongue_edges(paper.UNDAMPED, drive_amplitude=amplitude, order=order)
    low, high = float(tongue.low), float(tongue.high)
    width = high - low
    best = minimize_scalar(
        lambda ratio: -_growth(amplitude, w0 * ratio),
        bounds=(low, high), method="bounded", options={"xatol": 1e-4 * width},
    )  # fmt: skip
    return -float(best.fun), width


def _growth(amplitude: float, frequency: float) -> float:
    """Growth rate without damping, by Hill's determinant [1/s]."""
    drive = Harmonic(drive_amplitude=amplitude, drive_frequency=frequency)
    return float(growth_rate(paper.UNDAMPED, drive).growth_rate)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statements on resonance need."""

    def edge(amplitude: float) -> float:
        return float(dataset.lower_edge.sel(drive_amplitude=amplitude))

    undamped, damped = (float(value) for value in dataset.threshold_amplitude)
    pendulum = paper.PENDULUM
    rate = pendulum.damping / (pendulum.mass * pendulum.length)
    result = {
        "edge_smallest": edge(AMPLITUDES[0]),
        "edge_fig2": edge(0.05),
        "edge_fig4": edge(0.2),
        "edge_sweep": edge(0.5),
        "threshold_undamped": undamped,
        "threshold_damped": damped,
        "threshold_mm": 1e3 * damped,
        "first_order_mm": 1e3 * pendulum.length * rate / (2.0 * pendulum.natural_frequency),
        "largest_small": float(dataset.largest_angle.max()),
    }
    for multiple in TIMES_OMEGA0:
        result[f"growth_{multiple}"] = float(dataset.growth_at_multiples.sel(multiple=multiple))
    amplitudes = dataset.band_amplitude.values
    at = int(np.argmin(np.abs(amplitudes - paper.LARGEST_AMPLITUDE_RATIO)))
    for order in ORDERS:
        growth: Floats = dataset.band_growth.sel(order=order).values
        result[f"factor_{order}"] = math.exp(growth[at] * paper.SWEEP_DURATION)
        result[f"width_{order}"] = float(dataset.band_width.sel(order=order)[at])
        result[f"damped_{order}"] = float(growth[at]) - decay_rate(**paper.body(paper.TOY))
        needed = math.log(SHOWING) / paper.SWEEP_DURATION
        # Rates grow like a power of the amplitude: straight between logarithms.
        result[f"shows_{order}"] = math.exp(
            measure.first_above(np.log(amplitudes), np.log(growth), math.log(needed))
        )
    return result
