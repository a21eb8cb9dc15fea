"""Counts how often the truth lies within the stated deviations of fits of synthetic tables.

For each fit and noise: 100 tables with other parameters and seeds, and the shares of results
within one and two standard deviations (68 and 95 percent if these are right). Decays and models are
also fitted as a tracker sees them, with its smaller noise and a pivot 0.15 pixels beside its place
(``aside``) or where it was taken to be (``placed``). Run
``PYTHONPATH=tests/shared python benchmarks/fit_coverage.py [cases]``; prints a table.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterator

import numpy as np

import latolato as ll
from track_tables import PLACE, decay_table, drive_table, motion_table

CORRELATIONS = (0.0, 0.6, 0.9)
# Noise of tracked angles [rad].
TRACKED = 1.2e-4


def decay(seed: int, correlation: float) -> Iterator[tuple[str, float]]:
    generator = np.random.default_rng(1000 + seed)
    length, mass = generator.uniform(0.2, 0.4), generator.uniform(0.08, 0.12)
    damping, angle = generator.uniform(0.001, 0.006), generator.uniform(0.2, 1.2)
    table = decay_table(
        length=length, mass=mass, damping=damping, angle=angle, held=0.7 * (seed % 2),
        duration=generator.uniform(15.0, 25.0), seed=seed, correlation=correlation,
    )  # fmt: skip
    found = ll.fit_decay(table, mass=mass, compare=False, profile=False)
    for name, truth in (("damping", damping), ("damping_envelope", damping), ("length", length)):
        yield f"decay {name}", (found[name].value - truth) / found[name].sigma


def seen(seed: int, correlation: float) -> Iterator[tuple[str, float]]:
    generator = np.random.default_rng(5000 + seed)
    length, mass = generator.uniform(0.2, 0.4), generator.uniform(0.08, 0.12)
    damping, angle = generator.uniform(0.001, 0.006), generator.uniform(0.3, 1.0)
    aside = generator.normal(scale=PLACE, size=2)
    truth = ll.Pendulum(length=length, mass=mass, damping=damping)
    guess = ll.Pendulum(length=1.01 * length, mass=mass, damping=1.1 * damping)
    tracked = {"seed": seed, "correlation": correlation, "size": TRACKED}
    for words, error in (("aside", aside), ("placed", (0.0, 0.0))):
        table = decay_table(
            length=length, mass=mass, damping=damping, angle=angle, duration=16.0,
            pivot_error=error, **tracked,
        )  # fmt: skip
        found = ll.fit_decay(table, mass=mass, compare=False, profile=False)
        for name, value in (
            ("damping", damping),
            ("damping_envelope", damping),
            ("length", length),
        ):
            yield f"decay {name}, {words}", (found[name].value - value) / found[name].sigma
        table = motion_table(
            truth, initial_angle=angle, duration=12.0, pivot_error=error, **tracked
        )
        found = ll.fit_model(table, guess)
        for name, value in (("length", length), ("damping", damping)):
            yield f"model {name}, {words}", (found[name].value - value) / found[name].sigma


def drive(seed: int, correlation: float) -> Iterator[tuple[str, float]]:
    generator = np.random.default_rng(2000 + seed)
    truth = ll.Harmonic(
        drive_amplitude=generator.uniform(0.01, 0.04),
        drive_frequency=generator.uniform(6.0, 20.0),
        drive_phase=generator.uniform(-3.0, 3.0),
    )
    found = ll.fit_drive(
        drive_table(truth, duration=20.0, seed=seed, correlation=correlation), profile=False
    )
    for name in ("drive_amplitude", "drive_frequency", "drive_phase"):
        yield f"drive {name}", (found[name].value - getattr(truth, name)) / found[name].sigma


def model(seed: int, correlation: float) -> Iterator[tuple[str, float]]:
    generator = np.random.default_rng(3000 + seed)
    truth = ll.Pendulum(
        length=generator.uniform(0.3, 0.4), mass=0.1, damping=generator.uniform(0.002, 0.006)
    )
    moving = ll.Harmonic(drive_amplitude=0.02, drive_frequency=1.95 * truth.natural_frequency)
    table = motion_table(
        truth, moving, initial_angle=0.3, duration=12.0, seed=seed, correlation=correlation
    )
    found = ll.fit_model(table, ll.Pendulum(length=0.35, mass=0.1, damping=0.004))
    for name in ("length", "damping"):
        yield f"model {name}", (found[name].value - getattr(truth, name)) / found[name].sigma


def restitution(seed: int, correlation: float) -> Iterator[tuple[str, float]]:
    generator = np.random.default_rng(4000 + seed)
    truth = generator.uniform(0.5, 0.98)
    ball = ll.Ball(length=0.245, mass=0.106, damping=0.005, radius=0.02)
    pair = ll.BallPair(right=ball, left=ball, restitution=truth)
    moving = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.1) if seed % 2 else None
    table = motion_table(
        pair, moving, initial_angle=(0.7, -0.5), duration=8.0, fps=(60.0, 120.0)[seed // 2 % 2],
        seed=seed, correlation=correlation,
    )  # fmt: skip
    found = ll.fit_restitution(table, length=0.245, radius=0.02)["restitution"]
    yield "restitution", (found.value - truth) / found.sigma


def main(cases: int = 100) -> None:
    print(f"{'fit':32} {'noise':>5} {'cases':>5} {'1 sigma':>8} {'2 sigma':>8} {'spread':>7}")
    for fit in (decay, seen, drive, model, restitution):
        for correlation in CORRELATIONS:
            misses = defaultdict(list)
            for seed in range(cases):
                for name, miss in fit(seed, correlation):
                    misses[name].append(miss)
            for name, values in misses.items():
                size = np.abs(values)
                print(
                    f"{name:32} {correlation:5.1f} {len(size):5d} {np.mean(size < 1.0):8.2f} "
                    f"{np.mean(size < 2.0):8.2f} {np.std(values):7.2f}",
                    flush=True,
                )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
