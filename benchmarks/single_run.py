"""One run beside its peers: latolato, SciPy and heyoka, in CPU time at measured errors, in turns.

Work: the toy of Fig. 4 with a push of 0.2 rad, A0 = 0.2 m, both walls, e = 1, for 300 s; its
motion is chaotic, so errors are measured at 20 s and times over 300 s. Also the start-up costs of
the package and of the command line. Needs heyoka and SciPy; prints a table and records ratios.
"""

from __future__ import annotations

import math
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import heyoka as hy
import numpy as np
from scipy.integrate import solve_ivp

import latolato as ll
from latolato.numerics.integrate import Start, choose_step, integrate
from ratios import least_times, record, time_at

TOY = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1)
DRIVE = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
LOW, HIGH = TOY.contact_angle_low, TOY.contact_angle_high
START = LOW + 0.2
LONG, SHORT = 300.0, 20.0
DENSE = 30_000


def own(duration: float, tolerance: float, times: np.ndarray) -> float:
    """Return the angle at the end by latolato's integration alone."""
    start = Start((START,), (0.0,))
    step = choose_step(TOY, DRIVE, start, tolerance)
    run = integrate(TOY, DRIVE, start, times, duration, step=step, rest_speed=1e-7)
    return float(run.samples[0, -1])


def scipy_run(duration: float, tolerance: float, times: np.ndarray) -> float:
    """Return the angle at the end by DOP853 with terminal events, restarted at each contact."""
    rate = TOY.damping / (TOY.mass * TOY.length)
    a, w, g = DRIVE.drive_amplitude, DRIVE.drive_frequency, TOY.gravity

    def slope(t: float, y: np.ndarray) -> list[float]:
        pull = (g - a * w * w * math.cos(w * t)) * math.sin(y[0])
        return [y[1], -rate * y[1] - pull]

    def bottom(t: float, y: np.ndarray) -> float:
        return y[0] - LOW

    def top(t: float, y: np.ndarray) -> float:
        return y[0] - HIGH

    bottom.terminal = top.terminal = True  # type: ignore[attr-defined]
    bottom.direction, top.direction = -1.0, 1.0  # type: ignore[attr-defined]
    t, y = 0.0, np.array([START, 0.0])
    while t < duration:
        wanted = times[(times > t)]
        found = solve_ivp(
            slope, (t, duration), y, "DOP853", wanted, events=[bottom, top], rtol=tolerance,
            atol=tolerance,
        )  # fmt: skip
        if found.status != 1:
            return float(found.y[0, -1])
        walls = [i for i in (0, 1) if len(found.t_events[i])]
        t = float(found.t_events[walls[0]][-1])
        y = np.array([(LOW, HIGH)[walls[0]], -found.y_events[walls[0]][-1][1]])
    return float(y[0])


def make_heyoka(tolerance: float) -> Any:
    """Return a Taylor integrator whose terminal events reflect the ball."""
    x, v = hy.make_vars("x", "v")
    rate = TOY.damping / (TOY.mass * TOY.length)
    a, w, g = DRIVE.drive_amplitude, DRIVE.drive_frequency, TOY.gravity
    slope = -rate * v - (g - a * w * w * hy.cos(w * hy.time)) * hy.sin(x)

    def reflect(ta: Any, direction: int) -> bool:
        ta.state[1] = -ta.state[1]
        return True

    events = [
        hy.t_event(x - LOW, callback=reflect, direction=hy.event_direction.negative),
        hy.t_event(x - HIGH, callback=reflect, direction=hy.event_direction.positive),
    ]
    return hy.taylor_adaptive(
        [(x, v), (v, slope)], [START, 0.0], t_events=events, tol=tolerance, fast_math=True
    )


def heyoka_run(ta: Any, duration: float) -> float:
    """Return the angle at the end by heyoka, without dense output."""
    ta.time = 0.0
    ta.state[:] = [START, 0.0]
    ta.reset_cooldowns()
    ta.propagate_until(duration)
    return float(ta.state[0])


def start_up() -> dict[str, float]:
    """Return wall times of importing and of the warm command line, least of five [s]."""
    importing = [sys.executable, "-c", "import latolato"]
    with tempfile.TemporaryDirectory() as folder:
        simulate = [
            str(Path(sys.executable).with_name("latolato")), "simulate", "fig06_push",
            "--duration", "300", "--output", f"{folder}/run.nc",
        ]  # fmt: skip
        found = {}
        for name, command in (("import latolato", importing), ("latolato simulate", simulate)):
            walls = []
            for _ in range(6):
                begin = time.perf_counter()
                subprocess.run(command, check=True, capture_output=True)
                walls.append(time.perf_counter() - begin)
            found[name] = min(walls)
            found[f"{name}, median"] = statistics.median(walls[1:])
    return found


def main() -> None:
    """Measure, print, record."""
    end, dense = np.array([LONG]), np.linspace(0.0, LONG, DENSE)
    short = np.array([SHORT])
    exact = own(SHORT, 1e-13, short)
    # What is run, at which tolerance, the run of 300 s, and the angle at 20 s.
    rows: list[tuple[str, float, Any, float]] = []
    for tolerance in (1e-6, 1e-8, 1e-10):
        angle = own(SHORT, tolerance, short)
        rows += [
            ("latolato", tolerance, partial(own, LONG, tolerance, end), angle),
            (f"latolato, {DENSE} samples", tolerance, partial(own, LONG, tolerance, dense), angle),
        ]
    for tolerance in (1e-9, 1e-11, 1e-12):
        angle = scipy_run(SHORT, tolerance, short)
        rows.append(("SciPy", tolerance, partial(scipy_run, LONG, tolerance, end), angle))
    for tolerance in (1e-6, 1e-9, 1e-12):
        ta = make_heyoka(tolerance)
        angle = heyoka_run(ta, SHORT)
        rows.append(("heyoka", tolerance, partial(heyoka_run, ta, LONG), angle))
    seconds = least_times(*(action for _, _, action, _ in rows))
    runs: dict[str, list[tuple[float, float]]] = {}
    for (name, tolerance, _, angle), least in zip(rows, seconds, strict=True):
        error = abs(angle - exact)
        runs.setdefault(name, []).append((least, error))
        print(f"{name:24s} {tolerance:7.0e} {1e3 * least:9.2f} ms   error {error:.1e}")
    for name, wall in start_up().items():
        print(f"{name:34s} {wall:9.2f} s wall")
    for error, peers in (("1e-7", ("heyoka", "SciPy")), ("1e-9", ("heyoka",))):
        record(
            f"one run, error {error} rad",
            "the toy of Fig. 4 for 300 s, with impacts; the error is that of the angle at 20 s",
            time_at(float(error), runs["latolato"]),
            {name: time_at(float(error), runs[name]) for name in peers},
        )


if __name__ == "__main__":
    main()
