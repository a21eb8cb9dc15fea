"""Judges the text on the model: rods, motor, impacts and the damped equation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato import CrankSlider, Harmonic, equivalent_pendulum
from latolato.analysis import tongue_edges
from latolato.paper import measure
from latolato.paper import systems as paper
from latolato.paper.cases import Floats, instants, quantity, stack, variable
from latolato.paper.claim import Numbers
from latolato.physics.contacts import pair_impact

if TYPE_CHECKING:
    import xarray as xr

    from latolato.physics.drives import Drive

TITLE = "The model and the motor"
ROD_SHARE = 0.1  # of the total mass, the paper's "approximately 1/10"
BALL_RATIO = 0.08  # r/l, assumed as in Fig. 12
CRANK_RATIO = 0.1  # crank over connecting rod, assumed
SETTLING = 150.0  # s


def data(quick: bool = False) -> xr.Dataset:
    """Return the single pendulum's settling under a crank and a pure cosine, and both drives."""
    from latolato import simulate

    frequency, amplitude = paper.SINGLE_FREQUENCY, paper.SINGLE_AMPLITUDE
    motor = {
        "cosine": Harmonic(drive_amplitude=amplitude, drive_frequency=frequency),
        "crank": CrankSlider(
            drive_amplitude=amplitude,
            drive_frequency=frequency,
            connecting_rod_length=amplitude / CRANK_RATIO,
        ),
    }
    times = instants(SETTLING, frequency)
    # A start near the lasting amplitude settles soon.
    runs = {
        label: simulate(paper.SINGLE, drive, initial_angle=1.0, times=times)
        for label, drive in motor.items()
    }
    orders = np.arange(6)
    return stack(runs, title=TITLE, keep=("angle", "angular_velocity")).assign(
        height_harmonics=quantity(
            "pivot_height",
            ("case", "order"),
            [_harmonics(drive, "height") for drive in motor.values()],
            long_name="harmonics of the pivot's height",
        ),
        acceleration_harmonics=quantity(
            "pivot_acceleration",
            ("case", "order"),
            [_harmonics(drive, "acceleration") for drive in motor.values()],
            long_name="harmonics of the pivot's acceleration",
        ),
        order=variable("order", orders, units="1", long_name="order of the harmonic"),
    )


def _harmonics(drive: Drive, which: str) -> Floats:
    """Return the amplitudes of the first harmonics of a drive's height or acceleration."""
    (segment,) = drive.segments(1.0)
    period = 2.0 * math.pi / paper.SINGLE_FREQUENCY
    formula = getattr(drive, which)
    samples = np.array([formula(i * period / 64, segment) for i in range(64)])
    return np.asarray(np.abs(np.fft.rfft(samples))[:6] / 32.0)


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statements on the model need."""
    # Both rods together are a tenth of everything, so each is this part of one ball.
    rod = ROD_SHARE / (1.0 - ROD_SHARE)
    with_rod, _ = equivalent_pendulum(1.0, 1.0, rod_mass=rod)
    with_ball, _ = equivalent_pendulum(1.0, 1.0, radius=BALL_RATIO)
    crank = dataset.sel(case="crank")
    settled = {str(case): _settled(dataset.sel(case=case)) for case in dataset.case.values}
    gravity, length = paper.SINGLE.gravity, paper.SINGLE.length
    tongue = tongue_edges(paper.PENDULUM, drive_amplitude=paper.DRIVE.drive_amplitude)
    edge = float(tongue.low)
    return {
        "rod_shift": with_rod**-0.5 - 1.0,
        "edge": edge,
        "edge_distance": paper.PRINTED_EDGE / edge - 1.0,
        "ball_loss": 1.0 - with_ball**-0.5,
        "height_overtone": float(crank.height_harmonics[2] / crank.height_harmonics[1]),
        "acceleration_overtone": float(
            crank.acceleration_harmonics[2] / crank.acceleration_harmonics[1]
        ),
        "amplitude_change": settled["crank"] / settled["cosine"] - 1.0,
        **_impact_numbers(),
        "frequency_line": math.sqrt(gravity),
        "frequency_eq7": math.sqrt(gravity / length),
        "frequency_ratio": math.sqrt(length),
    }


def _settled(run: xr.Dataset) -> float:
    """Return the mean turning point of the last 10 s [rad]."""
    when, sizes = measure.peaks(run.time.values, run.angle.values, run.angular_velocity.values)
    return float(sizes[when > SETTLING - 10.0].mean())


def _impact_numbers() -> dict[str, float]:
    """Return how an elastic impact of Fig. 4's toy changes momentum, and eq11's for two lengths."""
    toy = paper.TOY
    inertia = toy.mass * toy.length**2
    before = (-1.0, 1.0)
    after = pair_impact(*before, inertia, inertia, 1.0)
    angles = (toy.contact_angle_low, -toy.contact_angle_low)

    def momentum(velocities: tuple[float, float]) -> Floats:
        parts = [
            toy.mass * toy.length * v * np.array([math.cos(x), math.sin(x)])
            for v, x in zip(velocities, angles, strict=True)
        ]
        return np.asarray(np.sum(parts, axis=0))

    moved = np.linalg.norm(momentum(after) - momentum(before))
    scale = 2.0 * toy.mass * toy.length
    # Paper: eq11 for equal masses exchanges the linear velocities l w.
    lengths = (1.0, 0.9)
    v1, v2 = (length * w for length, w in zip(lengths, before, strict=True))
    turned = lengths[0] * (v2 - v1) + lengths[1] * (v1 - v2)
    angular_change = abs(sum(after) - sum(before)) / 2.0
    return {
        "linear_change": float(moved / scale),
        "angular_change": angular_change,
        "angular_percent": 100.0 * angular_change,
        "eq11_change": abs(turned) / (lengths[0] * abs(v1) + lengths[1] * abs(v2)),
    }
