"""Analyses: what a map of Lyapunov exponents costs beside a plain one, branches and multipliers.

Work: (a) the largest Lyapunov exponent over a 60 x 60 grid, A0 in (0, 0.5] m, frequency ratio in
(0, 5], l = 1 m, m = 0.8 kg, r = 0.1 m, e = 0.9, C = 0.02, start 0.2 rad above the contact angle,
300 s, tolerance 1e-6, beside the same sweep that keeps the final angle only; at most 8 times its
time is asked for at 200 x 200 points. (b) 200 points of the softening branch of Fig. 11, downwards
from 2.4 natural frequencies; at most 5 s are asked for. (c) the Floquet multipliers of one orbit on
it, checks included. One thread, CPU time, compilation excluded. Prints a table and records the
ratio of the maps.

``python benchmarks/analysis.py [--points N]``
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import latolato as ll
from latolato.sweeps.batches import run_fastest
from latolato.sweeps.chunk import run_chunk
from latolato.sweeps.plan import make_plan
from ratios import least_times, record

MAPPED = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, damping=0.00506, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.4 * TOY.natural_frequency)
GUESS = {"initial_angle": 0.3, "initial_angular_velocity": 1.0}


def of_map(points: int, observable: str) -> float:
    """Return the CPU time per trajectory of a sweep in one chunk [s]; a first one may compile."""
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
    seconds = 0.0

    def run_points(*arguments: Any) -> None:
        nonlocal seconds
        begin = time.process_time()
        run_fastest(*arguments)
        seconds = time.process_time() - begin

    run_chunk(plan, 0, run_points)
    return seconds / plan.size


def cpu(action: Callable[[], Any], turns: int = 4) -> tuple[float, Any]:
    """Return the least CPU time of several calls [s], and a result."""
    (seconds,) = least_times(action, turns=turns)
    return seconds, action()


def maps(points: int) -> dict[str, float]:
    """Return both times per trajectory [ms] and their ratio; the maps take turns."""
    names = ("final_angle", "lyapunov_exponent")
    turns = [[of_map(points, name) for name in names] for _ in range(4)]
    plain, exponent = map(min, zip(*turns, strict=True))
    record(
        "a point of a damped map", "300 s with impacts, e = 0.9, one thread, in lanes", plain,
        {"the point with its Lyapunov exponent": exponent},
    )  # fmt: skip
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
    """Run everything, print and record it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=60, help="points along each axis of the maps")
    points = parser.parse_args().points
    results: dict[str, Any] = {
        "maps": maps(points),
        "branch": branch(),
        "floquet": multipliers(),
    }
    for name, found in results.items():
        print(f"{name}:", ", ".join(f"{k} {_short(v)}" for k, v in found.items()))


def _short(value: Any) -> Any:
    """Return a number with four digits, anything else as it is."""
    return f"{value:.4g}" if isinstance(value, float) else value


if __name__ == "__main__":
    main()
