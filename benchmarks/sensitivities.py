"""What derivatives with respect to parameters cost: the time of a run with them over one without.

Runs with and without take turns, and the least CPU time of each counts. The
engine's share is that of the integration alone, with the directions ready; preparing these takes
the same time for every duration. The aim is at most ``1 + 0.6 n`` for n parameters. Prints a table
and records the ratios of runs of 300 s with four parameters.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import latolato as ll
from latolato.numerics.integrate import integrate
from latolato.simulation.plan import RunPlan, make_run_plan
from latolato.simulation.run import run_plan
from latolato.simulation.sensitivity import batches_of, directions_of
from ratios import least_times, record

DRIVE = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.05)
OTHER = ll.Ball(length=0.95, mass=0.5, radius=0.08, damping=0.02)
ONE = ["length", "damping", "drive_amplitude", "drive_frequency", "initial_angle", "gravity",
       "drive_phase", "initial_angular_velocity"]  # fmt: skip
TWO = ["right_length", "right_damping", "drive_amplitude", "drive_frequency", "initial_angle_left",
       "gravity", "drive_phase", "left_mass"]  # fmt: skip
# System, drive, start and parameters of each case.
CASES: dict[str, tuple[Any, Any, dict[str, Any], list[str]]] = {
    "single swing": (
        ll.Pendulum(length=1.0, mass=0.8, damping=0.05), DRIVE, {"initial_angle": 0.8}, ONE,
    ),
    "colliding pair": (
        ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.05, restitution=0.9), DRIVE,
        {"initial_angle": 0.8}, ONE,
    ),
    "two balls": (
        ll.BallPair(right=BALL, left=OTHER, restitution=0.9), DRIVE,
        {"initial_angle": (0.8, -0.5)}, TWO,
    ),
    "string, taut": (
        ll.Pendulum(length=1.0, mass=0.8, damping=0.05, suspension="string"), DRIVE,
        {"initial_angle": 0.8}, ONE,
    ),
    "string, slack": (
        ll.Pendulum(length=1.0, mass=0.8, suspension="string", string_restitution=0.9), DRIVE,
        {"initial_angle": 2.2, "initial_angular_velocity": 0.5}, ONE,
    ),
}  # fmt: skip
COUNTS = (1, 2, 4, 8)
DURATIONS = (5.0, 300.0)
RECORDED = (300.0, 4)
AIM = 0.6


def integrated(plan: RunPlan, directions: Any) -> Any:
    """Return the trajectory of a plan."""
    return integrate(
        plan.system, plan.drive, plan.start, plan.instants, plan.end, law=plan.law, step=plan.step,
        rest_speed=plan.rest_speed, directions=directions,
    )  # fmt: skip


def measured(name: str, duration: float, count: int) -> dict[str, Any]:
    """Return the times of one case without and with derivatives [s]."""
    system, drive, start, names = CASES[name]
    times = np.linspace(0.0, duration, 1 + round(10 * duration))
    options = {"times": times, **start}
    plain = make_run_plan(system, drive, **options)
    plan = make_run_plan(system, drive, sensitivity_to=names[:count], **options)
    (parameters,) = batches_of(plan.sensitivity_to)
    directions = directions_of(plan, parameters)
    repeats = 9 if duration > 100.0 else 31
    begun = time.process_time()
    for _ in range(10):
        directions_of(plan, parameters)
    preparation = (time.process_time() - begun) / 10
    return {
        "case": name,
        "duration": duration,
        "parameters": count,
        "whole": least_times(lambda: run_plan(plain), lambda: run_plan(plan), turns=repeats),
        "engine": least_times(
            lambda: integrated(plan, None), lambda: integrated(plan, directions), turns=repeats
        ),
        "preparation_ms": 1e3 * preparation,
        "aim": 1.0 + AIM * count,
    }


def main() -> None:
    """Measure, print, record."""
    rows = [
        measured(name, duration, count)
        for name in CASES
        for duration in DURATIONS
        for count in COUNTS
    ]
    for row in rows:
        (plain, whole), (without, engine) = row["whole"], row["engine"]
        print(
            f"{row['case']:15s} {row['duration']:4g} s {row['parameters']} parameters: "
            f"run {whole / plain:5.2f}, engine {engine / without:5.2f}, aim {row['aim']:.1f}; "
            f"preparation {row['preparation_ms']:.1f} ms"
        )
        if (row["duration"], row["parameters"]) == RECORDED:
            record(
                f"one run, {row['case']}", "300 s, sampled ten times a second", plain,
                {"the run with four derivatives": whole},
            )  # fmt: skip


if __name__ == "__main__":
    main()
