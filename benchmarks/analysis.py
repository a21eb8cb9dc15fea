"""Analyses: what a map of Lyapunov exponents costs beside a plain one, branches and multipliers.

Work: (a) the largest Lyapunov exponent over a 60 x 60 grid, A0 in (0, 0.5] m, frequency ratio in
(0, 5], l = 1 m, m = 0.8 kg, r = 0.1 m, e = 0.9, C = 0.02, start 0.2 rad above the contact angle,
300 s, tolerance 1e-6, beside the same sweep that keeps the final angle only; at most 8 times its
time is asked for at 200 x 200 points. (b) 200 points of the softening branch of Fig. 11, downwards
from 2.4 natural frequencies; at most 5 s are asked for. (c) the Floquet multipliers of one orbit on
it, checks included. One thread, CPU time, compilation excluded. Prints a table and writes
``analysis.json`` beside itself.

``python benchmarks/analysis.py [--points N]``
"""

from __future__ import annotations

import argparse
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
from latolato.sweeps.batches import run_fastest
from latolato.sweeps.chunk import run_chunk
from latolato.sweeps.plan import make_plan

MAPPED = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, damping=0.00506, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.4 * TOY.natural_frequency)
GUESS = {"initial_angle": 0.3, "initial_angular_velocity": 1.0}


def of_map(points: int, observable: str) -> float:
    """Return the CPU time per trajectory of a sweep in one chunk [s]."""
    share = np.arange(1, points + 1) / points
    plan = make_plan(
        MAPPED,
        axes={"drive_amplitude": 0.5 * share, "frequency_ratio": 5.0 * share},
        duration=300.0,
        observables=[observable],
        initial_offset=0.2,
        tolerance=1e-6,
        chunk_size=points * points,
    )
    best = math.inf

    def run_points(*arguments: Any) -> None:
        nonlocal best
        begin = time.process_time()
        run_fastest(*arguments)
        best = min(best, time.process_time() - begin)

    for _ in range(3):  # the first one compiles, or loads what was compiled
        run_chunk(plan, 0, run_points)
    return best / plan.size


def cpu(action: Callable[[], Any], repeats: int = 3) -> tuple[float, Any]:
    """Return the least CPU time of several calls [s], after one more, and the last result."""
    least, result = math.inf, action()
    for _ in range(repeats):
        begin = time.process_time()
        result = action()
        least = min(least, time.process_time() - begin)
    return least, result


def maps(points: int) -> dict[str, float]:
    """Return both times per trajectory [ms] and their ratio."""
    plain, exponent = (of_map(points, name) for name in ("final_angle", "lyapunov_exponent"))
    return {
        "plain [ms]": 1e3 * plain,
        "Lyapunov [ms]": 1e3 * exponent,
        "ratio": exponent / plain,
        "200 x 200 Lyapunov [s]": exponent * 200 * 200,
    }


def branch() -> dict[str, Any]:
    """Return the time of a branch [s], its points and its fold."""
    seconds, found = cpu(
        lambda: ll.analysis.continue_orbit(
            TOY, DRIVE, low=1.0, high=3.0, direction="down", points=200, **GUESS
        )
    )
    fold = found.special_value.values[found.special_kind.values == "fold"]
    return {"seconds": seconds, "points": found.sizes["point"], "fold": fold.tolist()}


def multipliers() -> dict[str, Any]:
    """Return the time of one call of `floquet` [ms] and what it says."""
    seconds, found = cpu(lambda: ll.analysis.floquet(TOY, DRIVE, **GUESS), 20)
    sizes = np.abs(found.multipliers.values).tolist()
    return {"ms": 1e3 * seconds, "status": found.status.item(), "moduli": sizes}


def main() -> None:
    """Run everything, print it and write it down."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=60, help="points along each axis of the maps")
    points = parser.parse_args().points
    results: dict[str, Any] = {
        "machine": platform.platform(),
        "processor": platform.processor(),
        "versions": {n: version(n) for n in ("latolato", "numba", "numpy", "scipy")},
        "points": points,
        "maps": maps(points),
        "branch": branch(),
        "floquet": multipliers(),
    }
    for name in ("maps", "branch", "floquet"):
        print(f"{name}:", ", ".join(f"{k} {_short(v)}" for k, v in results[name].items()))
    path = Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(results, indent=1))
    print(f"written to {path}")


def _short(value: Any) -> Any:
    """Return a number with four digits, anything else as it is."""
    return f"{value:.4g}" if isinstance(value, float) else value


if __name__ == "__main__":
    main()
