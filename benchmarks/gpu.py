"""Maps on an NVIDIA GPU beside all cores of its host: time, and what agrees.

Work: grids of A0 in (0, 0.5] m and frequency ratio in (0, 5], l = 1 m, m = 0.8 kg, 100 s: (free)
from the contact angle at rest, (walls) both walls, e = 0.9, C = 0.02, (strings) the same toy on
strings, (pair) two unlike balls. Each executor is timed on its second sweep: the first compiles.
Regular motion agrees to rounding; chaos enlarges it, so the share of points within 1e-6 is given.

A kernel takes one to four minutes to compile. Prints a table and writes ``gpu.json`` beside itself
or into the folder of ``--into``; without a device it says so and measures nothing.

``python benchmarks/gpu.py [--points N] [--cases free,walls] [--into FOLDER]``
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numba import cuda

import latolato as ll

BODY = {"length": 1.0, "mass": 0.8, "damping": 0.02}
TOY = {"radius": 0.1, "restitution": 0.9}
ABOVE_CONTACT = 0.2
CASES: dict[str, tuple[Any, dict[str, Any]]] = {
    "free": (ll.Pendulum(length=1.0, mass=0.8), {"initial_angle": 0.1}),
    "walls": (ll.LatoLato(**BODY, **TOY), {"initial_offset": ABOVE_CONTACT}),
    "strings": (
        ll.LatoLato(**BODY, **TOY, suspension="string", string_restitution=0.5),
        {"initial_offset": ABOVE_CONTACT},
    ),
    "pair": (
        ll.BallPair(
            right=ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.02),
            left=ll.Ball(length=0.9, mass=0.5, radius=0.1, damping=0.02),
            restitution=0.9,
        ),
        {"initial_angle": (0.4, -0.4)},
    ),
}


def swept(case: str, points: int, executor: str) -> xr.Dataset:
    """The map of a case."""
    system, start = CASES[case]
    share = np.arange(1, points + 1) / points
    result: xr.Dataset = ll.sweep(
        system,
        axes={"drive_amplitude": 0.5 * share, "frequency_ratio": 5.0 * share},
        duration=100.0,
        observables=["largest_angle", "mean_energy", "crossings"],
        executor=executor,
        **start,
    )
    return result


def timed(case: str, points: int, executor: str) -> tuple[float, float, xr.Dataset]:
    """Seconds of a first and of a second sweep, and the map."""
    seconds = []
    for _ in range(2):
        begin = time.perf_counter()
        result = swept(case, points, executor)
        seconds.append(time.perf_counter() - begin)
    return seconds[0], seconds[1], result


def main() -> None:
    """Time the cases that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=512)
    parser.add_argument("--cases", default=",".join(CASES))
    parser.add_argument("--into", type=Path, default=Path(__file__).parent)
    arguments = parser.parse_args()
    if not cuda.is_available():
        print("no CUDA device here: nothing to measure")
        return
    device, cores = cuda.get_current_device().name, os.cpu_count()
    print(f"{device} beside {cores} cores, {arguments.points} x {arguments.points} points")
    rows = {}
    for case in arguments.cases.split(","):
        first, second, result = timed(case, arguments.points, "cuda")
        _, threads, expected = timed(case, arguments.points, "threads")
        close = np.isclose(result.largest_angle, expected.largest_angle, rtol=1e-6, atol=1e-6)
        rows[case] = {
            "cuda_first": first,
            "cuda": second,
            "threads": threads,
            "ratio": threads / second,
            "same_status": float((result.status == expected.status).mean()),
            "agree": float(close.mean()),
        }
        print(case, {name: round(value, 4) for name, value in rows[case].items()}, flush=True)
    report = {"device": device, "cores": cores, "points": arguments.points, "cases": rows}
    (arguments.into / "gpu.json").write_text(json.dumps(report, indent=2) + "\n")


if __name__ == "__main__":
    main()
