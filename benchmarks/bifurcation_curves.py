"""Curves of bifurcations: what 200 points cost for motions of one, five and ten impacts.

Work: the folds and period doublings of the toy's motions with n impacts a shake (l = 245 mm,
m = 106 g, r = 20 mm, e = 0.85, C = 0.005 kg m/s, first found at 30 mm), and the graze at which the
next impact appears, through amplitude and frequency; at most 10 s are asked for 200 points.
Beside the time stands its ratio to that of as many plain motions over one drive period, made by the
same engine with the same tolerance. One thread, CPU time, compilation excluded. Prints a table and
writes ``bifurcation_curves.json`` beside itself.

``python benchmarks/bifurcation_curves.py [--points N]``
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import latolato as ll
from latolato.analysis.flow import checked_flow, drive_period

TOY = ll.LatoLato(length=0.245, mass=0.106, radius=0.02, restitution=0.85, damping=0.005)
AMPLITUDE = 0.03
LOW, HIGH = (0.005, 0.8), (0.06, 6.0)
# Kind, frequency ratio, initial angle and angular velocity of special points of the branch that
# begins at one impact, by the impacts of the motion there.
BEGINNINGS = (
    (1, "fold", 1.519710813, 1.487750616, 5.838942703),
    (1, "period_doubling", 4.73, 0.0849, 0.658),
    (1, "grazing", 4.572742240, 0.081740712, 0.013200562),
    (5, "fold", 2.942310312, 0.083345194, 0.035488745),
    (5, "period_doubling", 2.946805172, 0.083223042, 0.037219818),
    (5, "grazing", 3.344917269, 0.081790480, 0.012606881),
    (10, "fold", 3.067170646, 0.082100568, 0.016658803),
    (10, "period_doubling", 3.067509007, 0.082093574, 0.016786091),
    (10, "grazing", 3.171704308, 0.081815867, 0.011522942),
)


def main() -> None:
    """Follow every curve, print what it costs and write it down."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=200)
    points = parser.parse_args().points
    rows = [measured(*beginning, points) for beginning in BEGINNINGS]
    results = {
        "processor": processor(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("latolato", "numpy", "numba", "scipy")},
        "curves": rows,
    }
    print(results["processor"])
    for row in rows:
        print(", ".join(f"{name} {_short(value)}" for name, value in row.items()))
    path = Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(results, indent=1))
    print(f"written to {path}")


def measured(
    impacts: int, kind: str, ratio: float, angle: float, velocity: float, points: int
) -> dict[str, Any]:
    """Return the time of a curve [s], its points and ends, and the ratio to plain motions."""
    drive = ll.Harmonic(drive_amplitude=AMPLITUDE, drive_frequency=ratio * TOY.natural_frequency)
    start = {"initial_angle": angle, "initial_angular_velocity": velocity}

    def follow(most: int) -> tuple[float, Any]:
        begin = time.process_time()
        curve = ll.analysis.bifurcation_curve(
            TOY, drive, kind=kind, low=LOW, high=HIGH, points=most, **start
        )
        return time.process_time() - begin, curve

    follow(4)  # compiles, or loads what was compiled
    seconds, curve = follow(points)
    flow = checked_flow(TOY, drive, contact="exact", tolerance=1e-12, rest_speed=1e-7)
    begin = time.process_time()
    for _ in range(points):
        flow.follow([angle, velocity], drive_period(drive))
    plain = time.process_time() - begin
    count = curve.sizes["point"]
    return {
        "impacts": impacts,
        "kind": kind,
        "found": curve.impacts.values[[0, count // 2, -1]].tolist() if count else [],
        "points": count,
        "ends": curve.end_reason.values.tolist(),
        "seconds": seconds,
        "seconds for 200 points": seconds * 200.0 / count if count else math.nan,
        "motions a point": seconds / plain * points / count if count else math.nan,
    }


def processor() -> str:
    """Return the name of the processor."""
    about = Path("/proc/cpuinfo")
    lines = about.read_text().splitlines() if about.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def _short(value: Any) -> Any:
    """Return a number with four digits, anything else as it is."""
    return f"{value:.4g}" if isinstance(value, float) else value


if __name__ == "__main__":
    main()
