"""What derivatives with respect to parameters cost: the time of a run with them over one without.

Runs with and without take turns, and the least CPU time of each counts. The
engine's share is that of the integration alone, with the directions ready; preparing these takes
the same time for every duration. The aim is at most ``1 + 0.6 n`` for n parameters. Prints a table
and writes ``sensitivities.json`` beside itself.
"""

from __future__ import annotations

import json
import math
import platform
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import latolato as ll
from latolato.numerics.integrate import integrate
from latolato.simulation.plan import RunPlan, make_run_plan
from latolato.simulation.run import run_plan
from latolato.simulation.sensitivity import batches_of, directions_of

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
AIM = 0.6


def ratio_of(plain: Callable[[], Any], other: Callable[[], Any], repeats: int) -> float:
    """Return how much longer `other` takes than `plain`: the least of calls that take turns."""
    least = [math.inf, math.inf]
    for _ in range(repeats):
        for k, action in enumerate((plain, other)):
            begun = time.process_time()
            action()
            least[k] = min(least[k], time.process_time() - begun)
    return least[1] / least[0]


def integrated(plan: RunPlan, directions: Any) -> Any:
    """Return the trajectory of a plan."""
    return integrate(
        plan.system, plan.drive, plan.start, plan.instants, plan.end, law=plan.law, step=plan.step,
        rest_speed=plan.rest_speed, directions=directions,
    )  # fmt: skip


def measured(name: str, duration: float, count: int) -> dict[str, Any]:
    """Return the ratios of one case."""
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
        "whole": ratio_of(lambda: run_plan(plain), lambda: run_plan(plan), repeats),
        "engine": ratio_of(
            lambda: integrated(plan, None), lambda: integrated(plan, directions), repeats
        ),
        "preparation_ms": 1e3 * preparation,
        "aim": 1.0 + AIM * count,
    }


def main() -> None:
    """Measure, print, save."""
    rows = [
        measured(name, duration, count)
        for name in CASES
        for duration in DURATIONS
        for count in COUNTS
    ]
    for row in rows:
        print(
            f"{row['case']:15s} {row['duration']:4g} s {row['parameters']} parameters: "
            f"run {row['whole']:5.2f}, engine {row['engine']:5.2f}, aim {row['aim']:.1f}; "
            f"preparation {row['preparation_ms']:.1f} ms"
        )
    machine = {
        "processor": platform.processor() or platform.machine(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("latolato", "numpy", "numba")},
    }
    Path(__file__).with_name("sensitivities.json").write_text(
        json.dumps({"machine": machine, "rows": rows}, indent=1)
    )


if __name__ == "__main__":
    main()
