"""Sweeps beside their peers: latolato's lanes, heyoka's batches and SciPy, at measured errors.

Work: a grid of 32 x 32 points, A0 in (0, 0.5] m, frequency ratio in (0, 5], l = 1 m, m = 0.8 kg,
300 s: (a) free from the contact angle at rest, (b) both walls, e = 1, from 0.2 rad above the
contact angle, (c) as (b) with e = 0.9 and C = 0.02. One thread, CPU time per trajectory,
compilation excluded; latolato and heyoka take turns. The error is the median of the final angle's
over the points whose motion is regular: a tight run of latolato and, in (a) and (b), one of heyoka
agree there to 1e-7.

heyoka runs at its best: batches of its recommended width with points of one frequency, fast_math,
terminal events with a callback in (b). It cannot do (c), whose bounces come to rest. SciPy's DOP853
runs at a few regular points. Prints tables and records the ratios.

With observables means mean_energy, crossings and final_angle, beside heyoka's end alone.

``python benchmarks/sweep.py [--points N] [--cases free,walls] [--lanes] [--sizes] [--scaling]
[--map]``
"""

from __future__ import annotations

import argparse
import math
import resource
import statistics
import subprocess
import sys
import time
from functools import partial
from typing import Any

import heyoka as hy
import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import latolato as ll
import latolato.numerics.jit  # makes formulas known to numba
from latolato.core.scalar import sine
from latolato.numerics import kernels, shipped
from latolato.sweeps.batches import run_fastest, run_scalar
from latolato.sweeps.chunk import run_chunk
from latolato.sweeps.plan import Plan, make_plan
from latolato.sweeps.points import stepper_of
from ratios import record, time_at

DURATION = 300.0
RADIUS = 0.1
LOW, HIGH = math.asin(RADIUS), math.pi - math.asin(RADIUS)
GRAVITY = 9.8
REGULAR = 1e-7
TOLERANCES = {
    "own": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9),
    "observed": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9),
    "heyoka": (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12),
    "SciPy": (1e-7, 1e-10),
}
TURNS = 3
OBSERVED = ("mean_energy", "crossings", "final_angle")
CASES: dict[str, dict[str, Any]] = {
    "free": {"damping": 0.0, "restitution": 1.0, "start": LOW, "walls": False},
    "walls": {"damping": 0.0, "restitution": 1.0, "start": LOW + 0.2, "walls": True},
    "damped": {"damping": 0.02, "restitution": 0.9, "start": LOW + 0.2, "walls": True},
}


def grid(points: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return amplitudes [m] and frequency ratios."""
    share = np.arange(1, points + 1) / points
    return 0.5 * share, 5.0 * share


def plan_of(case: str, points: int, tolerance: float, **options: Any) -> Plan:
    """Return the plan of a case."""
    c = CASES[case]
    amplitudes, ratios = grid(points)
    body = {"length": 1.0, "mass": 0.8, "damping": c["damping"]}
    system: Any = ll.Pendulum(**body)
    if c["walls"]:
        system = ll.LatoLato(**body, radius=RADIUS, restitution=c["restitution"])
    given = {
        "axes": {"drive_amplitude": amplitudes, "frequency_ratio": ratios},
        "duration": DURATION,
        "observables": ["final_angle"],
        "initial_angle": c["start"],
        "tolerance": tolerance,
        "chunk_size": points * points,
    }
    return make_plan(system, None, **(given | options))


def own(plan: Plan, runner: Any = run_fastest, repeats: int = 3) -> tuple[float, Any, int]:
    """Return CPU time per trajectory [s], the values, and the number of contacts."""
    best, contacts, values = math.inf, 0, None
    warm = False

    def run_points(plan: Plan, batch: Any, stepper: Any, order: Any, progress: Any) -> None:
        nonlocal best, contacts, warm
        if not warm:  # compile, or load what was compiled
            states = progress.states.copy()
            runner(plan, batch, stepper, order[-1:], progress)
            progress.states[:] = states
            warm = True
        begin = time.process_time()
        runner(plan, batch, stepper, order, progress)
        best = min(best, time.process_time() - begin)
        contacts = int(progress.states["contacts"].sum())

    for _ in range(repeats):
        values, _ = run_chunk(plan, 0, run_points)
    return best / plan.size, values, contacts


def heyoka_batch(case: str, tolerance: float) -> Any:
    """Return heyoka's batch integrator of a case: parameters are A0 w^2 and w."""
    x, v = hy.make_vars("x", "v")
    slope = -(GRAVITY - hy.par[0] * hy.cos(hy.par[1] * hy.time)) * hy.sin(x)
    width = hy.recommended_simd_size()
    events = []
    if CASES[case]["walls"]:

        def reflect(ta: Any, direction: int, lane: int) -> bool:
            ta.state[1, lane] = -ta.state[1, lane]
            return True

        events = [
            hy.t_event_batch(x - LOW, callback=reflect, direction=hy.event_direction.negative),
            hy.t_event_batch(x - HIGH, callback=reflect, direction=hy.event_direction.positive),
        ]
    return hy.taylor_adaptive_batch(
        [(x, v), (v, slope)],
        np.zeros((2, width)),
        t_events=events,
        pars=np.zeros((2, width)),
        tol=tolerance,
        fast_math=True,
    )


def heyoka_sweep(
    case: str, points: int, tolerance: float, ta: Any
) -> tuple[float, NDArray[np.float64]]:
    """Return CPU time per trajectory [s] and the final angles."""
    amplitudes, ratios = grid(points)
    width = ta.batch_size
    found = np.empty((points, points))
    begin = time.process_time()
    for column, ratio in enumerate(ratios):
        w = ratio * math.sqrt(GRAVITY)
        for first in range(0, points, width):
            rows = np.minimum(np.arange(first, first + width), points - 1)
            ta.set_time(0.0)
            ta.state[0], ta.state[1] = CASES[case]["start"], 0.0
            ta.pars[0], ta.pars[1] = amplitudes[rows] * w * w, w
            if CASES[case]["walls"]:
                ta.reset_cooldowns()
            ta.propagate_until(DURATION)
            found[rows, column] = ta.state[0]
    return (time.process_time() - begin) / (points * points), found


def scipy_point(case: str, amplitude: float, ratio: float, tolerance: float) -> tuple[float, float]:
    """Return CPU time [s] and the final angle of DOP853 with terminal events."""
    w = ratio * math.sqrt(GRAVITY)
    lift = amplitude * w * w

    def slope(t: float, y: NDArray[np.float64]) -> list[float]:
        return [y[1], -(GRAVITY - lift * math.cos(w * t)) * math.sin(y[0])]

    def bottom(t: float, y: NDArray[np.float64]) -> float:
        return float(y[0]) - LOW

    def top(t: float, y: NDArray[np.float64]) -> float:
        return float(y[0]) - HIGH

    bottom.terminal = top.terminal = True  # type: ignore[attr-defined]
    bottom.direction, top.direction = -1.0, 1.0  # type: ignore[attr-defined]
    events = [bottom, top] if CASES[case]["walls"] else []
    t, y = 0.0, [CASES[case]["start"], 0.0]
    begin = time.process_time()
    while t < DURATION:
        run = solve_ivp(
            slope, (t, DURATION), y, "DOP853", [], events=events, rtol=tolerance, atol=tolerance
        ) if events else solve_ivp(
            slope, (t, DURATION), y, "DOP853", [DURATION], rtol=tolerance, atol=tolerance
        )  # fmt: skip
        if run.status != 1:
            if events:  # the end was not asked for before it was known that no event comes
                run = solve_ivp(
                    slope, (t, DURATION), y, "DOP853", [DURATION], rtol=tolerance, atol=tolerance
                )
            return time.process_time() - begin, float(run.y[0, -1])
        wall = 0 if len(run.t_events[0]) else 1
        t = float(run.t_events[wall][-1])
        y = [(LOW, HIGH)[wall], -float(run.y_events[wall][-1][1])]
    return time.process_time() - begin, float(y[0])


def compare(case: str, points: int) -> None:
    """Print the times and errors of each code for one case, and record the ratios."""
    _, tight, _ = own(plan_of(case, points, 1e-13), repeats=1)
    reference = tight["final_angle"]
    peer = case != "damped"
    if peer:
        _, other = heyoka_sweep(case, points, 1e-15, heyoka_batch(case, 1e-15))
    else:
        _, loose, _ = own(plan_of(case, points, 1e-12), repeats=1)
        other = loose["final_angle"]
    regular = abs(reference - other) < REGULAR
    contacts = own(plan_of(case, points, 1e-9), repeats=1)[2] / points**2
    print(f"\n({case}) {regular.sum()} regular points, {contacts:.0f} contacts each")

    def run_own(plan: Plan) -> tuple[float, NDArray[np.float64]]:
        seconds, values, _ = own(plan, repeats=1)
        return seconds, values["final_angle"]

    codes: dict[tuple[str, float], Any] = {}
    for name, asked in (("own", ("final_angle",)), ("observed", OBSERVED)):
        for tolerance in TOLERANCES[name]:
            plan = plan_of(case, points, tolerance, observables=asked)
            codes[name, tolerance] = partial(run_own, plan)
    if peer:
        for tolerance in TOLERANCES["heyoka"]:
            ta = heyoka_batch(case, tolerance)
            codes["heyoka", tolerance] = partial(heyoka_sweep, case, points, tolerance, ta)
    runs: dict[str, list[tuple[float, float]]] = {}
    for (name, tolerance), turns in in_turns(codes).items():
        seconds = min(seconds for seconds, _ in turns)
        error = float(np.median(abs(turns[-1][1] - reference)[regular]))
        runs.setdefault(name, []).append((seconds, error))
        show(name, tolerance, seconds, error)
    if not peer:
        return
    amplitudes, ratios = grid(points)
    places = np.argwhere(regular)[:: max(1, int(regular.sum()) // 8)][:8]
    for tolerance in TOLERANCES["SciPy"]:
        alone = [scipy_point(case, amplitudes[i], ratios[j], tolerance) for i, j in places]
        errors = [abs(a - reference[i, j]) for (_, a), (i, j) in zip(alone, places, strict=True)]
        seconds, error = statistics.mean(s for s, _ in alone), float(np.median(errors))
        runs.setdefault("SciPy", []).append((seconds, error))
        show("SciPy", tolerance, seconds, error)
    for text, peers in (("1e-6", ("heyoka", "SciPy")), ("1e-9", ("heyoka",))):
        error = float(text)
        record(
            f"a point of a map, {case}, error {text} rad",
            "300 s, one thread, in lanes; the median error of the final angles",
            time_at(error, runs["own"]),
            {name: time_at(error, runs[name]) for name in peers},
        )
        ratio = time_at(error, runs["heyoka"]) / time_at(error, runs["observed"])
        print(f"  with observables at {text} rad: heyoka takes {ratio:.2g} times as long")


def in_turns(codes: dict[tuple[str, float], Any]) -> dict[tuple[str, float], list[Any]]:
    """Return what each code gives in each of `TURNS` turns."""
    turns = [{key: run() for key, run in codes.items()} for _ in range(TURNS)]
    return {key: [turn[key] for turn in turns] for key in codes}


def show(name: str, tolerance: float, seconds: float, error: float) -> None:
    """Print a row of a table."""
    print(
        f"  {name:8} tolerance {tolerance:7.0e}  {1e3 * seconds:9.4f} ms  median error {error:.1e}"
    )


def sizes() -> dict[str, float]:
    """Return CPU time per trajectory [us] of small and large grids at tolerance 1e-6."""
    found = {}
    for case in ("free", "walls"):
        for points in (32, 64, 400):
            for words, asked in (("the end", ("final_angle",)), ("observables", OBSERVED)):
                plan = plan_of(case, points, 1e-6, observables=asked)
                seconds = own(plan, repeats=1 if points > 64 else 3)[0]
                found[f"{case}, {points} x {points}, {words}"] = 1e6 * seconds
    return found


def few() -> dict[str, float]:
    """Return CPU time [ms] of sweeps of few points, every so many of a grid, at tolerance 1e-6."""
    found = {}
    for case in ("free", "walls"):
        plan = plan_of(case, 32, 1e-6)
        for count in (1, 8, 32, 128, plan.size):

            def run_some(plan: Plan, batch: Any, *rest: Any, count: int = count) -> None:
                stepper, order, progress = rest
                some = np.ascontiguousarray(order[:: plan.size // count])
                run_fastest(plan, batch, stepper, some, progress)

            found[f"{case}, {count} points"] = 1e3 * plan.size * own(plan, run_some)[0]
    return found


def own_tuning(points: int) -> dict[str, float]:
    """Return how much faster lanes are than without their tuning, at equal bits.

    They are compiled as for the processor itself and as `shipped.tuned_for_lanes` has it, in turns.
    """
    tuned, times = shipped.tuned_for_lanes, {}
    cases = [(case, tolerance) for case in ("free", "walls") for tolerance in (1e-6, 1e-9)]
    try:
        for repeat in range(3):
            for words, chosen in (("own", lambda processor: processor), ("tuned", tuned)):
                shipped.tuned_for_lanes = chosen
                shipped._this_machine.cache_clear()
                kernels._kernel.cache_clear()
                for case, tolerance in cases:
                    plan = plan_of(case, points, tolerance, observables=OBSERVED)
                    seconds, values, _ = own(plan, repeats=1)
                    key = case, tolerance, words
                    times[key] = min(times.get(key, math.inf), seconds)
                    if repeat == 0:
                        times[key, "bits"] = b"".join(values[name].tobytes() for name in values)
    finally:
        shipped.tuned_for_lanes = tuned
    for key in cases:
        assert times[(*key, "own"), "bits"] == times[(*key, "tuned"), "bits"]
    return {
        f"{case}, {tolerance:g}": times[case, tolerance, "own"] / times[case, tolerance, "tuned"]
        for case, tolerance in cases
    }


def threads(points: int) -> dict[str, float]:
    """Return wall time of a sweep with one and with two threads, and their ratio."""
    found = {}
    for workers in (1, 2):
        plan = plan_of("walls", points, 1e-6, chunk_size=max(256, points * points // 16))
        best = math.inf
        for _ in range(3):
            begin = time.perf_counter()
            ll.sweep(
                plan.system, axes={a.name: a.values[0] for a in plan.axes}, duration=DURATION,
                observables=plan.observables, initial_angle=LOW + 0.2, tolerance=1e-6,
                chunk_size=plan.chunk_size, workers=workers,
            )  # fmt: skip
            best = min(best, time.perf_counter() - begin)
        found[f"{workers} thread{'s' if workers > 1 else ''} [s]"] = best
    found["gain"] = found["1 thread [s]"] / found["2 threads [s]"]
    return found


_SCALE = """
import pathlib, sys, tempfile, time
import numpy as np
import latolato as ll
import latolato.numerics.jit  # makes formulas known to numba

side, store, duration = int(sys.argv[1]), sys.argv[2] == "store", float(sys.argv[3])
toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
options = dict(
    duration=duration, observables=["largest_angle"], initial_offset=0.2, tolerance=1e-6
)
ll.sweep(toy, axes={"drive_amplitude": [0.1], "frequency_ratio": [2.0]}, **options)
share = np.arange(1, side + 1) / side
with tempfile.TemporaryDirectory() as folder:
    begin = time.process_time()
    ll.sweep(
        toy, axes={"drive_amplitude": 0.5 * share, "frequency_ratio": 5.0 * share}, workers=2,
        store=pathlib.Path(folder) / "map.zarr" if store else None, **options,
    )
    seconds = time.process_time() - begin
peak = pathlib.Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]
print(seconds, float(peak) / 1e6)
"""


def scaling(counts: tuple[int, ...], duration: float, store: bool) -> None:
    """Print CPU time per point and peak memory of sweeps of growing size, each in a process."""
    for count in counts:
        side = math.isqrt(count)
        words = [sys.executable, "-c", _SCALE, str(side), "store" if store else "no", str(duration)]
        text = subprocess.run(words, check=True, capture_output=True, text=True).stdout
        seconds, memory = map(float, text.split())
        print(f"  {side**2} points: {1e6 * seconds / side**2:.3g} us a point, {memory:.2f} GB")


def big_map(points: int) -> dict[str, float]:
    """Return points and impacts per second of a map with walls over 300 s on all processors."""
    plan = plan_of("walls", points, 1e-6, chunk_size=4096)
    begin = time.perf_counter()
    result = ll.sweep(
        plan.system, axes={a.name: a.values[0] for a in plan.axes}, duration=DURATION,
        observables=["bottom_contacts", "top_contacts"], initial_angle=LOW + 0.2, tolerance=1e-6,
    )  # fmt: skip
    seconds = time.perf_counter() - begin
    impacts = float((result.bottom_contacts + result.top_contacts).sum())
    return {
        "points": points * points,
        "points per second": points * points / seconds,
        "impacts per second": impacts / seconds,
    }


def make_by_hand() -> Any:
    """Return a kernel written for the free pendulum alone: no laws, events, stops or refills."""
    lanes = 128

    @numba.njit(error_model="numpy", fastmath={"contract"})
    def by_hand(x, v, g, c, d, table, kicks, steps):  # type: ignore[no-untyped-def]
        s = np.empty(lanes)
        for j in range(lanes):
            s[j] = sine(x[j])
        stages = table.shape[0]
        for _ in range(steps):
            for i in range(stages):
                b = kicks[i]
                reach, cos, sin = table[i, 0], table[i, 1], table[i, 2]
                for j in range(lanes):
                    v[j] += b * (g[j] + c[j] * cos[j] - d[j] * sin[j]) * s[j]
                    x[j] += v[j] * reach[j]
                    s[j] = sine(x[j])
            b = kicks[stages]
            for j in range(lanes):
                cos, sin = table[stages - 1, 3, j], table[stages - 1, 4, j]
                c[j], d[j] = c[j] * cos - d[j] * sin, d[j] * cos + c[j] * sin
                v[j] += b * (g[j] + c[j]) * s[j]

    return by_hand


def against_hand(points: int) -> dict[str, float]:
    """Return the time per stage of the composed kernel over that of one written by hand."""
    plan = plan_of("free", points, 1e-6)
    stepper = stepper_of(plan)
    steps_of_all = 0.0

    def count(plan: Plan, batch: Any, stepper: Any, order: Any, progress: Any) -> None:
        nonlocal steps_of_all
        steps_of_all = float((DURATION / batch.points.settings["step"]).sum())

    run_chunk(plan, 0, count)
    by_hand, lanes, steps = make_by_hand(), 128, 5000
    amplitude, w = np.linspace(0.01, 0.5, lanes), np.linspace(0.1, 15.0, lanes)
    h = 0.05
    nodes = np.concatenate([[0.0], stepper.nodes])
    table = np.zeros((len(stepper.drifts), 5, lanes))
    table[:, 0] = stepper.drifts[:, None]
    for row, turn in ((1, nodes[:-1, None] * h * w), (3, nodes[1:, None] * h * w)):
        table[:, row], table[:, row + 1] = np.cos(turn), np.sin(turn)
    best = math.inf
    for repeat in range(6):
        x, v = np.full(lanes, 0.1), np.zeros(lanes)
        g, c, d = np.full(lanes, -h * h * GRAVITY), h * h * amplitude * w * w, np.zeros(lanes)
        begin = time.process_time()
        by_hand(x, v, g, c, d, table, stepper.kicks, steps if repeat else 1)
        if repeat:
            best = min(best, time.process_time() - begin)
    hand = best / (lanes * steps)
    composed_time = min(own(plan)[0] for _ in range(2)) * plan.size / steps_of_all
    return {
        "composed [ns per step]": 1e9 * composed_time,
        "by hand [ns per step]": 1e9 * hand,
        "ratio": composed_time / hand,
    }


def composed(points: int) -> dict[str, float]:
    """Return CPU time per trajectory of lanes and of single trajectories [ms]."""
    found = {}
    for case in CASES:
        plan = plan_of(case, points, 1e-6)
        found[f"{case}, lanes"] = 1e3 * own(plan)[0]
        found[f"{case}, one by one"] = 1e3 * own(plan, run_scalar, 1)[0]
    return found


def lanes(points: int) -> None:
    """Print what lanes gain, and what they cost beside other ways to run the same points."""
    print("\nlanes beside single trajectories, tolerance 1e-6 [ms]:", composed(points))
    print("composed beside written by hand, free:", against_hand(points))
    print("sweeps of few points [ms]:", few())
    here = shipped.this_processor()
    print(f"lanes tuned for {shipped.tuned_for_lanes(here).name} beside {here.name}:",
          own_tuning(points))  # fmt: skip
    print("two threads:", threads(max(points, 80)))


def main() -> None:
    """Run what was asked for, print and record it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=32, help="points along each axis")
    parser.add_argument("--cases", default="free,walls,damped")
    parser.add_argument("--lanes", action="store_true", help="also what lanes gain and cost")
    parser.add_argument("--sizes", action="store_true", help="also 32 x 32 and 400 x 400 points")
    parser.add_argument("--scaling", action="store_true", help="also cost and memory against size")
    parser.add_argument("--map", action="store_true", help="also a map of 400 x 400 points")
    options = parser.parse_args()
    for case in options.cases.split(","):
        compare(case, options.points)
    if options.lanes:
        lanes(options.points)
    if options.sizes:
        print("microseconds per trajectory:", sizes())
    if options.scaling:
        print("cost against size, 100 s with walls, in memory:")
        scaling((1_000, 10_000, 100_000, 1_000_000), 100.0, False)
        print("10 million short trajectories (1 s) into a store:")
        scaling((10_000_000,), 1.0, True)
    if options.map:
        print("400 x 400 with walls, 300 s:", big_map(400))
    print(f"peak memory here {resource.getrusage(0).ru_maxrss / 1e6:.2f} GB")


if __name__ == "__main__":
    main()
