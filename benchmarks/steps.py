"""Measures how the error of a run depends on the step, and what `choose_step` makes of it.

For each splitting method: the median error of the angle after 300 s over a map of driven pendula
(the paper's ranges of amplitude and frequency) against a run with a quarter of the finest step,
with the points left out whose motion is chaotic (neighbours at 1e-9 rad part by more than 1e3).
Run ``python benchmarks/steps.py``; prints a table and writes ``steps.json`` beside it.
"""

from __future__ import annotations

import json
import math
import platform
from pathlib import Path

import numpy as np

import latolato as ll
from latolato.numerics.integrate import Start, choose_step, integrate
from latolato.numerics.prepare import choose_stepper, step_for
from latolato.numerics.steppers import BLANES_MOAN_GENERAL

DURATION = 300.0
STEP_ANGLES = (0.4, 0.28, 0.2, 0.14, 0.1)  # step times the fastest rate


def final_angle(system: ll.Pendulum, drive: ll.Harmonic, angle: float, step: float) -> float:
    """Return the angle after `DURATION` [rad]."""
    end = np.array([DURATION])
    start = Start((angle,), (0.0,))
    run = integrate(system, drive, start, end, DURATION, step=step)
    return float(run.samples[0, 0])


def fastest_rate(system: ll.Pendulum, drive: ll.Harmonic, start: Start) -> float:
    """Return the fastest angular rate of a run that is known beforehand [rad/s]."""
    is_rough = choose_stepper(system) is BLANES_MOAN_GENERAL
    return step_for(1.0, 1.0, is_rough) / choose_step(system, drive, start, 1.0)


def points(count: int = 6) -> list[ll.Harmonic]:
    """Return drives over the paper's ranges, A0 in (0, 0.5] m and ratio in (0, 5]."""
    w0 = math.sqrt(9.8)
    return [
        ll.Harmonic(drive_amplitude=float(a), drive_frequency=float(ratio) * w0)
        for a in np.linspace(0.5 / count, 0.5, count)
        for ratio in np.linspace(5.0 / count, 5.0, count)
    ]


def measure(system: ll.Pendulum) -> list[dict[str, float]]:
    """Return the median error at each step size."""
    errors: list[list[float]] = []
    for drive in points():
        start = Start((0.1,), (0.0,))
        rate = fastest_rate(system, drive, start)
        fine = STEP_ANGLES[-1] / 4.0 / rate
        exact = final_angle(system, drive, 0.1, fine)
        if abs(final_angle(system, drive, 0.1 + 1e-9, fine) - exact) > 1e-6:
            continue  # chaotic: no error of a single run means anything there
        errors.append([abs(final_angle(system, drive, 0.1, s / rate) - exact) for s in STEP_ANGLES])
    table = np.array(errors)
    shares = np.percentile(table, [50, 90], axis=0).T
    return [
        {
            "step_angle": s,
            "median_error": float(half),
            "error_of_90_percent": float(most),
            "points": float(len(table)),
        }
        for s, (half, most) in zip(STEP_ANGLES, shares, strict=True)
    ]


def main() -> None:
    """Print and save the tables of both methods."""
    systems = {
        "no drag": ll.Pendulum(length=1.0, mass=0.8),
        "quadratic and Coulomb drag": ll.Pendulum(
            length=1.0, mass=0.8, damping=0.02, quadratic_damping=0.005, coulomb_damping=0.002
        ),
    }
    found = {}
    for name, system in systems.items():
        rows = measure(system)
        found[name] = rows
        logs = np.log([[r["step_angle"], r["median_error"]] for r in rows if r["median_error"] > 0])
        slope = np.polyfit(logs[:, 0], logs[:, 1], 1)[0]
        print(f"{name}: error ~ step^{slope:.2f} over {rows[0]['points']:.0f} regular points")
        for row in rows:
            unit = row["step_angle"] / row["median_error"] ** (1.0 / 6.0)
            print(f"  step {row['step_angle']:.2f}/rate  median error {row['median_error']:.2e}"
                  f"  90 percent below {row['error_of_90_percent']:.2e}"
                  f"  step at unit tolerance {unit:.2f}")  # fmt: skip
        for tolerance in (1e-6, 1e-8, 1e-10):
            drive = points()[20]
            start = Start((0.1,), (0.0,))
            step = choose_step(system, drive, start, tolerance)
            print(f"  tolerance {tolerance:g}: step {step * fastest_rate(system, drive, start):.3f}"
                  "/rate")  # fmt: skip
    machine = {"processor": platform.processor() or platform.machine(), "numpy": np.__version__}
    Path(__file__).with_name("steps.json").write_text(
        json.dumps({"machine": machine, "rows": found}, indent=1)
    )


if __name__ == "__main__":
    main()
