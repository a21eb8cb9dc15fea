"""WebAssembly in Node.js beside native code: one run, and a map in lanes, from the same memory.

Work: the toy of Fig. 4 with a push of 0.2 rad, A0 = 0.2 m, both walls, e = 1, for 300 s at
tolerance 1e-10; and 24 x 24 points of a map without drag, 300 s each at tolerance 1e-6, with the
final angle and with eight observables. Native code and Node.js take turns; each time is the least
of all. Prints a table and records the ratios.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import latolato as ll
from latolato.numerics.integrate import Start, choose_step, integrate
from latolato.sweeps.batches import run_fastest
from latolato.sweeps.chunk import run_chunk
from latolato.sweeps.plan import make_plan

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "shared"))
from in_node import MODULES, Case, in_node, points_case, record_run
from ratios import record

TOY = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1)
DRIVE = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
LONG = 300.0
SAMPLES = np.linspace(0.0, LONG, 30_000)
TURNS, REPEATS = 5, 3
SIDE = 24
SEVERAL = (
    "mean_energy", "crossings", "largest_angle", "bottom_contacts", "top_contacts",
    "impact_speed", "energy_ledger", "final_angle",
)  # fmt: skip


def one_run() -> tuple[Callable[[], None], Case]:
    """Return a native run and the same for Node.js."""
    start = TOY.contact_angle_low + 0.2
    began = Start((start,), (0.0,))
    step = choose_step(TOY, DRIVE, began, 1e-10)

    def native() -> None:
        integrate(TOY, DRIVE, began, SAMPLES, LONG, step=step, rest_speed=1e-6)

    return native, record_run(TOY, DRIVE, initial_angle=start, times=SAMPLES, duration=LONG)


def points(system: ll.LatoLato, observables: tuple[str, ...]) -> tuple[Callable[[], None], Case]:
    """Return what runs a map natively, and the same for Node.js."""
    share = (np.arange(SIDE) + 0.5) / SIDE
    plan = make_plan(
        system, None, axes={"drive_amplitude": 0.5 * share, "frequency_ratio": 5.0 * share},
        duration=LONG, observables=observables, initial_angle=math.asin(0.1) + 0.2,
        tolerance=1e-6, chunk_size=SIDE**2,
    )  # fmt: skip
    cases: list[Case] = []
    run_chunk(plan, 0, lambda *batch: cases.append(points_case(*batch, in_lanes=True)))
    return lambda: run_chunk(plan, 0, run_fastest) and None, cases[0]


def measure(native: Callable[[], None], case: Case) -> tuple[float, float]:
    """Return the least seconds of native code and of Node.js."""
    case.repeats = REPEATS
    here, there = math.inf, math.inf
    native()
    for _ in range(TURNS):
        for _ in range(REPEATS):
            begin = time.perf_counter()
            native()
            here = min(here, time.perf_counter() - begin)
        (found,) = in_node([case])
        there = min(there, found["seconds"])
    return here, there


def main() -> None:
    """Measure, print, record."""
    elastic = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    work = {
        "a run with samples": ("300 s with impacts, 30,000 samples", 1, one_run()),
        "a point of a map": (
            "300 s with impacts, in lanes", SIDE**2, points(elastic, ("final_angle",)),
        ),
        "a point, eight observables": (
            "300 s with impacts, in lanes", SIDE**2, points(elastic, SEVERAL),
        ),
        "a point with drag": (
            "300 s with impacts, in lanes, eight observables", SIDE**2, points(TOY, SEVERAL),
        ),
    }  # fmt: skip
    for name, (meaning, count, (native, case)) in work.items():
        here, there = measure(native, case)
        record(name, meaning, here / count, {"WebAssembly in Node.js": there / count})
    sizes = {path.stem: path.stat().st_size for path in sorted(MODULES.glob("*.wasm"))}
    print("sizes in bytes:", sizes)


if __name__ == "__main__":
    main()
