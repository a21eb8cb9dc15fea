"""Judges the text on the model: rods, motor, impacts and the damped equation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from latolato.analysis.closed_forms import mathieu_tongue_edges
from latolato.figures import measure, paper
from latolato.figures.cases import Floats, instants, quantity, stack, variable
from latolato.figures.claim import Limit, Numbers, Statement
from latolato.physics.contacts import pair_impact
from latolato.physics.drives import CrankSlider, Drive, Harmonic
from latolato.physics.pendulum import equivalent_pendulum

if TYPE_CHECKING:
    import xarray as xr

TITLE = "The model and the motor"
ROD_SHARE = 0.1  # of the total mass, the paper's "approximately 1/10"
BALL_RATIO = 0.08  # r/l, assumed as in Fig. 12
CRANK_RATIO = 0.1  # crank over connecting rod, assumed
SETTLING = 150.0  # s

STATEMENTS = (
    Statement(
        name="rod-mass",
        where="Theoretical Framework (a)",
        words="The massless rod assumption m_rod = 0 remains valid even in practical scenarios",
        printed=(
            Limit("rod_shift", "relative shift of ω0 by rods of 1/10 of the mass", -0.01, 0.01),
        ),
        finding=(
            "Uniform rods of a tenth of the total mass raise ω0 by {rod_shift:.2%}; a solid ball "
            "of r/l = 0.08 lowers it by {ball_loss:.2%}."
        ),
        why=(
            "Small, yet more than the {edge_distance:.2%} between the printed edge 1.92 and the "
            "computed {edge:.3f}: the paper's l must be read as the length of the equivalent "
            "pendulum."
        ),
    ),
    Statement(
        name="sinusoidal-motor",
        where="Experimental verification",
        words=(
            "produces near-perfect sinusoidal vibration. Given the rotary arm's significantly "
            "shorter length compared to the connecting rod"
        ),
        assumed=(
            Limit("height_overtone", "second harmonic of the pivot's height, relative", high=0.05),
        ),
        assumption=(
            "The connecting rod is ten times as long as the crank; neither length is printed."
        ),
        finding=(
            "With a connecting rod ten times as long as the crank, the second harmonic is "
            "{height_overtone:.1%} of the pivot's height but {acceleration_overtone:.1%} of its "
            "acceleration, which is what drives; the lasting amplitude of Fig. 8 changes by "
            "{amplitude_change:+.3%}."
        ),
        why="Differentiating twice multiplies the second harmonic, λ/4 of the height, by four.",
    ),
    Statement(
        name="momentum",
        where="text before eq11",
        words="At the moment of the collision, the system's momentum is conserved",
        printed=(
            Limit(
                "linear_change",
                "change of the linear momentum at a bottom contact, relative",
                high=1e-6,
            ),
        ),
        assumed=(
            Limit(
                "angular_change",
                "change of the angular momentum about the pivot, relative",
                high=1e-12,
            ),
        ),
        assumption="Angular momentum about the pivot is meant.",
        finding=(
            "In the toy of Fig. 4 a contact changes the linear momentum by {linear_change:.1%} of "
            "the sum of both balls' momenta, and the angular momentum about the pivot by "
            "{angular_percent:.1g}%."
        ),
        why=(
            "The rods meet at an angle, so the pivot takes up linear momentum. In terms of linear "
            "velocities eq11 holds for equal lengths only: for l2 = 0.9 l1 it would change the "
            "angular momentum by {eq11_change:.1%}."
        ),
    ),
    Statement(
        name="line-before-eq7",
        where="line before eq7",
        words="ml θ'' + mgl sin θ = -C θ'",
        printed=(
            Limit(
                "frequency_ratio", "ω0 of this line over that of eq7, l = 0.3630 m", 0.999, 1.001
            ),
        ),
        finding=(
            "The line before eq7 would give ω0 = {frequency_line:.3f} rad/s for the experiment's "
            "pendulum; eq7 gives {frequency_eq7:.3f} rad/s."
        ),
        why="Its units do not fit: m l² θ'' + m g l sin θ = -C l θ' leads to eq7, which is right.",
    ),
)


def data(quick: bool = False) -> xr.Dataset:
    """Return the single pendulum's settling under a crank and a pure cosine, and both drives."""
    from latolato.simulation.run import simulate

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
    (stretch,) = drive.stretches(1.0)
    period = 2.0 * math.pi / paper.SINGLE_FREQUENCY
    formula = getattr(drive, which)
    samples = np.array([formula(i * period / 64, stretch) for i in range(64)])
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
    edge, _ = mathieu_tongue_edges(
        drive_amplitude=paper.DRIVE.drive_amplitude, **paper.body(paper.PENDULUM)
    )
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
