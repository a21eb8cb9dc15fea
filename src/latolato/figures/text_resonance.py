"""Judges the text on where resonance occurs: its range, its orders, its smallest amplitude."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis.closed_forms import (
    decay_rate,
    mathieu_growth_rate,
    mathieu_threshold_amplitude,
    mathieu_tongue_edges,
)
from latolato.figures import measure, paper
from latolato.figures.cases import Floats, instants, quantity, stack, variable
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.physics.drives import Harmonic

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

STATEMENTS = (
    Statement(
        name="starting-from-2",
        where="Abstract",
        words=(
            "parametric resonance consistently occurs within a characteristic frequency ratio "
            "range (ω/ω0) starting from 2"
        ),
        printed=(
            Limit("edge_sweep", "lower edge at A0 = 0.5 l, eq14 without damping", low=1.95),
            Limit("edge_fig2", "lower edge at A0 = 0.05 l", low=1.95),
        ),
        assumed=(Limit("edge_smallest", "lower edge at A0 = 0.005 l", 1.98, 2.0),),
        assumption="The limit of small driving amplitudes is meant.",
        finding=(
            "The lower edge of the resonance is at ω/ω0 = {edge_smallest:.3f}, {edge_fig2:.3f}, "
            "{edge_fig4:.3f} and {edge_sweep:.3f} for A0/l = 0.005, 0.05, 0.2 and 0.5."
        ),
        why=(
            "The tongue opens from 2 to both sides as A0 grows. For the colliding pair the range "
            "depends on the start as well: see the claims of Fig. 5."
        ),
    ),
    Statement(
        name="integer-multiples",
        where="Introduction",
        words=(
            "The parametric resonance occurs at driving frequencies that are integer multiples of "
            "the natural frequency"
        ),
        printed=tuple(
            Limit(
                f"growth_{n}",
                f"growth rate at ω = {n} ω0, A0 = 0.05 l, no damping",
                low=1e-4,
                unit="1/s",
            )
            for n in TIMES_OMEGA0
        ),
        finding=(
            "At ω = ω0, 2ω0, 3ω0 and 4ω0 the growth rate of eq14 is {growth_1:.5g}, "
            "{growth_2:.5g}, {growth_3:.5g} and {growth_4:.5g} 1/s, where 0 means that nothing "
            "grows."
        ),
        why=(
            "The condition is ω = 2ω0/n, as the paper says later: multiples hold for n = 1 and 2 "
            "only."
        ),
    ),
    Statement(
        name="small-amplitude-stable",
        where="text on Fig. 3cd",
        words=(
            "if the selected driving amplitude A0 is too small, regardless of how ω/ω0 is chosen, "
            "the motion of the system will always remain in a stable state"
        ),
        printed=(
            Limit(
                "threshold_undamped",
                "smallest A0 that grows at ω = 2 ω0, C = 0",
                low=1e-4,
                unit="m",
            ),
        ),
        assumed=(
            Limit(
                "threshold_damped",
                "smallest A0 that grows at ω = 2 ω0, C of Fig. 2",
                low=1e-3,
                unit="m",
            ),
            Limit(
                "largest_small",
                "largest angle of all ratios at A0 = 0.01 l, C = 0",
                high=2.0,
                unit="rad",
            ),
        ),
        assumption=(
            "There is damping, or stable means never reaching 2 rad (the paper's criterion 2); "
            "its sweep has C = 0."
        ),
        finding=(
            "With the damping of Fig. 2, growth needs A0 ≥ {threshold_mm:.3f} mm (first order "
            "lC/(2mlω0) = {first_order_mm:.3f} mm); without damping any A0 > 0 is enough at ω = "
            "2ω0, and A0 = 0.01 l then leads to {largest_small:.2f} rad at most."
        ),
        why=(
            "Without damping the tongue of eq14 reaches down to A0 = 0 at ratio 2, but detuning "
            "keeps the swing small there."
        ),
    ),
    Statement(
        name="further-bands",
        where="text on Fig. 3cd",
        words=(
            "there should also exist sub-secondary resonance regions … so weak that they are "
            "practically undetectable"
        ),
        printed=tuple(
            Limit(
                f"factor_{n}",
                f"growth in 300 s in band n = {n}, A0 = 0.5 l, C = 0, as a factor",
                high=SHOWING,
            )
            for n in ORDERS
        ),
        finding=(
            "At A0 = 0.5 l the motion grows at most by a factor of {factor_3:.2f} in band n = 3 "
            "and {factor_4:.4f} in band n = 4 in 300 s; a factor of ten takes A0 ≥ {shows_3:.2f} "
            "l and {shows_4:.2f} l."
        ),
        why=(
            "Band n narrows like (A0/l)ⁿ: at A0 = 0.5 l it is {width_3:.1e} and {width_4:.1e} "
            "wide in ω/ω0. With Fig. 4's damping the rates there are {damped_3:.4f} and "
            "{damped_4:.4f} 1/s: both bands are gone."
        ),
    ),
)


def data(quick: bool = False) -> xr.Dataset:
    """Return edges, growth rates and thresholds of eq14, and runs of eq10 at a small amplitude."""
    from latolato.simulation.run import simulate

    length, mass = paper.UNDAMPED.length, paper.UNDAMPED.mass
    w0 = paper.UNDAMPED.natural_frequency
    edges = [mathieu_tongue_edges(drive_amplitude=a, length=length)[0] for a in AMPLITUDES]
    multiples = mathieu_growth_rate(
        drive_amplitude=paper.DRIVE.drive_amplitude,
        drive_frequency=w0 * np.array(TIMES_OMEGA0),
        length=length,
    )
    dampings = (paper.UNDAMPED.damping, paper.PENDULUM.damping)
    thresholds = [
        mathieu_threshold_amplitude(length=length, mass=mass, damping=damping)
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
    """Return the largest growth rate in an undamped band [1/s] and its width in w/w0."""
    length, w0 = paper.UNDAMPED.length, paper.UNDAMPED.natural_frequency
    low, high = mathieu_tongue_edges(drive_amplitude=amplitude, length=length, order=order)
    rates = mathieu_growth_rate(
        drive_amplitude=amplitude, drive_frequency=w0 * np.linspace(low, high, 101), length=length
    )
    return float(rates.max()), high - low


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statements on resonance need."""

    def edge(amplitude: float) -> float:
        return float(dataset.lower_edge.sel(drive_amplitude=amplitude))

    undamped, damped = (float(value) for value in dataset.threshold_amplitude)
    pendulum = paper.PENDULUM
    rate = pendulum.damping / (pendulum.mass * pendulum.length)
    found = {
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
        found[f"growth_{multiple}"] = float(dataset.growth_at_multiples.sel(multiple=multiple))
    amplitudes = dataset.band_amplitude.values
    at = int(np.argmin(np.abs(amplitudes - paper.LARGEST_AMPLITUDE_RATIO)))
    for order in ORDERS:
        growth: Floats = dataset.band_growth.sel(order=order).values
        found[f"factor_{order}"] = math.exp(growth[at] * paper.SWEEP_DURATION)
        found[f"width_{order}"] = float(dataset.band_width.sel(order=order)[at])
        found[f"damped_{order}"] = float(growth[at]) - decay_rate(**paper.body(paper.TOY))
        needed = math.log(SHOWING) / paper.SWEEP_DURATION
        # Rates grow like a power of the amplitude: straight between logarithms.
        found[f"shows_{order}"] = math.exp(
            measure.first_above(np.log(amplitudes), np.log(growth), math.log(needed))
        )
    return found
