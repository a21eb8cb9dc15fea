"""Maps as pages compute them, in Node.js with two workers, beside native code on two processors.

Work: the toy of Fig. 5 without drag, both walls, e = 1, 300 s at tolerance 1e-6, amplitude over
frequency: 50 x 50 points (asked for: first picture after 0.3 s, done after 1.5 s), and 200 x 200
(a new picture at least every 0.5 s, done after 20 s). The first picture has every coarse cell.
Both take turns; workers and their modules are new in the first turn, each time is the least of
all. Prints a table and writes ``page_maps.json`` beside itself.

``python benchmarks/page_maps.py [SIZE ...]``
"""

from __future__ import annotations

import json
import math
import platform
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import latolato as ll

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "shared"))
from map_in_node import maps_in_node

BALL = {"length": 1.0, "mass": 0.8, "radius": 0.1}
OBSERVABLES = ("mean_energy", "crossings", "largest_angle")
START = math.asin(0.1) + 0.2
LONG, TOLERANCE, REST_SPEED = 300.0, 1e-6, 1e-6
TURNS = 3
# Cells of the first picture along each axis.
COARSE = {50: 13, 200: 25}


def axes(size: int) -> dict[str, Any]:
    """Return the values along both axes."""
    share = (np.arange(size) + 0.5) / size
    return {"drive_amplitude": 0.5 * share, "frequency_ratio": 5.0 * share}


def native(size: int) -> float:
    """Return how long native code takes [s]."""
    begin = time.perf_counter()
    ll.sweep(
        ll.LatoLato(**BALL), None, axes=axes(size), duration=LONG, observables=OBSERVABLES,
        initial_angle=START, tolerance=TOLERANCE, rest_speed=REST_SPEED,
    )  # fmt: skip
    return time.perf_counter() - begin


def page_plan(size: int) -> dict[str, Any]:
    """Return the same map for a page."""
    y, x = axes(size).items()
    numbers = {"gravity": 9.8, "restitution": 1.0, "meets": 1, "initial_angle": START}
    return {
        "drive": "harmonic",
        "parameters": {**BALL, **numbers, "tolerance": TOLERANCE, "rest_speed": REST_SPEED},
        "x": {"name": x[0], "values": x[1].tolist()},
        "y": {"name": y[0], "values": y[1].tolist()},
        "observables": [{"name": name} for name in OBSERVABLES],
        "duration": LONG,
    }


def pictures(size: int) -> dict[str, float]:
    """Return when the first picture and the last one came, and the longest time between two [s]."""
    (page,) = maps_in_node([page_plan(size)])
    coarse = COARSE[size] ** 2
    at = [0.0, *(picture["seconds"] for picture in page["pictures"])]
    first = next(p["seconds"] for p in page["pictures"] if p["points"] >= coarse)
    return {"first_s": first, "done_s": at[-1], "longest_wait_s": max(np.diff(at))}


def main() -> None:
    """Measure and print."""
    results = {}
    for size in map(int, sys.argv[1:] or COARSE):
        native(size)  # compiled, or loaded
        here, there = [], []
        for _ in range(TURNS):
            here.append(native(size))
            there.append(pictures(size))
        page = {name: min(each[name] for each in there) for name in there[0]}
        ratio = min(each["done_s"] / own for each, own in zip(there, here, strict=True))
        results[size] = {"native_s": min(here), **page, "ratio": ratio}
        print(f"{size} x {size}: native {min(here):.2f} s, page {page['done_s']:.2f} s, ratio "
              f"{ratio:.1f}; first picture {page['first_s']:.2f} s, longest wait "
              f"{page['longest_wait_s']:.2f} s")  # fmt: skip
    about = {"machine": platform.machine(), "maps": results}
    Path(__file__).with_suffix(".json").write_text(json.dumps(about, indent=1))


if __name__ == "__main__":
    main()
